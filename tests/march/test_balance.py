"""What is left of balance, and where a step that leaves too much is told: by hand, on a block or two."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import masonry_fem.march.measure as measuring
import masonry_fem.march.rounds as rounds_of_steps
import masonry_fem.march.turning as rounds_that_turn
from masonry_fem.bodies.base import Scheme
from masonry_fem.bodies.support import SupportGroup
from masonry_fem.contact.detection import detect
from masonry_fem.contact.place import place
from masonry_fem.contact.placement import Rule
from masonry_fem.fem.groups import elastic_groups
from masonry_fem.fem.material import ElasticMaterial
from masonry_fem.joints import Assignment, Dry
from masonry_fem.joints.fold import solve_with_laws
from masonry_fem.march.acting import Acting, relative
from masonry_fem.march.clock import Clock
from masonry_fem.march.conditions import shifted_jump
from masonry_fem.march.coupling import connect
from masonry_fem.march.encounter import expelling_step
from masonry_fem.march.loads import external_forces
from masonry_fem.march.model import Model
from masonry_fem.march.motion import BlockMotion, greatest_shift
from masonry_fem.march.place import begun, reached, turning
from masonry_fem.march.step import initial_state, step
from masonry_fem.nscd import SolverSettings
from masonry_fem.solid.assembly import Assembly, Block, Shape
from masonry_fem.solid.polytope import Polytope
from masonry_fem.solid.pose import Pose
from tests.fem.meshes import box, box_mesh
from tests.march.test_march import G, stack

WEIGHT = 1000 * G  # of a cube [N], in the plane a metre deep


def acting(load: list[float], solved: list[bool]) -> Acting:
    """Blocks in the plane, two metres long, with vertical loads [N]."""
    count = len(load)
    forces = np.zeros((count, 3))
    forces[:, 1] = load
    nothing = np.zeros_like(forces)
    return Acting(
        forces, nothing, np.zeros(count), nothing, nothing, nothing, np.zeros((count, 2)),
        np.full(count, 2.0), np.zeros((0, 2, 2)), np.array(solved), np.zeros(count, dtype=bool),
    )  # fmt: skip


@pytest.mark.parametrize(
    ("load", "largest", "scale"),
    [
        ([-100.0, -100.0, -1.0], 50.0, [100.0, 100.0, 67.0]),  # a light block is compared with the mean
        ([-1e-6, -1e-6, -1e-6], 1e-6, [1e-6, 1e-6, 1e-6]),
        ([-1e-6, 0.0, 0.0], 1e-6, [1e-6, 1e-6, 1e-6]),  # those without load are not in the mean
        ([0.0, 0.0, 0.0], 1e-3, [1e-3, 1e-3, 1e-3]),  # no load: the largest contact force
        ([0.0, 0.0, 0.0], 0.0, [1.0, 1.0, 1.0]),  # nothing at all: newtons
    ],
)
def test_what_is_left_is_relative_to_a_blocks_load(load, largest, scale) -> None:
    left = np.array([[0.3, 0.4, 0.0], [0.0, 0.0, 1.0], [0.0, 0.1, 3.0], [7.0, 7.0, 7.0]])
    size = np.array([0.5, 0.5, 1.5])  # a moment by the block's length
    told = relative(left, acting([*load, -1e9], [True] * 3 + [False]), largest)
    assert told == pytest.approx([*(size / scale), 0.0], rel=1e-12)


@pytest.mark.parametrize(("pressed", "reference"), [(1e-3, WEIGHT * 0.01), (1e6, 1e6)])
def test_turning_is_relative_to_the_largest_load_or_impulse(pressed: float, reference: float) -> None:
    """Arms that change by a millimetre under one contact's impulse [N s]."""
    model, scheme = stack(1, 2), Scheme(0.01, 1.0)
    coupling = connect(model)
    start = begun(coupling, tuple(group.rest() for group in model.groups))
    forces = external_forces(model, 1.0)
    free = tuple(
        group.free(own, own, force, scheme)
        for group, own, force in zip(model.groups, start.bodies, forces, strict=True)
    )
    impulse = np.zeros((model.contacts.count, 2))
    impulse[0, 0] = pressed
    change = np.zeros_like(start.rigid_map)
    change[0, :, 0, 2] = 1e-3 / np.sqrt(1000.0)  # rigid modes are mass-orthonormal
    place = replace(start, rigid_map=start.rigid_map - change)
    left = turning(coupling, start, free, forces, scheme, impulse, place)
    assert left == pytest.approx(1e-3 * pressed / reference, rel=1e-12)


