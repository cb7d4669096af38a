"""Crossing: two edges of convex blocks that touch crosswise, in one point.

Found by the separating axes along cross products of edges. Each edge is an arc between the normals of its two
faces on the unit sphere; only pairs of edges whose arcs cross are faces of the Minkowski difference, so no
other pairs are examined. The crossing must lie inside both edges: blocks that merely share a corner do not
touch.
"""

from __future__ import annotations

import numpy as np

from masonry_fem.host.compiled import compiled
from masonry_fem.solid.mesh import IntArray
from masonry_fem.solid.polytope import Polytope
from masonry_fem.solid.pose import FloatArray

PARALLEL = 1e-3  # sine of the angle between two edges below which they count as parallel
ALONG = 1e-6  # sine of the angle between an edge and a face below which the edge lies along the face


def edges_of(solid: Polytope) -> IntArray:
    """Edges of a closed solid: two vertices and the faces beside them, shape (e, 4); none in 2D."""
    if solid.dimension == 2:
        return np.empty((0, 4), dtype=np.int64)
    beside: dict[tuple[int, int], list[int]] = {}
    for face, loop in enumerate(solid.faces):
        for a, b in zip(loop, (*loop[1:], loop[0]), strict=True):
            beside.setdefault((min(a, b), max(a, b)), []).append(face)
    rows = [(*ends, *faces) for ends, faces in sorted(beside.items()) if len(faces) == 2]
    return np.array(rows, dtype=np.int64).reshape(-1, 4)


@compiled
def crossings(
    vertices: FloatArray,
    normal: FloatArray,
    edges: IntArray,
    count: IntArray,
    pairs: IntArray,
    by_face: FloatArray,
    reach: float,
    margin: float,
) -> tuple[IntArray, FloatArray, FloatArray, FloatArray]:
    """The edges that part each pair of convex blocks best.

    Parameters
    ----------
    vertices, normal : Of the blocks and their faces in the world, (b, v, 3), (b, f, 3).
    edges, count : Edges of the blocks (see ``edges_of``) and their numbers, (b, e, 4), (b,).
    pairs : Blocks, shape (m, 2). by_face : What their faces part them by, shape (m,) [m].
    reach : Distance beyond which a pair is not looked at [m].
    margin : Distance to an edge's ends that a crossing keeps [m].

    Returns
    -------
    Edges of the first and the second block, −1 where none part them or they do not cross (m, 2);
    the distance (m,), −∞ where no edges are faced; unit normals towards the first block (m, 3);
    the points on both edges (m, 2, 3).
    """
    found = np.full((len(pairs), 2), -1)
    apart = np.full(len(pairs), -np.inf)
    axis, points = np.zeros((len(pairs), 3)), np.zeros((len(pairs), 2, 3))
    for m in range(len(pairs)):
        if by_face[m] > reach:
            continue
        a, b = pairs[m, 0], pairs[m, 1]
        for i in range(count[a]):
            p, u = vertices[a, edges[a, i, 0]], vertices[a, edges[a, i, 1]] - vertices[a, edges[a, i, 0]]
            n1, n2 = normal[a, edges[a, i, 2]], normal[a, edges[a, i, 3]]
            for j in range(count[b]):
                o1, o2 = normal[b, edges[b, j, 2]], normal[b, edges[b, j, 3]]
                q = vertices[b, edges[b, j, 0]]
                w = vertices[b, edges[b, j, 1]] - q
                if not _arcs_cross(u, w, n1, n2, o1, o2):
                    continue
                n = np.cross(u, w)
                length = np.sqrt((n * n).sum())
                if length <= PARALLEL * np.sqrt((u * u).sum() * (w * w).sum()):
                    continue
                n /= length
                toward = (n * (n1 + n2)).sum()
                # the arcs, not the great circles: the axis leaves the first and enters the second
                if toward * (n * (o1 + o2)).sum() >= 0:
                    continue
                if toward > 0:
                    n = -n
                distance = (n * (p - q)).sum()
                if distance <= apart[m]:
                    continue
                apart[m], axis[m] = distance, n
                found[m, 0] = found[m, 1] = -1
                if _inside(p, u, q, w, margin, points[m]):
                    found[m, 0], found[m, 1] = i, j
    return found, apart, axis, points


@compiled
def _arcs_cross(
    u: FloatArray, w: FloatArray, n1: FloatArray, n2: FloatArray, o1: FloatArray, o2: FloatArray
) -> bool:
    """Whether the ends of the arcs n1-n2 and (-o1)-(-o2) are on different sides, and no edge is along a face.

    ``u`` and ``w`` are the edges; the circles of the arcs may still cross elsewhere.
    """
    s1, s2 = -(u * o1).sum(), -(u * o2).sum()
    t1, t2 = (w * n1).sum(), (w * n2).sum()
    if s1 * s2 >= 0 or t1 * t2 >= 0:
        return False
    along, across = ALONG * np.sqrt((u * u).sum()), ALONG * np.sqrt((w * w).sum())
    result: bool = min(abs(s1), abs(s2)) > along and min(abs(t1), abs(t2)) > across
    return result


@compiled
def _inside(
    p: FloatArray, u: FloatArray, q: FloatArray, w: FloatArray, margin: float, points: FloatArray
) -> bool:
    """Whether the points of two lines nearest each other lie inside both edges; writes them."""
    uu, uw, ww = (u * u).sum(), (u * w).sum(), (w * w).sum()
    ur, wr = (u * (q - p)).sum(), (w * (q - p)).sum()
    determinant = uu * ww - uw * uw
    s, t = (ur * ww - wr * uw) / determinant, (ur * uw - wr * uu) / determinant
    points[0], points[1] = p + s * u, q + t * w
    at_first, at_second = margin / np.sqrt(uu), margin / np.sqrt(ww)
    inside: bool = at_first < s < 1 - at_first and at_second < t < 1 - at_second
    return inside
