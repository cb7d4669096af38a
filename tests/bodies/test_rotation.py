"""Rotation vectors and matrices against SciPy, and their limits."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

from masonry_fem.bodies.rotation import chained, change, exponential, lever, logarithm, moment

VECTORS = arrays(float, (5, 3), elements=st.floats(-1.8, 1.8, allow_subnormal=False))  # |v| < π


@given(VECTORS)
def test_exponential_agrees_with_scipy_and_logarithm_inverts_it(vectors):
    rotations = exponential(vectors)
    np.testing.assert_allclose(rotations, Rotation.from_rotvec(vectors).as_matrix(), atol=1e-14)
    np.testing.assert_allclose(logarithm(rotations), vectors, atol=1e-13)


@pytest.mark.parametrize("angle", [0.0, 1e-12, 1e-6, 0.99e-4, 1.01e-4, 0.1, 3.0, np.pi])
def test_angles_small_and_large(angle):
    axis = np.array([2.0, -1.0, 2.0]) / 3
    rotation = exponential(angle * axis)
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-15)
    np.testing.assert_allclose(rotation, Rotation.from_rotvec(angle * axis).as_matrix(), atol=1e-15)
    back = logarithm(rotation)
    sign = np.sign(back @ axis) if angle > 3.1 else 1.0  # half a turn has two vectors
    np.testing.assert_allclose(sign * back, angle * axis, rtol=1e-14, atol=1e-16)


def test_plane_angles():
    np.testing.assert_allclose(exponential(np.array([np.pi / 6])), [[0.75**0.5, -0.5], [0.5, 0.75**0.5]])
    np.testing.assert_allclose(logarithm(exponential(np.array([[-2.0], [0.3]]))), [[-2.0], [0.3]])


def test_lever_is_spin_cross_arm_and_its_transpose_the_moment():
    random = np.random.default_rng(0)
    arms, spins, forces = random.normal(size=(3, 4, 3))
    velocity = np.einsum("kdr,kr->kd", lever(arms), spins)
    np.testing.assert_allclose(velocity, np.cross(spins, arms))
    np.testing.assert_allclose(moment(arms, forces), np.cross(arms, forces))
    flat = moment(np.array([2.0, 3.0]), np.array([5.0, 7.0]))
    np.testing.assert_allclose(flat, [2 * 7 - 3 * 5])


@pytest.mark.parametrize("dimension", [2, 3])
def test_rounding_does_not_accumulate(dimension):
    turn = change(np.full((1, 1 if dimension == 2 else 3), 0.1))
    turned = np.zeros((1, dimension, dimension))
    for _ in range(20_000):
        turned = chained(turned, turn)
    rotation = np.eye(dimension) + turned
    np.testing.assert_allclose(rotation[0].T @ rotation[0], np.eye(dimension), atol=1e-14)
