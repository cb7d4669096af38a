"""Mesh: the elements of one shape, as plain arrays in VTK node order.

Straight or curved, first or second order: ``points`` holds every node that carries a
displacement, so a quadratic mesh holds its mid-side nodes too (isoparametric).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from masonry_fem.solid.pose import FloatArray

IntArray = NDArray[np.int64]

# cell -> facet of the same order; node counts by kind
FACET_OF = {
    "triangle": "line", "quad": "line", "tetra": "triangle", "hexahedron": "quad",
    "triangle6": "line3", "quad9": "line3", "tetra10": "triangle6", "hexahedron27": "quad9",
}  # fmt: skip
NODES_OF = {
    "line": 2, "triangle": 3, "quad": 4, "tetra": 4, "hexahedron": 8,
    "line3": 3, "triangle6": 6, "quad9": 9, "tetra10": 10, "hexahedron27": 27,
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Mesh:
    """Finite-element mesh of one shape, in the shape's own frame.

    Attributes
    ----------
    points : Node positions [m], shape (n, d).
    cell : Kind of all cells, a key of ``FACET_OF`` (names and node order as in meshio).
    cells : Node numbers of the cells, shape (m, NODES_OF[cell]).
    facets : Boundary facets, node order giving an outward normal (in 2D the solid lies on the
        left of the edge), shape (f, NODES_OF[FACET_OF[cell]]).
    facet_face : For each facet the face of the shape's polytope that it lies on, shape (f,).
    """

    points: FloatArray
    cell: str
    cells: IntArray
    facets: IntArray
    facet_face: IntArray

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return int(self.points.shape[1])

    @property
    def facet(self) -> str:
        """Kind of the boundary facets."""
        return FACET_OF[self.cell]

    @property
    def order(self) -> int:
        """Polynomial order of the elements, 1 or 2."""
        return 1 if NODES_OF[self.cell] <= 8 and self.cell != "triangle6" else 2
