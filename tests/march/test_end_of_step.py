"""Statics balances where a step ends, however far blocks turn in it (formulation 3b)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from masonry_fem.analyses.run import RunResult
from masonry_fem.bodies.rotation import exponential
from masonry_fem.joints import fold as folding
from masonry_fem.march import step as stepping
from masonry_fem.scene.specs import (
    Contact,
    Dynamics,
    Joint,
    Loads,
    MeshSettings,
    Motion,
    PointForce,
    Statics,
    Support,
    Table,
    law_record,
)
from masonry_fem.structures.arch import ArchStructure
from masonry_fem.structures.block import BlockStructure
from masonry_fem.structures.wall import WallStructure
from tests.validation.scenes import G, solved

EVENLY = Table(points=((0.0, 0.0), (1.0, 1.0)))


def spread_arch(load_steps: int, spread: float = 0.05, fidelity: str = "rigid", **keys) -> RunResult:
    """An arch of radius 1 m whose right springing moves outwards."""
    arch = ArchStructure(
        name="a", material="stone", radius=1.0, thickness=0.2, depth=0.3, voussoirs=11
    )  # fmt: skip
    motion = Motion(displacement=(spread, 0.0, 0.0), time=EVENLY)
    return solved(
        dimension=3,
        fidelity=fidelity,
        structures=(arch,),
        supports=(Support(on="a.springing_right", motion=motion),),
        joints=(Joint(friction=0.6),),
        analysis=Statics(load_steps=load_steps),
        **keys,
    )


def thrust(result: RunResult) -> float:
    return float(result.march.report.support_resultants["a.springing_left"][0])


def unbalanced(result: RunResult, points: dict[str, tuple] | None = None) -> float:
    """What forces and moments leave on any rigid block, by the sum that anyone can do, over its weight.

    From nothing but points, frames and reactions of the contacts and where blocks are: moments about the
    origin. ``points`` are forces at material points (block: (point, force)).
    """
    model, state = result.march.model, result.march.state
    d, assembly = model.assembly.dimension, model.assembly
    force = np.einsum("cij,ci->cj", state.frame, state.reaction)
    worst = 0.0
    for group, own in zip(model.groups, state.bodies, strict=True):
        if group.prescribed or group.deforms:
            continue
        for body, block in enumerate(group.blocks.tolist()):
            weight = np.array([0.0] * (d - 1) + [-G * group.mass[body]])
            centre = group.centres[body] + own.shift[body]
            acts = [(centre, weight)]
            if points and assembly.blocks[block].name in points:
                at, push = points[assembly.blocks[block].name]
                turned = own.rotation[body] @ (np.array(at) - group.centres[body])
                acts.append((centre + turned, np.array(push)))
            for side, sign in ((0, 1.0), (1, -1.0)):
                touching = model.contacts.blocks[:, side] == block
                acts += list(zip(state.points[touching], sign * force[touching], strict=True))
            total = sum(push for _, push in acts)
            moment = sum(np.cross(np.pad(at, (0, 3 - d)), np.pad(push, (0, 3 - d))) for at, push in acts)
            left = np.append(total, moment)
            worst = max(worst, float(np.linalg.norm(left)) / float(np.linalg.norm(weight)))
    return worst


@pytest.mark.parametrize("steps", [1, 2, 10, pytest.param(50, marks=pytest.mark.slow)])
def test_an_arch_has_one_thrust_whatever_the_number_of_steps(steps: int) -> None:
    """741.413 N at a spread of 5 %; impulses of the start of the step gave 665.7 N in one step."""
    result = spread_arch(steps)
    assert result.outcome == "equilibrium"
    assert thrust(result) == pytest.approx(741.413, rel=1e-5)
    assert unbalanced(result) < 1e-9
    report = result.march.report
    assert report.block_balance < 1e-9
    assert report.max_penetration < 1e-10


@pytest.mark.slow
def test_a_spread_too_far_brings_the_arch_down_where_small_steps_do() -> None:
    """One step of 0.25 m is divided until it is known to 1/32 where the arch falls."""
    fell = []
    for steps in (1, 16):
        result = spread_arch(steps, 0.25)
        assert result.outcome == "no_equilibrium"
        assert "a.v07" in result.message
        fell.append(result.march.state.time)
    assert fell[0] == pytest.approx(fell[1], abs=1 / 32)


def test_measures_are_of_the_written_geometry() -> None:
    """The step says what forces leave where the stones are; as if they had not turned it would be 0.1."""
    result = spread_arch(1)
    state, model = result.march.state, result.march.model
    np.testing.assert_array_equal(state.reaction_frame, state.frame)
    assert np.abs(state.frame - model.contacts.frame).max() > 0.02
    assert result.summary.certificate.written.balance.value < 1e-9
    march = replace(result.march, state=replace(state, frame=model.contacts.frame))
    assert unbalanced(replace(result, march=march)) > 0.05


@pytest.mark.parametrize("steps", [1, 3])
@pytest.mark.parametrize("dimension", [2, 3])
def test_a_block_rides_on_ground_that_turns(dimension: int, steps: int) -> None:
    """It stays where it is on the ground, turned by 20 degrees about the ground's pivot at once."""
    flat = (1.0,) * (dimension - 1)
    ground = BlockStructure(
        name="ground",
        material="stone",
        size=(*(3.0,) * (dimension - 1), 0.5),
        position=(*(-1.0,) * (dimension - 1), -0.5),
    )
    block = BlockStructure(name="block", material="stone", size=(*flat, 1.0), position=(0.0,) * dimension)
    vector = np.array([0.35]) if dimension == 2 else np.array([0.25, -0.2, 0.15])
    pivot = np.array([-1.0, 0.3]) if dimension == 2 else np.array([-1.0, 0.5, 0.3])
    motion = Motion(
        rotation=float(vector[0]) if dimension == 2 else tuple(vector), pivot=tuple(pivot), time=EVENLY
    )
    at = np.array([*flat, 1.0])
    push = np.array([*(0.0,) * (dimension - 1), -2e4])
    result = solved(
        dimension=dimension,
        fidelity="rigid",
        structures=(ground, block),
        supports=(Support(on="ground", motion=motion),),
        joints=(Joint(friction=0.6),),
        loads=Loads(
            gravity=(*(0.0,) * (dimension - 1), -G),
            points=(PointForce(block="block", point=tuple(at), vector=tuple(push)),),
        ),
        analysis=Statics(load_steps=steps),
    )
    assert result.outcome == "equilibrium"
    state, turn = result.march.state, exponential(vector)
    centre = np.array([*(0.5,) * (dimension - 1), 0.5])
    np.testing.assert_allclose(state.bodies[1].rotation[0], turn, atol=1e-10)
    np.testing.assert_allclose(state.bodies[1].shift[0], pivot + turn @ (centre - pivot) - centre, atol=1e-10)
    assert unbalanced(result, {"block": (at, push)}) < 1e-9
    given = result.march.report.support_resultants["ground"]
    weight = 2400.0 * G + 2e4
    np.testing.assert_allclose(given[:dimension], [*(0.0,) * (dimension - 1), weight], atol=1e-7 * weight)


