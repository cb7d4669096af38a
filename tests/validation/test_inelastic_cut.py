"""A vertical cut in clay (Tresca): it stands up to γ H/c between 3.77 and 3.83, from above, at first order.

The upper bound is that of a slip circle (Chen, Limit Analysis and Soil Plasticity, 1975), the lower one that
of limit analysis by finite elements. Gravity follows from how far the crest comes down. Below the toe is
rock.
"""

from __future__ import annotations

import numpy as np
import pytest

from masonry_fem.analyses.run import solve_scene
from masonry_fem.march.equilibrium.path import Path
from masonry_fem.scene.reading import check
from masonry_fem.scene.specs import Loads, Material, MeshSettings, Probe, Scene, Support, material_record
from masonry_fem.structures.block import BlockStructure

COHESION, DENSITY, HEIGHT = 1e4, 2000.0, 1.0


def stability(cells: int) -> float:
    """γ H/c after the crest has come down by 1 % of the height."""
    law = material_record("mohr_coulomb", cohesion=COHESION, friction_angle=0.0)
    mesh = MeshSettings(element="Q2", divisions=(2 * cells, cells))
    size = (2 * HEIGHT, HEIGHT)
    result = solve_scene(
        check(
            Scene(
                dimension=2,
                fidelity="inelastic",
                materials={"m": Material(density=DENSITY, young=1e7, poisson=0.3, inelastic=law)},
                structures=(BlockStructure(name="soil", material="m", size=size, mesh=mesh),),
                supports=(Support(on="soil/left", components=("x",)), Support(on="soil/bottom")),
                probes=(Probe(name="crest", block="soil", point=size),),
                loads=Loads(gravity=(0.0, -COHESION / DENSITY / HEIGHT)),
                analysis=Path(probe="crest", direction=(0.0, -1.0), distance=0.01, load_steps=10),
            )
        )
    )
    assert result.outcome == "finished"
    return result.march.report.time


@pytest.mark.slow
def test_the_height_of_a_vertical_cut():
    found = [stability(cells) for cells in (4, 8, 16)]
    assert np.log2((found[0] - found[1]) / (found[1] - found[2])) == pytest.approx(1.0, abs=0.1), found
    assert found[2] > 3.83
    assert 3.77 <= 2 * found[2] - found[1] <= 3.83, found
