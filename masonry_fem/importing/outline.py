"""Outline: the flat faces of a meshed body, from its boundary facets.

Neighbouring facets in one plane and of one name become one polygon; what is curved, or has holes,
stays facet by facet.
"""

from __future__ import annotations

from collections import defaultdict

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from masonry_fem.meshing.cells import corner_count
from masonry_fem.solid.mesh import FACET_OF, IntArray
from masonry_fem.solid.polytope import Polytope
from masonry_fem.solid.pose import FloatArray

FLAT = 1e-6  # distance from a common plane, and sine of a kink, that count as none


def outline(
    points: FloatArray,
    cell: str,
    facets: IntArray,
    names: list[str],
    unnamed: str,
    conforming: bool = False,
    flat: float = FLAT,
) -> tuple[Polytope, IntArray]:
    """The polytope bounded by facets, and the face that each facet lies on.

    Parameters
    ----------
    points : Nodes, shape (n, d). cell : Kind of the cells. facets : Outward, shape (f, k).
    names : Name of each facet ("" for none), which also becomes the face's joint label.
    unnamed : Joint label of the faces without a name.
    conforming : A corner in which one face bends stays in all that meet there, also in those that go
        straight on: what meshes the faces needs it.
    flat : Distance from a common plane, over its size, and sine of a kink that count as none.
    """
    corners = facets[:, : corner_count(FACET_OF[cell])]
    normals = _normals(points[corners])
    patches = _patches(corners, normals, names, flat)
    loops: list[tuple[int, ...]] = []
    labels: list[str] = []
    owner = np.empty(len(facets), dtype=np.int64)
    for patch in range(patches.max() + 1):
        members = np.flatnonzero(patches == patch)
        loop = _loop(points, corners[members], normals[members], flat)
        if loop is None:  # curved or holed
            for facet in members:
                owner[facet] = len(loops)
                loops.append(tuple(int(v) for v in corners[facet]))
                labels.append(names[facet])
            continue
        owner[members] = len(loops)
        loops.append(loop)
        labels.append(names[members[0]])
    if points.shape[1] == 3:
        loops = _straightened(points, loops, conforming, flat)
    used, faces = _compact(loops)
    solid = Polytope(points[used], faces, tuple(labels), tuple(label or unnamed for label in labels))
    return solid, owner


def _normals(corners: FloatArray) -> FloatArray:
    """Unit normals of facets given by corner positions, shape (f, k, d)."""
    if corners.shape[2] == 2:
        edge = corners[:, 1] - corners[:, 0]
        area = np.column_stack([edge[:, 1], -edge[:, 0]])
    else:
        spokes = corners[:, 1:] - corners[:, :1]
        area = np.cross(spokes[:, :-1], spokes[:, 1:]).sum(axis=1)
    return np.asarray(area / np.linalg.norm(area, axis=1, keepdims=True))


def _sides(corners: IntArray) -> IntArray:
    """Sides of facets: their edges (k, 2), or end points in 2D (k, 1), facet by facet."""
    if corners.shape[1] == 2:
        return corners[:, :, None]
    return np.stack([corners, np.roll(corners, -1, axis=1)], axis=2)


def _patches(corners: IntArray, normals: FloatArray, names: list[str], kink: float) -> IntArray:
    """Number of the flat patch of each facet: neighbours without a kink, of one name."""
    count, per = corners.shape[0], corners.shape[1]
    sides = np.sort(_sides(corners).reshape(count * per, -1), axis=1)
    order = np.lexsort(sides.T)
    same = (sides[order][1:] == sides[order][:-1]).all(axis=1)
    first, second = order[:-1][same] // per, order[1:][same] // per
    flat = np.linalg.norm(normals[first] - normals[second], axis=1) < kink
    alike = np.array(names)[first] == np.array(names)[second]
    joined = flat & alike
    graph = sparse.coo_array(
        (np.ones(int(joined.sum())), (first[joined], second[joined])), shape=(count, count)
    )
    return np.asarray(connected_components(graph, directed=False)[1], dtype=np.int64)


def _loop(points: FloatArray, corners: IntArray, normals: FloatArray, flat: float) -> tuple[int, ...] | None:
    """Corners of a patch's outer polygon; None where it is not flat or not a single polygon."""
    size = float(np.ptp(points[corners].reshape(-1, points.shape[1]), axis=0).max())
    heights = (points[corners] - points[corners[0, 0]]) @ normals[0]
    if np.abs(heights).max() > flat * size:
        return None
    if corners.shape[1] == 2:
        start = set(corners[:, 0].tolist()) - set(corners[:, 1].tolist())
        end = set(corners[:, 1].tolist()) - set(corners[:, 0].tolist())
        return (start.pop(), end.pop()) if len(start) == len(end) == 1 else None
    edges = {(int(a), int(b)) for a, b in _sides(corners).reshape(-1, 2)}
    after: dict[int, list[int]] = defaultdict(list)
    for a, b in edges:
        if (b, a) not in edges:
            after[a].append(b)
    if any(len(following) != 1 for following in after.values()):
        return None  # it touches itself in a corner
    loop = [next(iter(sorted(after)))]
    while (following := after[loop[-1]][0]) != loop[0]:
        loop.append(following)
    if len(loop) != len(after):
        return None  # it has a hole
    return tuple(loop)


def _straightened(
    points: FloatArray, loops: list[tuple[int, ...]], conforming: bool, flat: float
) -> list[tuple[int, ...]]:
    """The loops without the corners at which they, or all of them, go straight on."""
    bends = [_bends(points, loop, flat) for loop in loops]
    needed = {
        v for loop, bend in zip(loops, bends, strict=True) for v, b in zip(loop, bend, strict=True) if b
    }
    return [
        tuple(v for v, b in zip(loop, bend, strict=True) if b or (conforming and v in needed))
        for loop, bend in zip(loops, bends, strict=True)
    ]


def _bends(points: FloatArray, loop: tuple[int, ...], flat: float) -> list[bool]:
    before, at, after = (points[np.roll(loop, shift)] for shift in (1, 0, -1))
    there, on = at - before, after - at
    there = there / np.linalg.norm(there, axis=1, keepdims=True)
    on = on / np.linalg.norm(on, axis=1, keepdims=True)
    return [bool(bend) for bend in np.linalg.norm(there - on, axis=1) > flat]


def _compact(loops: list[tuple[int, ...]]) -> tuple[IntArray, tuple[tuple[int, ...], ...]]:
    used = np.unique(np.concatenate([np.array(loop) for loop in loops]))
    number = {int(vertex): index for index, vertex in enumerate(used)}
    return used, tuple(tuple(number[v] for v in loop) for loop in loops)
