"""Clipping: the common part of two convex polygons of one plane (Sutherland and Hodgman).

Polygons are corner points in counter-clockwise order, shape (k, 2). Distances below ``tolerance``
count as touching; the result has neither double nor collinear corners.
"""

from __future__ import annotations

import numpy as np

from masonry_fem.host.compiled import compiled, put
from masonry_fem.solid.mesh import IntArray
from masonry_fem.solid.pose import FloatArray

STRAIGHT = 1e-9  # sine of a turn below which three corners are on a line


@compiled
def clip(subject: FloatArray, window: FloatArray, tolerance: float) -> FloatArray:
    """Common part of two convex polygons, shape (k, 2); k = 0 where they have none.

    Parameters
    ----------
    subject, window : Corners in counter-clockwise order, shapes (n, 2) and (m, 2) [m].
    tolerance : Distance below which they merely touch, and corners coincide [m].

    References
    ----------
    Sutherland, Hodgman, Reentrant polygon clipping, Comm. ACM 17 (1974).
    """
    now = np.empty((len(subject) + len(window), 2))
    new = np.empty_like(now)
    count = len(subject)
    put(now, subject)
    for edge in range(len(window)):
        px, py = window[edge, 0], window[edge, 1]
        after = (edge + 1) % len(window)
        ex, ey = window[after, 0] - px, window[after, 1] - py
        length = np.hypot(ex, ey)
        if length <= tolerance:
            continue
        kept = 0
        for i in range(count):
            j = (i + 1) % count
            di = (ex * (now[i, 1] - py) - ey * (now[i, 0] - px)) / length
            dj = (ex * (now[j, 1] - py) - ey * (now[j, 0] - px)) / length
            if di >= -tolerance:
                new[kept, 0], new[kept, 1] = now[i, 0], now[i, 1]
                kept += 1
            # a corner on the window's edge is kept already and is the crossing itself
            if (di > tolerance and dj < -tolerance) or (di < -tolerance and dj > tolerance):
                for axis in range(2):
                    new[kept, axis] = now[i, axis] + di / (di - dj) * (now[j, axis] - now[i, axis])
                kept += 1
        now, new = new, now
        count = kept
        if count == 0:
            break
    return tidy(now[:count], tolerance)  # type: ignore[no-any-return]


@compiled
def tidy(polygon: FloatArray, tolerance: float) -> FloatArray:
    """The polygon without corners that coincide or lie on a straight side."""
    kept = np.empty_like(polygon)
    count = 0
    for i in range(len(polygon)):
        x, y = polygon[i, 0], polygon[i, 1]
        if count == 0 or np.hypot(x - kept[count - 1, 0], y - kept[count - 1, 1]) > tolerance:
            kept[count, 0], kept[count, 1] = x, y
            count += 1
    while (
        count > 1 and np.hypot(kept[0, 0] - kept[count - 1, 0], kept[0, 1] - kept[count - 1, 1]) <= tolerance
    ):
        count -= 1
    result = np.empty((count, 2))
    left = 0
    for i in range(count):
        before, after = (i - 1) % count, (i + 1) % count
        ax, ay = kept[i, 0] - kept[before, 0], kept[i, 1] - kept[before, 1]
        bx, by = kept[after, 0] - kept[i, 0], kept[after, 1] - kept[i, 1]
        if ax * by - ay * bx > STRAIGHT * np.hypot(ax, ay) * np.hypot(bx, by):
            result[left, 0], result[left, 1] = kept[i, 0], kept[i, 1]
            left += 1
    return result[:left] if left >= 3 else result[:0]


@compiled
def polygon_area(polygon: FloatArray) -> float:
    """Area of a polygon, positive where it runs counter-clockwise."""
    total = 0.0
    for i in range(1, len(polygon) - 1):
        ax, ay = polygon[i, 0] - polygon[0, 0], polygon[i, 1] - polygon[0, 1]
        bx, by = polygon[i + 1, 0] - polygon[0, 0], polygon[i + 1, 1] - polygon[0, 1]
        total += 0.5 * (ax * by - ay * bx)
    return total


