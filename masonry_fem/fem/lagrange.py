"""Lagrange: shape functions of cells and facets in VTK node order, and their quadrature.

    element = lagrange("hexahedron27")
    element.values(points), element.gradients(points)     # (p, nodes), (p, nodes, t)
    points, weights = quadrature("hexahedron27")

Reference cells are [0, 1]^t or the unit simplex. Shape functions are found by inverting the matrix of
monomials at the nodes, so that a kind of cell is defined by the list of its nodes alone.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from itertools import product

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

_CORNERS = {
    "line": [(0,), (1,)],
    "triangle": [(0, 0), (1, 0), (0, 1)],
    "quad": [(0, 0), (1, 0), (1, 1), (0, 1)],
    "tetra": [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)],
    "hexahedron": [
        (0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1),
    ],
}  # fmt: skip
# second-order nodes as means of corners: edges, then faces, then the middle
_RING = [(0, 1), (1, 2), (2, 3), (3, 0)]
_MEANS: dict[str, tuple[str, list[tuple[int, ...]]]] = {
    "line3": ("line", [(0, 1)]),
    "triangle6": ("triangle", [(0, 1), (1, 2), (2, 0)]),
    "quad9": ("quad", [*_RING, (0, 1, 2, 3)]),
    "tetra10": ("tetra", [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]),
    "hexahedron27": (
        "hexahedron",
        [
            *_RING, (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7),
            (0, 3, 4, 7), (1, 2, 5, 6), (0, 1, 4, 5), (2, 3, 6, 7), (0, 1, 2, 3), (4, 5, 6, 7),
            (0, 1, 2, 3, 4, 5, 6, 7),
        ],
    ),
}  # fmt: skip
_SIMPLICES = ("triangle", "tetra", "triangle6", "tetra10")


@dataclass(frozen=True, slots=True)
class Lagrange:
    """Shape functions of one kind of cell.

    Attributes
    ----------
    nodes : Reference coordinates of the nodes in VTK order, shape (k, t).
    exponents : Exponents of the monomials that span the space, shape (k, t).
    coefficients : Monomials to shape functions, shape (k, k).
    """

    nodes: FloatArray
    exponents: IntArray
    coefficients: FloatArray

    def values(self, points: FloatArray) -> FloatArray:
        """Shape functions at reference points (..., t), shape (..., k)."""
        result: FloatArray = _monomials(points, self.exponents) @ self.coefficients
        return result

    def gradients(self, points: FloatArray) -> FloatArray:
        """Derivatives of the shape functions at reference points (..., t), shape (..., k, t)."""
        columns = []
        for axis in range(self.nodes.shape[1]):
            power = self.exponents[:, axis]
            lower = self.exponents.copy()
            lower[:, axis] = np.maximum(power - 1, 0)
            columns.append((power * _monomials(points, lower)) @ self.coefficients)
        return np.stack(columns, axis=-1)


def _monomials(points: FloatArray, exponents: IntArray) -> FloatArray:
    result: FloatArray = np.prod(points[..., None, :] ** exponents, axis=-1)
    return result


def is_simplex(cell: str) -> bool:
    """Whether the cell is a triangle or a tetrahedron."""
    return cell in _SIMPLICES


def linear(cell: str) -> str:
    """The first-order kind of a cell."""
    return _MEANS[cell][0] if cell in _MEANS else cell


def order(cell: str) -> int:
    """Polynomial order, 1 or 2."""
    return 2 if cell in _MEANS else 1


@cache
def lagrange(cell: str) -> Lagrange:
    """The shape functions of a kind of cell or facet."""
    corners = np.array(_CORNERS[linear(cell)], dtype=float)
    means = [corners[list(group)].mean(axis=0) for group in (_MEANS[cell][1] if cell in _MEANS else ())]
    nodes = np.vstack([corners, *means])
    degree, axes = order(cell), corners.shape[1]
    exponents = np.array(
        [e for e in product(range(degree + 1), repeat=axes) if not is_simplex(cell) or sum(e) <= degree]
    )
    return Lagrange(nodes, exponents, np.linalg.inv(_monomials(nodes, exponents)))


@cache
def quadrature(cell: str) -> tuple[FloatArray, FloatArray]:
    """Gauss points of the stiffness and their weights: 2 a direction for order 1, 3 for order 2.

    Simplices of order 1 have one point, of order 2 the rule of degree 2 (3 or 4 points).
    """
    if not is_simplex(cell):
        return gauss(lagrange(cell).nodes.shape[1], order(cell) + 1)
    axes = lagrange(cell).nodes.shape[1]
    volume = 0.5 if axes == 2 else 1 / 6
    if order(cell) == 1:
        return np.full((1, axes), 1 / (axes + 1)), np.array([volume])
    low = 1 / 6 if axes == 2 else (5 - np.sqrt(5)) / 20
    points = np.full((axes + 1, axes), low)
    points[np.arange(1, axes + 1), np.arange(axes)] = 1 - axes * low
    return points, np.full(axes + 1, volume / (axes + 1))


@cache
def fine_quadrature(cell: str) -> tuple[FloatArray, FloatArray]:
    """A rule exact for products of two shape functions on straight cells."""
    axes = lagrange(cell).nodes.shape[1]
    if not is_simplex(cell):
        return gauss(axes, order(cell) + 1)
    # a simplex is the image of a square or cube (Duffy's map), whose Jacobian raises the degree by two
    points, weights = gauss(axes, order(cell) + 2)
    if axes == 2:
        u, v = points.T
        return np.column_stack([u, v * (1 - u)]), weights * (1 - u)
    u, v, w = points.T
    folded = np.column_stack([u, v * (1 - u), w * (1 - u) * (1 - v)])
    return folded, weights * (1 - u) ** 2 * (1 - v)


def gauss(axes: int, count: int) -> tuple[FloatArray, FloatArray]:
    """Gauss-Legendre product rule on [0, 1]^t.

    Parameters
    ----------
    axes : The dimension t.
    count : Number of points in each direction; exact for polynomials of degree 2 · count − 1.

    Returns
    -------
    Points (count^t, t) and weights (count^t,), which sum to 1.
    """
    nodes, weights = np.polynomial.legendre.leggauss(count)
    nodes, weights = 0.5 * (nodes + 1), 0.5 * weights
    points = np.array(list(product(nodes, repeat=axes)))
    return points, np.array([np.prod(w) for w in product(weights, repeat=axes)])
