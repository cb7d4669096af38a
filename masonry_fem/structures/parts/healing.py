"""Healing: move points a little until their Voronoi cells have no short edges.

    tiling = healed(Tiling.of(points, size), shortest=0.05)     # [m]

Thin stones have short edges, which give poor meshes and poor contacts. Each round makes the smallest move of
the points that would, to first order, bring all short edges to the wanted length (Gauss-Newton). A penalty on
the change of the other edges keeps these from becoming short or inverted.
"""

from __future__ import annotations

import numpy as np

from masonry_fem.solid.mesh import IntArray
from masonry_fem.solid.pose import FloatArray
from masonry_fem.structures.parts.voronoi import Tiling

ROUNDS = 60  # mostly 3 to 8 suffice
SURPLUS = 1.1  # times the shortest length: the target, so that the last round exceeds the shortest length
DAMPING = 0.5  # weight of a move relative to the change of edge lengths
FARTHEST = 0.1  # of a cell's size: largest move of a point in a round


def healed(tiling: Tiling, shortest: float) -> Tiling:
    """The tiling with its points moved until no edge is too short, or the best one found.

    Parameters
    ----------
    tiling : Voronoi cells in a box.
    shortest : Wanted length of the shortest edge [m].
    """
    best, longest = tiling, 0.0
    farthest = FARTHEST * tiling.cell_size
    margin = 1e-3 * tiling.cell_size
    for _ in range(ROUNDS):
        least = float(edge_lengths(tiling).min())
        if least >= shortest:
            return tiling
        if least > longest:
            best, longest = tiling, least
        move = _move(tiling, SURPLUS * shortest)
        length = np.linalg.norm(move, axis=1, keepdims=True)
        move *= np.minimum(1.0, farthest / np.maximum(length, margin))
        tiling = Tiling.of(np.clip(tiling.points + move, margin, tiling.size - margin), tiling.size)
    return best


def edge_lengths(tiling: Tiling) -> FloatArray:
    """Of all edges of all cells [m], shape (e,)."""
    one, two = tiling.edges().T
    return np.asarray(np.linalg.norm(tiling.vertices[one] - tiling.vertices[two], axis=1))


def _move(tiling: Tiling, wanted: float) -> FloatArray:
    """Least move of the points, to first order, to bring all edges shorter than ``wanted`` to it."""
    from scipy.sparse import csr_array  # noqa: PLC0415  slow to load
    from scipy.sparse.linalg import lsqr  # noqa: PLC0415

    edges = tiling.edges()
    along = tiling.vertices[edges[:, 1]] - tiling.vertices[edges[:, 0]]
    length = np.linalg.norm(along, axis=1)
    short = length < wanted
    edges, along, length = edges[short], along[short] / length[short, None], length[short]
    around = _around(tiling, np.unique(edges))
    entries: list[tuple[int, int, FloatArray]] = []
    for row, ((start, end), unit) in enumerate(zip(edges.tolist(), along, strict=True)):
        for vertex, sign in ((start, -1.0), (end, 1.0)):
            slopes = _slopes(tiling, vertex, around[vertex], sign * unit)
            entries += [(row, cell, slope) for cell, slope in slopes]
    count, d = tiling.points.shape
    rows = np.repeat([row for row, _, _ in entries], d)
    columns = np.concatenate([d * cell + np.arange(d) for _, cell, _ in entries])
    values = np.concatenate([slope for _, _, slope in entries])
    jacobian = csr_array((values, (rows, columns)), shape=(len(edges), count * d))
    return np.asarray(lsqr(jacobian, wanted - length, damp=DAMPING, atol=1e-6, btol=1e-6)[0]).reshape(
        count, d
    )


def _around(tiling: Tiling, wanted: IntArray) -> dict[int, tuple[list[int], list[int]]]:
    """Cells that meet in each wanted vertex, and axes of the box's sides that it lies on."""
    touching: dict[int, tuple[set[int], set[int]]] = {int(vertex): (set(), set()) for vertex in wanted}
    for loop, (one, two) in zip(tiling.faces, tiling.sides.tolist(), strict=True):
        for vertex in loop:
            if vertex in touching:
                cells, axes = touching[vertex]
                cells.add(one)
                if two >= 0:
                    cells.add(two)
                else:
                    axes.add((-1 - two) // 2)
    return {vertex: (sorted(cells), sorted(axes)) for vertex, (cells, axes) in touching.items()}


def _slopes(
    tiling: Tiling, vertex: int, around: tuple[list[int], list[int]], direction: FloatArray
) -> list[tuple[int, FloatArray]]:
    """Derivatives of a vertex's place along ``direction`` by the points of the cells about it.

    The vertex v is as far from all these points: (p_i - p_0) v = (|p_i|² - |p_0|²) / 2, and keeps to its
    sides of the box.
    """
    cells, axes = around
    place, d = tiling.vertices[vertex], len(tiling.size)
    arms = tiling.points[cells] - place
    rows = np.concatenate([np.eye(d)[axes], arms[1:] - arms[0]])
    # as many conditions as axes, except where more cells meet in a vertex than is usual
    weights = np.linalg.lstsq(rows.T, direction, rcond=None)[0][len(axes) :]
    shares = [-weights.sum(), *weights]
    return [(cell, share * arm) for cell, share, arm in zip(cells, shares, arms, strict=True)]