@pytest.mark.parametrize(("gap", "jammed"), [(0.0, False), (-1e-3, True)])
def test_a_step_is_jammed_while_overlaps_are_held_not_when_they_are_gone(gap: float, jammed: bool) -> None:
    """Expulsion waits for some more steps after one that found no way out."""
    model = replace(stack(1, 2), expulsion=1.0)
    coupling = connect(model)
    state = initial_state(model, coupling, tuple(group.rest() for group in model.groups))
    cached = coupling.placement(state.bodies)
    cached.gap[:] = gap
    settings = SolverSettings()
    made = expelling_step(
        model, coupling, replace(state, held=(2, 2)), Scheme(0.01, 1.0), settings, 0.01, Clock()
    )
    assert made.jammed is jammed
    assert made.after.held == (1, 2)


@pytest.mark.parametrize(
    ("left", "missed", "strayed"), [(0.0, 0.0, False), (1.0, 0.0, True), (0.0, 1.0, True)]
)
def test_a_step_that_leaves_forces_or_misses_its_way_is_told(left, missed, strayed, monkeypatch) -> None:
    monkeypatch.setattr(rounds_that_turn, "_left", lambda *_: (left, missed))
    model = stack(1, 2)
    coupling = connect(model)
    state = initial_state(model, coupling, tuple(group.rest() for group in model.groups))
    made = step(model, coupling, state, Scheme(1.0, 1.0, 0.0), SolverSettings())
    assert made.strayed is strayed


@pytest.mark.parametrize("dimension", [2, 3])
def test_motion_of_blocks_is_that_of_their_corners(dimension: int) -> None:
    model = stack(2, dimension)
    bodies = [group.rest() for group in model.groups]
    stones = model.groups[1]
    velocity = np.array([1.0, -2.0, 0.5])[:dimension]
    spin = np.array([0.2, 0.4, -0.7])[: 1 if dimension == 2 else 3]
    bodies[1] = stones.with_velocity(bodies[1], 1, velocity, spin)
    motion = BlockMotion.of(model, bodies, bodies)
    for block in (1, 2):
        solid = model.assembly.solid(block)
        assert motion.centre[block] == pytest.approx(solid.vertices.mean(axis=0), abs=1e-12)
        assert motion.corners[block] == pytest.approx(stones.nodes(block - 1), abs=1e-12)
    assert motion.held.tolist() == [True, False, False]
    assert motion.velocity == pytest.approx(np.array([0 * velocity, 0 * velocity, velocity]), abs=1e-12)
    assert motion.spin == pytest.approx(np.array([0 * spin, 0 * spin, spin]), abs=1e-12)
    moved = motion.at(np.full(2**dimension, 2), motion.corners[2])
    assert moved == pytest.approx(stones.velocities(bodies[1])[-(2**dimension) :], abs=1e-12)


@pytest.mark.parametrize("dimension", [2, 3])
def test_the_greatest_shift_is_that_of_the_fastest_corner(dimension: int) -> None:
    """A cube that goes 3 mm up, and one that turns by 0.01 rad about its centre."""
    model = stack(2, dimension)
    before = [group.rest() for group in model.groups]
    shift, turned = before[1].shift.copy(), before[1].turned.copy()
    shift[0, -1] += 3e-3
    assert greatest_shift(model, before, before) == 0.0
    after = [before[0], replace(before[1], shift=shift)]
    assert greatest_shift(model, before, after) == pytest.approx(3e-3, rel=1e-9)
    c, s = np.cos(0.01), np.sin(0.01)
    turned[1, :2, :2] = [[c - 1, -s], [s, c - 1]]
    after = [before[0], replace(before[1], shift=shift, turned=turned)]
    assert greatest_shift(model, before, after) == pytest.approx(2 * np.sin(0.005) * np.sqrt(0.5), rel=1e-9)


