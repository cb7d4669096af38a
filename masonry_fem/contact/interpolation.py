"""Interpolation: weights of a facet's nodes at a point on it.

    N = weights(mesh, facets, points)      # displacement at the points: Σ_k N[:, k] u[mesh.facets[facets, k]]

Facets are lines, triangles or quadrilaterals of first or second order in VTK node order. The
weights sum to one and reproduce linear fields; a point off the facet is projected on it.
"""

from __future__ import annotations

import numpy as np

from masonry_fem.host.compiled import compiled, put
from masonry_fem.solid.mesh import IntArray, Mesh
from masonry_fem.solid.pose import FloatArray

LINE, TRIANGLE, QUAD, LINE3, TRIANGLE6, QUAD9 = range(6)
KINDS = {
    "line": LINE, "triangle": TRIANGLE, "quad": QUAD, "line3": LINE3, "triangle6": TRIANGLE6, "quad9": QUAD9,
}  # fmt: skip
CORNERS_OF = {"line": 2, "line3": 2, "triangle": 3, "triangle6": 3, "quad": 4, "quad9": 4}
NEWTON_LIMIT = 30

# node of a 3×3 tensor grid (column, row) for each node of the 9-node quadrilateral
_GRID = np.array([[0, 0], [2, 0], [2, 2], [0, 2], [1, 0], [2, 1], [1, 2], [0, 1], [1, 1]])


def weights(mesh: Mesh, facets: IntArray, points: FloatArray) -> FloatArray:
    """Shape functions of boundary facets at points.

    Parameters
    ----------
    mesh : Mesh of the shape.
    facets : Facet that carries each point, shape (k,).
    points : Points in the shape's frame [m], shape (k, d).

    Returns
    -------
    FloatArray
        Weight of each node of the facet, shape (k, nodes of a facet).
    """
    nodes = mesh.points[mesh.facets[np.asarray(facets, dtype=np.int64)]]
    found: FloatArray = weights_at(KINDS[mesh.facet], nodes, np.ascontiguousarray(points, dtype=float))
    return found


@compiled
def weights_at(kind: int, nodes: FloatArray, points: FloatArray) -> FloatArray:
    """Shape functions of facets at points, shape (k, n).

    Parameters
    ----------
    kind : Number of the facet's kind.
    nodes : Nodes of each facet, shape (k, n, d) [m].
    points : One point per facet, shape (k, d) [m].
    """
    result = np.empty(nodes.shape[:2])
    for i in range(len(points)):
        put(result[i], _shape(kind, _inverse(kind, nodes[i], points[i]))[0])
    return result


@compiled
def _inverse(kind: int, nodes: FloatArray, point: FloatArray) -> FloatArray:
    """Local coordinates of the facet point nearest to ``point``, by Gauss-Newton, shape (2,)."""
    local = np.zeros(2)
    if kind in (TRIANGLE, TRIANGLE6):
        local[0] = local[1] = 1 / 3
    flat = kind in (LINE, LINE3)
    for _ in range(NEWTON_LIMIT):
        value, slope = _shape(kind, local)
        a = b = c = r = s = 0.0
        for axis in range(nodes.shape[1]):
            miss, x1, x2 = point[axis], 0.0, 0.0
            for n in range(nodes.shape[0]):
                miss -= value[n] * nodes[n, axis]
                x1 += slope[0, n] * nodes[n, axis]
                x2 += slope[1, n] * nodes[n, axis]
            a += x1 * x1
            b += x1 * x2
            c += x2 * x2
            r += x1 * miss
            s += x2 * miss
        if flat:
            d1, d2 = r / a, 0.0
        else:
            determinant = a * c - b * b
            d1, d2 = (c * r - b * s) / determinant, (a * s - b * r) / determinant
        local[0] += d1
        local[1] += d2
        if abs(d1) + abs(d2) < 1e-14:
            break
    return local


@compiled
def _quadratic(t: float) -> tuple[FloatArray, FloatArray]:
    """Quadratic polynomials of the nodes −1, 0, 1 and their slopes."""
    return (
        np.array([0.5 * t * (t - 1), 1 - t * t, 0.5 * t * (t + 1)]),
        np.array([t - 0.5, -2 * t, t + 0.5]),
    )


@compiled
def _shape(kind: int, local: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Shape functions (n,) and their slopes (2, n) at local coordinates."""
    x, y = local[0], local[1]
    if kind == LINE:
        return np.array([0.5 * (1 - x), 0.5 * (1 + x)]), np.array([[-0.5, 0.5], [0.0, 0.0]])
    if kind == TRIANGLE:
        return np.array([1 - x - y, x, y]), np.array([[-1.0, 1.0, 0.0], [-1.0, 0.0, 1.0]])
    if kind == QUAD:
        return (
            0.25 * np.array([(1 - x) * (1 - y), (1 + x) * (1 - y), (1 + x) * (1 + y), (1 - x) * (1 + y)]),
            0.25 * np.array([[y - 1, 1 - y, 1 + y, -1 - y], [x - 1, -1 - x, 1 + x, 1 - x]]),
        )
    if kind == LINE3:
        value, slope = _quadratic(x)
        order = np.array([0, 2, 1])
        slopes = np.zeros((2, 3))
        put(slopes[0], slope[order])
        return value[order], slopes
    if kind == TRIANGLE6:
        z = 1 - x - y
        return (
            np.array([z * (2 * z - 1), x * (2 * x - 1), y * (2 * y - 1), 4 * z * x, 4 * x * y, 4 * y * z]),
            np.array([
                [1 - 4 * z, 4 * x - 1, 0.0, 4 * (z - x), 4 * y, -4 * y],
                [1 - 4 * z, 0.0, 4 * y - 1, -4 * x, 4 * x, 4 * (z - y)],
            ]),
        )  # fmt: skip
    values, slopes = np.empty(9), np.empty((2, 9))
    (u, du), (v, dv) = _quadratic(x), _quadratic(y)
    for n in range(9):
        i, j = _GRID[n]
        values[n] = u[i] * v[j]
        slopes[0, n] = du[i] * v[j]
        slopes[1, n] = u[i] * dv[j]
    return values, slopes
