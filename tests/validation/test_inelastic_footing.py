"""Prandtl's strip footing on soil without weight and friction: N_c = 2 + π, from above and at first order.

Half of a smooth footing 2 m wide on 5 m × 3 m of soil (Mohr and Coulomb, φ = 0), in contact with it. The size
of elements at the footing's edge, where the load is singular, makes the order 1.
"""

from __future__ import annotations

import numpy as np
import pytest

from masonry_fem.analyses.run import solve_scene
from masonry_fem.scene.reading import check
from masonry_fem.scene.specs import (
    Joint,
    Loads,
    Material,
    MeshSettings,
    Motion,
    Scene,
    Statics,
    Support,
    Table,
    material_record,
)
from masonry_fem.structures.block import BlockStructure

COHESION = 1e5


def bearing(cells: tuple[int, int]) -> float:
    """Force on half of the footing over its width and the cohesion, after 5 cm."""
    law = material_record("mohr_coulomb", cohesion=COHESION, friction_angle=0.0)
    soil = MeshSettings(element="Q2", divisions=cells)
    down = Motion(displacement=(0.0, -0.05), time=Table(points=((0.0, 0.0), (1.0, 1.0))))
    result = solve_scene(
        check(
            Scene(
                dimension=2,
                fidelity="inelastic",
                materials={"m": Material(density=1000.0, young=1e8, poisson=0.3, inelastic=law)},
                structures=(
                    BlockStructure(name="soil", material="m", size=(5.0, 3.0), mesh=soil),
                    BlockStructure(name="foot", material="m", size=(1.0, 0.5), position=(0.0, 3.0)),
                ),
                supports=(
                    Support(on="foot", motion=down),
                    Support(on="soil/left", components=("x",)),
                    Support(on="soil/right", components=("x",)),
                    Support(on="soil/bottom"),
                ),
                joints=(Joint(friction=0.0),),
                loads=Loads(gravity=(0.0, 0.0)),
                analysis=Statics(load_steps=10),
            )
        )
    )
    assert result.march.outcome == "equilibrium"
    return -float(result.summary.supports["foot"].force[1]) / COHESION


@pytest.mark.slow
def test_the_bearing_capacity_tends_to_prandtls_from_above():
    found = [bearing(cells) for cells in ((10, 6), (20, 12), (40, 24))]
    exact = 2 + np.pi
    over = np.array(found) - exact
    assert (over > 0).all(), found
    assert np.log2(over[:-1] / over[1:]) == pytest.approx([1.0, 1.0], abs=0.1)
    assert 2 * found[2] - found[1] == pytest.approx(exact, rel=0.01)  # extrapolated at that order
