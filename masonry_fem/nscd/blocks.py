"""Block-sparse operators: assembly from the blocks of masonry that join contacts.

W = assemble_blocks(c, d, [(contacts, matrix), ...])       # a bsr_array of (d, d) blocks
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from masonry_fem.errors import ProblemError

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


def assemble_blocks(
    count: int,
    dimension: int,
    contributions: Sequence[tuple[IntArray, FloatArray]],
    *,
    symmetric: bool = True,
    pattern: sparse.csr_array | None = None,
) -> sparse.bsr_array:
    """Sum of dense contributions, each between the contacts of one block of masonry.

    Parameters
    ----------
    count, dimension : c contacts of d components.
    contributions : (contact numbers (s,), matrix (s d, s d)) of each block.
    symmetric : Of each only the symmetric part is taken; else they are taken as they are.
    pattern : As ``pattern_of`` these contact numbers, where the caller keeps it.

    Returns
    -------
    Shape (c d, c d), (d, d) blocks, sorted; where ``symmetric``, symmetric to the last bit. Beyond the
    result itself only its pattern and one contribution at a time are held in memory.

    Raises
    ------
    ProblemError : A matrix has another shape than its contacts.
    """
    d = dimension
    members = [np.asarray(contacts, dtype=np.int64) for contacts, _ in contributions]
    pattern = pattern_of(count, members) if pattern is None else pattern
    if count == 0:
        return sparse.bsr_array((0, 0), blocksize=(1, 1))
    data = np.zeros((pattern.nnz, d, d))
    from masonry_fem.nscd.scatter import add_dense  # noqa: PLC0415  Numba, for elastic problems only

    for contacts, (_, matrix) in zip(members, contributions, strict=True):
        s = len(contacts)
        if matrix.shape != (s * d, s * d):
            raise ProblemError(
                f"compliance between {s} contacts has shape {matrix.shape}, expected {(s * d, s * d)}"
            )
        add_dense(pattern.indptr, pattern.indices, data, contacts, np.ascontiguousarray(matrix), symmetric)
    return sparse.bsr_array((data, pattern.indices, pattern.indptr), shape=(count * d, count * d))


def block_rows(matrix: sparse.bsr_array) -> IntArray:
    """Block row of each stored block, shape (stored,)."""
    rows: IntArray = np.repeat(np.arange(len(matrix.indptr) - 1, dtype=np.int64), np.diff(matrix.indptr))
    return rows


def pattern_of(count: int, members: Sequence[IntArray]) -> sparse.csr_array:
    """Which contacts share a contribution.

    Parameters
    ----------
    count : Contacts c. members : Contact numbers of each contribution.

    Returns
    -------
    Shape (c, c), sorted.
    """
    contact = np.concatenate([*members, np.zeros(0, dtype=np.int64)])
    owner = np.repeat(np.arange(len(members)), [len(m) for m in members])
    shape = (count, max(len(members), 1))
    incidence = sparse.csr_array((np.ones(len(contact)), (contact, owner)), shape=shape)
    pattern = sparse.csr_array(incidence @ incidence.T)
    pattern.sort_indices()
    return pattern
