"""Schur: the inverse of a factorised matrix on rows that were eliminated last, from PETSc's MUMPS.

    eliminated_last(factor, rows)          # before the factor is made
    inverse = inverse_there(factor, len(rows))

What these rows have left when all others are eliminated is inverted as it is. Columns of the inverse, one by
one, would read all of the factor for each. petsc4py has no names for this: PETSc's own functions are called.
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


def _call(petsc: Any, name: str, *given: Any) -> None:
    """A function of PETSc."""
    error = getattr(_library(petsc.__file__), name)(*given)
    if error:
        raise np.linalg.LinAlgError(f"PETSc's {name} fails with error {error}")


def _handle(thing: Any) -> ctypes.c_void_p:
    return ctypes.c_void_p(thing.handle)


def eliminated_last(petsc: Any, factor: Any, rows: IntArray) -> None:
    """Have rows eliminated last; the factor solves for all rows as before.

    Parameters
    ----------
    petsc : petsc4py.PETSc. factor : Of MUMPS, not made yet. rows : Shape (c,).
    """
    places = petsc.IS().createGeneral(rows.astype(petsc.IntType), comm=petsc.COMM_SELF)
    _call(petsc, "MatFactorSetSchurIS", _handle(factor), _handle(places))


def inverse_there(petsc: Any, factor: Any, count: int) -> FloatArray:
    """The inverse on the ``count`` rows that were eliminated last, shape (count, count).

    Parameters
    ----------
    petsc : petsc4py.PETSc. factor : Of MUMPS, made with these rows.
    """
    _call(petsc, "MatFactorInvertSchurComplement", _handle(factor))
    inverse, state, values = ctypes.c_void_p(), ctypes.c_int(), ctypes.POINTER(ctypes.c_double)()
    _call(petsc, "MatFactorGetSchurComplement", _handle(factor), ctypes.byref(inverse), ctypes.byref(state))
    try:
        _call(petsc, "MatDenseGetArrayRead", inverse, ctypes.byref(values))
        found = np.ctypeslib.as_array(values, (count, count)).copy(order="K")
        _call(petsc, "MatDenseRestoreArrayRead", inverse, ctypes.byref(values))
    finally:
        _call(petsc, "MatFactorRestoreSchurComplement", _handle(factor), ctypes.byref(inverse), state)
    return found
