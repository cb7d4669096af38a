"""Wedges: elements of two triangles and three quadrilaterals, divided into tetrahedra whose faces fit.

Each face with four corners is cut from the corner with the least number, in both wedges alike.

References
----------
Dompierre, Labbé, Vallet and Camarero, How to subdivide pyramids, prisms and hexahedra into tetrahedra,
8th International Meshing Roundtable (1999).
"""

from __future__ import annotations

import numpy as np

from masonry_fem.solid.mesh import IntArray

# a wedge by the corner that shall be its first, and its tetrahedra by the diagonal of the far face
TURNS = np.array([
    (0, 1, 2, 3, 4, 5), (1, 2, 0, 4, 5, 3), (2, 0, 1, 5, 3, 4),
    (3, 5, 4, 0, 2, 1), (4, 3, 5, 1, 0, 2), (5, 4, 3, 2, 1, 0),
])  # fmt: skip
TETRAHEDRA = np.array([
    ((0, 1, 2, 5), (0, 1, 5, 4), (0, 4, 5, 3)),
    ((0, 1, 2, 4), (0, 4, 2, 5), (0, 4, 5, 3)),
])  # fmt: skip


def divided(kind: str, rows: IntArray) -> tuple[str, IntArray]:
    """Kind and rows of three tetrahedra for each wedge; the same where the elements are no wedges.

    Parameters
    ----------
    kind : Of the elements. rows : Of their nodes, shape (k, n).
    """
    if kind != "wedge":
        return kind, rows
    turned = np.take_along_axis(rows, TURNS[rows.argmin(axis=1)], axis=1)  # its least number comes first
    first = np.minimum(turned[:, 1], turned[:, 5]) < np.minimum(turned[:, 2], turned[:, 4])
    cut = np.where(first[:, None, None], TETRAHEDRA[0], TETRAHEDRA[1])
    return "tetra", np.take_along_axis(turned[:, None, :], cut, axis=2).reshape(-1, 4)


def halves(corners: list[int]) -> list[list[int]]:
    """The triangles of a wedge's face: itself, or two that are cut from the corner with the least number."""
    if len(corners) == 3:
        return [corners]
    at = corners.index(min(corners))
    a, b, c, d = corners[at:] + corners[:at]
    return [[a, b, c], [a, c, d]]
