"""Mumps: sparse LU and Cholesky factors by MUMPS through PETSc, for matrices of one pattern after another.

The contacts of a deformable block are coupled densely, two blocks only through what is between them. MUMPS
eliminates such a matrix as dense fronts, and keeps their order while the pattern stays.

    mumps = Mumps(matrix)          # for its pattern
    x = mumps.solve(matrix, rhs)   # as often as the values change

Of a single matrix that is large only the factor is kept:

    factor = MumpsFactor(matrix, definite=True)
    x = factor.answer(rhs)
    part = inverse_entries(petsc, factor, rows, columns)        # single entries of the inverse
    inverse = factor.columns(numbers)
    part = factor.among(numbers)        # rows and columns of it
"""

from __future__ import annotations

import ctypes
import errno
import shutil
import tempfile
import weakref
from contextlib import suppress
from functools import cache
from importlib import import_module
from typing import Any, override

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from masonry_fem.errors import InstallationError

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

# MUMPS' parameters ICNTL for LU: no column permutation, approximate minimum degree, no scaling, and the
# determinant. Its own choices, a matching and scaling of entries and METIS, cost a quarter to a half more.
CONTROLS = {6: 0, 7: 0, 8: 0, 33: 1}
# ICNTL(14), per cent of memory beyond what is expected, one after the other where it was too little, which
# INFOG(1) tells. Pivots that have to wait need more; in definite matrices none do.
SPACES = (50, 200, 1000, 5000)
EXPECTED = 0
SHORT_OF_SPACE = {-8, -9}
NO_MEMORY, NO_DISK = -13, -90
# ICNTL of definite matrices: low ranks, but with CNTL(7) = 0 nothing is compressed. It works on panels, in
# half the time, with the same digits. Where memory counts that takes a sixth more of it.
PANELS = {35: 3}
ON_DISK = {22: 1, 35: 0}
# Columns of the inverse that are asked for together, and of these solved for together, which is ICNTL(27):
# each time a part of the factor is read.
AT_ONCE, TOGETHER = 256, {27: 128}
LARGE = 50_000  # rows from which factors go to disk: a third of the memory with 90 000 (307 MB, not 872)


@cache
def _library(path: str) -> ctypes.CDLL:
    """PETSc, as petsc4py has loaded it from its own file."""
    return ctypes.CDLL(path)


