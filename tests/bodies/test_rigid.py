"""Rigid blocks: inertia, free spin, finite turns, damping and refusals."""

from dataclasses import replace

import numpy as np
import pytest

from masonry_fem.bodies.base import Scheme
from masonry_fem.bodies.rigid import RigidGroup
from masonry_fem.bodies.rotation import change, exponential
from masonry_fem.errors import GeometryError
from masonry_fem.solid.assembly import Assembly, Block, Shape
from masonry_fem.solid.polytope import Polytope
from masonry_fem.solid.pose import Pose
from tests.bodies.groups import bricks


def box(*size, turn=(0.0, 0.0, 0.0)):
    """One box with a corner at the shape's origin, turned by a rotation vector."""
    d = len(size)
    shape = Shape("box", Polytope.box((0.0,) * d, size))
    pose = Pose(exponential(np.array(turn[: 1 if d == 2 else 3])), np.arange(1.0, d + 1))
    return Assembly(d, (shape,), (Block("box", 0, pose),))


def coast(group, state, scheme, steps):
    """Steps without forces or contacts; yields every state."""
    force = group.acceleration_force(np.zeros(group.dimension))
    for _ in range(steps):
        free = group.free(state, state, force, scheme)
        state = group.advance(state, free, free.rigid_velocity, None, scheme)
        yield state


def test_box_has_its_textbook_inertia():
    group = RigidGroup(box(1.0, 2.0, 3.0, turn=(0.4, -0.2, 0.9)), [0], density=10.0)
    mass = 60.0
    np.testing.assert_allclose(group.mass, [mass])
    np.testing.assert_allclose(np.sort(group.inertia[0]), mass / 12 * np.array([1 + 4, 1 + 9, 4 + 9]))
    flat = RigidGroup(box(1.0, 2.0, turn=(0.7,)), [0], density=10.0)
    np.testing.assert_allclose(flat.inertia, [[20 / 12 * (1 + 4)]])


@pytest.mark.parametrize("dimension", [2, 3])
def test_spin_about_a_principal_axis_is_exact(dimension):
    """n steps turn by n h ω, momentum and energy stay to rounding."""
    assembly = box(*(1.0, 2.0, 3.0)[:dimension])
    group, h, n = RigidGroup(assembly, [0], 2000.0), 0.01, 500
    spin = np.array([2.0]) if dimension == 2 else np.array([0.0, 2.0, 0.0])
    start = group.with_velocity(group.rest(), 0, np.zeros(dimension), spin)
    *_, end = coast(group, start, Scheme(h, 0.5), n)
    np.testing.assert_allclose(end.rotation[0], exponential(n * h * spin), atol=1e-11)
    np.testing.assert_allclose(group.kinetic_energy(end), group.kinetic_energy(start), rtol=1e-13)
    np.testing.assert_allclose(end.shift, start.shift, atol=1e-14)


@pytest.mark.slow
def test_tumbling_box_keeps_momentum_and_energy():
    """Spin near the middle axis (Dzhanibekov): it flips over; L stays exactly, energy does not drift."""
    group, h = RigidGroup(box(1.0, 2.0, 3.0, turn=(0.2, 0.5, -0.3)), [0], 2000.0), 0.01
    spin = group.axes[0] @ np.array([0.01, 3.0, 0.01])
    start = group.with_velocity(group.rest(), 0, np.array([0.1, 0.0, 0.0]), spin)
    states = list(coast(group, start, Scheme(h, 0.5), 5000))
    momentum = np.array([group.angular_momentum(state)[0] for state in states])
    expected = group.angular_momentum(start)[0]
    assert np.abs(momentum - expected).max() <= 1e-11 * np.linalg.norm(expected)
    energy = np.array([group.kinetic_energy(state)[0] for state in states])
    first = group.kinetic_energy(start)[0]
    assert np.abs(energy / first - 1).max() <= 2e-4  # the scheme's h² ripple ...
    assert abs(energy[-1000:].mean() - energy[:1000].mean()) <= 2e-5 * first  # ... has no trend
    along = np.array([state.velocity[0, 4] for state in states])
    assert along.min() < -0.9 * along.max() < 0  # it did flip


