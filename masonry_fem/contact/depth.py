"""Depth: how deep blocks overlap, wherever they have moved and however they are deformed.

    found = overlaps(skin, points)
    found.pairs, found.depth
    overlapping(assembly)               # the same for blocks in their initial positions

There are three measures. Convex blocks that keep their shape are judged by separating axes, which is exact.
If both have very many edges, the diameter of the largest ball in both replaces it. If one is deformed or not
convex, the depth is at most that of two faces that look at each other, which is where they are deepest in
each other; facets of one round face count as one. Where no faces do, hollows count as filled.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from masonry_fem.contact.boxes import near_pairs
from masonry_fem.contact.clipping import common_parts
from masonry_fem.contact.contacts import height, local_frames
from masonry_fem.contact.facing import facing_rows
from masonry_fem.contact.posed import corners
from masonry_fem.contact.skin import Layout, Skin
from masonry_fem.host.compiled import compiled
from masonry_fem.solid.assembly import Assembly
from masonry_fem.solid.mesh import IntArray
from masonry_fem.solid.polytope import Polytope
from masonry_fem.solid.pose import FloatArray

ROUNDING = 1e-6  # of the smaller block's least extent: smaller overlaps are rounding errors
STEEPEST = -0.5  # cosine of the normals of facets that look at each other
SLIVER = 1e-4  # of the smaller of two faces: smaller common parts are not considered
MANY = 20_000  # pairs of edges above which the largest common ball replaces the axes
PARALLEL = 1e-6  # sine of the angle below which two edges are parallel and give no axis


@dataclass(frozen=True, slots=True)
class Overlaps:
    """Pairs of blocks that overlap, and how deep.

    Attributes
    ----------
    pairs : Block numbers, the lower one first, shape (m, 2).
    depth : Depth of each overlap, shape (m,) [m].
    """

    pairs: IntArray
    depth: FloatArray


def overlaps(skin: Skin, points: FloatArray) -> Overlaps:
    """Blocks that overlap by more than rounding errors; two supports are allowed to.

    Parameters
    ----------
    skin : Surfaces of all blocks.
    points : Where the nodes of the surfaces are now, shape (n, d) [m].

    References
    ----------
    Gottschalk, Lin, Manocha, OBBTree, SIGGRAPH 1996 (separating axes: face normals and products of edges).
    """
    low, high = skin.boxes(points)
    pairs = near_pairs(low, high, 0.0)
    pairs = pairs[~skin.support[pairs].all(axis=1)]
    allowed = ROUNDING * skin.size[pairs].min(axis=1)
    inside = np.minimum(high[pairs[:, 0]] - low[pairs[:, 1]], high[pairs[:, 1]] - low[pairs[:, 0]]).min(
        axis=1
    )
    pairs, allowed = pairs[inside > allowed], allowed[inside > allowed]
    areas = skin.areas(points)
    faces = skin.face_areas(areas)
    axes = faces / np.maximum(np.linalg.norm(faces, axis=1), 1e-300)[:, None]
    many = np.diff(skin.first_edge)[pairs].prod(axis=1) > MANY
    depth = _by_axes(
        points, skin.nodes, axes, skin.first_face, skin.edges, skin.first_edge, pairs, allowed, many
    )
    for round_ in np.flatnonzero(many & (depth > allowed)):
        one, two = (points[slice(*skin.nodes[block])] for block in pairs[round_])
        depth[round_] = min(depth[round_], _ball_in_both(one, two))
    deep = depth > allowed
    pairs, depth, allowed = pairs[deep], depth[deep], allowed[deep]
    hollow = skin.hollow[pairs].sum(axis=1)
    unlike = np.flatnonzero(skin.meshed[pairs].any(axis=1) | (hollow > 0))
    if len(unlike):
        seen = _by_facets(skin, points, areas, pairs[unlike], depth[unlike])
        filled = depth[unlike] - np.where(np.isfinite(seen), 0.0, hollow[unlike])
        depth[unlike] = np.minimum(filled, seen)
    deep = depth > allowed
    return Overlaps(pairs[deep], depth[deep])


@compiled
def _by_axes(
    points: FloatArray,
    nodes: IntArray,
    axes: FloatArray,
    first_face: IntArray,
    edges: IntArray,
    first_edge: IntArray,
    pairs: IntArray,
    allowed: FloatArray,
    many: NDArray[np.bool_],
) -> FloatArray:
    """Least overlap of the blocks' hulls along face normals and across edges, shape (m,) [m].

    Pairs with too ``many`` edges are looked at along face normals alone. Once no more than ``allowed``
    a pair is looked at no further.
    """
    result = np.empty(len(pairs))
    for m in range(len(pairs)):
        one, two = pairs[m]
        result[m] = _along_normals(points, nodes, axes, first_face, one, two, allowed[m])
        if points.shape[1] == 3 and not many[m]:
            result[m] = _across_edges(points, nodes, edges, first_edge, one, two, (result[m], allowed[m]))
    return result


@compiled
def _along_normals(
    points: FloatArray,
    nodes: IntArray,
    axes: FloatArray,
    first_face: IntArray,
    one: int,
    two: int,
    allowed: float,
) -> float:
    """Least overlap of two blocks along the normals of their faces [m]."""
    least = np.inf
    for block in (one, two):
        for face in range(first_face[block], first_face[block + 1]):
            if least > allowed and (axes[face] ** 2).sum() > 0.5:  # zero: a face without facets
                least = min(least, _along(points, nodes, one, two, axes[face]))
    return least


@compiled
def _across_edges(
    points: FloatArray,
    nodes: IntArray,
    edges: IntArray,
    first_edge: IntArray,
    one: int,
    two: int,
    known: tuple[float, float],
) -> float:
    """Least overlap of two blocks across their edges; ``known`` is the least so far and what is allowed."""
    least, allowed = known
    axis = np.empty(3)
    for e in range(first_edge[one], first_edge[one + 1]):
        for f in range(first_edge[two], first_edge[two + 1]):
            if least <= allowed:
                return least
            a = points[edges[e, 1]] - points[edges[e, 0]]
            b = points[edges[f, 1]] - points[edges[f, 0]]
            axis[0] = a[1] * b[2] - a[2] * b[1]
            axis[1] = a[2] * b[0] - a[0] * b[2]
            axis[2] = a[0] * b[1] - a[1] * b[0]
            length = np.sqrt((axis**2).sum())
            if length > PARALLEL * np.sqrt((a**2).sum() * (b**2).sum()):
                least = min(least, _along(points, nodes, one, two, axis / length))
    return least


@compiled
def _along(points: FloatArray, nodes: IntArray, one: int, two: int, axis: FloatArray) -> float:
    """Overlap of two blocks' shadows on an axis [m]."""
    ends = np.empty((2, 2))
    for k, block in enumerate((one, two)):
        low, high = np.inf, -np.inf
        for v in range(nodes[block, 0], nodes[block, 1]):
            at = 0.0
            for c in range(points.shape[1]):
                at += points[v, c] * axis[c]
            low, high = min(low, at), max(high, at)
        ends[k, 0], ends[k, 1] = low, high
    return min(ends[0, 1] - ends[1, 0], ends[1, 1] - ends[0, 0])  # type: ignore[no-any-return]


