"""Supports: they are where their motion says, and their velocities lead there."""

import numpy as np
import pytest

from masonry_fem.bodies.base import Scheme, by_block
from masonry_fem.bodies.rotation import exponential
from masonry_fem.bodies.support import Motion, SupportGroup
from masonry_fem.errors import SceneError
from tests.bodies.groups import bricks, sides_of


def march(group, scheme, steps):
    """States and the Free of each step."""
    state, force = group.rest(), group.no_force()
    for _ in range(steps):
        free = group.free(state, state, force, scheme)
        after = group.advance(state, free, free.rigid_velocity, None, scheme)
        yield state, free, after
        state = after


@pytest.mark.parametrize("dimension", [2, 3])
def test_support_without_motion_stays(dimension):
    group = SupportGroup(bricks(dimension), [0, 2])
    *_, (_, free, after) = march(group, Scheme(0.1, 0.5), 3)
    assert not free.rigid_velocity.any()
    assert not by_block(group, group.displacements(after))[1].any()
    assert after.time == pytest.approx(0.3)
    assert group.prescribed
    assert not group.mass.any()


@pytest.mark.parametrize("theta", [0.5, 0.7, 1.0])
def test_theta_rule_leads_exactly_to_the_prescribed_place(theta):
    """q + h[(1−θ) u + θ u⁺] is the prescribed q⁺, for a smooth and for a kinked motion."""

    def shake(time):
        return np.array([0.1 * np.sin(7 * time), 0.02 * time**2, min(time, 0.25)])

    group, h = SupportGroup(bricks(3), [0], [Motion(displacement=shake)]), 0.05
    for state, free, after in march(group, Scheme(h, theta), 20):
        mean = (1 - theta) * state.velocity + theta * free.rigid_velocity
        np.testing.assert_allclose(state.shift + h * mean[:, :3], after.shift, atol=1e-13)
        moved = by_block(group, group.displacements(after))[0]
        np.testing.assert_allclose(moved, np.broadcast_to(shake(after.time), moved.shape), atol=1e-13)


@pytest.mark.parametrize("theta", [0.5, 0.7, 1.0])
def test_end_velocity_is_the_motions_own(theta):
    """No alternating error: u⁺ is q̇(t+h) to second order for every step of a smooth motion."""
    group = SupportGroup(bricks(2), [0], [Motion(displacement=lambda t: np.array([np.sin(t), 0.0]))])

    def worst(h):
        order = h**2 if theta == 0.5 else h
        steps = march(group, Scheme(h, theta), round(2 / h))
        return max(abs(free.rigid_velocity[0, 0] - np.cos(after.time)) for _, free, after in steps) / order

    assert worst(0.1) <= 1.0
    assert worst(0.01) <= 1.0


@pytest.mark.parametrize("h", [1e-4, 1e-2, 1.0])
def test_velocity_that_a_step_goes_on_with_is_the_motions_derivative(h):
    """Where θ < 1: by differences over 1e-4 of the step, so to 1e-7 whatever its length."""
    motion = Motion(displacement=lambda t: np.array([np.sin(t), 0.0]), rotation=lambda t: 0.2 * np.cos(t))
    group = SupportGroup(bricks(2), [0], [motion])
    for _, _, after in march(group, Scheme(h, 0.5), 5):
        expected = [[np.cos(after.time), 0.0, -0.2 * np.sin(after.time)]]
        np.testing.assert_allclose(after.velocity, expected, atol=1e-7)


def test_constant_speed_with_a_sudden_start_does_not_ring():
    ramp = Motion(displacement=lambda t: np.array([0.0, -0.5 * t]))
    group = SupportGroup(bricks(2), [0], [ramp])
    for _, free, after in march(group, Scheme(0.1, 0.5), 10):
        np.testing.assert_allclose(free.rigid_velocity, [[0.0, -0.5, 0.0]], atol=1e-9)
        np.testing.assert_allclose(after.velocity, [[0.0, -0.5, 0.0]], atol=1e-9)


