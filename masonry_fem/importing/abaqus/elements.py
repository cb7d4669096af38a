"""Elements: made whole where the file has no nodes in the middle of faces and of the body; wedges divided.

Wedges have two triangles and three quadrilaterals. That their tetrahedra fit those of their neighbours, each
face with four corners is cut from the corner with the least number, in both wedges alike.

References
----------
Dompierre, Labbé, Vallet and Camarero, How to subdivide pyramids, prisms and hexahedra into tetrahedra,
8th International Meshing Roundtable (1999).
"""

from __future__ import annotations

import numpy as np

from masonry_fem.solid.mesh import IntArray
from masonry_fem.solid.pose import FloatArray

# a wedge by the corner that shall be its first, and its tetrahedra by the diagonal of the far face
TURNS = np.array([
    (0, 1, 2, 3, 4, 5), (1, 2, 0, 4, 5, 3), (2, 0, 1, 5, 3, 4),
    (3, 5, 4, 0, 2, 1), (4, 3, 5, 1, 0, 2), (5, 4, 3, 2, 1, 0),
])  # fmt: skip
TETRAHEDRA = np.array([
    ((0, 1, 2, 5), (0, 1, 5, 4), (0, 4, 5, 3)),
    ((0, 1, 2, 4), (0, 4, 2, 5), (0, 4, 5, 3)),
])  # fmt: skip

# faces of a hexahedron in our order, by the nodes of a 20-node one on them: 4 corners, 4 middles
HEX_FACES = (
    (0, 3, 7, 4, 11, 19, 15, 16), (1, 2, 6, 5, 9, 18, 13, 17), (0, 1, 5, 4, 8, 17, 12, 16),
    (3, 2, 6, 7, 10, 18, 14, 19), (0, 1, 2, 3, 8, 9, 10, 11), (4, 5, 6, 7, 12, 13, 14, 15),
)  # fmt: skip
COMPLETE = {"hexahedron20": "hexahedron27", "quad8": "quad9"}


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


def completed(kind: str, rows: IntArray, points: FloatArray) -> tuple[str, IntArray, FloatArray]:
    """Kind, rows and points with the nodes that elements lack; the same where they lack none.

    Parameters
    ----------
    kind : Of the elements. rows : Of their nodes, shape (k, n). points : All nodes, shape (m, 3).
    """
    if kind not in COMPLETE:
        return kind, rows, points
    return COMPLETE[kind], *FULL[kind](rows, points)


def _complete_hexahedra(rows: IntArray, points: FloatArray) -> tuple[IntArray, FloatArray]:
    """27 nodes of 20: those of faces are shared by the two elements that meet there."""
    faces = rows[:, np.array(HEX_FACES)]  # (elements, 6, 8)
    keys = np.sort(faces[..., :4], axis=2).reshape(-1, 4)
    _, first, where = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    own = points[faces.reshape(-1, 8)[first]]
    middle = 0.5 * own[:, 4:].sum(axis=1) - 0.25 * own[:, :4].sum(axis=1)
    body = 0.25 * points[rows[:, 8:]].sum(axis=1) - 0.25 * points[rows[:, :8]].sum(axis=1)
    count = len(points)
    inner = count + len(middle) + np.arange(len(rows))[:, None]
    whole = np.hstack([rows, count + where.reshape(-1, 6), inner])
    return whole, np.concatenate([points, middle, body])


def _complete_quads(rows: IntArray, points: FloatArray) -> tuple[IntArray, FloatArray]:
    """9 nodes of 8."""
    middle = 0.5 * points[rows[:, 4:]].sum(axis=1) - 0.25 * points[rows[:, :4]].sum(axis=1)
    inner = len(points) + np.arange(len(rows))[:, None]
    return np.hstack([rows, inner]), np.concatenate([points, middle])


FULL = {"hexahedron20": _complete_hexahedra, "quad8": _complete_quads}
