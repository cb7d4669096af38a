"""Recovered stress and the error estimate made of it, for every kind of cell."""

from itertools import product
from math import factorial

import numpy as np
import pytest

from masonry_fem.fem import error_estimate, imbalance
from masonry_fem.fem.error_estimate import ErrorEstimate, comparison, energy_density
from masonry_fem.fem.lagrange import is_simplex, lagrange, order, quadrature
from masonry_fem.fem.material import ElasticMaterial
from masonry_fem.fem.recovery import superconvergent
from masonry_fem.fem.stress import StressRecovery
from tests.fem.cantilever import solved, true_square
from tests.fem.meshes import CELLS, box_mesh, dimension_of

STONE = ElasticMaterial(10e9, 0.2, 2400.0)


def _gauss_points(mesh):
    points, _ = quadrature(mesh.cell)
    places = np.einsum("pk,mkd->mpd", lagrange(mesh.cell).values(points), mesh.points[mesh.cells])
    return places.reshape(-1, mesh.dimension)


def _polynomial(points, degree):
    """A polynomial with all terms up to a degree."""
    d = points.shape[1]
    exponents = [e for e in product(range(degree + 1), repeat=d) if sum(e) <= degree]
    weights = np.random.default_rng(3).uniform(-1, 1, len(exponents))
    return sum(w * np.prod(points ** np.array(e), axis=1) for w, e in zip(weights, exponents, strict=True))


@pytest.mark.parametrize("cell", CELLS)
@pytest.mark.parametrize("count", [2, 3])
def test_recovery_has_polynomials_of_the_elements_order(cell, count):
    """Straight meshes of unequal cells, surface and corners too."""
    d = dimension_of(cell)
    mesh = box_mesh(cell, (count,) * d, (0.0,) * d, (1.0, 0.7, 1.3)[:d])
    found = superconvergent(mesh) @ _polynomial(_gauss_points(mesh), order(cell))
    assert found == pytest.approx(_polynomial(mesh.points, order(cell)), abs=1e-6)


@pytest.mark.parametrize("cell", CELLS)
def test_recovery_of_a_uniform_stress_on_any_mesh(cell):
    d = dimension_of(cell)
    for counts in ((1,) * d, (3, *(1,) * (d - 1)), (4,) * d):
        mesh = box_mesh(cell, counts, (0.0,) * d, (1.0,) * d, distort=0.2)
        matrix = superconvergent(mesh)
        assert matrix @ np.ones(matrix.shape[1]) == pytest.approx(np.ones(len(mesh.points)), abs=1e-6)


def test_one_quadratic_cell_across_takes_no_square_from_nowhere():
    """Two samples across cannot tell y² from 1: the lower term has it."""
    mesh = box_mesh("quad9", (6, 1), (0.0, 0.0), (6.0, 1.0))
    height = _gauss_points(mesh)[:, 1]
    assert superconvergent(mesh) @ height == pytest.approx(mesh.points[:, 1], abs=1e-6)
    assert (superconvergent(mesh) @ height**2).max() <= 1.0


@pytest.mark.parametrize("cell", CELLS)
def test_comparison_integrates_squares(cell):
    points, weights = comparison(cell)
    d = points.shape[1]
    for exponents in product(range(2 * order(cell) + 1), repeat=d):
        simplex = is_simplex(cell)
        if simplex and sum(exponents) > 2 * order(cell):
            continue
        if simplex:
            exact = np.prod([factorial(e) for e in exponents]) / factorial(sum(exponents) + d)
        else:
            exact = np.prod([1 / (e + 1) for e in exponents])
        assert weights @ np.prod(points ** np.array(exponents), axis=1) == pytest.approx(exact, rel=1e-12)


@pytest.mark.parametrize("cell", CELLS)
def test_uniform_strain_has_no_error(cell):
    d = dimension_of(cell)
    mesh = box_mesh(cell, (2, *(3,) * (d - 1)), (0.0,) * d, (1.0,) * d, distort=0.2)
    strain = 1e-4 * np.random.default_rng(1).uniform(-1, 1, (d, d))
    moved = (mesh.points @ strain).ravel()[None]
    recovery = StressRecovery.of(mesh, STONE, "strain" if d == 2 else None)
    gauss = recovery.gauss_stress(moved)
    squares = ErrorEstimate.of(mesh, STONE).squares(gauss)
    norm = (energy_density(gauss, STONE)[0] * recovery.weight).sum()
    assert squares.sum() <= 1e-10 * norm