def test_a_jump_at_the_start_is_made_in_the_first_step():
    group = SupportGroup(bricks(2), [0], [Motion(displacement=lambda t: np.array([0.0, -0.01]))])
    assert not group.displacements(group.rest()).any()
    (_, free, after), (_, later, _) = march(group, Scheme(0.5, 1.0, 0.0), 2)
    np.testing.assert_allclose(free.rigid_velocity, [[0.0, -0.02, 0.0]], atol=1e-14)
    np.testing.assert_allclose(after.velocity, free.rigid_velocity)
    np.testing.assert_allclose(later.rigid_velocity, 0.0, atol=1e-14)


@pytest.mark.parametrize("dimension", [2, 3])
def test_turn_about_a_pivot(dimension):
    """Points circle about the pivot; contact velocities have the spin's direction and size."""
    pivot = np.array([0.3, -0.4, 1.0])[:dimension]
    axis = np.array([0.0, 0.6, 0.8]) if dimension == 3 else np.array([1.0])
    motion = Motion(rotation=lambda t: 0.2 * t * axis, pivot=pivot)
    assembly = bricks(dimension)
    group, scheme = SupportGroup(assembly, [1], [motion]), Scheme(0.1, 0.5)
    sides = sides_of(group, assembly)
    attachment = group.attach(sides)
    for state, free, after in march(group, scheme, 30):
        turn = exponential(0.2 * after.time * axis)
        expected = pivot + (sides.point - pivot) @ turn.T
        np.testing.assert_allclose(sides.point + attachment.displacements(after), expected, atol=1e-12)
        np.testing.assert_allclose(free.rigid_velocity[0, dimension:], 0.2 * axis, atol=1e-9)
        now = sides.point + attachment.displacements(state)
        world = np.broadcast_to(np.eye(dimension), sides.frame.shape)
        velocity = attachment.rigid_map(state, now, world) @ free.rigid_velocity[0]
        arms = now - pivot
        spin = 0.2 * axis
        turning = (
            np.cross(spin, arms) if dimension == 3 else spin * np.column_stack([-arms[:, 1], arms[:, 0]])
        )
        np.testing.assert_allclose(velocity, turning, atol=1e-9)


def test_plane_rotation_may_be_a_plain_number():
    group = SupportGroup(bricks(2), [0], [Motion(rotation=lambda t: 0.1 * t)])
    *_, (_, _, after) = march(group, Scheme(0.5, 1.0), 2)
    np.testing.assert_allclose(after.rotation[0], exponential(np.array([0.1])), atol=1e-15)


def test_supports_take_loads_and_impulses_without_an_answer():
    assembly = bricks(3)
    group = SupportGroup(assembly, [0, 1])
    state, scheme = group.rest(), Scheme(0.1, 0.5)
    assert not group.acceleration_force(np.array([0.0, 0.0, -9.81])).any()
    assert not group.traction_force(0, 5, np.ones(3)).any()
    assert not group.point_force(0, None, np.ones(3)).any()
    push = np.ones((2, 6))
    assert not group.imbalance(state, state, state, group.no_force(), push, None, scheme).any()
    assert not group.kinetic_energy(state).any()
    assert not group.step_energy(state, state, group.no_force(), None, scheme).external.any()
    assert group.attach(sides_of(group, assembly)).compliance(scheme, np.zeros((8, 3, 3))) == ()


def test_wrong_input_is_refused():
    with pytest.raises(SceneError, match="1 motions for 2 blocks"):
        SupportGroup(bricks(2), [0, 1], [None])
    with pytest.raises(SceneError, match=r"support 'b2': displacement has shape \(3,\), expected \(2,\)"):
        SupportGroup(bricks(2), [2], [Motion(displacement=lambda t: np.zeros(3))])
    group = SupportGroup(bricks(2), [0])
    with pytest.raises(SceneError, match="support 'b0': initial velocity"):
        group.with_velocity(group.rest(), 0, np.ones(2), np.zeros(1))
