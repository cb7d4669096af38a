"""Touching by a feature: a corner or an edge of one convex block that stands on a face of another.

Found by the separating axis among the face normals: the block lies wholly in front of the face, and only
one or two of its corners are nearest. The corner or edge must lie inside the face: blocks that merely
share an edge or a corner do not touch. If the product of two edges separates the blocks better than a face
normal does, the edges cross (``crossing``).
"""

from __future__ import annotations

import numpy as np

from masonry_fem.contact.clipping import depths
from masonry_fem.contact.contacts import Interface, local_frames
from masonry_fem.contact.crossing import crossings
from masonry_fem.contact.posed import Posed
from masonry_fem.host.compiled import compiled
from masonry_fem.solid.mesh import IntArray
from masonry_fem.solid.pose import FloatArray

INSIDE = 1e-6  # of a block's size: how deep inside a face a corner must stand
LEVEL = 1e-6  # of a block's size: corners whose heights differ by less are equally high
ROUNDING = 1e-12


def standing_pairs(
    posed: Posed, pairs: IntArray, reach: float, overlap: float, size: float
) -> list[Interface]:
    """Interfaces of one or two points: convex blocks that stand on a corner or edge, or whose edges cross.

    Parameters
    ----------
    posed : Corners, edges and faces of all blocks.
    pairs : Pairs of near blocks, shape (p, 2).
    reach : Largest gap [m].
    overlap : Largest overlap [m].
    size : Typical size of a block, for tolerances [m].
    """
    pairs = pairs[posed.convex[pairs].all(axis=1)]
    if len(pairs) == 0:
        return []
    level = LEVEL * size
    found, by_face = _features(
        posed.vertices, posed.count, posed.on_face, posed.normal, posed.faces, pairs, reach, overlap, level
    )
    edges, apart, axis, points = crossings(
        posed.vertices, posed.normal, posed.edges, posed.edge_count, pairs, by_face, reach + level, level
    )
    crossed = (edges[:, 0] >= 0) & (apart <= reach + level) & (apart >= -overlap - level)
    better = apart > by_face + level
    made = []
    for m in np.flatnonzero(crossed | ((found[:, 0] >= 0) & ~better)).tolist():
        interface = None
        if found[m, 0] >= 0 and not better[m]:
            side, face, u, v = found[m].tolist()
            corners = [u] if v < 0 else [u, v]
            interface = _interface(posed, pairs[m, side], face, pairs[m, 1 - side], corners, size)
        # the corner is beside the face: take the edges, if they separate the blocks equally well
        if interface is None and crossed[m] and apart[m] >= by_face[m] - level:
            interface = _crossing(posed, pairs[m], edges[m], axis[m], points[m], size)
        if interface is not None:
            made.append(interface)
    return made


def _crossing(
    posed: Posed, pair: IntArray, edges: IntArray, axis: FloatArray, points: FloatArray, size: float
) -> Interface:
    """The interface of two edges that cross; the later block is the candidate, unless a support."""
    first, second = pair.tolist()
    gap = float(axis @ (points[0] - points[1]))
    faces = []
    for block, edge in zip((first, second), edges, strict=True):
        beside = posed.edges[block, edge, 2:]
        against = np.abs(posed.normal[block, beside] @ axis)
        faces.append(int(beside[0] if against[0] >= against[1] - 1e-9 else beside[1]))
    later = int(not (posed.support[second] and not posed.support[first]))
    return Interface(
        blocks=(second, first) if later else (first, second),
        faces=(faces[1], faces[0]) if later else (faces[0], faces[1]),
        normal=-axis if later else axis,
        polygon=points.mean(axis=0)[None],
        gap=np.array([gap if abs(gap) >= ROUNDING * size else 0.0]),
        area=0.0,
        label=posed.shared_labels(np.array([[first, second]]), np.array([faces]))[0],
    )


def _interface(
    posed: Posed, carrier: int, face: int, other: int, corners: list[int], size: float
) -> Interface | None:
    """The interface of corners of ``other`` with a face of ``carrier``; None if they miss the face."""
    frame = local_frames(posed.normal[carrier, face][None])[0]
    loop = posed.vertices[carrier, list(posed.solids[posed.shape[carrier]].faces[face])]
    window = (loop - loop[0]) @ frame[1:].T
    if not faces_at(posed, other, corners):  # no edge joins the two: the block stands on the lower one only
        corners = corners[:1]
    feature = posed.vertices[other, corners]
    feature = _part_inside(window, (feature - loop[0]) @ frame[1:].T, feature, INSIDE * size)
    return standing(posed, carrier, face, other, corners, feature, size) if len(feature) else None


def faces_at(posed: Posed, block: int, corners: list[int]) -> list[int]:
    """Faces of a block that have all of some corners."""
    loops = posed.solids[posed.shape[block]].faces
    return [face for face, loop in enumerate(loops) if set(corners) <= set(loop)]


