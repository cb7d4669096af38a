"""Boxes: which blocks are near each other, by axis-aligned bounding boxes (sweep and prune)."""

from __future__ import annotations

import numpy as np

from masonry_fem.host.compiled import compiled, put
from masonry_fem.solid.mesh import IntArray
from masonry_fem.solid.pose import FloatArray


def near_pairs(low: FloatArray, high: FloatArray, reach: float) -> IntArray:
    """Pairs of boxes that are at most ``reach`` apart along every axis.

    Parameters
    ----------
    low, high : Opposite corners of each box, shape (n, d) [m].
    reach : Largest gap [m].

    Returns
    -------
    Pairs (i < j), sorted, shape (m, 2).

    References
    ----------
    Cohen, Lin, Manocha, Ponamgi, I-COLLIDE, Symp. on Interactive 3D Graphics 1995 (sweep and prune; here
    along the axis of greatest variance).
    """
    if len(low) < 2:
        return np.empty((0, 2), dtype=np.int64)
    axis = int(np.var(0.5 * (low + high), axis=0).argmax())
    order = np.argsort(low[:, axis], kind="stable")
    pairs: IntArray = _sweep(low, high, order, axis, reach)
    pairs.sort(axis=1)
    return pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]


@compiled
def _sweep(low: FloatArray, high: FloatArray, order: IntArray, axis: int, reach: float) -> IntArray:
    count, d = low.shape
    found = np.empty((max(16, 8 * count), 2), dtype=np.int64)
    total = 0
    active = np.empty(count, dtype=np.int64)
    alive = 0
    for at in range(count):
        i = order[at]
        kept = 0
        for k in range(alive):
            j = active[k]
            if high[j, axis] + reach < low[i, axis]:
                continue  # no longer a candidate: all later boxes start beyond its end
            active[kept] = j
            kept += 1
            near = True
            for c in range(d):
                if low[i, c] > high[j, c] + reach or low[j, c] > high[i, c] + reach:
                    near = False
                    break
            if near:
                if total == len(found):
                    more = np.empty((2 * total, 2), dtype=np.int64)
                    put(more, found)
                    found = more
                found[total, 0], found[total, 1] = i, j
                total += 1
        active[kept] = i
        alive = kept + 1
    return found[:total].copy()