def inverse_entries(petsc: Any, factor: Any, rows: IntArray, columns: IntArray) -> FloatArray:
    """Rows of some columns of the inverse, transposed: shape (c, r).

    For entries in few rows MUMPS reads a part of the factor only, and makes no column of the inverse as a
    whole. petsc4py has no name for this: PETSc's own function is called.

    Parameters
    ----------
    petsc : petsc4py.PETSc. factor : Of MUMPS, made.
    rows : Ascending, shape (r,). columns : Ascending, shape (c,).

    Raises
    ------
    LinAlgError : PETSc fails.

    References
    ----------
    P. R. Amestoy, I. S. Duff, J.-Y. L'Excellent, Y. Robert, F.-H. Rouet and B. Uçar, "On computing inverse
    entries of a sparse matrix in an out-of-core environment", SIAM Journal on Scientific Computing 34 (2012).
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


@cache
def petsc() -> Any:
    """PETSc with MUMPS; None where they are not installed."""
    with suppress(ImportError):
        import_module("dolfinx_solver")  # the wheel's loader must come before petsc4py
    try:
        library = import_module("petsc4py.PETSc")
    except (ImportError, RuntimeError):  # mpi4py without an MPI library is a RuntimeError
        return None
    return library if library.Sys.hasExternalPackage("mumps") else None


class Mumps:
    """Factors of matrices of one pattern, of which one is held at a time.

    Parameters
    ----------
    matrix : Square, shape (n, n); its values do not matter.

    Raises
    ------
    InstallationError : petsc4py or its MUMPS is missing.
    """

    _controls = CONTROLS
    _type = "lu"

    def __init__(self, matrix: sparse.csr_array) -> None:
        library = petsc()
        if library is None:
            raise InstallationError(
                "linear solver 'mumps' needs petsc4py with MUMPS, which is not installed; "
                "install the 'fenicsx' extra or use library 'auto'"
            )
        self._petsc = library
        self._operator = self._stored(matrix)
        self._held: sparse.csr_array | None = None
        self._analyse(self._spaces[0])

    def _stored(self, matrix: sparse.csr_array) -> Any:
        """A matrix of PETSc, which reads its values from an array."""
        self._values = np.zeros(matrix.nnz)
        return self._with_arrays(matrix, self._values)

    def _with_arrays(self, matrix: sparse.csr_array, values: FloatArray) -> Any:
        library = self._petsc
        places = [np.asarray(given, library.IntType) for given in (matrix.indptr, matrix.indices)]
        return library.Mat().createAIJWithArrays(matrix.shape, (*places, values), comm=library.COMM_SELF)

    def _fill(self, matrix: sparse.csr_array) -> None:
        """Put a matrix's values where PETSc reads them."""
        self._values[:] = matrix.data
        self._operator.stateIncrease()

    def solve(self, matrix: sparse.csr_array, rhs: FloatArray) -> FloatArray:
        """Solution of matrix @ x = rhs, shaped like it; infinite where the matrix is singular.

        Parameters
        ----------
        matrix : Of the pattern given first; its factor is made unless it is held.
        rhs : Shape (n,) or (n, k).
        """
        self.hold(matrix)
        return self.answer(rhs)

    def answer(self, rhs: FloatArray) -> FloatArray:
        """Solution for right-hand sides (n,) or (n, k), with the factor that is held."""
        if self._failed:
            return np.full_like(rhs, np.inf)
        columns = np.asfortranarray(rhs.reshape(len(rhs), -1))
        given = self._petsc.Mat().createDense(columns.shape, array=columns, comm=self._petsc.COMM_SELF)
        return self._solved(given, columns.shape).reshape(rhs.shape)

    def _solved(self, given: Any, shape: tuple[int, int]) -> FloatArray:
        """Solution of this shape for a matrix of PETSc."""
        answer: FloatArray = np.zeros(shape, order="F")
        found = self._petsc.Mat().createDense(shape, array=answer, comm=self._petsc.COMM_SELF)
        if shape[1]:  # MUMPS takes none as an error
            self._factor.matSolve(given, found)
        return answer

    def sign(self, matrix: sparse.csr_array) -> int:
        """Sign of the determinant, 1 or -1; 0 where the matrix is singular."""
        self.hold(matrix)
        return 0 if self._failed else int(np.sign(self._factor.getMumpsRinfog(12)))

    def hold(self, matrix: sparse.csr_array) -> None:
        """Make the factor of a matrix, if it is not that of the last one."""
        if self._held is matrix:
            return
        if self._held is not None and self._failed:
            self._analyse(self._spaces[0])  # PETSc makes no factor after one that failed
        self._held = matrix
        self._fill(matrix)
        self._steps.setUp()
        for space in self._spaces[1:]:
            if self._factor.getMumpsInfog(1) not in SHORT_OF_SPACE:
                return
            self._analyse(space)
            self._steps.setUp()

    @property
    def _failed(self) -> bool:
        return bool(self._factor.getMumpsInfog(1) < 0)

    @property
    def _spaces(self) -> tuple[int, ...]:
        """What to try."""
        return SPACES

    def _analyse(self, space: int) -> None:
        """Begin anew; the order of elimination is found with the next factor."""
        self._steps = self._petsc.PC().create(self._petsc.COMM_SELF)
        self._steps.setOperators(self._operator)
        self._steps.setType(self._type)
        self._steps.setFactorSolverType("mumps")
        self._steps.setFactorSetUpSolverType()
        self._factor = self._steps.getFactorMatrix()
        for number, value in ({14: space} | self._controls).items():
            self._factor.setMumpsIcntl(number, value)


