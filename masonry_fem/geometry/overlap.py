"""Overlap: two blocks that penetrate, found by separating axes on their convex hulls."""

from __future__ import annotations

import numpy as np
from scipy.optimize import linprog
from scipy.spatial import ConvexHull

from masonry_fem.solid.assembly import Assembly
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
    hollows = [_concavity(shape.solid) for shape in assembly.shapes]
    low = np.array([solid.vertices.min(axis=0) for solid in solids])
    high = np.array([solid.vertices.max(axis=0) for solid in solids])
    slack = TOLERANCE * (high - low).min(axis=1)
    order = np.argsort(low[:, 0], kind="stable")
    ends = np.searchsorted(low[order, 0], high[order, 0])
    found = []
    for place, one in enumerate(order):
        others = order[place + 1 : ends[place]]
        depth = np.minimum(high[one] - low[others], high[others] - low[one]).min(axis=1)
        for other in others[depth > np.minimum(slack[one], slack[others])]:
            a, b = sorted((int(one), int(other)))
            if assembly.blocks[a].support and assembly.blocks[b].support:
                continue
            allowed = min(slack[a], slack[b])
            allowed += hollows[assembly.blocks[a].shape] + hollows[assembly.blocks[b].shape]
            penetration = _penetration(solids[a], solids[b], allowed)
            if penetration > allowed:
                found.append((a, b, penetration))
    return sorted(found)


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
