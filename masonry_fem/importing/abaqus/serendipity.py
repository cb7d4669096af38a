"""Serendipity: elements without nodes in the middle of faces and of the body, and with them."""

from __future__ import annotations

import numpy as np

from masonry_fem.solid.mesh import IntArray
from masonry_fem.solid.pose import FloatArray

# faces of a hexahedron in our order, by the nodes of a 20-node one on them: 4 corners, 4 middles
HEX_FACES = (
    (0, 3, 7, 4, 11, 19, 15, 16), (1, 2, 6, 5, 9, 18, 13, 17), (0, 1, 5, 4, 8, 17, 12, 16),
    (3, 2, 6, 7, 10, 18, 14, 19), (0, 1, 2, 3, 8, 9, 10, 11), (4, 5, 6, 7, 12, 13, 14, 15),
)  # fmt: skip
COMPLETE = {"hexahedron20": "hexahedron27", "quad8": "quad9"}


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
