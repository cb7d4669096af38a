"""Scatter: compiled additions of dense contributions to block-sparse matrices."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray


@njit(cache=True)
def add_dense(
    indptr: NDArray[np.int32],
    indices: NDArray[np.int32],
    data: NDArray[np.float64],
    contacts: NDArray[np.int64],
    matrix: NDArray[np.float64],
    symmetric: bool,
) -> None:
    """Add a matrix between s contacts, or its symmetric part, to its (d, d) blocks.

    Parameters
    ----------
    indptr, indices, data : Block-sparse matrix that is added to, its columns sorted; ``data`` (k, d, d).
    contacts : Contacts that the matrix is of, shape (s,).
    matrix : What is added, shape (s d, s d). symmetric : Only its symmetric part.
    """
    d = data.shape[1]
    for a in range(len(contacts)):
        first, last = indptr[contacts[a]], indptr[contacts[a] + 1]
        row = indices[first:last]
        for b in range(len(contacts)):
            at = first + np.searchsorted(row, contacts[b])
            for i in range(d):
                for j in range(d):
                    there, back = matrix[a * d + i, b * d + j], matrix[b * d + j, a * d + i]
                    data[at, i, j] += 0.5 * (there + back) if symmetric else there
