"""Parked: large arrays that nothing needs for a while, in a file instead of in memory."""

from __future__ import annotations

import tempfile

import numpy as np
from numpy.typing import NDArray
from scipy import sparse


def park(matrix: sparse.csr_array) -> None:
    """Move a matrix's numbers to a file without a name, out of which they are read as they are asked for.

    Parameters
    ----------
    matrix : It remains what it is; what is written to it stays in memory.

    Raises
    ------
    OSError : The folder for temporary files has no room.
    """
    matrix.data, matrix.indices = _on_disk(matrix.data), _on_disk(matrix.indices)


def _on_disk[T: np.generic](values: NDArray[T]) -> NDArray[T]:
    if values.size == 0 or isinstance(values.base, np.memmap):
        return values
    with tempfile.TemporaryFile(prefix="masonry_fem-") as file:
        values.tofile(file)
        file.flush()
        return np.asarray(np.memmap(file, values.dtype, "c", shape=values.shape))
