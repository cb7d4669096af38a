"""LinearCost: what a factor and an iteration cost on a matrix of bodies, in seconds a step.

Foreseen from the graph of bodies that touch, before anything is factorised. Orders of magnitude are
enough: where the two are close, either will do.

    cost = LinearCost.foreseen(body_matrix.indices, body_matrix.pointer, body_matrix.size)
    if cost.iteration_pays(symmetric=True): ...
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse import csgraph

IntArray = NDArray[np.int64]

# Seconds of one step, measured on walls of one brick and of many, 255 to 8410 bodies. SuperLU's factor: in
# units of the cube of its widest front, the largest dense matrix within it; and the bookkeeping of a body. An
# iteration: of a block's entry, set-up and two solutions, symmetric or not; and what no step is without.
FRONT, BODY = 1e-9, 3e-5
ENTRY_SYMMETRIC, ENTRY_SLIDING, CYCLE = 2.2e-7, 4e-6, 0.02
# Fronts below this are not worth a second thought, nor MUMPS being loaded for them.
CHEAP = 0.3


@dataclass(frozen=True, slots=True)
class LinearCost:
    """CPU seconds of a step.

    Attributes
    ----------
    fronts, bookkeeping : Of a factor: arithmetic on fronts, and what each body costs besides.
    symmetric, sliding : Of an iteration on a symmetric matrix, and on one that is not.
    """

    fronts: float
    bookkeeping: float
    symmetric: float
    sliding: float

    @staticmethod
    def foreseen(indices: IntArray, pointer: IntArray, size: int) -> LinearCost:
        """From the blocks of the bodies' matrix by rows, shapes (nnz,) and (b + 1,), of ``size`` unknowns."""
        front = float(size * widest_level(indices, pointer))
        entries = len(indices) * size**2
        return LinearCost(
            FRONT * front**3,
            BODY * (len(pointer) - 1),
            CYCLE + ENTRY_SYMMETRIC * entries,
            CYCLE + ENTRY_SLIDING * entries,
        )

    def iteration_pays(self, *, symmetric: bool) -> bool:
        """True where the factor costs clearly more."""
        iteration = self.symmetric if symmetric else self.sliding
        return self.fills and self.fronts + self.bookkeeping > iteration

    @property
    def fills(self) -> bool:
        """True where the factor is mostly arithmetic on fronts."""
        return self.fronts > CHEAP


def widest_level(indices: IntArray, pointer: IntArray) -> int:
    """Bodies at one distance from an end of the largest group that touches, at most.

    Such a level parts the graph in two; no factor has a much smaller widest front.
    """
    count = len(pointer) - 1
    if count == 0:
        return 0
    graph: sparse.csr_array = sparse.csr_array(
        (np.ones(len(indices)), indices, pointer), shape=(count, count), dtype=np.float64
    )
    _, group = csgraph.connected_components(graph, directed=False)
    root, levels = int(np.flatnonzero(group == np.argmax(np.bincount(group)))[0]), np.zeros(0)
    for _ in range(2):  # the body farthest from any other lies at an end
        levels = csgraph.dijkstra(graph, indices=root, unweighted=True)
        root = int(np.argmax(np.where(np.isfinite(levels), levels, -1.0)))
    return int(np.bincount(levels[np.isfinite(levels)].astype(np.int64)).max())