def test_supports_that_turn_about_different_axes() -> None:
    """A lintel on two piers, one of which leans while the other twists: it rests on three corners."""
    size = (0.4, 0.4, 1.0)
    piers = [
        BlockStructure(name=f"p{i}", material="stone", size=size, position=(1.2 * i, 0.0, 0.0))
        for i in (0, 1)
    ]
    lintel = BlockStructure(name="lintel", material="stone", size=(1.6, 0.4, 0.3), position=(0.0, 0.0, 1.0))
    turns = ((0.12, 0.0, 0.0), (0.0, -0.08, 0.15))
    result = solved(
        dimension=3,
        fidelity="rigid",
        structures=(*piers, lintel),
        supports=tuple(
            Support(on=f"p{i}", motion=Motion(rotation=turn, pivot=(1.2 * i, 0.2, 0.0), time=EVENLY))
            for i, turn in enumerate(turns)
        ),
        joints=(Joint(friction=0.6),),
        analysis=Statics(),
    )
    assert result.outcome == "equilibrium"
    assert unbalanced(result) < 1e-9
    state = result.march.state
    assert state.gap.min() > -1e-9
    carrying = state.reaction[:, 0] > 1.0
    assert 3 <= carrying.sum() < len(carrying)
    np.testing.assert_allclose(state.gap[carrying], 0.0, atol=1e-9)


def test_friction_works_on_the_way_of_the_whole_step() -> None:
    """Ground that shifts and turns under a block that a wall holds: it slides all the way, in any steps."""
    ground = BlockStructure(name="ground", material="stone", size=(4.0, 0.5), position=(-2.0, -0.5))
    block = BlockStructure(name="block", material="stone", size=(1.0, 0.5), position=(0.0, 0.0))
    stop = BlockStructure(name="stop", material="stone", size=(0.5, 2.0), position=(1.0, 0.02), support=True)
    motion = Motion(displacement=(0.3, 0.0), rotation=-0.06, pivot=(0.5, 0.0), time=EVENLY)
    found = []
    for steps in (1, 8):
        result = solved(
            dimension=2,
            fidelity="rigid",
            structures=(ground, block, stop),
            supports=(Support(on="ground", motion=motion),),
            joints=(Joint(friction=0.3), Joint(between=("block", "stop"), friction=0.0)),
            contact=Contact(reach=0.05),
            analysis=Statics(load_steps=steps),
        )
        assert result.outcome == "equilibrium"
        assert unbalanced(result) < 1e-9
        state, contacts = result.march.state, result.march.model.contacts
        below = (contacts.blocks == 0).any(axis=1) & (state.reaction[:, 0] > 1.0)
        assert below.any()
        r = state.reaction[below]
        np.testing.assert_allclose(np.abs(r[:, 1]), 0.3 * r[:, 0], rtol=1e-7)
        assert (r[:, 1] * state.velocity[below, 1] < 0).all()
        found.append(result.march.report.support_resultants["stop"][:2])
    np.testing.assert_allclose(found[0], found[1], rtol=1e-6, atol=1e-3)


