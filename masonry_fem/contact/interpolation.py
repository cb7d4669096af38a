"""Interpolation: weights of a facet's nodes at a point on it.

    N = weights(mesh, facets, points)      # displacement at the points: Σ_k N[:, k] u[mesh.facets[facets, k]]

Facets are lines, triangles or quadrilaterals of first or second order in VTK node order. The
weights sum to one and reproduce linear fields; a point off the facet is projected on it.
"""

from __future__ import annotations

import numpy as np

from masonry_fem.host.compiled import compiled
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
    return weights_on(kind, nodes, np.arange(len(points)), points)  # type: ignore[no-any-return]


@compiled
def weights_on(kind: int, nodes: FloatArray, facet: IntArray, points: FloatArray) -> FloatArray:
    """Shape functions of facets at any number of points on each, shape (k, n).

    Parameters
    ----------
    kind : Number of the facets' kind.
    nodes : Nodes of each facet, shape (f, n, d) [m].
    facet : The facet of each point, shape (k,).
    points : Shape (k, d) [m].
    """
    result = np.empty((len(points), nodes.shape[1]))
    slope = np.zeros((2, nodes.shape[1]))
    local = np.empty(2)
    for i in range(len(points)):
        _invert(kind, nodes[facet[i]], points[i], local, result[i], slope)
        _shape(kind, local[0], local[1], result[i], slope)
    return result


@compiled
def _invert(
    kind: int,
    nodes: FloatArray,
    point: FloatArray,
    local: FloatArray,
    value: FloatArray,
    slope: FloatArray,
) -> None:
    """Local coordinates (2,) of the facet point nearest to ``point``, by Gauss-Newton.

    ``value`` (n,) and ``slope`` (2, n) are room for shape functions.
    """
    local[0] = local[1] = 1 / 3 if kind in (TRIANGLE, TRIANGLE6) else 0.0
    flat = kind in (LINE, LINE3)
    # a step from 1e-8 off ends at rounding, unless the point is off the facet
    last = 1e-8 if nodes.shape[1] == (1 if flat else 2) else 1e-14
    for _ in range(NEWTON_LIMIT):
        _shape(kind, local[0], local[1], value, slope)
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
        if abs(d1) + abs(d2) < last:
            break


@compiled
def _quadratic(t: float) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    """Quadratic polynomials of the nodes −1, 0, 1 and their slopes."""
    return (0.5 * t * (t - 1), 1 - t * t, 0.5 * t * (t + 1)), (t - 0.5, -2 * t, t + 0.5)


@compiled
def _shape(kind: int, x: float, y: float, value: FloatArray, slope: FloatArray) -> None:
    """Shape functions (n,) and their slopes (2, n) at local coordinates."""
    if kind == LINE:
        value[0], value[1] = 0.5 * (1 - x), 0.5 * (1 + x)
        slope[0, 0], slope[0, 1] = -0.5, 0.5
    elif kind == TRIANGLE:
        value[0], value[1], value[2] = 1 - x - y, x, y
        slope[0, 0], slope[0, 1], slope[0, 2] = -1.0, 1.0, 0.0
        slope[1, 0], slope[1, 1], slope[1, 2] = -1.0, 0.0, 1.0
    elif kind == QUAD:
        for n in range(4):
            along = 1.0 if n in (1, 2) else -1.0
            across = 1.0 if n >= 2 else -1.0
            u, v = 1 + along * x, 1 + across * y
            value[n] = 0.25 * (u * v)
            slope[0, n], slope[1, n] = 0.25 * (along * v), 0.25 * (across * u)
    elif kind == LINE3:
        (u0, u1, u2), (d0, d1, d2) = _quadratic(x)
        value[0], value[1], value[2] = u0, u2, u1
        slope[0, 0], slope[0, 1], slope[0, 2] = d0, d2, d1
    elif kind == TRIANGLE6:
        z = 1 - x - y
        value[0], value[1], value[2] = z * (2 * z - 1), x * (2 * x - 1), y * (2 * y - 1)
        value[3], value[4], value[5] = 4 * z * x, 4 * x * y, 4 * y * z
        slope[0, 0], slope[0, 1], slope[0, 2] = 1 - 4 * z, 4 * x - 1, 0.0
        slope[0, 3], slope[0, 4], slope[0, 5] = 4 * (z - x), 4 * y, -4 * y
        slope[1, 0], slope[1, 1], slope[1, 2] = 1 - 4 * z, 0.0, 4 * y - 1
        slope[1, 3], slope[1, 4], slope[1, 5] = -4 * x, 4 * x, 4 * (z - y)
    else:
        u, du = _quadratic(x)
        v, dv = _quadratic(y)
        for n in range(9):
            i, j = _GRID[n]
            value[n] = u[i] * v[j]
            slope[0, n], slope[1, n] = du[i] * v[j], u[i] * dv[j]