@pytest.mark.slow
def test_free_tumbling_converges_with_second_order():
    group = RigidGroup(box(1.0, 2.0, 3.0), [0], 2000.0)
    start = group.with_velocity(group.rest(), 0, np.zeros(3), np.array([1.0, 2.0, -1.5]))

    def attitude(steps):
        *_, end = coast(group, start, Scheme(1.0 / steps, 0.5), steps)
        return end.rotation[0]

    exact = attitude(3200)
    errors = [np.abs(attitude(steps) - exact).max() for steps in (50, 100, 200)]
    rates = np.log2(np.array(errors[:-1]) / errors[1:])
    np.testing.assert_allclose(rates, 2.0, atol=0.1)


def test_modes_stay_mass_orthonormal_while_the_block_turns():
    """½ U·U is the kinetic energy of the velocity field, integrated over the turned box."""
    group = RigidGroup(box(1.0, 2.0, 3.0, turn=(0.2, 0.5, -0.3)), [0], 2000.0)
    start = group.with_velocity(group.rest(), 0, np.array([1.0, -2.0, 0.3]), np.array([1.0, 2.0, -1.5]))
    *_, end = coast(group, start, Scheme(0.02, 0.5), 60)
    # two Gauss points an axis integrate the square of a linear field exactly
    unit = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) / np.sqrt(3)
    local = (0.5 + 0.5 * unit) * [1.0, 2.0, 3.0]
    points = group.assembly.blocks[0].pose.to_world(local)
    now = points + group.displacement(end, 0, points)
    field = group.velocity_map(end, np.zeros(8, dtype=int), now) @ end.velocity[0]
    energy = 0.5 * group.mass[0] / 8 * (field**2).sum()
    np.testing.assert_allclose(group.kinetic_energy(end)[0], energy, rtol=1e-12)


@pytest.mark.parametrize("theta", [0.5, 1.0])
def test_mass_damping_follows_its_own_recursion(theta):
    """u⁺ = u (1 − (1−θ) hα)/(1 + θ hα) for a body that coasts."""
    h, alpha = 0.05, 3.0
    group = RigidGroup(bricks(2), [0, 1], 2000.0, damping=alpha)
    state = group.with_velocity(group.rest(), 1, np.array([1.0, 0.5]), np.array([2.0]))
    free = group.free(state, state, group.no_force(), Scheme(h, theta))
    after = free.rigid_velocity + free.rigid_impulse / free.rigid_mass
    ratio = (1 - (1 - theta) * h * alpha) / (1 + theta * h * alpha)
    np.testing.assert_allclose(after, ratio * state.velocity, atol=1e-12)


def test_eccentric_force_starts_the_right_spin():
    """A force F at arm a over a short step gives v = hF/m and ω = h a×F/J."""
    group, h = RigidGroup(box(1.0, 2.0, 3.0), [0], 10.0), 0.01
    corner, pull = group.nodes(0)[6], np.array([3.0, -5.0, 2.0])
    state = group.rest()
    free = group.free(state, state, group.point_force(0, corner, pull), Scheme(h, 0.5))
    after = group.advance(state, free, free.rigid_impulse, None, Scheme(h, 0.5))
    gained = group.angular_momentum(replace(after, turned=state.turned))[0]  # impulses act in its axes
    np.testing.assert_allclose(gained, h * np.cross(corner - group.centres[0], pull))
    np.testing.assert_allclose(60.0 * (after.shift - state.shift)[0], h**2 / 2 * pull)


