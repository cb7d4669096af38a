"""The march on rigid blocks put together by hand: no scene, no files."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from masonry_fem.bodies.base import Scheme
from masonry_fem.bodies.rigid import RigidGroup
from masonry_fem.bodies.support import Motion, SupportGroup
from masonry_fem.contact.detection import detect
from masonry_fem.contact.place import place
from masonry_fem.contact.placement import Rule
from masonry_fem.joints import Assignment, Dry
from masonry_fem.march.acting import acted, extents
from masonry_fem.march.conditions import contact_status
from masonry_fem.march.coupling import connect
from masonry_fem.march.equilibrium.dynamics import Dynamics
from masonry_fem.march.equilibrium.equilibrium import Equilibrium
from masonry_fem.march.equilibrium.statics import Statics
from masonry_fem.march.march import march
from masonry_fem.march.measure import measure, moving_blocks
from masonry_fem.march.model import Load, Model
from masonry_fem.march.state import OPEN, SLIP, STICK
from masonry_fem.march.step import initial_state, step
from masonry_fem.nscd import SolverSettings
from masonry_fem.solid.assembly import Assembly, Block, Shape
from masonry_fem.solid.polytope import Polytope
from masonry_fem.solid.pose import Pose

G = 9.81


def stack(count: int, dimension: int = 3, friction: float = 0.6, push: float = 0.0, motion=None) -> Model:
    """``count`` unit cubes on a slab; gravity and a horizontal acceleration ``push``."""
    flat = dimension - 1
    cube = Shape("cube", Polytope.box((0.0,) * dimension, (1.0,) * dimension))
    slab = Shape("slab", Polytope.box((-2.0,) * flat + (-1.0,), (3.0,) * flat + (0.0,)))
    blocks = [Block("ground", 1, Pose.identity(dimension), support=True)]
    blocks += [Block(f"b{i + 1}", 0, Pose.at(*(0.0,) * flat, float(i))) for i in range(count)]
    assembly = Assembly(dimension, (cube, slab), tuple(blocks))
    interfaces = detect(assembly)
    contacts = place(assembly, interfaces, [Rule("corners")] * len(interfaces))
    laws = Assignment.of(Dry(friction), contacts.count)
    stones = RigidGroup(assembly, list(range(1, count + 1)), 1000.0)
    gravity = np.zeros(dimension)
    gravity[0], gravity[-1] = push, -G
    load = Load("gravity", (None, stones.acceleration_force(gravity)), lambda _: 1.0)
    groups = (SupportGroup(assembly, [0], [motion]), stones)
    return Model(assembly, groups, interfaces, contacts, laws, (load,), (), 1.0)


@pytest.mark.parametrize("dimension", [2, 3])
def test_stack_stands_and_the_ground_carries_it(dimension: int) -> None:
    made = march(
        stack(5, dimension), Equilibrium(strategy="brutal_damping", step=0.1), SolverSettings(tolerance=1e-12)
    )
    assert made.outcome == "equilibrium"
    support = made.report.support_resultants["ground"]
    assert support[dimension - 1] == pytest.approx(5000 * G, rel=1e-9)
    assert made.report.block_balance < 1e-9
    assert made.report.global_balance < 1e-9


def test_push_beyond_friction_slides() -> None:
    """With a = 0.5 g and µ = 0.3 a cube slides at 0.2 g."""
    made = march(stack(1, 3, 0.3, 0.5 * G), Dynamics(step=0.01, duration=0.1, theta=0.5), SolverSettings())
    assert made.outcome == "finished"
    assert made.report.speed == pytest.approx(0.2 * G * 0.1, rel=1e-9)
    assert made.ledger.imbalance < 1e-12
    assert made.ledger.friction_dissipation == pytest.approx(0.3 * 1000 * G * 0.5 * 0.2 * G * 0.01, rel=1e-9)


@pytest.mark.parametrize("theta", [0.5, 1.0])
def test_global_balance_holds_while_blocks_speed_up(theta: float) -> None:
    """A cube slides at 0.2 g: the ground does not carry the push, inertia does."""
    made = march(stack(2, 3, 0.3, 0.5 * G), Dynamics(step=0.01, duration=0.1, theta=theta), SolverSettings())
    carried = made.report.support_resultants["ground"] + made.report.applied
    assert np.linalg.norm(carried[:3]) > 0.1 * np.linalg.norm(made.report.applied[:3])
    assert made.report.global_balance < 1e-9


def test_global_balance_tells_a_reaction_that_was_left_out() -> None:
    model = stack(2)
    coupling = connect(model)
    state = initial_state(model, coupling, tuple(group.rest() for group in model.groups))
    made = step(model, coupling, state, Scheme(0.01, 1.0), SolverSettings())
    size = extents(model.assembly)
    assert measure(model, coupling, acted(model, made, size)).global_balance < 1e-9
    less = replace(made, after=replace(made.after, reaction=0.9 * made.after.reaction))
    assert measure(model, coupling, acted(model, less, size)).global_balance == pytest.approx(0.1, rel=1e-6)


def test_global_balance_of_blocks_that_nothing_acts_on() -> None:
    model = replace(stack(2), loads=())
    made = march(model, Dynamics(step=0.01, duration=0.05, theta=0.5), SolverSettings())
    assert made.report.global_balance == 0.0


def test_no_equilibrium_names_the_blocks() -> None:
    made = march(
        stack(2, 3, 0.3, 0.5 * G),
        Equilibrium(strategy="linear_damping", step=0.01, velocity_factor=0.5, max_steps=20),
        SolverSettings(),
    )
    assert made.outcome == "no_equilibrium"
    assert {name for name, _, _ in made.moving} == {"b1", "b2"}
    assert "slide; see what should hold them" in made.message


def test_blocks_drawn_upwards_rise() -> None:
    model = stack(2)
    up = model.groups[1].acceleration_force(np.array([0.0, 0.0, G]))
    model = replace(model, loads=(Load("gravity", (None, up), lambda _: 1.0),))
    made = march(
        model,
        Equilibrium(strategy="linear_damping", step=0.01, velocity_factor=0.5, max_steps=3),
        SolverSettings(),
    )
    assert made.outcome == "no_equilibrium"
    assert {way for _, _, way in made.moving} == {"rises"}
    assert " rise;" in made.message


def test_steps_that_miss_the_tolerance_are_told(caplog) -> None:
    few = SolverSettings(method="nsgs", max_iterations=60)
    march(stack(2, 3, 0.3, 0.1 * G), Dynamics(step=0.01, duration=0.03, theta=1.0), few)
    assert "of 3 steps missed the solver's tolerance 1e-10, the worst with an error of" in caplog.text


def test_an_aim_below_rounding_is_told(caplog) -> None:
    tight = SolverSettings(tolerance=1e-300, acceptable=1e-6)
    made = march(stack(2, 3, 0.3, 0.1 * G), Dynamics(step=0.01, duration=0.03, theta=1.0), tight)
    assert "3 of 3 steps ended at an error of up to" in caplog.text
    assert f"Up to {made.report.rounding:.1e} of it may be rounding" in caplog.text
    assert 0 < made.report.quality.error <= made.report.rounding < 1e-12


def test_moving_support_carries_the_stack() -> None:
    lift = Motion(displacement=lambda t: np.array([0.0, 0.0, 0.1 * t]))
    made = march(stack(2, 3, motion=lift), Dynamics(step=0.01, duration=0.1, theta=1.0), SolverSettings())
    assert made.state.gap == pytest.approx(np.zeros(8), abs=1e-12)
    assert made.report.speed == pytest.approx(0.1, rel=1e-9)


def test_true_statics_of_rigid_blocks() -> None:
    made = march(stack(3), Statics(), SolverSettings())
    assert made.outcome == "equilibrium"
    assert made.report.support_resultants["ground"][2] == pytest.approx(3000 * G, rel=1e-9)


def test_same_bits_twice() -> None:
    one, two = (
        march(stack(3, push=0.2 * G), Dynamics(step=0.01, duration=0.05), SolverSettings()) for _ in range(2)
    )
    assert np.array_equal(one.state.reaction, two.state.reaction)
    assert np.array_equal(one.state.bodies[1].velocity, two.state.bodies[1].velocity)


@pytest.mark.parametrize(("expulsion", "left"), [(0.0, 1e-3), (1e-3, 1e-3 - 1e-3 * 0.1), (0.1, 0.0)])
def test_overlap_is_held_or_driven_apart_slowly(expulsion: float, left: float) -> None:
    """A cube set 1 mm into the ground: held there, or raised at the expulsion speed for 0.1 s."""
    model = replace(stack(1), expulsion=expulsion)
    ground, stones = model.groups
    sunk = stones.rest()
    sunk = replace(sunk, shift=sunk.shift - np.array([0, 0, 1e-3]))
    made = march(
        model,
        Dynamics(step=0.01, duration=0.1, theta=1.0),
        SolverSettings(),
        bodies=(ground.rest(), sunk),
    )
    assert -made.state.gap == pytest.approx(np.full(4, left), abs=1e-9)


@pytest.mark.parametrize(("theta", "impulses"), [(0.5, 4.5), (0.75, 5.25), (1.0, 6.0)])
def test_loads_count_with_theta_where_a_step_ends(theta: float, impulses: float) -> None:
    """A push that grows by 1 m/s² a step, on a cube without friction: v = h Σ (1 − θ) a_i + θ a_{i+1}."""
    model = stack(1, 3, 0.0)
    stones = model.groups[1]
    push = Load(
        "push", (None, stones.acceleration_force(np.array([1.0, 0.0, 0.0]))), lambda time: time / 0.01
    )
    made = march(
        replace(model, loads=(*model.loads, push)),
        Dynamics(step=0.01, duration=0.03, theta=theta),
        SolverSettings(),
    )
    assert made.report.speed == pytest.approx(0.01 * impulses, rel=1e-9)


def test_what_presses_by_rounding_only_is_open() -> None:
    pressed = np.array([[1.0, 0.0], [1e-9, 0.0], [1e-7, 0.0], [1.0, 0.6]])
    assert contact_status(pressed, np.full(4, 0.6)).tolist() == [STICK, OPEN, STICK, SLIP]


def test_a_block_is_as_fast_as_its_fastest_corner() -> None:
    model = stack(1, dimension=2)
    rest = tuple(group.rest() for group in model.groups)
    mass = 1000.0 * np.array([1.0, 1.0, 1.0 / 6.0])
    bodies = (rest[0], replace(rest[1], velocity=np.sqrt(mass)[None] * [1.0, 0.0, 1.0]))
    ((name, speed, way),) = moving_blocks(model, initial_state(model, connect(model), bodies))
    assert (name, way) == ("b1", "tips")
    assert speed == pytest.approx(np.hypot(1.5, 0.5), rel=1e-12)


def test_the_loss_of_adhesion_is_that_of_the_contact_that_loses_most() -> None:
    model = stack(1, dimension=2)
    state = initial_state(model, connect(model), tuple(group.rest() for group in model.groups))
    made = step(model, connect(model), state, Scheme(1.0, 1.0, 0.0), SolverSettings())
    assert made.adhesion_loss == 0.0
    joints = (replace(state.joints, adhesion=np.array(own)) for own in ([1.0, 0.5], [0.7, 0.4]))
    before, after = (replace(state, joints=own) for own in joints)
    assert replace(made, before=before, after=after).adhesion_loss == pytest.approx(0.3)