def standing(
    posed: Posed, carrier: int, face: int, other: int, corners: list[int], feature: FloatArray, size: float
) -> Interface:
    """The interface of a corner or edge of one block that stands on a face of another.

    Parameters
    ----------
    posed : Corners and faces of all blocks.
    carrier, face : The block that carries, and its face.
    other, corners : The block that stands, and its corner or the two that its edge joins.
    feature : The corner, or the part of the edge that is above the face, shape (1 or 2, d) [m].
    size : Typical size of a block, for tolerances [m].
    """
    normal = posed.normal[carrier, face]
    gap = (feature - posed.on_face[carrier, face]) @ normal
    gap[np.abs(gap) < ROUNDING * size] = 0.0
    against = max(
        faces_at(posed, other, corners), key=lambda f: (-round(float(posed.normal[other, f] @ normal), 9), -f)
    )
    blocks, faces = (other, carrier), (against, face)
    return Interface(
        blocks=blocks,
        faces=faces,
        normal=normal,
        polygon=feature - gap[:, None] * normal,
        gap=gap,
        area=0.0,
        label=posed.shared_labels(np.array([blocks]), np.array([faces]))[0],
    )


def _part_inside(window: FloatArray, flat: FloatArray, feature: FloatArray, margin: float) -> FloatArray:
    """The part of a corner or edge that projects inside a convex polygon (none: no rows)."""
    if len(flat) == 1:
        return feature if depths(window, flat)[0] > margin else feature[:0]
    low, high = 0.0, 1.0
    for p, q in zip(window, np.roll(window, -1, axis=0), strict=True):
        edge = (q - p) / np.linalg.norm(q - p)
        start, end = (edge[0] * (x[1] - p[1]) - edge[1] * (x[0] - p[0]) for x in flat)
        if max(start, end) <= margin:
            return feature[:0]
        if start < 0:
            low = max(low, start / (start - end))
        if end < 0:
            high = min(high, start / (start - end))
    length = float(np.linalg.norm(flat[1] - flat[0]))
    if (high - low) * length <= margin:
        return feature[:0]
    ends = np.array([low, high])[:, None]
    part: FloatArray = (1 - ends) * feature[0] + ends * feature[1]
    return part


@compiled
def _features(
    vertices: FloatArray,
    count: IntArray,
    on_face: FloatArray,
    normal: FloatArray,
    faces: IntArray,
    pairs: IntArray,
    reach: float,
    overlap: float,
    level: float,
) -> tuple[IntArray, FloatArray]:
    """For each pair (which block carries, its face, one or two corners of the other; −1: none), (m, 4).

    The separating face is the one with the largest smallest height; ``level`` is the height
    difference below which corners count as equally high. Last the largest of these heights among
    all faces, by which the faces part the pair, shape (m,) [m].
    """
    d = vertices.shape[2]
    result = np.full((len(pairs), 4), -1)
    apart = np.full(len(pairs), -np.inf)
    for m in range(len(pairs)):
        best = flat = -np.inf
        for side in range(2):
            carrier, other = pairs[m, side], pairs[m, 1 - side]
            heights = np.empty(count[other])
            for f in range(faces[carrier]):
                heights = _heights(vertices[other, : count[other]], on_face[carrier, f], normal[carrier, f])
                low = _three_lowest(heights)
                lowest = heights[low[0]]
                apart[m] = max(apart[m], lowest)
                if lowest < -overlap - level or lowest > reach + level or lowest <= best:
                    continue
                # a face, which detection of faces finds, or an edge that is merely shared
                if (heights <= lowest + level).sum() > d - 1:
                    flat = max(flat, lowest)
                    continue
                best = lowest
                result[m, 0], result[m, 1], result[m, 2] = side, f, low[0]
                result[m, 3] = _other_end(heights, low, reach, level) if d == 3 else -1
        # nothing near in front of some face: the blocks are apart; or a face parts them better
        if apart[m] > reach + level or flat > best + level:
            result[m] = -1
    return result, apart


@compiled
def _heights(corners: FloatArray, on_face: FloatArray, normal: FloatArray) -> FloatArray:
    """Heights of corners above a face, shape (v,) [m]."""
    heights = np.zeros(len(corners))
    for v in range(len(corners)):
        for c in range(len(normal)):
            heights[v] += (corners[v, c] - on_face[c]) * normal[c]
    return heights


@compiled
def _other_end(heights: FloatArray, low: IntArray, reach: float, level: float) -> int:
    """A second corner within reach, which makes an edge if all others are clearly higher; −1: none."""
    edge = heights[low[1]] <= reach and heights[low[2]] > heights[low[1]] + level
    return low[1] if edge else -1


@compiled
def _three_lowest(heights: FloatArray) -> IntArray:
    """Indices of the three smallest values, ascending; the first of equals comes first."""
    low = np.zeros(3, dtype=np.int64)
    known = 0
    for i in range(len(heights)):
        at = known
        while at > 0 and heights[i] < heights[low[at - 1]]:
            if at < 3:
                low[at] = low[at - 1]
            at -= 1
        if at < 3:
            low[at] = i
            known = min(known + 1, 3)
    return low