@pytest.mark.parametrize("theta", [0.25, 0.5, 1.0])
def test_laws_see_the_jump_that_the_last_velocity_leads_to(theta: float) -> None:
    """u + h (1 − θ) v."""
    model = stack(1, 2)
    state = initial_state(model, connect(model), tuple(group.rest() for group in model.groups))
    state = replace(
        state, jump=np.array([[1.0, 2.0], [3.0, 4.0]]), velocity=np.array([[10.0, 0], [0, -20.0]])
    )
    seen = shifted_jump(state, Scheme(0.1, theta))
    assert seen == pytest.approx(state.jump + 0.1 * (1 - theta) * state.velocity, rel=1e-12)


def test_faces_overlap_past_where_mortar_and_roughness_have_them_touch() -> None:
    """Mortar pressed by 3 mm lets faces come 3 mm nearer; rough ones raised by 1 mm touch so much earlier."""
    model = stack(1, 2)
    state = initial_state(model, connect(model), tuple(group.rest() for group in model.groups))
    elastic = np.array([[-3e-3, 0.0], [-3e-3, 0.0]])
    joints = replace(state.joints, elastic=elastic, dilation=np.array([0.0, 1e-3]))
    state = replace(state, joints=joints, gap=np.array([-3e-3, -5e-3]))
    assert measuring._overlap(state) == pytest.approx([0.0, 3e-3], abs=1e-15)


@pytest.mark.parametrize("theta", [0.5, 0.75, 1.0])
def test_a_step_ends_a_step_later_under_the_mean_of_its_loads(theta: float) -> None:
    """A load that grows with time: (1 − θ) of that at the start and θ of that at the end."""
    steady = stack(1, 2)
    (gravity,) = steady.loads
    model = replace(steady, loads=(replace(gravity, factor=lambda t: 1.0 + 50.0 * t),))
    coupling = connect(model)
    state = initial_state(model, coupling, tuple(group.rest() for group in model.groups))
    made = step(model, coupling, replace(state, time=0.1), Scheme(0.01, theta), SolverSettings())
    assert made.after.time == pytest.approx(0.11, rel=1e-12)
    assert made.forces[1][0, 1] == pytest.approx(-WEIGHT * (6.0 + 0.5 * theta), rel=1e-12)
    until = step(model, coupling, state, Scheme(0.01, theta), SolverSettings(), until=0.3)
    assert until.after.time == 0.3
    assert until.forces[1][0, 1] == pytest.approx(-WEIGHT * (1.0 + 15.0 * theta), rel=1e-12)


def test_arms_of_loads_turn_with_a_block_and_contacts_may_balance_that() -> None:
    """A weight at a corner of a cube that turns by 0.01 rad, and a contact whose arm takes its moment."""
    model, scheme = stack(1, 2), Scheme(0.01, 1.0, 0.0)
    coupling, stones = connect(model), model.groups[1]
    start = begun(coupling, tuple(group.rest() for group in model.groups))
    c, s = np.cos(0.01), np.sin(0.01)
    turned = replace(start.bodies[1], turned=np.array([[[c - 1, -s], [s, c - 1]]]))
    there = replace(start, bodies=(start.bodies[0], turned))
    forces = list(external_forces(model, 1.0))
    forces[1] = forces[1] + stones.point_force(0, np.array([1.0, 1.0]), np.array([0.0, -WEIGHT]))
    free = tuple(
        group.free(own, own, force, scheme)
        for group, own, force in zip(model.groups, start.bodies, forces, strict=True)
    )
    impulse, change = np.zeros((model.contacts.count, 2)), np.zeros_like(start.rigid_map)
    left = turning(coupling, there, free, tuple(forces), scheme, impulse, start)
    # arm (0.5, 0.5) turns to (0.5 (c − s), ...), under twice the weight in all
    assert left == pytest.approx(0.5 * (1 - c + s) / 2 / np.sqrt(1 / 6), rel=1e-6)
    moments = stones.free(start.bodies[1], turned, forces[1], scheme).rigid_impulse - free[1].rigid_impulse
    impulse[0, 0] = 1.0
    change[0, :, 0] = -moments[0]
    place = replace(start, rigid_map=start.rigid_map - change)
    assert turning(coupling, there, free, tuple(forces), scheme, impulse, place) < 1e-12


