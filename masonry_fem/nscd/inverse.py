"""Inverse: single entries of the inverse of a factorised matrix, from PETSc's MUMPS.

    part = inverse_entries(petsc, factor, rows, columns)

For entries in few rows MUMPS reads a part of the factor only, and makes no column of the inverse as a whole.
petsc4py has no name for this: PETSc's own function is called.

References
----------
P. R. Amestoy, I. S. Duff, J.-Y. L'Excellent, Y. Robert, F.-H. Rouet and B. Uçar, "On computing inverse
entries of a sparse matrix in an out-of-core environment", SIAM Journal on Scientific Computing 34 (2012).
"""

from __future__ import annotations

import ctypes
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@cache
def _library(path: str) -> ctypes.CDLL:
    """PETSc, as petsc4py has loaded it from its own file."""
    return ctypes.CDLL(path)


def inverse_entries(petsc: Any, factor: Any, rows: IntArray, columns: IntArray) -> FloatArray:
    """Rows of some columns of the inverse, transposed: shape (c, r).

    Parameters
    ----------
    petsc : petsc4py.PETSc. factor : Of MUMPS, made.
    rows : Ascending, shape (r,). columns : Ascending, shape (c,).
    """
    size = factor.getSize()[0]
    count = np.zeros(size + 1, dtype=petsc.IntType)
    count[columns + 1] = len(rows)
    places = np.cumsum(count, dtype=petsc.IntType), np.tile(rows.astype(petsc.IntType), len(columns))
    entries = np.zeros((len(columns), len(rows)))
    asked = petsc.Mat().createAIJWithArrays((size, size), (*places, entries.ravel()), comm=petsc.COMM_SELF)
    given = petsc.Mat().createTranspose(asked)
    handles = (ctypes.c_void_p(one.handle) for one in (factor, given))
    error = _library(petsc.__file__).MatMumpsGetInverse(*handles)
    factor.setMumpsIcntl(30, 0)  # it is for solutions again
    if error:
        raise np.linalg.LinAlgError(f"PETSc's MatMumpsGetInverse fails with error {error}")
    return entries
