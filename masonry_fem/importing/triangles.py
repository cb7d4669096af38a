"""Triangles: polygons in space divided without new corners, convex or not, flat or slightly warped.

A warped quadrilateral is divided along its shorter diagonal, so that two blocks that share it divide it
alike.
"""

from __future__ import annotations

import numpy as np

from masonry_fem.solid.pose import FloatArray

EQUAL = 1e-9  # of a polygon's size: diagonals whose lengths differ by less are equally long


def area_vector(corners: FloatArray) -> FloatArray:
    """Normal times area of a polygon, flat or not, shape (3,) [m²]."""
    spokes = corners - corners[0]
    return np.asarray(0.5 * np.cross(spokes[1:-1], spokes[2:]).sum(axis=0))


def triangles_of(points: FloatArray, loop: tuple[int, ...]) -> list[tuple[int, int, int]]:
    """Triangles of a polygon, oriented as the polygon is.

    Parameters
    ----------
    points : All points, shape (n, 3) [m].
    loop : Point numbers of the corners, in order.
    """
    if len(loop) == 3:
        return [(loop[0], loop[1], loop[2])]
    flat = _flattened(points[list(loop)])
    turns = [turn(flat[i - 1], flat[i], flat[(i + 1) % len(flat)]) for i in range(len(flat))]
    if len(loop) == 4 and min(turns) > 0:
        return _quartered(points, loop)
    return [(loop[a], loop[b], loop[c]) for a, b, c in ears(flat)]


def ears(flat: FloatArray) -> list[tuple[int, int, int]]:
    """Triangles of a counter-clockwise polygon of the plane, by its fattest ears; rows of ``flat``."""
    rows, made = list(range(len(flat))), []
    while len(rows) > 3:
        best, fattest = 0, -np.inf
        for i in range(len(rows)):
            a, b, c = rows[i - 1], rows[i], rows[(i + 1) % len(rows)]
            area = turn(flat[a], flat[b], flat[c])
            longest = max(_length(flat[a], flat[b]), _length(flat[b], flat[c]), _length(flat[c], flat[a]))
            fat = area / longest**2 if longest > 0 else 0.0
            if fat > fattest and (fat <= 0 or not _holds_another(flat, rows, a, b, c)):
                best, fattest = i, fat
        made.append((rows[best - 1], rows[best], rows[(best + 1) % len(rows)]))
        del rows[best]
    return [*made, (rows[0], rows[1], rows[2])]


def _flattened(corners: FloatArray) -> FloatArray:
    """Corners in a plane across their normal, counter-clockwise, shape (k, 2)."""
    normal = area_vector(corners)
    normal = normal / np.linalg.norm(normal)
    first = np.cross(normal, np.eye(3)[int(np.argmin(np.abs(normal)))])
    first /= np.linalg.norm(first)
    return np.asarray((corners - corners[0]) @ np.stack([first, np.cross(normal, first)], axis=1))


def _quartered(points: FloatArray, loop: tuple[int, ...]) -> list[tuple[int, int, int]]:
    a, b, c, d = loop
    one, two = _length(points[a], points[c]), _length(points[b], points[d])
    if abs(one - two) <= EQUAL * (one + two):  # choose the same diagonal wherever the loop begins
        shorter = min(tuple(points[a]), tuple(points[c])) < min(tuple(points[b]), tuple(points[d]))
    else:
        shorter = one < two
    return [(a, b, c), (a, c, d)] if shorter else [(a, b, d), (b, c, d)]


def _holds_another(flat: FloatArray, rows: list[int], a: int, b: int, c: int) -> bool:
    """Whether another corner lies in the triangle, or on the side that the cut would make."""
    for row in rows:
        if row in (a, b, c):
            continue
        point = flat[row]
        if (
            turn(flat[a], flat[b], point) > 0
            and turn(flat[b], flat[c], point) > 0
            and turn(flat[c], flat[a], point) >= 0
        ):
            return True
    return False


def turn(a: FloatArray, b: FloatArray, c: FloatArray) -> float:
    """Twice the area of a triangle, positive where its corners run counter-clockwise.

    Parameters
    ----------
    a, b, c : The corners, shape (2,).
    """
    return float((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))


def _length(a: FloatArray, b: FloatArray) -> float:
    return float(np.linalg.norm(a - b))
