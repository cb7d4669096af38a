"""Projection on the cone and the Alart–Curnier function."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from masonry_fem.nscd.graphs import augmented_velocity, natural_map, project_cone
from masonry_fem.nscd.solvers.linearisation import linearise


@given(st.sampled_from([2, 3]), st.integers(0, 10**6), st.sampled_from([0.0, 0.3, 1.0, 1e6]))
def test_projection_is_the_nearest_point(d, seed, mu):
    rng = np.random.default_rng(seed)
    x, friction = rng.normal(size=(40, d)), np.full(40, mu)
    p = project_cone(x, friction)
    assert (np.linalg.norm(p[:, 1:], axis=1) <= mu * p[:, 0] * (1 + 1e-14)).all()
    # Moreau: what is left is orthogonal to p and in the polar cone
    left = x - p
    assert np.abs((left * p).sum(axis=1)).max() <= 1e-12 * max(1, mu)
    assert (mu * np.linalg.norm(left[:, 1:], axis=1) <= -left[:, 0] + 1e-12 * max(1, mu)).all()
    assert project_cone(p, friction) == pytest.approx(p, abs=1e-12)


@given(st.sampled_from([2, 3]), st.integers(0, 10**6), st.sampled_from([0.0, 0.3, 1.0, 30.0]))
def test_natural_map_is_the_way_to_the_nearest_point(d, seed, mu):
    """p − P_K(p − v̂/w), by the projection itself; also where p, v or both are nothing."""
    rng = np.random.default_rng(seed)
    p, v = rng.normal(size=(40, d)), rng.normal(size=(40, d))
    p[:5], v[3:8], p[10:20, 1:], v[15:20, 1:] = 0.0, 0.0, 0.0, 0.0
    friction, scale = np.full(40, mu), rng.uniform(0.1, 10, 40)
    x = p - augmented_velocity(v, friction) / scale[:, None]
    size = np.abs(x).max()
    assert natural_map(p, v, friction, scale) == pytest.approx(
        p - project_cone(x, friction), abs=1e-13 * size
    )


@pytest.mark.parametrize("d", [2, 3])
def test_derivatives_are_those_of_differences(d):
    rng = np.random.default_rng(d)
    c = 200
    p, v, mu, rho = (
        rng.normal(size=(c, d)),
        rng.normal(size=(c, d)),
        rng.uniform(0, 1, c),
        rng.uniform(0.5, 2, c),
    )
    line = linearise(p, v, mu, rho)
    assert 0 < line.open.sum() < c
    assert 0 < line.plain.sum() < c
    step = 1e-7

    def residual(p, v):
        return linearise(p, v, mu, rho).residual

    for axis in range(d):
        e = step * np.eye(d)[axis]
        by_p = (residual(p + e, v) - residual(p - e, v)) / (2 * step)
        by_v = (residual(p, v + e) - residual(p, v - e)) / (2 * step) / rho[:, None]
        assert by_p == pytest.approx(line.by_impulse[:, :, axis], abs=1e-6)
        assert by_v == pytest.approx(line.by_velocity[:, :, axis], abs=1e-6)
    assert np.array_equal(line.residual[line.open], p[line.open])
    trial = p - rho[:, None] * v
    assert np.array_equal(line.residual[line.plain], (p - trial)[line.plain])  # as exact as p, not as v


def test_both_functions_vanish_on_the_graphs():
    mu = np.array([0.5, 0.5, 0.5])
    p = np.array([[0.0, 0, 0], [2.0, 0.3, -0.2], [2.0, 0.6, 0.8]])
    v = np.array([[1.0, -2, 3], [0.0, 0, 0], [0.0, -3, -4]])  # open, stick, slip
    assert linearise(p, v, mu, np.full(3, 0.7)).residual == pytest.approx(0, abs=1e-15)
    assert natural_map(p, v, mu, np.full(3, 1.3)) == pytest.approx(0, abs=1e-15)
    against = v * [1, -1, -1]  # friction that drives
    assert np.abs(linearise(p, against, mu, np.full(3, 0.7)).residual[2]).max() > 0.1
    assert np.abs(natural_map(p, against, mu, np.full(3, 1.3))[2]).max() > 0.1