def counted(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """One entry a contact problem that steps have solved: its linear solves."""
    made: list[int] = []
    inner = folding.solve

    def solve(*given):
        solution = inner(*given)
        made.append(solution.linear_solves)
        return solution

    monkeypatch.setattr(folding, "solve", solve)
    return made


@pytest.mark.parametrize("what", ["wall", "arch"])
@pytest.mark.parametrize(
    ("fidelity", "update", "solves", "factors"),
    [("rigid", "moving", 1, 10), ("elastic", "fixed", 1, 4), ("elastic", "moving", 3, 6)],
)
def test_where_nothing_turns_a_step_is_one_solve(
    monkeypatch: pytest.MonkeyPatch, what: str, fidelity: str, update: str, solves: int, factors: int
) -> None:
    """Elastic stones turn a little as they bend: two more solves, each from where the last one ended."""
    made = counted(monkeypatch)
    wall = WallStructure(name="w", material="stone", brick=(0.5, 0.25), columns=3, courses=3)
    arch = ArchStructure(name="a", material="stone", radius=2.0, thickness=0.4, voussoirs=7)
    result = solved(
        dimension=2,
        fidelity=fidelity,
        structures=(wall if what == "wall" else arch,),
        mesh=MeshSettings(divisions=(2, 2)),
        joints=(Joint(friction=0.6),),
        contact=Contact(update=update),
        analysis=Statics(load_steps=4),
    )
    assert result.outcome == "equilibrium"
    assert len(made) <= 4 * solves
    assert sum(made) <= 4 * factors


@pytest.mark.slow
def test_rough_first_rounds_lead_where_exact_ones_do(monkeypatch: pytest.MonkeyPatch) -> None:
    """The same thrusts, balanced as well, by fewer factors."""
    made, found, factors = counted(monkeypatch), [], []
    for exact in (False, True):
        if exact:
            monkeypatch.setattr(stepping, "turned_roughly", lambda rounds: None)
        found.append(spread_arch(4, fidelity="elastic", mesh=MeshSettings(divisions=(3, 2, 2))))
        assert found[-1].outcome == "equilibrium"
        assert found[-1].summary.certificate.block_balance < 1e-9
        factors.append(sum(made))
        made.clear()
    assert thrust(found[0]) == pytest.approx(thrust(found[1]), rel=1e-9)
    assert factors[0] < factors[1]


def test_contacts_that_stay_where_they_were_are_solved_once(monkeypatch: pytest.MonkeyPatch) -> None:
    made = counted(monkeypatch)
    result = spread_arch(2, 0.01, contact=Contact(update="fixed"))
    assert result.outcome == "equilibrium"
    assert len(made) == 2
    model, state = result.march.model, result.march.state
    np.testing.assert_array_equal(state.frame, model.contacts.frame)
    assert result.march.report.block_balance < 1e-9
    assert result.summary.certificate.written.balance.value < 1e-9


def test_dynamics_writes_reactions_in_the_frames_of_the_start_of_the_step() -> None:
    """A bar that topples about its edge: the last frames have turned further than those of its reaction."""
    bar = BlockStructure(name="bar", material="stone", size=(0.2, 1.0), position=(0.0, 0.0))
    ground = BlockStructure(name="ground", material="stone", size=(2.0, 0.5), position=(-1.0, -0.5))
    push = Motion(rotation=-0.4, pivot=(0.0, 0.0), time=Table(points=((0.0, 0.0), (0.1, 1.0))))
    result = solved(
        dimension=2,
        fidelity="rigid",
        structures=(ground, bar),
        supports=(Support(on="ground", motion=push),),
        joints=(Joint(friction=2.0),),
        analysis=Dynamics(step=2e-3, duration=0.06, theta=0.5),
    )
    state, made = result.march.state, result.march.last
    assert np.abs(state.frame - state.reaction_frame).max() > 1e-4
    np.testing.assert_array_equal(state.reaction_frame, made.here.frame)
    force = np.einsum("cij,ci->cj", state.reaction_frame, state.reaction).sum(axis=0)
    gained = made.after.bodies[1].velocity[0, :2] - made.before.bodies[1].velocity[0, :2]
    mass = float(result.march.model.groups[1].mass[0])
    carried = np.sqrt(mass) * gained / made.scheme.step + [0.0, mass * G]
    sign = 1.0 if result.march.model.contacts.blocks[0, 0] == 1 else -1.0
    np.testing.assert_allclose(sign * force, carried, rtol=1e-9, atol=1e-6)


def test_rigid_and_elastic_blocks_balance_side_by_side() -> None:
    """What is claimed of a wall of both is what its written points, frames and arms give."""
    size = (0.5, 0.25, 0.25)
    blocks = [
        BlockStructure(
            name=f"b{course}{column}",
            material="stone",
            size=size,
            position=(0.5 * column + 0.25 * course, 0.0, 0.25 * course),
            fidelity="rigid" if (course + column) % 2 else "elastic",
        )
        for course in range(3)
        for column in range(3 - course)
    ]
    floor = BlockStructure(
        name="floor", material="stone", size=(3.0, 1.0, 0.1), position=(-0.5, -0.4, -0.1), support=True
    )
    result = solved(
        dimension=3,
        structures=(floor, *blocks),
        mesh=MeshSettings(divisions=(2, 2, 2)),
        joints=(Joint(friction=0.6),),
        loads=Loads(gravity=(0.15 * G, 0.0, -G)),
        analysis=Statics(),
    )
    assert result.outcome == "equilibrium"
    told = result.summary.certificate.written.balance.value
    assert told < 1e-9
    assert result.march.report.block_balance < 1e-9
    assert unbalanced_of(result) == pytest.approx(told, abs=1e-10)


def unbalanced_of(result: RunResult) -> float:
    """The same sum with the arms that are written for each side: elastic blocks take forces at the start."""
    model, state = result.march.model, result.march.state
    force = np.einsum("cij,ci->cj", state.reaction_frame, state.reaction)
    worst = 0.0
    for block in range(1, len(model.assembly.blocks)):
        total, about = np.zeros(3), np.zeros(3)
        centre, load = state.acting.centre[block], state.acting.load[block]
        for side, sign in ((0, 1.0), (1, -1.0)):
            own = model.contacts.blocks[:, side] == block
            total += sign * force[own].sum(axis=0)
            about += sign * np.cross(state.acting.arms[own, side] - centre, force[own]).sum(axis=0)
        about += load[3:] - np.cross(centre, load[:3])
        size = state.acting.size[block] * np.linalg.norm(load[:3])
        worst = max(
            worst, np.linalg.norm(total + load[:3]) / np.linalg.norm(load[:3]), np.linalg.norm(about) / size
        )
    return float(worst)


@pytest.mark.parametrize(
    "law",
    [
        law_record("elastic", normal_stiffness=1e9, tangential_stiffness=1e9),
        law_record("fremond_cangemi", normal_stiffness=1e10, tangential_stiffness=1e10, energy=2.0),
    ],
    ids=["elastic", "adhesion"],
)
def test_joints_with_laws_turn_with_their_blocks(law) -> None:
    """A cantilever glued to ground that turns by 20 degrees, in one step and in five."""
    ground = BlockStructure(name="ground", material="stone", size=(0.5, 1.0), position=(-0.5, 0.0))
    beam = BlockStructure(name="beam", material="stone", size=(0.6, 0.2), position=(0.0, 0.4))
    found = []
    for steps in (1, 5):
        result = solved(
            dimension=2,
            fidelity="rigid",
            structures=(ground, beam),
            supports=(Support(on="ground", motion=Motion(rotation=0.35, pivot=(-0.5, 0.0), time=EVENLY)),),
            joints=(Joint(friction=0.5, law=law),),
            analysis=Statics(load_steps=steps),
        )
        assert result.outcome == "equilibrium"
        assert unbalanced(result) < 1e-7
        state, start = result.march.state, result.march.model.contacts
        # the jump that the law saw is the one that there is, in the frames that turned with the ground
        made = result.march.last
        np.testing.assert_allclose(state.jump, made.here.offset - start_offset(start), atol=1e-11)
        found.append(state)
    np.testing.assert_allclose(found[0].reaction, found[1].reaction, rtol=1e-5, atol=1e-2)
    np.testing.assert_allclose(found[0].joints.adhesion, found[1].joints.adhesion, atol=1e-6)
    turned = exponential(np.array([0.35]))
    np.testing.assert_allclose(found[0].bodies[1].rotation[0], turned, atol=1e-3)


def start_offset(contacts) -> np.ndarray:
    apart = contacts.points[:, 0] - contacts.points[:, 1]
    return np.einsum("cij,cj->ci", contacts.frame, apart)
