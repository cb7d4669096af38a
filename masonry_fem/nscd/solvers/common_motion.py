"""CommonMotion: the motions that bodies share, and that no contact between them resists.

A wall that moves as one rigid body costs no contact anything: these motions are what a smoother of
the bodies' matrix leaves, and what its coarse levels must hold. They follow from the contacts alone:
where B_i U_i + B_j U_j = 0 at all contacts of two bodies, U_j = −(B_jᵀ B_j)⁺ B_jᵀ B_i U_i.

    motions = common_motions(bodies, maps, count)      # (b, m, m)
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse import csgraph

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

# Contacts of two bodies count as a hinge, or less, below this ratio of the eigenvalues of B_jᵀ B_j.
# Motions pass through hinges only where there is no other way.
HINGE = 1e-8
DETOUR = 1e3


def common_motions(bodies: IntArray, maps: FloatArray, count: int) -> FloatArray:
    """One full set of motions for each group of bodies that touch.

    Parameters
    ----------
    bodies : Bodies on the two sides of each contact, −1 for none, shape (c, 2).
    maps : B by contact and side, shape (c, 2, d, m).
    count : Number of bodies b.

    Returns
    -------
    Velocities of each body (rows) in the motions (columns), shape (b, m, m): the identity at one body
    of each group.
    """
    m = maps.shape[3]
    motions = np.tile(np.eye(m), (count, 1, 1))
    inner = np.flatnonzero((bodies >= 0).all(axis=1))
    if not len(inner):
        return motions
    sides = bodies[inner]
    keys, pair = np.unique(sides[:, 0] * count + sides[:, 1], return_inverse=True)
    first, second = keys // count, keys % count
    passing = _passing(maps[inner], pair, len(keys))
    before, hops = _tree(first, second, passing, count)
    edge = _edges(first, second, before, count)
    for distance in range(1, int(hops.max()) + 1):
        here = np.flatnonzero(hops == distance)
        which, forward = edge[here] % len(keys), edge[here] < len(keys)
        along = np.where(forward[:, None, None], passing.forth[which], passing.back[which])
        motions[here] = along @ motions[before[here]]
    return motions


class _Passing:
    """How motions pass between the bodies of pairs: to the second body, to the first, and how surely."""

    def __init__(self, forth: FloatArray, back: FloatArray, firm: NDArray[np.bool_]) -> None:
        self.forth, self.back, self.firm = forth, back, firm


def _passing(maps: FloatArray, pair: IntArray, pairs: int) -> _Passing:
    m = maps.shape[3]
    squares = np.zeros((3, pairs, m, m))  # B_iᵀ B_i, B_jᵀ B_j, B_jᵀ B_i
    for place, (one, other) in enumerate(((0, 0), (1, 1), (1, 0))):
        np.add.at(squares[place], pair, maps[:, one].transpose(0, 2, 1) @ maps[:, other])
    values = [np.linalg.eigvalsh(square) for square in squares[:2]]
    firm = np.logical_and(*(part[:, 0] > HINGE * part[:, -1] for part in values))
    to_first, to_second = (np.linalg.pinv(square, rcond=HINGE, hermitian=True) for square in squares[:2])
    return _Passing(-to_second @ squares[2], -to_first @ squares[2].transpose(0, 2, 1), firm)


def _tree(first: IntArray, second: IntArray, passing: _Passing, count: int) -> tuple[IntArray, IntArray]:
    """Body that each one's motion comes from (negative at roots), and its hops from the root."""
    length = np.where(passing.firm, 1.0, DETOUR)
    graph = sparse.csr_array((length, (first, second)), shape=(count, count))
    _, group = csgraph.connected_components(graph, directed=False)
    _, roots = np.unique(group, return_index=True)
    _, before, _ = csgraph.dijkstra(
        graph, directed=False, indices=roots, return_predecessors=True, min_only=True
    )
    hops, at = np.zeros(count, dtype=np.int64), before.astype(np.int64)
    while (moving := np.flatnonzero(at >= 0)).size:
        hops[moving] += 1
        at[moving] = before[at[moving]]
    return before.astype(np.int64), hops


def _edges(first: IntArray, second: IntArray, before: IntArray, count: int) -> IntArray:
    """Pair that leads to each body; those that are passed backwards come after all others."""
    keys = np.concatenate([first * count + second, second * count + first])
    order = np.argsort(keys)
    wanted = np.maximum(before, 0) * count + np.arange(count)
    place = np.searchsorted(keys[order], wanted).clip(max=len(keys) - 1)
    edges: IntArray = order[place]
    return edges
