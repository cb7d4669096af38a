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
from importlib import import_module
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy import linalg, sparse
from scipy.sparse.linalg import splu

from masonry_fem.errors import InstallationError
from masonry_fem.nscd.fronts import Elimination, FrontFactor, FrontPlan

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
) -> Solve:
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
        return lambda rhs: rhs.copy()
    if library in {"auto", "direct", "krylov"}:
        known = groups is not None and elimination is not None
        library = "dense" if n < DENSE_BELOW else "fronts" if known else "superlu"
    if library == "fronts":
        if groups is None or elimination is None:
            raise ValueError("library 'fronts' needs groups and their elimination order")
        plan = FrontPlan(matrix, groups, elimination) if plan is None else plan
        return _refined(matrix, FrontFactor(plan, matrix.data).solve)
    return _refined(matrix, {"dense": _dense, "superlu": _superlu, "mumps": _mumps}[library](matrix))


def _refined(matrix: sparse.csr_array, solve: Solve) -> Solve:
    def refined(rhs: FloatArray) -> FloatArray:
        best = solve(rhs)
        size = float(np.abs(rhs).max(initial=0.0))
        residual = rhs - matrix @ best
        error = float(np.abs(residual).max(initial=0.0))
        for _ in range(REFINEMENTS):
            if not REFINED * size < error < np.inf:
                break
            better = best + solve(residual)
            residual = rhs - matrix @ better
            left = float(np.abs(residual).max(initial=0.0))
            if not left < error:
                break
            best, error = better, left
        return best

    return refined


def _dense(matrix: sparse.csr_array) -> Solve:
    factor, pivots, info = linalg.lapack.dgetrf(np.asfortranarray(matrix.toarray()), overwrite_a=True)
    if info > 0:
        tiny = 1e-300 + 1e-16 * float(np.abs(matrix.data).max(initial=0.0))
        zero = np.nonzero(np.diagonal(factor) == 0)[0]
        factor[zero, zero] = tiny

    def solve(rhs: FloatArray) -> FloatArray:
        answer: FloatArray = linalg.lapack.dgetrs(factor, pivots, rhs)[0]
        return answer

    return solve


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
