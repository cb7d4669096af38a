"""Linear: factors of the Newton matrices, behind one function.

    solve = factorise(matrix, groups, elimination)
    x = solve(rhs)

Small matrices go to dense LAPACK, larger ones to ``fronts`` where their groups are known and to
SuperLU where they are not. MUMPS (petsc4py) is taken only when asked for by name, so that a result
never depends on what else a program has imported.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from importlib import import_module
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy import linalg, sparse
from scipy.sparse.linalg import splu

from masonry_fem.errors import InstallationError
from masonry_fem.nscd.fronts import Elimination, FrontFactor, FrontPlan, determinant_sign, row_order

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
Solve = Callable[[FloatArray], FloatArray]
Library = Literal["auto", "direct", "krylov", "dense", "fronts", "superlu", "mumps"]

# Below this size a dense factor costs less than any bookkeeping.
DENSE_BELOW = 240
REFINEMENTS = 2
REFINED = 1e-14


def factorise(
    matrix: sparse.csr_array,
    groups: IntArray | None = None,
    elimination: Elimination | None = None,
    library: Library = "auto",
    plan: FrontPlan | None = None,
) -> Factorised:
    """Factor a square matrix; the function returned solves with iterative refinement.

    A singular matrix raises nothing: the solution is then huge or not finite, which the caller
    tests anyway.

    Parameters
    ----------
    matrix : Square, shape (n, n).
    groups, elimination : Group of each unknown (n,) and their order, see ``fronts``.
    library : Which factor; "auto" and "direct" by size. "krylov" is the callers' (``BodySolver``): what
        they have no iteration for, or where it failed, is factorised.
    plan : The fronts' plan, where the caller keeps it for matrices of one pattern.

    Raises
    ------
    InstallationError : MUMPS was asked for and petsc4py is missing.
    """
    n = matrix.shape[0]
    if n == 0:
        return Factorised(matrix, np.copy, lambda: 1)
    if library in {"auto", "direct", "krylov"}:
        known = groups is not None and elimination is not None
        library = "dense" if n < DENSE_BELOW else "fronts" if known else "superlu"
    if library == "fronts":
        if groups is None or elimination is None:
            raise ValueError("library 'fronts' needs groups and their elimination order")
        plan = FrontPlan(matrix, groups, elimination) if plan is None else plan
        factor = FrontFactor(plan, matrix.data)
        return Factorised(matrix, factor.solve, factor.sign)
    if library == "dense":
        return Factorised(matrix, *_dense(matrix))
    return Factorised(matrix, {"superlu": _superlu, "mumps": _mumps}[library](matrix))


@dataclass(frozen=True, slots=True)
class Factorised:
    """Solves with a factor and iterative refinement.

    Attributes
    ----------
    matrix : What was factorised, shape (n, n).
    bare : The factor's own solution.
    sign : Gives the sign of the determinant, 1 or -1; 0 where the factor does not tell.
    """

    matrix: sparse.csr_array
    bare: Solve
    sign: Callable[[], int] = lambda: 0

    def __call__(self, rhs: FloatArray) -> FloatArray:
        """Solution x of matrix @ x = rhs, shape (n,)."""
        best = self.bare(rhs)
        size = float(np.abs(rhs).max(initial=0.0))
        residual = rhs - self.matrix @ best
        error = float(np.abs(residual).max(initial=0.0))
        for _ in range(REFINEMENTS):
            if not REFINED * size < error < np.inf:
                break
            better = best + self.bare(residual)
            residual = rhs - self.matrix @ better
            left = float(np.abs(residual).max(initial=0.0))
            if not left < error:
                break
            best, error = better, left
        return best


def _dense(matrix: sparse.csr_array) -> tuple[Solve, Callable[[], int]]:
    factor, pivots, info = linalg.lapack.dgetrf(np.asfortranarray(matrix.toarray()), overwrite_a=True)
    if info > 0:
        tiny = 1e-300 + 1e-16 * float(np.abs(matrix.data).max(initial=0.0))
        zero = np.nonzero(np.diagonal(factor) == 0)[0]
        factor[zero, zero] = tiny

    def solve(rhs: FloatArray) -> FloatArray:
        answer: FloatArray = linalg.lapack.dgetrs(factor, pivots, rhs)[0]
        return answer

    return solve, lambda: determinant_sign(factor, row_order(pivots))


def _superlu(matrix: sparse.csr_array) -> Solve:
    try:
        return splu(matrix.tocsc(), permc_spec="COLAMD").solve
    except RuntimeError:  # exactly singular
        return lambda rhs: np.full_like(rhs, np.inf)


def _mumps(matrix: sparse.csr_array) -> Solve:
    with suppress(ImportError):
        import_module("dolfinx_solver")  # the wheel's loader must come before petsc4py
    try:
        PETSc = import_module("petsc4py.PETSc")
    except ImportError as error:
        raise InstallationError(
            "linear solver 'mumps' needs petsc4py, which is not installed; "
            "install the 'fenicsx' extra or use library 'auto'"
        ) from error
    arrays = (matrix.indptr.astype(PETSc.IntType), matrix.indices.astype(PETSc.IntType), matrix.data)
    operator = PETSc.Mat().createAIJ(matrix.shape, csr=arrays, comm=PETSc.COMM_SELF)
    solver = PETSc.KSP().create(PETSc.COMM_SELF)
    solver.setOperators(operator)
    solver.setType("preonly")
    solver.getPC().setType("lu")
    solver.getPC().setFactorSolverType("mumps")
    solver.setUp()

    def solve(rhs: FloatArray) -> FloatArray:
        given, answer = operator.createVecLeft(), operator.createVecRight()
        given.setArray(rhs)
        solver.solve(given, answer)
        found: FloatArray = np.array(answer.getArray())
        return found

    return solve
