"""Quadrature over the pieces that two meshes cut out of a polygon.

A piece is the common part of the polygon and one facet of each side; there the shape functions of
both sides are polynomials. Parallelograms get tensor-product Gauss points, other pieces a fan of triangles,
or of quadrilaterals where Gauss points are enough for their varying Jacobian, too.
On affine facets, products of linear (line, triangle) or bilinear shape functions of both sides are integrated
exactly; on quadratic facets, the consistent forces of a uniform pressure are.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np

from masonry_fem.contact.clipping import clip, polygon_area
from masonry_fem.host.compiled import compiled, put
from masonry_fem.solid.mesh import IntArray
from masonry_fem.solid.pose import FloatArray

SLIVER = 1e-12  # of the polygon's area: pieces below it are rounding

_A, _B = 0.445948490915965, 0.091576213509771
_DEGREE2 = np.array([[2 / 3, 1 / 6, 1 / 6], [1 / 6, 2 / 3, 1 / 6], [1 / 6, 1 / 6, 2 / 3]])
_DEGREE4 = np.array(
    [[1 - 2 * a, a, a] for a in (_A, _B)]
    + [[a, 1 - 2 * a, a] for a in (_A, _B)]
    + [[a, a, 1 - 2 * a] for a in (_A, _B)]
)
_DEGREE4_WEIGHT = np.array([0.223381589678011, 0.109951743655322] * 3)

type Rules = tuple[tuple[FloatArray, FloatArray], tuple[FloatArray, FloatArray]]


def quadrature(
    polygon: FloatArray,
    candidate: FloatArray,
    antagonist: FloatArray,
    degree: int,
    quadratic: bool,
    density: int,
) -> tuple[FloatArray, FloatArray, IntArray]:
    """Points and weights that integrate products of shape functions of both sides over a polygon.

    Parameters
    ----------
    polygon : Corners in the common plane, shape (k, p) with p = d − 1 [m].
    candidate, antagonist : Facets of either side in the same plane, shape (f, k, p) [m]; an unmeshed side
        is one facet, the polygon itself.
    degree : Of the rule for triangles, 2 or 4.
    quadratic : Whether facets are of second order.
    density : Subdivisions of each piece along its sides.

    Returns
    -------
    Points (m, p), weights (m,) and rows of the facets of both sides (m, 2).
    """
    order = 3 if quadratic else 2
    if polygon.shape[1] == 1:
        facets = candidate, antagonist
        ranges = [np.array([[0, len(own)]]) for own in facets]
        return gauss_lines(polygon[None], np.zeros((1, 1)), np.ones((1, 1)), facets, ranges, order, density)[
            1:
        ]
    tensor, triangle = rules_of(degree, order)
    return on_polygon(polygon, candidate, antagonist, *tensor, *triangle, density, False)  # type: ignore[no-any-return]


def rules_of(degree: int, order: int) -> Rules:
    """Points and weights on [-1, 1], and on a triangle.

    Parameters
    ----------
    degree : Of the rule for triangles, 2 or 4.
    order : Gauss points on [-1, 1].
    """
    triangle = (_DEGREE2, np.full(3, 1 / 3)) if degree == 2 else (_DEGREE4, _DEGREE4_WEIGHT)
    return gauss_rule(order), triangle


@cache
def gauss_rule(order: int, density: int = 1) -> tuple[FloatArray, FloatArray]:
    """Gauss points and weights on equal parts of [-1, 1]; NumPy computes them anew each time.

    Parameters
    ----------
    order : Points of each part. density : Number of parts.
    """
    local, weight = np.polynomial.legendre.leggauss(order)
    middle = 2.0 * np.arange(density) + 1.0 - density
    return ((middle[:, None] + local) / density).ravel(), np.tile(weight / density, density)


@cache
def triangle_rule(order: int) -> tuple[FloatArray, FloatArray]:
    """Barycentric points and weights of a triangle: Gauss points of a square, one side drawn to a corner."""
    local, weight = gauss_rule(order)
    u, v = (grid.ravel() for grid in np.meshgrid(0.5 * (1 + local), 0.5 * (1 + local), indexing="ij"))
    points = np.stack([u, (1 - u) * v, (1 - u) * (1 - v)], axis=1)
    return points, 0.5 * (1 - u) * np.outer(weight, weight).ravel()


def gauss_lines(
    polygon: FloatArray,
    origin: FloatArray,
    along: FloatArray,
    facets: Sequence[FloatArray],
    ranges: Sequence[IntArray],
    order: int,
    density: int = 1,
) -> tuple[IntArray, FloatArray, FloatArray, IntArray]:
    """Gauss points of the common intervals of many lines and the facets of both sides (2D).

    Parameters
    ----------
    polygon : Ends of the lines, shape (k, 2, 1) [m].
    origin, along : Origins and unit vectors of the lines, shape (k, p) each [m].
    facets : Nodes of the facets of candidate and antagonist, in the same axes, shape (f, v, p) each [m].
    ranges : First facet of each line and the one after its last, shape (k, 2) each; −1 where the side has
        none and the line is one facet.
    order : Gauss points of each part of an interval.
    density : Equal parts of each interval.

    Returns
    -------
    Line (q,), place on it (q, 1), weight (q,) and facets of both sides (q, 2) of the points.
    """
    count = [np.where(own[:, 0] < 0, 1, own[:, 1] - own[:, 0]) for own in ranges]
    both = count[0] * count[1]
    line = np.repeat(np.arange(len(polygon)), both)
    number = np.arange(len(line)) - np.repeat(np.cumsum(both) - both, both)
    low, high = polygon.min(axis=(1, 2))[line], polygon.max(axis=(1, 2))[line]
    least = SLIVER * (high - low)
    rows = np.full((len(line), 2), -1)
    for side, own in enumerate((number // count[1][line], number % count[1][line])):
        if len(facets[side]):
            rows[:, side] = ranges[side][line, 0] + own
            ends = facets[side][rows[:, side]] - origin[line, None]
            ends = np.einsum("nkd,nd->nk", ends, along[line])
            low, high = np.maximum(low, ends.min(axis=1)), np.minimum(high, ends.max(axis=1))
    kept = high - low > least
    line, rows, low, high = line[kept], rows[kept], low[kept], high[kept]
    local, weight = gauss_rule(order, density)
    length = (high - low)[:, None]
    return (
        np.repeat(line, len(local)),
        (low[:, None] + length * (0.5 * (1 + local))).reshape(-1, 1),
        (length * (0.5 * weight)).ravel(),
        np.repeat(rows, len(local), axis=0),
    )


@compiled
def on_polygon(
    polygon: FloatArray,
    candidate: FloatArray,
    antagonist: FloatArray,
    gauss: FloatArray,
    gauss_weight: FloatArray,
    barycentric: FloatArray,
    weight: FloatArray,
    density: int,
    quadrilaterals: bool,
) -> tuple[FloatArray, FloatArray, IntArray]:
    """The compiled loop of ``quadrature`` over the pieces of a polygon (3D).

    Parameters
    ----------
    polygon, candidate, antagonist : As for ``quadrature``.
    gauss, gauss_weight : Gauss points of [-1, 1] and their weights, which sum to 2, shape (g,) each.
    barycentric, weight : Points of a triangle, and weights that sum to 1, shapes (t, 3) and (t,).
    density : Subdivisions of each piece along its sides.
    quadrilaterals : Whether Gauss points will do on those that are no parallelograms: half as many points.

    Returns
    -------
    Points (m, 2), weights (m,) and rows of the facets of both sides (m, 2).
    """
    size = np.sqrt(polygon_area(polygon))
    pieces, corners, rows = _pieces(polygon, candidate, antagonist, 1e-9 * size)
    each = max(len(gauss) ** 2, len(weight)) * (pieces.shape[1] - 2) * density * density
    points, weights = np.empty((len(pieces) * each, 2)), np.empty(len(pieces) * each)
    owner = np.empty((len(pieces) * each, 2), dtype=np.int64)
    total = np.int64(0)  # a bare 0 has a type of its own, for which loops would be compiled once more
    part = np.empty((4, 2))
    for number in range(len(pieces)):
        piece = pieces[number, : corners[number]]
        before = total
        step = 2 if quadrilaterals or _is_parallelogram(piece, 1e-9 * size) else 1
        for i in range(1, len(piece) - 1, step):
            for k in range(4):  # corner 0, and those from i on
                part[k] = piece[min(i + k - 1, len(piece) - 1) if k > 0 else 0]
            if step == 2 and i + 2 < len(piece):
                total = _on_quadrilateral(part, gauss, gauss_weight, density, points, weights, total)
            else:
                total = _on_triangle(part[:3], barycentric, weight, density, points, weights, total)
        for i in range(before, total):
            owner[i, 0], owner[i, 1] = rows[number, 0], rows[number, 1]
    return points[:total], weights[:total], owner[:total]


@compiled
def _pieces(
    polygon: FloatArray, candidate: FloatArray, antagonist: FloatArray, tolerance: float
) -> tuple[FloatArray, IntArray, IntArray]:
    """Common parts of the polygon and one facet of each side.

    Corners, padded (m, k, 2), their numbers (m,) and the facets' rows (m, 2).
    """
    most = len(polygon) + candidate.shape[1] + antagonist.shape[1]
    room = len(candidate) + len(antagonist)
    pieces = np.empty((room, most, 2))
    found = np.empty((room, 3), dtype=np.int64)  # rows, number of corners
    total = 0
    smallest = SLIVER * polygon_area(polygon)
    for i in range(len(candidate)):
        if _apart(polygon, candidate[i]):
            continue
        part = clip(polygon, candidate[i], tolerance)
        if len(part) < 3:
            continue
        for j in range(len(antagonist)):
            if _apart(part, antagonist[j]):
                continue
            piece = clip(part, antagonist[j], tolerance)
            if len(piece) < 3 or polygon_area(piece) <= smallest:
                continue
            if total == len(pieces):
                more, also = np.empty((2 * total, most, 2)), np.empty((2 * total, 3), dtype=np.int64)
                put(more, pieces)
                put(also, found)
                pieces, found = more, also
            put(pieces[total], piece)
            found[total, 0], found[total, 1], found[total, 2] = i, j, len(piece)
            total += 1
    return pieces[:total], found[:total, 2], found[:total, :2]


@compiled
def _apart(first: FloatArray, second: FloatArray) -> bool:
    """Whether the bounding boxes of two polygons have nothing in common."""
    for axis in range(2):
        low = high = first[0, axis]
        for point in first:
            low, high = min(low, point[axis]), max(high, point[axis])
        below = above = True
        for point in second:
            below = below and point[axis] <= low
            above = above and point[axis] >= high
        if below or above:
            return True
    return False


@compiled
def _is_parallelogram(piece: FloatArray, tolerance: float) -> bool:
    """Whether a piece has four corners, and opposite sides that differ by no more than a tolerance [m]."""
    if len(piece) != 4:
        return False
    miss = piece[0] - piece[1] + piece[2] - piece[3]
    return bool(max(abs(miss[0]), abs(miss[1])) < tolerance)


@compiled
def _on_quadrilateral(
    piece: FloatArray,
    gauss: FloatArray,
    gauss_weight: FloatArray,
    density: int,
    points: FloatArray,
    weights: FloatArray,
    total: int,
) -> int:
    """Tensor-product Gauss points of a convex quadrilateral, mapped bilinearly."""
    along, across = np.empty(2), np.empty(2)
    for row in range(density):
        for column in range(density):
            for j in range(len(gauss)):
                for i in range(len(gauss)):
                    x = (column + 0.5 * (1 + gauss[i])) / density
                    y = (row + 0.5 * (1 + gauss[j])) / density
                    for axis in range(2):
                        a, b, c, d = piece[0, axis], piece[1, axis], piece[2, axis], piece[3, axis]
                        points[total, axis] = a + x * (b - a) + y * (d - a) + x * y * (a - b + c - d)
                        along[axis], across[axis] = (
                            (1 - y) * (b - a) + y * (c - d),
                            (1 - x) * (d - a) + x * (c - b),
                        )
                    area = along[0] * across[1] - along[1] * across[0]
                    weights[total] = 0.25 * area * gauss_weight[i] * gauss_weight[j] / density**2
                    total += 1
    return total


@compiled
def _on_triangle(
    triangle: FloatArray,
    barycentric: FloatArray,
    weight: FloatArray,
    density: int,
    points: FloatArray,
    weights: FloatArray,
    total: int,
) -> int:
    area = polygon_area(triangle)
    for row in range(density):
        for column in range(density - row):
            for turned in range(2 if column < density - row - 1 else 1):
                sign = 1.0 - 2.0 * turned  # the upside-down triangle hangs from the opposite corner
                for k in range(len(weight)):
                    x = (column + turned + sign * barycentric[k, 1]) / density
                    y = (row + turned + sign * barycentric[k, 2]) / density
                    for axis in range(2):
                        p = triangle[0, axis]
                        along = x * (triangle[1, axis] - p) + y * (triangle[2, axis] - p)
                        points[total, axis] = p + along
                    weights[total] = area * weight[k] / density**2
                    total += 1
    return total
