"""Sewing: which faces of a heap of polygons bound the same body.

Two faces at an edge belong together. Where bodies touch, four or more meet in an edge: going round it, a
face behind which there is stone belongs to the next one that has stone before it.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from masonry_fem.importing.triangles import area_vector
from masonry_fem.solid.mesh import IntArray
from masonry_fem.solid.pose import FloatArray

SAME = 1e-5  # angle [rad]: faces whose angles about an edge differ by less coincide


def bodies_of(points: FloatArray, loops: Sequence[tuple[int, ...]]) -> IntArray:
    """Number of the body of each polygon, counted in their order, shape (len(loops),).

    Parameters
    ----------
    points : Corners, shape (n, 3). loops : Polygons, counter-clockwise seen from outside; corners that
        coincide are one.
    """
    beside: dict[tuple[int, int], list[tuple[int, bool]]] = defaultdict(list)
    for face, loop in enumerate(loops):
        for a, b in zip(loop, (*loop[1:], loop[0]), strict=True):
            if a != b:
                beside[min(a, b), max(a, b)].append((face, a < b))
    pairs: list[tuple[int, int]] = []
    for (a, b), faces in beside.items():
        if len(faces) == 2:
            pairs.append((faces[0][0], faces[1][0]))
        elif len(faces) > 2:
            pairs += _paired(points, loops, points[b] - points[a], faces)
    rows = np.array(pairs, dtype=np.int64).reshape(-1, 2)
    links = coo_array((np.ones(len(rows)), (rows[:, 0], rows[:, 1])), shape=(len(loops),) * 2)
    return np.asarray(connected_components(links, directed=False)[1], dtype=np.int64)


def _paired(
    points: FloatArray, loops: Sequence[tuple[int, ...]], along: FloatArray, faces: list[tuple[int, bool]]
) -> list[tuple[int, int]]:
    """Pairs of the faces about an edge that have stone between them."""
    along = along / np.linalg.norm(along)
    first = np.cross(along, np.eye(3)[int(np.argmin(np.abs(along)))])
    first /= np.linalg.norm(first)
    second = np.cross(along, first)
    order = []
    for face, forward in faces:
        normal = area_vector(points[list(loops[face])])
        inwards = np.cross(normal, along if forward else -along)  # from the edge into the face
        angle = np.arctan2(inwards @ second, inwards @ first) % (2 * np.pi)
        if 2 * np.pi - angle < SAME:
            angle = 0.0
        # of two coinciding faces, the one that ends a body comes before the one that begins the next
        order.append((round(angle / SAME), not forward, face))
    order.sort()
    pairs = []
    for at, (_, begins, face) in enumerate(order):
        following = order[at + 1 :] + order[:at]
        if begins and following and not following[0][1]:
            pairs.append((face, following[0][2]))
    return pairs