def test_impulses_on_stones_that_deform_turn_with_their_joints() -> None:
    """An impulse p whose joint turns by φ about its point: 2 p sin(φ/2) of it is left."""
    low, high = (0.0, 0.0), (1.0, 1.0)
    stone = Shape("stone", box(low, high), box_mesh("quad", (1, 1), low, high, 0.0))
    slab = Shape("slab", Polytope.box((-1.0, -1.0), (2.0, 0.0)))
    blocks = (Block("ground", 1, Pose.identity(2), support=True), Block("b", 0, Pose.identity(2)))
    assembly = Assembly(2, (stone, slab), blocks)
    interfaces = detect(assembly)
    (group,) = elastic_groups(assembly, {1: ElasticMaterial(1e9, 0.2, 1000.0)}, turns=True)
    contacts = place(assembly, interfaces, [Rule("nodes")] * len(interfaces))
    laws = Assignment.of(Dry(0.6), contacts.count)
    model = Model(
        assembly, (SupportGroup(assembly, [0], [None]), group), interfaces, contacts, laws, (), (), 1.0
    )
    coupling, scheme = connect(model), Scheme(1.0, 1.0, 0.0)
    start = begun(coupling, tuple(one.rest() for one in model.groups))
    forces = tuple(one.no_force() for one in model.groups)
    free = tuple(
        one.free(own, own, force, scheme)
        for one, own, force in zip(model.groups, start.bodies, forces, strict=True)
    )
    c, s = np.cos(0.01), np.sin(0.01)
    turn = np.array([[c, -s], [s, c]])
    seen = tuple(None if one is None else one @ turn for one in start.contact.seen)
    there = replace(start, contact=replace(start.contact, seen=seen))
    impulse = np.zeros((contacts.count, 2))
    impulse[0] = 3.0, 4.0
    left = turning(coupling, there, free, forces, scheme, impulse, start)
    assert left == pytest.approx(2 * np.sin(0.005), rel=1e-9)


@pytest.mark.parametrize(
    ("residuals", "kept"),
    [((1e-3,), True), ((1e-3, 4e-4), True), ((1e-3, 6e-4), False), ((1e-10, 9e-11), True)],
)
def test_tangents_are_kept_while_a_round_halves_what_is_left(residuals, kept) -> None:
    model = replace(stack(1, 2), keeps_tangents=True)
    coupling = connect(model)
    state = initial_state(model, coupling, tuple(group.rest() for group in model.groups))
    scheme, start = Scheme(1.0, 1.0, 0.0), begun(coupling, state.bodies)
    rounds = rounds_of_steps.Rounds(model, coupling, state, scheme, SolverSettings(), 1.0, Clock(), start)
    last = replace(rounds.solved(start, None), residuals=residuals, tangents=("of the first round",))
    assert rounds._tangents(last, ("new",)) == (last.tangents if kept else ("new",))


def test_a_step_tells_the_efforts_of_all_its_rounds(monkeypatch) -> None:
    """Here rounds go on until none brings balance nearer."""
    model, each = stack(1, 2), []

    def solved(*arguments):
        taken = solve_with_laws(*arguments)
        each.append(replace(taken.solution, iterations=3, linear_solves=5, seconds=0.25))
        return replace(taken, solution=each[-1])

    monkeypatch.setattr(rounds_of_steps, "solve_with_laws", solved)
    monkeypatch.setattr(rounds_that_turn, "_left", lambda *_: (1.0, 0.0))
    coupling = connect(model)
    state = initial_state(model, coupling, tuple(group.rest() for group in model.groups))
    made = step(model, coupling, state, Scheme(1.0, 1.0, 0.0), SolverSettings())
    told = made.solution
    assert len(each) > 1
    assert (told.iterations, told.linear_solves, told.seconds) == tuple(len(each) * n for n in (3, 5, 0.25))


@pytest.mark.parametrize("away", [0.0, 1e6])
def test_what_places_are_rounded_by_is_no_bend(away: float) -> None:
    """A cube that only slides goes straight; farther off places are rounded more, and that is all."""
    model, h = stack(1, 2), 0.01
    coupling = connect(model)
    ends = []
    for shift in (away, away + 0.3 * h):
        bodies = tuple(group.rest() for group in model.groups)
        stone = replace(
            bodies[1], shift=np.array([[shift, 0.0]]), velocity=np.sqrt(1000.0) * np.array([[0.3, 0, 0]])
        )
        ends.append((bodies[0], stone))
    start = begun(coupling, ends[0])
    there = reached(coupling, start, ends[1], h)
    moved = (there.contact.offset - start.contact.offset)[:, 1] / h
    assert np.abs(moved) == pytest.approx(0.3, rel=1e-6)
    assert not there.bend.any()
