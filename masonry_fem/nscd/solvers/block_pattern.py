"""BlockPattern: where dense blocks of several sizes stand in a sparse matrix.

pattern = BlockPattern(size, [Family(rows, columns, 3, 3), Family(rows, columns, 3, 6)])
matrix = pattern.filled([blocks, wider_blocks])       # as often as values change
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Family:
    """Blocks of one size.

    Attributes
    ----------
    rows, columns : Of their first entries, shape (k,).
    height, width : Their size.
    """

    rows: IntArray
    columns: IntArray
    height: int
    width: int


class BlockPattern:
    """Places of blocks, none over another; those that begin in one row have one height.

    Parameters
    ----------
    size : Rows of the matrix, and columns.
    families : The blocks.
    """

    def __init__(self, size: int, families: Sequence[Family]) -> None:
        from masonry_fem.nscd.scatter import put_columns  # noqa: PLC0415 - Numba is slow to import

        counts = [len(one.rows) for one in families]
        rows = np.concatenate([one.rows for one in families])
        columns = np.concatenate([one.columns for one in families])
        widths = np.repeat([one.width for one in families], counts)
        length = np.bincount(rows, weights=widths, minlength=size).astype(np.int64)  # of first rows
        stored = np.zeros(size, dtype=np.int64)  # entries of each row
        for one in families:
            stored[one.rows[:, None] + np.arange(one.height)] = length[one.rows][:, None]
        pointer = np.concatenate([[0], np.cumsum(stored)])
        order = np.argsort(rows * size + columns, kind="stable")
        before = np.cumsum(widths[order]) - widths[order]  # widths of all blocks that come first,
        before -= (np.cumsum(length) - length)[rows[order]]  # and of those in the same row
        first = np.empty(len(rows), dtype=np.int64)
        first[order] = pointer[rows[order]] + before
        self.size, self.pointer = size, pointer.astype(np.int32)
        self.indices = np.empty(int(pointer[-1]), dtype=np.int32)
        self.first = np.split(first, np.cumsum(counts)[:-1])
        self.length = [length[one.rows] for one in families]
        for one, own, long in zip(families, self.first, self.length, strict=True):
            put_columns(self.indices, own, long, one.columns, one.height, one.width)

    def filled(self, blocks: Sequence[FloatArray]) -> sparse.csr_array:
        """The matrix with values in its blocks, one array of shape (k, height, width) a family."""
        from masonry_fem.nscd.scatter import put_blocks  # noqa: PLC0415 - Numba is slow to import

        values = np.empty(len(self.indices))
        for first, length, own in zip(self.first, self.length, blocks, strict=True):
            put_blocks(values, first, length, np.ascontiguousarray(own))
        return sparse.csr_array((values, self.indices, self.pointer), shape=(self.size, self.size))