def test_density_is_that_of_strain_times_stress():
    """In 3D and, with the σ_zz that they have, in plane strain and plane stress."""
    for d, plane in ((3, None), (2, "strain"), (2, "stress")):
        gradient = 1e-4 * np.random.default_rng(d).uniform(-1, 1, (d, d))
        stress = np.einsum("sij,ij->s", STONE.stress_matrix(d, plane), gradient)
        tensor = stress[[0, 3, 5, 3, 1, 4, 5, 4, 2]].reshape(3, 3)[:d, :d]
        strain = (gradient + gradient.T) / 2
        assert energy_density(stress, STONE) == pytest.approx((tensor * strain).sum(), rel=1e-12)


def test_blocks_are_taken_in_portions_without_a_difference(monkeypatch):
    mesh = box_mesh("quad", (3, 3), (0.0, 0.0), (1.0, 1.0))
    recovery = StressRecovery.of(mesh, STONE, "strain")
    gauss = recovery.gauss_stress(np.random.default_rng(2).normal(size=(5, mesh.points.size)))
    estimate = ErrorEstimate.of(mesh, STONE)
    whole = estimate.squares(gauss)
    monkeypatch.setattr(error_estimate, "AT_ONCE", 1)
    assert estimate.squares(gauss) == pytest.approx(whole, rel=1e-12)


@pytest.mark.parametrize("cell", ["tetra", "hexahedron", "hexahedron27"])
def test_cells_are_taken_in_portions_without_a_difference(monkeypatch, cell):
    mesh = box_mesh(cell, (2, 2, 3), (0.0, 0.0, 0.0), (1.0, 1.0, 1.0), distort=0.2)
    recovery = StressRecovery.of(mesh, STONE, None)
    gauss = recovery.gauss_stress(np.random.default_rng(2).normal(size=(2, mesh.points.size)))
    whole = ErrorEstimate.of(mesh, STONE).squares(gauss)
    monkeypatch.setattr(error_estimate, "CELLS", 5)
    monkeypatch.setattr(imbalance, "AT_ONCE", 5)
    assert ErrorEstimate.of(mesh, STONE).squares(gauss) == pytest.approx(whole, rel=1e-12)


def _estimated(mesh, material, moved):
    plane = "stress" if mesh.dimension == 2 else None
    gauss = StressRecovery.of(mesh, material, plane).gauss_stress(moved[None])
    return float(ErrorEstimate.of(mesh, material).squares(gauss).sum())


@pytest.mark.parametrize("distort", [0.0, 0.2])
@pytest.mark.parametrize("cell", CELLS)
def test_cantilever_effectivity(cell, distort):
    """Estimated over true error of a beam of known stress: issue 6 asks for 0.7 to 1.4."""
    mesh, material, moved = solved(cell, 4, distort)
    effectivity = np.sqrt(_estimated(mesh, material, moved) / true_square(mesh, material, moved))
    assert 0.85 <= effectivity <= 1.1


@pytest.mark.parametrize(
    ("cell", "counts"),
    [("triangle", (16, 32)), ("quad", (8, 16)), ("triangle6", (4, 8)), ("quad9", (4, 8)),
     pytest.param("tetra", (8, 16), marks=pytest.mark.slow), ("hexahedron", (4, 8)),
     pytest.param("tetra10", (4, 8), marks=pytest.mark.slow),
     pytest.param("hexahedron27", (4, 8), marks=pytest.mark.slow)],
)  # fmt: skip
def test_cantilever_orders(cell, counts):
    """Energy norm of error and estimate: order 1 for linear, 2 for quadratic elements."""
    true, estimated = [], []
    for n in counts:
        mesh, material, moved = solved(cell, n)
        true.append(true_square(mesh, material, moved))
        estimated.append(_estimated(mesh, material, moved))
    for squares in (true, estimated):
        assert np.log2(squares[0] / squares[1]) / 2 == pytest.approx(order(cell), abs=0.12)
