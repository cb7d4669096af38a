"""MatrixEntries: the dense blocks of a sparse matrix before they are put together, and where they go.

entries = MatrixEntries(size)
entries.add(rows, columns, blocks)
pattern = MatrixPattern(kept, coupled, entries)
solve = pattern.factorise(entries, "auto")
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from masonry_fem.nscd.linear import Library, Solve, factorise, library_for
from masonry_fem.nscd.mumps import Mumps

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


class MatrixEntries:
    """Dense blocks at (row, column) of their first entries, none over another: a matrix in pieces."""

    def __init__(self, size: int) -> None:
        self.size = size
        self.blocks: list[tuple[IntArray, IntArray, FloatArray]] = []

    def add(self, rows: IntArray, columns: IntArray, blocks: FloatArray) -> None:
        """Blocks of shape (k, p, q) at k places."""
        self.blocks.append((rows, columns, blocks))

    def values(self) -> FloatArray:
        """All values, block after block."""
        return np.concatenate([blocks.ravel() for _, _, blocks in self.blocks])

    def places(self) -> tuple[IntArray, IntArray]:
        """Row and column of each value."""
        rows, columns = [], []
        for first_row, first_column, blocks in self.blocks:
            height, width = np.arange(blocks.shape[1])[:, None], np.arange(blocks.shape[2])
            rows.append(np.broadcast_to(first_row[:, None, None] + height, blocks.shape).ravel())
            columns.append(np.broadcast_to(first_column[:, None, None] + width, blocks.shape).ravel())
        return np.concatenate(rows), np.concatenate(columns)


class MatrixPattern:
    """Where the entries of a matrix go, kept while the same contacts are closed.

    The interior-point method keeps all contacts, and Newton's active set does not change in the end.

    Parameters
    ----------
    kept : Contacts that are closed.
    coupled : Matrix of these contacts, of which the pattern counts.
    entries : The blocks, whose values do not count.
    """

    def __init__(self, kept: IntArray, coupled: sparse.bsr_array, entries: MatrixEntries) -> None:
        self.kept, self.coupled = kept, coupled.indices
        rows, columns = entries.places()
        numbers = sparse.coo_array(
            (np.arange(len(rows)), (rows, columns)), shape=(entries.size, entries.size)
        )
        self.numbers = numbers.tocsr()  # of the entries, no two of which share a place
        self.mumps: Mumps | None = None

    def fits(self, kept: IntArray, coupled: sparse.bsr_array) -> bool:
        """True where these contacts give a matrix of this pattern."""
        return np.array_equal(kept, self.kept) and np.array_equal(coupled.indices, self.coupled)

    def factorise(self, entries: MatrixEntries, library: Library) -> Solve:
        """The factor's solver of a matrix of this pattern."""
        numbers = self.numbers
        values = entries.values()[numbers.data]
        matrix = sparse.csr_array((values, numbers.indices, numbers.indptr), shape=numbers.shape)
        library = library_for(entries.size, library, fills=True)
        if library == "mumps" and self.mumps is None:
            self.mumps = Mumps(matrix)
        return factorise(matrix, library, self.mumps)
