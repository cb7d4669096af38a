"""The witness: what the written points, frames, reactions and loads leave of each block's balance."""

from __future__ import annotations

import numpy as np
import pytest

from masonry_fem.analyses.run import RunResult
from masonry_fem.march.acting import contact_wrenches, imbalance
from masonry_fem.march.witness import Written
from masonry_fem.scene.specs import (
    Contact,
    Dynamics,
    Initial,
    Joint,
    Loads,
    MeshSettings,
    Motion,
    Statics,
    Support,
    Table,
    Traction,
)
from masonry_fem.structures.arch import ArchStructure
from masonry_fem.structures.block import BlockStructure
from masonry_fem.structures.stack import StackStructure
from tests.validation.scenes import G, solved


def test_a_couple_is_told_whatever_the_origin() -> None:
    """A beam on two points that carry ¼ and ¾ of its weight: moments lack a quarter of W L."""
    blocks = np.array([[1, 0], [1, 0]])
    force = np.array([[0.0, 25.0], [0.0, 75.0]])
    for origin in (np.zeros(2), np.array([1e3, -20.0])):
        points = np.array([[0.0, 0.0], [2.0, 0.0]]) + origin
        middle = np.array([1.0, 0.1]) + origin
        given = np.zeros((2, 3))
        given[1] = [0.0, -100.0, -100.0 * middle[0]]
        pressed = contact_wrenches(blocks, np.repeat(points[:, None], 2, axis=1), force, 2)
        left = imbalance(pressed + given, np.tile(middle, (2, 1)))
        np.testing.assert_allclose(left[1], [0.0, 0.0, 50.0], atol=1e-10)
        np.testing.assert_allclose(left[0], [0.0, -100.0, -50.0], atol=1e-10)


def written(result: RunResult) -> Written:
    return result.summary.certificate.written


def clamped_beam(dimension: int, update: str) -> RunResult:
    """A pillar on a beam that is clamped at one end, under its own weight and a traction."""
    deep = (0.2,) * (dimension - 2)
    side = (0.0,) * (dimension - 2)
    beam = BlockStructure(name="beam", material="stone", size=(1.0, *deep, 0.3), position=(0.0, *side, 0.0))
    post = BlockStructure(name="post", material="stone", size=(0.2, *deep, 0.4), position=(0.7, *side, 0.3))
    return solved(
        dimension=dimension,
        structures=(beam, post),
        mesh=MeshSettings(divisions=(4, *(1,) * (dimension - 2), 2)),
        supports=(Support(on="beam/left"),),
        loads=Loads(
            gravity=(*(0.0,) * (dimension - 1), -G),
            tractions=(Traction(on="post/top", vector=(1e3, *side, -1e4)),),
        ),
        contact=Contact(update=update),
        analysis=Statics(),
    )


@pytest.mark.parametrize(("update", "left"), [("fixed", 1e-8), ("moving", 1e-5)])
@pytest.mark.parametrize("dimension", [2, 3])
def test_clamps_and_tractions_are_in_the_balance(dimension: int, update: str, left: float) -> None:
    """The beam, which is clamped, balances in the reference, the post where it is: 0.1 mm from there."""
    result = clamped_beam(dimension, update)
    assert result.outcome == "equilibrium"
    assert written(result).balance.value < 1e-9
    acting = result.march.state.acting
    carried = acting.clamp.sum(axis=0) + acting.load.sum(axis=0)
    assert np.abs(carried).max() < left * np.abs(acting.load).max()


@pytest.mark.parametrize("fidelity", ["rigid", "elastic"])
def test_a_block_in_motion_balances_with_its_inertia(fidelity: str) -> None:
    """A stack on ground that starts to move: what presses is not the weight alone."""
    shake = Motion(displacement=(0.0, 0.01), time=Table(points=((0.0, 0.0), (0.1, 1.0), (0.2, 1.0))))
    result = solved(
        dimension=2,
        fidelity=fidelity,
        structures=(StackStructure(name="s", material="stone", size=(1.0, 1.0), count=2),),
        mesh=MeshSettings(divisions=(2, 2)),
        supports=(Support(on="s.ground", motion=shake),),
        analysis=Dynamics(step=1e-3, duration=0.05, theta=1.0),
    )
    assert result.outcome == "finished"
    assert np.abs(result.march.state.acting.inertia[:, 1]).max() > 0
    assert written(result).balance.value < 1e-9