@compiled
def depths(polygon: FloatArray, points: FloatArray) -> FloatArray:
    """Distances of points from the nearest side of a convex polygon, negative outside it, shape (m,) [m].

    Parameters
    ----------
    polygon : Corners in counter-clockwise order, shape (k, 2); or the ends of an interval in either order,
        shape (2, 1) [m].
    points : Shape (m, 2) or (m, 1) [m].
    """
    result = np.full(len(points), np.inf)
    if polygon.shape[1] == 1:
        low, high = min(polygon[0, 0], polygon[1, 0]), max(polygon[0, 0], polygon[1, 0])
        for i in range(len(points)):
            result[i] = min(points[i, 0] - low, high - points[i, 0])
        return result
    for edge in range(len(polygon)):
        px, py = polygon[edge, 0], polygon[edge, 1]
        after = (edge + 1) % len(polygon)
        ex, ey = polygon[after, 0] - px, polygon[after, 1] - py
        length = np.hypot(ex, ey)
        if length > 0:
            for i in range(len(points)):
                depth = (ex * (points[i, 1] - py) - ey * (points[i, 0] - px)) / length
                result[i] = min(result[i], depth)
    return result


@compiled
def locate(polygons: FloatArray, points: FloatArray, tolerance: float) -> IntArray:
    """Which polygon holds each point, or the nearest one where none does, shape (m,).

    Parameters
    ----------
    polygons : Convex, corners in counter-clockwise order, shape (f, k, 2) [m].
    points : Shape (m, 2) [m].
    tolerance : A point that is this much outside a polygon still lies in it [m]; so the first of two polygons
        holds the points on their common side, whatever the rounding.
    """
    best = np.full(len(points), -np.inf)
    found = np.zeros(len(points), dtype=np.int64)
    for number in range(len(polygons)):
        depth = depths(polygons[number], points)
        for i in range(len(points)):
            # the first polygon holds points on a common side, whatever the rounding
            if depth[i] > best[i] and best[i] < -tolerance:
                best[i] = depth[i]
                found[i] = number
    return found


def common_parts(
    at: FloatArray,
    count: IntArray,
    candidate: IntArray,
    antagonist: IntArray,
    origin: FloatArray,
    basis: FloatArray,
    tolerance: FloatArray,
) -> tuple[FloatArray, IntArray, FloatArray]:
    """Common parts of pairs of convex faces, seen along the normals of common planes.

    Parameters
    ----------
    at, count : Corners of all faces, padded, shape (f, k, d) [m], and how many are real, shape (f,).
    candidate, antagonist : Faces of each pair, which look at each other, each of shape (m,).
    origin : Origin of each common plane, shape (m, d) [m].
    basis : Its unit vectors, right-handed with the antagonist's outward normal, shape (m, d - 1, d).
    tolerance : Distance below which polygons merely touch, shape (m,) [m].

    Returns
    -------
    Corners in the planes, padded (m, k, d - 1) [m]; how many are real (m,); areas, in 2D lengths (m,).
    """
    if at.shape[2] == 3:
        # one layout, or all of it is compiled twice
        pairs_and_planes = map(np.ascontiguousarray, (candidate, antagonist, origin, basis))
        return _common_polygons(at, count, *pairs_and_planes, tolerance)  # type: ignore[no-any-return]
    along = [
        np.einsum("mkd,md->mk", at[rows] - origin[:, None], basis[:, 0]) for rows in (candidate, antagonist)
    ]
    low = np.maximum(along[0].min(axis=1), along[1].min(axis=1))
    high = np.minimum(along[0].max(axis=1), along[1].max(axis=1))
    return np.stack([low, high], axis=1)[:, :, None], np.where(high > low, 2, 0), np.maximum(high - low, 0.0)


@compiled
def _common_polygons(
    at: FloatArray,
    count: IntArray,
    candidate: IntArray,
    antagonist: IntArray,
    origin: FloatArray,
    basis: FloatArray,
    tolerance: FloatArray,
) -> tuple[FloatArray, IntArray, FloatArray]:
    pairs = len(candidate)
    result = np.zeros((pairs, 2 * at.shape[1], 2))
    corners, area = np.zeros(pairs, dtype=np.int64), np.zeros(pairs)
    for m in range(pairs):
        c, a = candidate[m], antagonist[m]
        subject, window = np.empty((count[c], 2)), np.empty((count[a], 2))
        for p in range(2):
            for k in range(count[c]):  # outward of the candidate is against the normal: turn round
                subject[count[c] - 1 - k, p] = ((at[c, k] - origin[m]) * basis[m, p]).sum()
            for k in range(count[a]):
                window[k, p] = ((at[a, k] - origin[m]) * basis[m, p]).sum()
        polygon = clip(subject, window, tolerance[m])
        corners[m] = len(polygon)
        put(result[m], polygon)
        area[m] = polygon_area(polygon)
    return result, corners, area
