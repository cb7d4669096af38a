"""Lagrange: shape functions of cells and facets, and their quadrature, by basix in VTK's order of nodes.

    element = lagrange("hexahedron27")
    element.values(points), element.gradients(points)     # (p, nodes), (p, nodes, t)
    points, weights = quadrature("hexahedron27")

Reference cells are [0, 1]^t or the unit simplex.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from masonry_fem.fem._compat import basix

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

# kind of cell: basix's name of it, order, and which of basix's nodes VTK has first, second, ...
_KINDS = {
    "line": ("interval", 1, (0, 1)),
    "triangle": ("triangle", 1, (0, 1, 2)),
    "quad": ("quadrilateral", 1, (0, 1, 3, 2)),
    "tetra": ("tetrahedron", 1, (0, 1, 2, 3)),
    "hexahedron": ("hexahedron", 1, (0, 1, 3, 2, 4, 5, 7, 6)),
    "line3": ("interval", 2, (0, 1, 2)),
    "triangle6": ("triangle", 2, (0, 1, 2, 5, 3, 4)),
    "quad9": ("quadrilateral", 2, (0, 1, 3, 2, 4, 6, 7, 5, 8)),
    "tetra10": ("tetrahedron", 2, (0, 1, 2, 3, 9, 6, 8, 7, 5, 4)),
    "hexahedron27": (
        "hexahedron", 2,
        (0, 1, 3, 2, 4, 5, 7, 6, 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 15, 14, 22, 23, 21, 24, 20, 25, 26),
    ),
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Lagrange:
    """Shape functions of one kind of cell.

    Attributes
    ----------
    element : Basix's. own : Number in it of each node in VTK's order, shape (k,).
    """

    element: Any
    own: IntArray

    @property
    def nodes(self) -> FloatArray:
        """Reference coordinates of the nodes, shape (k, t)."""
        places: FloatArray = self.element.points[self.own]
        return places

    def values(self, points: FloatArray) -> FloatArray:
        """Shape functions at reference points (p, t), shape (p, k)."""
        result: FloatArray = self._tabulated(0, points)[0]
        return result

    def gradients(self, points: FloatArray) -> FloatArray:
        """Derivatives of the shape functions at reference points (p, t), shape (p, k, t)."""
        return np.ascontiguousarray(np.moveaxis(self._tabulated(1, points)[1:], 0, -1))

    def _tabulated(self, derivatives: int, points: FloatArray) -> FloatArray:
        table: FloatArray = self.element.tabulate(derivatives, np.ascontiguousarray(points, dtype=float))
        return table[:, :, self.own, 0]


def basix_name(cell: str) -> str:
    """The name that basix and DOLFINx have for the form of a cell."""
    return _KINDS[cell][0]


def is_simplex(cell: str) -> bool:
    """Whether the cell is a triangle or a tetrahedron."""
    return basix_name(cell) in ("triangle", "tetrahedron")


def linear(cell: str) -> str:
    """The first-order kind of a cell."""
    return next(kind for kind, (form, *_) in _KINDS.items() if form == basix_name(cell))


def order(cell: str) -> int:
    """Polynomial order, 1 or 2."""
    return _KINDS[cell][1]


@cache
def lagrange(cell: str) -> Lagrange:
    """The shape functions of a kind of cell or facet."""
    form, degree, own = _KINDS[cell]
    variant = basix.LagrangeVariant.gll_warped
    element = basix.create_element(basix.ElementFamily.P, getattr(basix.CellType, form), degree, variant)
    return Lagrange(element, np.array(own))


def stiffness_degree(cell: str) -> int:
    """Degree of the quadrature of the stiffness: exact on straight simplices, full in boxes."""
    return 2 * (order(cell) - 1) if is_simplex(cell) else 2 * order(cell)


def quadrature(cell: str) -> tuple[FloatArray, FloatArray]:
    """Gauss points of the stiffness and their weights: 2 a direction for order 1, 3 for order 2.

    Simplices of order 1 have one point, of order 2 the rule of degree 2 (3 or 4 points).
    """
    return rule(cell, stiffness_degree(cell))


def fine_quadrature(cell: str) -> tuple[FloatArray, FloatArray]:
    """A rule exact for products of two shape functions on straight cells, and a degree more."""
    return rule(cell, 2 * order(cell) + 1)


@cache
def rule(cell: str, degree: int) -> tuple[FloatArray, FloatArray]:
    """Points (p, t) and weights (p,) that integrate polynomials exactly.

    Parameters
    ----------
    cell : Kind of the cell.
    degree : Of the polynomials, in boxes in each direction.
    """
    points, weights = basix.make_quadrature(getattr(basix.CellType, basix_name(cell)), degree)
    return points, weights
