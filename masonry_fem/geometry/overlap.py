"""Overlap: two blocks that penetrate, found by separating axes on their convex hulls."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from masonry_fem.contact.boxes import near_pairs
from masonry_fem.solid.assembly import Assembly
from masonry_fem.solid.mesh import IntArray
from masonry_fem.solid.polytope import Polytope
from masonry_fem.solid.pose import FloatArray

MANY = 20_000  # pairs of edges up to which each gives an axis to try
TOLERANCE = 1e-6  # of the smaller block: round-off of poses stays far below


def overlapping(assembly: Assembly) -> list[tuple[int, int, float]]:
    """Pairs of blocks (numbers) that penetrate, and the depth [m].

    Supports do not move, so they may penetrate each other.
    A pair with a concave block counts only where its hull goes deeper than the concavity.
    """
    solids = [assembly.solid(number) for number in range(len(assembly.blocks))]
    hollows = np.array([_concavity(shape.solid) for shape in assembly.shapes])
    low = np.array([solid.vertices.min(axis=0) for solid in solids])
    high = np.array([solid.vertices.max(axis=0) for solid in solids])
    shape = np.array([block.shape for block in assembly.blocks])
    support = np.array([block.support for block in assembly.blocks])
    slack = TOLERANCE * (high - low).min(axis=1)
    pairs = near_pairs(low, high, 0.0)
    pairs = pairs[~support[pairs].all(axis=1)]
    least = slack[pairs].min(axis=1)
    inside = np.minimum(high[pairs[:, 0]] - low[pairs[:, 1]], high[pairs[:, 1]] - low[pairs[:, 0]]).min(
        axis=1
    )
    allowed = least + hollows[shape[pairs]].sum(axis=1)
    doubtful = np.flatnonzero(inside > least)
    normals = [
        np.array([own.solid.normal(face) for face in range(len(own.solid.faces))]) for own in assembly.shapes
    ]
    axes = [normals[block.shape] @ block.pose.rotation.T for block in assembly.blocks]
    apart = _parted(
        *_packed([solid.vertices for solid in solids]), *_packed(axes), pairs[doubtful], allowed[doubtful]
    )
    found = []
    for number in doubtful[~apart].tolist():
        first, second = pairs[number].tolist()
        penetration = _penetration(solids[first], solids[second], float(allowed[number]))
        if penetration > allowed[number]:
            found.append((first, second, penetration))
    return sorted(found)


def thickness(solid: Polytope) -> float:
    """The least of the solid's extents behind its faces [m]."""
    points = solid.vertices
    return min(
        float(((points[loop[0]] - points) @ solid.normal(face)).max())
        for face, loop in enumerate(solid.faces)
    )


def _packed(arrays: list[FloatArray]) -> tuple[FloatArray, IntArray]:
    """Rows of all arrays one after another, and where each begins, the end of the last included."""
    return np.concatenate(arrays), np.cumsum([0, *(len(array) for array in arrays)])


@njit(cache=True)
def _parted(
    points: FloatArray,
    point_of: IntArray,
    axes: FloatArray,
    axis_of: IntArray,
    pairs: IntArray,
    allowed: FloatArray,
) -> NDArray[np.bool_]:
    """Whether a face's normal parts each pair but for what is allowed: what most pairs need, (m,)."""
    result = np.zeros(len(pairs), dtype=np.bool_)
    for m in range(len(pairs)):
        for side in range(2):
            for axis in range(axis_of[pairs[m, side]], axis_of[pairs[m, side] + 1]):
                ends = np.empty((2, 2))
                for k in range(2):
                    low, high = np.inf, -np.inf
                    for v in range(point_of[pairs[m, k]], point_of[pairs[m, k] + 1]):
                        at = 0.0
                        for c in range(points.shape[1]):
                            at += points[v, c] * axes[axis, c]
                        low, high = min(low, at), max(high, at)
                    ends[k, 0], ends[k, 1] = low, high
                if min(ends[0, 1] - ends[1, 0], ends[1, 1] - ends[0, 0]) <= allowed[m]:
                    result[m] = True
                    break
            if result[m]:
                break
    return result


def _penetration(one: Polytope, two: Polytope, allowed: float) -> float:
    normals = np.array([s.normal(face) for s in (one, two) for face in range(len(s.faces))])
    depth = _least(normals, one, two)
    if depth <= allowed or one.dimension == 2:
        return depth
    first, second = _edges(one), _edges(two)
    if len(first) * len(second) > MANY:  # curved: time and memory grow with the pairs of edges
        return min(depth, _common_ball(one, two))
    crossed = np.cross(first[:, None], second[None]).reshape(-1, 3)
    length = np.linalg.norm(crossed, axis=1)
    axes = crossed[length > 1e-6] / length[length > 1e-6, None]
    return min(depth, _least(axes, one, two)) if len(axes) else depth


def _least(axes: FloatArray, one: Polytope, two: Polytope) -> float:
    a, b = one.vertices @ axes.T, two.vertices @ axes.T
    return float(np.minimum(a.max(0) - b.min(0), b.max(0) - a.min(0)).min())


def _common_ball(one: Polytope, two: Polytope) -> float:
    """Diameter [m] of the largest ball in both hulls: to part them takes at least as much."""
    # loaded only for hulls that do penetrate, as they take a fifth of a second
    from scipy.optimize import linprog  # noqa: PLC0415
    from scipy.spatial import ConvexHull  # noqa: PLC0415

    origin = one.vertices.mean(axis=0)
    size = float(np.ptp(one.vertices, axis=0).max())
    planes = np.concatenate([ConvexHull((s.vertices - origin) / size).equations for s in (one, two)])
    sides = np.column_stack([planes[:, :-1], np.ones(len(planes))])
    aim = np.zeros(sides.shape[1])
    aim[-1] = -1.0  # the largest radius; negative where the hulls are apart
    best = linprog(
        aim,
        A_ub=sides,
        b_ub=-planes[:, -1],
        bounds=(None, None),
        options={"primal_feasibility_tolerance": 1e-10},
    )
    assert best.x is not None  # bounded, and feasible with a negative radius
    return 2 * size * float(best.x[-1])


def _edges(solid: Polytope) -> FloatArray:
    pairs = {tuple(sorted(p)) for f in solid.faces for p in zip(f, (*f[1:], f[0]), strict=True)}
    ends = np.array(sorted(pairs))
    edges = solid.vertices[ends[:, 1]] - solid.vertices[ends[:, 0]]
    unit: FloatArray = edges / np.linalg.norm(edges, axis=1, keepdims=True)
    return unit


def _concavity(solid: Polytope) -> float:
    """How far a vertex lies outside a face's plane [m]; 0 where the solid is convex."""
    size = np.ptp(solid.vertices, axis=0).max()
    out = [
        float(((solid.vertices - solid.face_points(f)[0]) @ solid.normal(f)).max())
        for f in range(len(solid.faces))
    ]
    return max(out) if max(out) > 1e-9 * size else 0.0
