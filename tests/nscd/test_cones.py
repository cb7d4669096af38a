"""Algebra of second-order cones: its identities, on random points inside."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from masonry_fem.nscd.solvers import cones

E = np.array([1.0, 0.0, 0.0])


def inside(rng, count, d):
    """Points inside, some of them near the boundary."""
    tangent = rng.normal(size=(count, d - 1)) * 10.0 ** rng.uniform(-3, 3, (count, 1))
    size = np.linalg.norm(tangent, axis=1, keepdims=True)
    return np.concatenate([size * (1 + 10.0 ** rng.uniform(-4, 1, (count, 1))), tangent], axis=1)


@given(seed=st.integers(0, 10**6), d=st.sampled_from([2, 3]))
def test_quotient_and_inverse_undo_the_product(seed, d):
    rng = np.random.default_rng(seed)
    x, y = inside(rng, 8, d), rng.normal(size=(8, d))
    recovered = cones.product(x, cones.quotient(x, y))
    np.testing.assert_allclose(recovered, y, atol=1e-9 * np.abs(y).max())
    np.testing.assert_allclose(cones.product(x, cones.inverse(x)), np.tile(E[:d], (8, 1)), atol=1e-8)


@given(seed=st.integers(0, 10**6), d=st.sampled_from([2, 3]))
def test_scaling_maps_both_to_one_point(seed, d):
    rng = np.random.default_rng(seed)
    x, z = inside(rng, 8, d), inside(rng, 8, d)
    forth, back = cones.scaling(x, z)
    np.testing.assert_allclose(forth @ back, np.tile(np.eye(d), (8, 1, 1)), atol=1e-5)
    one = (back @ x[:, :, None])[:, :, 0]
    other = (forth @ z[:, :, None])[:, :, 0]
    size = np.linalg.norm(other, axis=1, keepdims=True)
    np.testing.assert_allclose(one / size, other / size, atol=1e-6)


@given(seed=st.integers(0, 10**6), d=st.sampled_from([2, 3]))
def test_longest_step_ends_on_a_boundary(seed, d):
    """In a direction outside the cone: points are inside by their normal part less the tangential one."""
    rng = np.random.default_rng(seed)
    x = inside(rng, 1, d)
    change = rng.normal(size=(1, d))
    change[:, 0] = rng.uniform(-2.0, 0.99) * np.linalg.norm(change[:, 1:])
    change *= x[:, :1]
    length = cones.longest_step(x, change)
    assert 0 < length < np.inf
    before, after = x + 0.999 * length * change, x + 1.001 * length * change
    assert before[0, 0] - np.linalg.norm(before[0, 1:]) > 0
    assert after[0, 0] - np.linalg.norm(after[0, 1:]) < 0


@given(seed=st.integers(0, 10**6), d=st.sampled_from([2, 3]))
def test_steps_in_a_direction_inside_the_cone_have_no_end(seed, d):
    rng = np.random.default_rng(seed)
    assert cones.longest_step(inside(rng, 1, d), inside(rng, 1, d)) == np.inf


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ((-1.0, 0, 0), 1.0),
        ((0.0, 2, 0), 0.5),
        ((1.0, 0, 0), np.inf),
        ((1.0, 1, 0), np.inf),
        ((-1.0, 1, 0), 0.5),
    ],
)
def test_longest_step_from_the_axis(change, expected):
    assert cones.longest_step(np.array([E]), np.array([change])) == pytest.approx(expected)
