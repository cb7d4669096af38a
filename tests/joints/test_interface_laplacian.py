"""−Δ among the points of interfaces: closed forms, and what an M-matrix promises."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from masonry_fem.joints import FremondCangemi, probe
from masonry_fem.joints.spreading import interface_laplacian
from tests.joints.samples import path_laplacian

C, ENERGY = 1e10, 50.0
U0 = np.sqrt(ENERGY / C)


def line(count, length=1.0):
    """Points of a plane joint with the areas of linear elements."""
    x = np.linspace(0, length, count)[:, None]
    area = np.full(count, length / (count - 1))
    area[[0, -1]] /= 2
    return x, area


def grid(nx, ny, sizes=(1.0, 0.5)):
    axes = [np.linspace(0, size, n) for size, n in zip(sizes, (nx, ny), strict=True)]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
    sides = [np.where((np.arange(n) == 0) | (np.arange(n) == n - 1), 0.5, 1.0) * size / (n - 1)
             for n, size in zip((nx, ny), sizes, strict=True)]  # fmt: skip
    return points, np.multiply.outer(*sides).ravel()


def one(points):
    return np.zeros(len(points), dtype=np.int64)


def test_a_row_is_the_second_difference():
    points, area = line(9)
    matrix = interface_laplacian(points, area, one(points)).toarray()
    np.testing.assert_allclose(matrix[1:-1], path_laplacian(0.125, 9).toarray()[1:-1], atol=1e-9)
    # at a free end half the area bears the same flow
    np.testing.assert_allclose(matrix[0, :2], np.array([2, -2]) * 64)


def test_a_grid_is_the_stencil_of_five_points():
    points, area = grid(6, 5)
    matrix = interface_laplacian(points, area, one(points)).toarray()
    inside = (points[:, 0] > 0) & (points[:, 0] < 1) & (points[:, 1] > 0) & (points[:, 1] < 0.5)
    squares = points[:, 0] ** 2 + 3 * points[:, 1] ** 2
    np.testing.assert_allclose((matrix @ squares)[inside], -8.0, rtol=1e-9)
    assert ((matrix != 0).sum(axis=1)[inside] == 5).all()


def test_linear_fields_have_none_inside():
    rng = np.random.default_rng(2)
    edge = np.linspace(0, 1, 6)
    square = np.concatenate([[(x, 0), (x, 1), (0, x), (1, x)] for x in edge]).reshape(-1, 2)
    points = np.concatenate([np.unique(square, axis=0), rng.uniform(0.1, 0.9, (40, 2))])
    matrix = interface_laplacian(points, np.ones(len(points)), one(points))
    inside = (points > 0).all(axis=1) & (points < 1).all(axis=1)
    assert np.abs(matrix @ (points @ [2.0, -1.0]))[inside].max() < 1e-9


@given(seed=st.integers(0, 10**6), dimension=st.sampled_from([1, 2]), count=st.integers(1, 25))
def test_it_is_an_m_matrix_and_knows_no_numbering(seed, dimension, count):
    rng = np.random.default_rng(seed)
    points, area = rng.uniform(size=(count, dimension)), rng.uniform(0.1, 1, count)
    interface = rng.integers(0, 3, count)
    matrix = interface_laplacian(points, area, interface).toarray()
    off = matrix - np.diag(np.diag(matrix))
    assert (off <= 0).all()
    assert np.abs(matrix.sum(axis=1)).max() <= 1e-12 * max(np.abs(matrix).max(), 1)
    weights = area[:, None] * off
    np.testing.assert_allclose(weights, weights.T, atol=1e-12 * max(np.abs(weights).max(), 1))
    assert not off[interface[:, None] != interface].any()
    order = rng.permutation(count)
    again = interface_laplacian(points[order], area[order], interface[order]).toarray()
    np.testing.assert_allclose(
        again, matrix[np.ix_(order, order)], rtol=1e-7, atol=1e-6 * np.abs(matrix).max()
    )


def test_points_on_a_line_in_space():
    """Two points, and three on an edge: no triangle has an area."""
    for count in (2, 3, 4):
        along, area = line(count)
        points = along @ np.array([[0.6, 0.8]])
        np.testing.assert_allclose(
            interface_laplacian(points, area, one(points)).toarray(),
            interface_laplacian(along, area, one(points)).toarray(),
            atol=1e-9,
        )


def test_flat_triangles_of_the_hull_bind_nothing():
    """Points on the edge of a face lie on a line to rounding only."""
    points, area = grid(5, 4)
    shaken = points + np.random.default_rng(1).uniform(-1e-14, 1e-14, points.shape)
    one_matrix, other = (interface_laplacian(p, area, one(p)).toarray() for p in (points, shaken))
    np.testing.assert_allclose(other, one_matrix, atol=1e-6 * np.abs(one_matrix).max())


def law(points, area, gradient):
    return FremondCangemi(normal_stiffness=C, tangential_stiffness=C, energy=ENERGY, gradient=gradient,
                          laplacian=interface_laplacian(points, area, one(points)))  # fmt: skip


def beside_a_broken_point(x, broken, points, area, gradient, stretch=1.5):
    """β along x of a joint stretched evenly, where some points are broken."""
    own = law(points, area, gradient)
    state = own.initial(len(points), points.shape[1] + 1)
    state.adhesion[broken] = 0.0
    path = np.zeros((1, len(points), points.shape[1] + 1))
    path[..., 0] = stretch * U0
    history = probe(own, path, state=state)
    exact = (1 - np.exp(-x * np.sqrt(ENERGY * stretch**2 / gradient))) / stretch**2
    return history.adhesion[0], exact


def test_damage_spreads_as_far_as_the_root_of_k_over_y():
    """β = (w/Y)(1 − exp(−x√(Y/k))) along a row of uneven spacing, and along a strip of triangles."""
    for gradient in (5e-3, 2e-2):  # √(k/Y) = 6.7 mm, 13.3 mm
        x = 0.2 * np.linspace(0, 1, 201) ** 1.5
        area = np.gradient(x)
        beta, exact = beside_a_broken_point(x, x == 0, x[:, None], area, gradient)
        assert np.abs(beta - exact).max() < 2e-3
        points, areas = grid(161, 4, (0.2, 0.01))
        beta, exact = beside_a_broken_point(points[:, 0], points[:, 0] == 0, points, areas, gradient)
        assert np.abs(beta - exact).max() < 2e-3


def test_what_damage_burns_is_surface_energy_and_gradient():
    """Work never comes back: each step gives up w Δβ and stores ½k∫|∇β|², but for second order."""
    rng = np.random.default_rng(6)
    points, area = grid(7, 6)
    path = np.zeros((10, len(points), 3))
    path[..., 0] = U0 * rng.uniform(0, 3, (10, len(points)))
    gradient = 1.0
    own = law(points, area, gradient)
    history = probe(own, path)
    assert history.settled.all()
    adhesion = np.concatenate([np.ones((1, len(points))), history.adhesion])
    fallen = -np.diff(adhesion, axis=0)
    assert (fallen >= 0).all()
    assert (np.diff(history.dissipated, axis=0, prepend=0.0) >= 0).all()

    def bent(beta):
        return 0.5 * gradient * np.einsum("nc,nc->n", beta * area, (own.laplacian @ beta.T).T)

    burnt = np.diff(history.dissipated, axis=0, prepend=0.0) @ area
    stored = np.diff(bent(adhesion))
    assert burnt == pytest.approx(ENERGY * fallen @ area + stored + bent(fallen), rel=1e-9, abs=1e-12)