def _by_facets(
    skin: Skin, points: FloatArray, areas: FloatArray, pairs: IntArray, depth: FloatArray
) -> FloatArray:
    """Least depth over the faces of each pair that look at each other, facet by facet, shape (m,) [m].

    Infinite where none do.
    """
    size = np.linalg.norm(areas, axis=1)
    normal = areas / np.maximum(size, 1e-300)[:, None]
    at = points[skin.corners]
    rows = facing_rows(
        normal, at.min(axis=1), at.max(axis=1), skin.first, pairs, STEEPEST, float(depth.max())
    )
    lower, upper = rows[:, 0], rows[:, 1]
    mean = normal[lower] - normal[upper]
    frame = local_frames(mean / np.linalg.norm(mean, axis=1)[:, None])
    gap, area = _gaps(skin, at, normal, lower, upper, frame)
    face = np.stack([skin.side[lower], skin.side[upper]], axis=1)
    both, number = np.unique(face[area > 0], axis=0, return_inverse=True)
    if len(both) == 0:
        return np.full(len(pairs), np.inf)
    number = number.ravel()
    deepest = np.full(len(both), -np.inf)
    np.maximum.at(deepest, number, -gap[area > 0])
    common = np.bincount(number, area[area > 0], len(both))
    whole = np.bincount(skin.side, size, int(skin.first_face[-1]))[both].min(axis=1)
    says = common > SLIVER * whole
    # the pair that two faces belong to: pairs are sorted, and blocks hold faces in their order
    owner = np.searchsorted(skin.first_face, both, side="right") - 1
    count = len(skin.first)
    place = np.searchsorted(pairs @ [count, 1], owner @ [count, 1])
    result = np.full(len(pairs), np.inf)
    np.minimum.at(result, place[says], deepest[says])
    return result