@pytest.mark.slow
@pytest.mark.parametrize("dimension", [2, 3])
def test_dead_load_is_conservative_through_large_turns(dimension):
    """A box on a string pull at a corner swings like a pendulum: kinetic energy = F · corner's path.

    The arm is taken at the start of each step, so the error falls with h.
    """
    group = RigidGroup(box(*(1.0, 2.0, 1.5)[:dimension]), [0], 100.0)
    corner, pull = group.nodes(0)[-1], np.array([0.0, -300.0, 100.0])[:dimension]
    load = group.point_force(0, corner, pull) - group.point_force(0, None, pull)  # a couple that turns

    def error(h):
        state, scheme, largest, turned = group.rest(), Scheme(h, 0.5), 0.0, 0.0
        for _ in range(round(3 / h)):
            free = group.free(state, state, load, scheme)
            end = free.rigid_velocity + free.rigid_impulse
            state = group.advance(state, free, end, None, scheme)
            work = pull @ group.displacement(state, 0, corner)
            largest = max(largest, abs(group.kinetic_energy(state)[0] - work))
            turned = max(turned, 3.0 - np.trace(state.rotation[0]) - (3 - dimension))
        assert turned > 2.0  # it went round by more than a right angle
        return largest

    assert error(0.001) / error(0.002) == pytest.approx(0.5, abs=0.05)
    assert error(0.001) < 0.02 * np.linalg.norm(pull)


def test_turned_block_shows_its_corners_where_they_are():
    group = RigidGroup(box(1.0, 2.0), [0], 12.0)
    rest = group.rest()
    quarter = type(rest)(rest.shift, change(np.array([[np.pi / 2]])), rest.velocity)
    corners = group.positions(quarter)
    np.testing.assert_allclose(corners, group.centres[0] + [[1, -0.5], [1, 0.5], [-1, 0.5], [-1, -0.5]])
    assert group.cells(0) == ((3, 0), (1, 2), (0, 1), (2, 3))


def test_shared_shape_is_measured_once(monkeypatch):
    calls = []
    measure = Polytope.mass_properties
    monkeypatch.setattr(Polytope, "mass_properties", lambda solid: calls.append(1) or measure(solid))
    RigidGroup(bricks(3), [0, 1, 2], 2000.0)
    assert len(calls) == 2


def test_inside_out_solid_is_refused():
    shape = Polytope.box((0.0, 0.0), (1.0, 1.0))
    turned = Polytope(shape.vertices, tuple((b, a) for a, b in shape.faces))
    assembly = Assembly(2, (Shape("stone", turned),), (Block("s", 0, Pose.identity(2)),))
    with pytest.raises(GeometryError, match="shape 'stone': volume is -1, expected > 0"):
        RigidGroup(assembly, [0], 2000.0)


def test_bad_density_is_refused():
    with pytest.raises(GeometryError, match="block 'b1': density is -1"):
        RigidGroup(bricks(2), [0, 1], np.array([2000.0, -1.0]))


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_static_step_led_on_from_another_place_says_what_leads_there_at_once(dimension):
    """Where a round of statics goes on from where the last one led, far from the step's start."""
    random = np.random.default_rng(dimension)
    group, scheme = RigidGroup(box(*(1.0, 2.0, 3.0)[:dimension]), [0], 2000.0), Scheme(0.25, 1.0, 0.0)
    force = group.no_force()

    def led(state, guess, velocity):
        return group.advance(state, group.free(state, guess, force, scheme), velocity, None, scheme)

    first, second, third = 30.0 * random.normal(size=(3, *group.rest().velocity.shape))
    state = replace(led(group.rest(), group.rest(), first), velocity=np.zeros_like(first))
    guess = led(state, state, second)
    there = led(state, guess, third)
    assert np.abs(there.shift - guess.shift).max() > 1e-2
    at_once = led(state, state, there.velocity)
    np.testing.assert_allclose(at_once.shift, there.shift, atol=1e-12)
    np.testing.assert_allclose(at_once.rotation, there.rotation, atol=1e-12)
    kept = led(state, guess, guess.velocity)  # nothing beyond the guess
    np.testing.assert_allclose(kept.shift, guess.shift, atol=1e-12)
    np.testing.assert_allclose(kept.velocity, guess.velocity, rtol=1e-9)