def springing(fidelity: str, move: float, update: str = "moving") -> RunResult:
    """An arch whose right springing moves outwards by ``move`` [m] of its radius of 1 m, in ten steps."""
    motion = Motion(displacement=(move, 0.0), time=Table(points=((0.0, 0.0), (1.0, 1.0))))
    return solved(
        dimension=2,
        fidelity=fidelity,
        structures=(ArchStructure(name="a", material="stone", radius=1.0, thickness=0.2, voussoirs=11),),
        mesh=MeshSettings(divisions=(2, 2)),
        supports=(Support(on="a.springing_right", motion=motion),),
        contact=Contact(update=update),
        analysis=Statics(load_steps=10),
    )


@pytest.mark.parametrize("move", [0.001, pytest.param(0.05, marks=pytest.mark.slow)])
def test_elastic_voussoirs_that_turn_have_the_thrust_of_rigid_ones(move: float) -> None:
    elastic, rigid = springing("elastic", move), springing("rigid", move)
    thrusts = [abs(one.summary.supports["a.springing_left"].force[0]) for one in (elastic, rigid)]
    assert thrusts[0] == pytest.approx(thrusts[1], rel=2e-3)
    assert written(elastic).balance.value < 1e-8
    assert written(elastic).turning.value == 0


@pytest.mark.parametrize(("move", "told"), [(0.001, False), pytest.param(0.05, True, marks=pytest.mark.slow)])
def test_stones_that_should_turn_are_told_by_what_it_does(
    move: float, told: bool, caplog: pytest.LogCaptureFixture
) -> None:
    """With contacts that stay they keep their thrust, which grows with the span where voussoirs turn."""
    elastic, rigid = springing("elastic", move, "fixed"), springing("rigid", move)
    thrusts = [abs(one.summary.supports["a.springing_left"].force[0]) for one in (elastic, rigid)]
    lost = 1 - thrusts[0] / thrusts[1]
    turning = written(elastic).turning
    assert written(elastic).balance.value < 1e-8
    assert 0.5 * lost < turning.value < 2.0 * lost
    assert (turning.value > 0.01) == told == ("balance where they were at the start" in caplog.text)
    assert written(rigid).turning.value == 0


@pytest.mark.slow
@pytest.mark.parametrize(
    ("update", "cure"),
    [("moving", ""), ("fixed", "leave it out"), ("redetect", "")],
)
def test_a_block_that_falls_over_into_the_ground_is_told_with_what_helps(
    update: str, cure: str, caplog: pytest.LogCaptureFixture
) -> None:
    """Contacts of the start are those of its foot; its side finds the ground unless they stay so."""
    result = solved(
        dimension=2,
        fidelity="rigid",
        structures=(StackStructure(name="s", material="stone", size=(0.2, 1.0), count=1),),
        initial=(Initial(blocks="s.b1", spin=5.0),),
        joints=(Joint(friction=0.8),),
        contact=Contact(update=update),
        analysis=Dynamics(step=5e-3, duration=1.0, theta=1.0),
    )
    assert result.outcome == "finished"
    assert (written(result).overlap.value > 0.01) == bool(cure)
    assert ("'s.ground' and 's.b1' overlap" in caplog.text) == bool(cure)
    assert cure in caplog.text


@pytest.mark.parametrize("form", ["velocity", "gap"])
def test_what_impacts_leave_in_each_other_is_told_as_such(
    form: str, caplog: pytest.LogCaptureFixture
) -> None:
    """A block dropped from 1 m meets the ground with 4.4 m/s, late by half a step of 0.1 s at most."""
    result = solved(
        dimension=2,
        fidelity="rigid",
        structures=(StackStructure(name="s", material="stone", size=(0.5, 0.5), count=1, gap=1.0),),
        joints=(Joint(friction=0.5, form=form),),
        contact=Contact(reach=1.5),
        analysis=Dynamics(step=0.01, duration=0.6, theta=0.5),
    )
    deep = written(result).overlap.value
    assert (1e-3 < deep < 0.006 * 4.43) == (form == "velocity")
    assert ("half of speed times step" in caplog.text) == (form == "velocity")