def _gaps(
    skin: Skin, at: FloatArray, normal: FloatArray, lower: IntArray, upper: IntArray, frame: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Least gap over the common part of pairs of facets, and its area; (m,), (m,); area 0: none."""
    if len(lower) == 0:
        return np.zeros(0), np.zeros(0)
    origin = at[lower, 0]
    tolerance = 1e-9 * np.linalg.norm(at[lower] - origin[:, None], axis=2).max(axis=1)
    flat, count, area = common_parts(at, skin.count, upper, lower, origin, frame[:, 1:], tolerance)
    corners = origin[:, None] + np.einsum("mkp,mpd->mkd", flat, frame[:, 1:])
    shown = np.arange(corners.shape[1]) < count[:, None]
    across = np.broadcast_to(frame[:, :1], corners.shape)
    above = height(corners, across, at[upper, :1], normal[upper, None])
    below = height(corners, across, at[lower, :1], normal[lower, None])
    gap: FloatArray = np.where(shown, above - below, np.inf).min(axis=1)
    return gap, np.where(np.isfinite(gap), area, 0.0)


def _ball_in_both(one: FloatArray, two: FloatArray) -> float:
    """Diameter [m] of the largest ball within two convex hulls at once; negative if the hulls are apart.

    To separate the hulls, one must be moved by at least this much.

    Parameters
    ----------
    one, two : Points whose convex hulls are meant, each of shape (n, 3) [m].
    """
    # loaded only for blocks that overlap, as loading takes a fifth of a second
    from scipy.optimize import linprog  # noqa: PLC0415
    from scipy.spatial import ConvexHull  # noqa: PLC0415

    origin = one.mean(axis=0)
    size = float(np.ptp(one, axis=0).max())
    planes = np.concatenate([ConvexHull((cloud - origin) / size).equations for cloud in (one, two)])
    sides = np.column_stack([planes[:, :-1], np.ones(len(planes))])
    aim = np.zeros(sides.shape[1])
    aim[-1] = -1.0  # the largest radius
    best = linprog(
        aim,
        A_ub=sides,
        b_ub=-planes[:, -1],
        bounds=(None, None),
        options={"primal_feasibility_tolerance": 1e-10},
    )
    assert best.x is not None  # bounded, and feasible with a negative radius
    return 2 * size * float(best.x[-1])


def overlapping(assembly: Assembly) -> list[tuple[int, int, float]]:
    """Pairs of blocks (numbers) that penetrate, and the depth [m].

    Supports do not move, so they may penetrate each other.
    """
    padded, count = corners(assembly)
    vertices = padded[np.arange(padded.shape[1]) < count[:, None]]
    start = np.cumsum(count) - count
    shapes = assembly.blocks.shape
    used = [np.flatnonzero(shapes == shape) for shape in np.unique(shapes)]
    skin = Skin.of(assembly, [Layout(int(shapes[own[0]]), False, own, start[own]) for own in used])
    found = overlaps(skin, vertices)
    return [
        (one, two, depth)
        for (one, two), depth in zip(found.pairs.tolist(), found.depth.tolist(), strict=True)
    ]


def thickness(solid: Polytope) -> float:
    """The least of the solid's extents behind its faces [m]."""
    points = solid.vertices
    return min(
        float(((points[loop[0]] - points) @ solid.normal(face)).max())
        for face, loop in enumerate(solid.faces)
    )
