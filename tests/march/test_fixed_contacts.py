"""Contacts that stay where they were: small kinematics of rigid blocks."""

import numpy as np
import pytest

from masonry_fem.scene.specs import Contact, Equilibrium, Joint, Loads, Motion, Support, Table
from masonry_fem.structures.arch import ArchStructure
from masonry_fem.structures.block import BlockStructure
from tests.validation.scenes import G, solved

TILT = np.radians(1.0)


def on_ground_that_turns(update: str, dimension: int):
    """A cube on ground that turns by 1 degree about its lower edge, with friction for half of that."""
    up = (0.0,) * (dimension - 1)
    along = (1.0,) * (dimension - 1)
    ground = BlockStructure(
        name="ground",
        material="stone",
        size=(*(3.0,) * (dimension - 1), 0.5),
        position=(*(-1.0,) * (dimension - 1), -0.5),
    )
    block = BlockStructure(name="block", material="stone", size=(*along, 1.0), position=(*up, 0.0))
    turn = TILT if dimension == 2 else (0.0, -TILT, 0.0)
    motion = Motion(
        rotation=turn, pivot=(*(0.0,) * (dimension - 1), 0.0), time=Table(points=((0.0, 0.0), (1.0, 1.0)))
    )
    return solved(
        dimension=dimension,
        fidelity="rigid",
        structures=(ground, block),
        supports=(Support(on="ground", motion=motion),),
        joints=(Joint(friction=0.5 * np.tan(TILT)),),
        loads=Loads(gravity=(*(0.0,) * (dimension - 1), -G)),
        contact=Contact(update=update),
        analysis=Equilibrium(strategy="large_step", step=0.1, max_steps=30, tolerance=1e-6),
    )


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_block_slides_off_a_tilt_only_where_frames_follow(dimension: int) -> None:
    fixed, moving = (on_ground_that_turns(update, dimension) for update in ("fixed", "moving"))
    assert moving.outcome == "no_equilibrium"
    assert fixed.outcome == "equilibrium"
    # it turned with the ground all the same
    turned = fixed.march.state.bodies[1].rotation[0]
    assert turned[0, 0] == pytest.approx(np.cos(TILT), abs=1e-5)
    assert np.abs(fixed.march.state.gap).max() < 1e-6


def test_an_arch_that_hardly_moves_feels_no_difference() -> None:
    reactions = [
        solved(
            dimension=2,
            fidelity="rigid",
            structures=(
                ArchStructure(name="arch", material="stone", radius=5.0, thickness=1.0, voussoirs=11),
            ),
            joints=(Joint(friction=0.6),),
            contact=Contact(update=update),
            analysis=Equilibrium(strategy="large_step", step=0.01, max_steps=5, tolerance=1e-6),
        ).march.report.support_resultants["arch.springing_left"]
        for update in ("fixed", "moving")
    ]
    assert reactions[0] == pytest.approx(reactions[1], rel=1e-9)
