"""Mumps: sparse LU by MUMPS through PETSc, for matrices of one pattern after another.

The contacts of a deformable block are coupled densely, two blocks only through what is between them. MUMPS
eliminates such a matrix as dense fronts, and keeps their order while the pattern stays.

    mumps = Mumps(matrix)          # for its pattern
    x = mumps.solve(matrix, rhs)   # as often as the values change
"""

from __future__ import annotations

from contextlib import suppress
from functools import cache
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from masonry_fem.errors import InstallationError

FloatArray = NDArray[np.float64]

# MUMPS' parameters ICNTL: no column permutation, approximate minimum degree, no scaling, and the determinant.
# Its own choices, a matching and scaling of entries and METIS, cost a quarter more and bring nothing here.
CONTROLS = {6: 0, 7: 0, 8: 0, 33: 1}
# ICNTL(14), per cent of memory beyond what is expected, one after the other where it was too little, which
# INFOG(1) tells. Pivots that have to wait need more.
SPACES = (50, 200, 1000, 5000)
SHORT_OF_SPACE = {-8, -9}


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

    def __init__(self, matrix: sparse.csr_array) -> None:
        library = petsc()
        if library is None:
            raise InstallationError(
                "linear solver 'mumps' needs petsc4py with MUMPS, which is not installed; "
                "install the 'fenicsx' extra or use library 'auto'"
            )
        self._petsc = library
        self._values = np.zeros(matrix.nnz)  # PETSc reads them here
        places = [np.array(given, library.IntType) for given in (matrix.indptr, matrix.indices)]
        self._operator = library.Mat().createAIJWithArrays(
            matrix.shape, (*places, self._values), comm=library.COMM_SELF
        )
        self._given, self._found = self._operator.createVecLeft(), self._operator.createVecRight()
        self._held: sparse.csr_array | None = None
        self._analyse(SPACES[0])

    def solve(self, matrix: sparse.csr_array, rhs: FloatArray) -> FloatArray:
        """Solution of matrix @ x = rhs, shape (n,); infinite where the matrix is singular.

        Parameters
        ----------
        matrix : Of the pattern given first; its factor is made unless it is held.
        rhs : Shape (n,).
        """
        self.hold(matrix)
        self._given.setArray(rhs)
        self._factor.solve(self._given, self._found)
        answer: FloatArray = self._found.getArray().copy()
        return answer

    def sign(self, matrix: sparse.csr_array) -> int:
        """Sign of the determinant, 1 or -1; 0 where the matrix is singular."""
        self.hold(matrix)
        return int(np.sign(self._factor.getMumpsRinfog(12))) if self._factor.getMumpsInfog(1) >= 0 else 0

    def hold(self, matrix: sparse.csr_array) -> None:
        """Make the factor of a matrix, if it is not that of the last one."""
        if self._held is matrix:
            return
        if self._held is not None and self._factor.getMumpsInfog(1) < 0:
            self._analyse(SPACES[0])  # PETSc makes no factor after one that failed
        self._held = matrix
        self._values[:] = matrix.data
        self._operator.stateIncrease()
        self._steps.setUp()
        for space in SPACES[1:]:
            if self._factor.getMumpsInfog(1) not in SHORT_OF_SPACE:
                return
            self._analyse(space)
            self._steps.setUp()

    def _analyse(self, space: int) -> None:
        """Begin anew; the order of elimination is found with the next factor."""
        self._steps = self._petsc.PC().create(self._petsc.COMM_SELF)
        self._steps.setOperators(self._operator)
        self._steps.setType("lu")
        self._steps.setFactorSolverType("mumps")
        self._steps.setFactorSetUpSolverType()
        self._factor = self._steps.getFactorMatrix()
        for number, value in (CONTROLS | {14: space}).items():
            self._factor.setMumpsIcntl(number, value)
