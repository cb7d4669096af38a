"""Spreading: adhesion of neighbouring points of an interface that decays together.

    (Y + b/h) β + k L β + λ = w + b β_i/h,    β ≤ β_i,    λ ≥ 0,    λ (β_i − β) = 0

with L ≥ 0 for −Δ on the interface: an obstacle problem with an M-matrix, solved by active sets, which
end after finitely many linear systems. A broken point weakens its neighbours within √(k/Y).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import spsolve

FloatArray = NDArray[np.float64]

LIMIT = 100  # active sets; a handful in practice


def spread_damage(diagonal: FloatArray, coupling: Any, load: FloatArray, before: FloatArray) -> FloatArray:
    """β at the end of a step, shape (c,).

    Parameters
    ----------
    diagonal : Y + b/h [J/m²], shape (c,). coupling : k L, sparse, shape (c, c) [J/m²].
    load : w + b β_i/h [J/m²], shape (c,). before : β_i, shape (c,).
    """
    matrix = sparse.csr_array(sparse.diags_array(diagonal) + coupling)
    after = before.copy()
    decays = np.zeros(len(before), dtype=bool)
    for _ in range(LIMIT):
        # where kept the multiplier tells, where free the bound
        pushes = matrix @ after - load > 1e-14 * load
        chosen = np.where(decays, after < before, pushes)
        if (chosen == decays).all():
            break
        decays = chosen
        after = before.copy()
        free, kept = np.flatnonzero(decays), np.flatnonzero(~decays)
        if len(free):
            right = load[free] - matrix[free][:, kept] @ before[kept]
            after[free] = np.atleast_1d(spsolve(sparse.csc_array(matrix[free][:, free]), right))
    return np.clip(after, 0.0, before)