class MumpsFactor(Mumps):
    """The factor of one matrix, which itself is not kept.

    Parameters
    ----------
    matrix : Square, sorted, shape (n, n). A definite one is emptied: the factor may need the room.
    definite : It is symmetric positive definite.

    Raises
    ------
    InstallationError : petsc4py or its MUMPS is missing.
    MemoryError : There is not enough.
    OSError : The disk has no room for the factor.
    LinAlgError : The matrix is singular.
    """

    def __init__(self, matrix: sparse.csr_array, *, definite: bool) -> None:
        self._definite, self._size = definite, matrix.shape[0]
        if definite:
            self._controls, self._type = PANELS | TOGETHER, "cholesky"
        library = petsc()
        if self._size < LARGE or library is None:
            self._made(matrix)
            return
        self._folder = tempfile.mkdtemp(prefix="masonry_fem-")
        self._controls = self._controls | ON_DISK
        options, key = library.Options(), "mat_mumps_ooc_tmpdir"
        options[key] = self._folder
        try:
            self._made(matrix)
        finally:
            del options[key]
            # MUMPS removes its files as the factor goes, which may be at the end of the program
            weakref.finalize(self, _removed, self._factor, self._folder)

    def _made(self, matrix: sparse.csr_array) -> None:
        super().__init__(matrix)
        self.hold(matrix)
        self._held = None
        self._steps.destroy()
        self._operator.destroy()
        told = self._factor.getMumpsInfog(1)
        if told == NO_MEMORY:
            raise MemoryError
        if told == NO_DISK:
            raise OSError(errno.ENOSPC, "no room for the factor of a large block", self._folder)
        if told < 0:
            raise np.linalg.LinAlgError(f"MUMPS finds no factor: INFOG(1) = {told}")

    @property
    @override
    def _spaces(self) -> tuple[int, ...]:
        return (EXPECTED, *SPACES) if self._definite else SPACES

    @override
    def _stored(self, matrix: sparse.csr_array) -> Any:
        """The matrix itself where that is whole; there is no other."""
        if not self._definite:
            return self._with_arrays(matrix, matrix.data)
        library, upper = self._petsc, sparse.triu(matrix, format="csr")
        matrix.data, matrix.indices = matrix.data[:0].copy(), matrix.indices[:0].copy()
        arrays = [np.asarray(given, library.IntType) for given in (upper.indptr, upper.indices)]
        made = library.Mat().createSBAIJ(matrix.shape, 1, csr=(*arrays, upper.data), comm=library.COMM_SELF)
        made.setOption(library.Mat.Option.SPD, True)
        return made

    @override
    def _fill(self, matrix: sparse.csr_array) -> None:
        """Nothing: they are there."""

    def among(self, numbers: IntArray) -> FloatArray:
        """Rows and columns of the inverse of a definite matrix, ascending, shape (c, c)."""
        count = len(numbers)
        part = np.empty((count, count))
        for first in range(0, count, AT_ONCE):
            some = slice(first, first + AT_ONCE)
            rows = inverse_entries(self._petsc, self._factor, numbers[first:], numbers[some])
            part[some, first:], part[first:, some] = rows, rows.T
        return part

    def columns(self, numbers: IntArray) -> FloatArray:
        """Some columns of the inverse, shape (n, k); zeros of unit vectors cost nothing."""
        library, count = self._petsc, len(numbers)
        shape, rows = (count, self._size), np.arange(count + 1)
        places = [np.array(given, library.IntType) for given in (rows, numbers)]
        units = library.Mat().createAIJWithArrays(shape, (*places, np.ones(count)), comm=library.COMM_SELF)
        return self._solved(library.Mat().createTranspose(units), (self._size, count))


def _removed(factor: Any, folder: str) -> None:
    """Take a factor away, and its files."""
    factor.destroy()
    shutil.rmtree(folder, ignore_errors=True)
