"""A6.6: a springing of a semicircular arch that sinks or heaves, t = 0.15 R, 20 voussoirs, no sliding.

Whatever the amount, between 1e-5 and 1e-3 R, the force of that springing goes to the least it can have,
0.488294 of the weight, or to the greatest, 0.511706, and with three hinges the arch is determinate.
"""

from __future__ import annotations

import numpy as np
import pytest

from masonry_fem.analyses.limit import analyse
from masonry_fem.scene.specs import Joint, Loads, Motion, Scene, Statics, Support
from masonry_fem.structures.arch import ArchStructure
from tests.validation.scenes import STONE, G, rigid_arch

LEAST, GREATEST = 0.488294, 0.511706
WEIGHT = 0.15 * np.pi * STONE.density * G


def vertical(rise: float, steps: int = 2) -> float:
    """Vertical force of the springing that moves by ``rise`` [m], over the arch's weight."""
    moved = Support(on="arch.springing_right", motion=Motion(displacement=(0.0, rise)))
    result = rigid_arch(
        thickness=0.15, voussoirs=20, friction=5.0, supports=(moved,), analysis=Statics(load_steps=steps)
    )
    assert result.outcome == "equilibrium"
    forces = {name: value.force for name, value in result.summary.supports.items()}
    total = sum(float(force[1]) for force in forces.values())
    # the curved faces of voussoirs are polygons
    assert total == pytest.approx(WEIGHT, rel=0.01)
    return float(forces["arch.springing_right"][1]) / total


@pytest.mark.parametrize("amount", [1e-5, 1e-4, 1e-3])
def test_a_springing_that_sinks_is_relieved(amount: float) -> None:
    assert vertical(-amount) == pytest.approx(LEAST, rel=2e-4 + 2 * amount)


@pytest.mark.parametrize("amount", [1e-5, 1e-4, 1e-3])
def test_a_springing_that_heaves_is_loaded(amount: float) -> None:
    assert vertical(amount) == pytest.approx(GREATEST, rel=2e-4 + 2 * amount)


def test_limit_analysis_has_the_same_ends() -> None:
    arch = ArchStructure(name="arch", material="stone", radius=1.0, thickness=0.15, voussoirs=20)
    made = Scene(
        dimension=2,
        fidelity="rigid",
        materials={"stone": STONE},
        structures=(arch,),
        joints=(Joint(friction=5.0),),
        loads=Loads(gravity=(0.0, -G)),
    )
    told = analyse(made).supports
    low, high = told["arch.springing_right"]["y"]
    whole = low + told["arch.springing_left"]["y"][1]
    assert (low / whole, high / whole) == pytest.approx((LEAST, GREATEST), abs=2e-6)
