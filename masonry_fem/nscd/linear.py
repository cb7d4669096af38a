"""Linear: factors of the Newton matrices, behind one function.

    solve = factorise(matrix)
    x = solve(rhs)

Small matrices go to dense LAPACK, larger ones to SuperLU. Those whose factor fills, with contacts of
deformable blocks or of thick masonry, go to MUMPS where it is installed, whatever a program has imported.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any, Literal, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy import linalg, sparse
from scipy.sparse import csgraph
from scipy.sparse.linalg import splu

from masonry_fem.nscd.mumps import Mumps, petsc

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
Solve = Callable[[FloatArray], FloatArray]
Library = Literal["auto", "direct", "krylov", "dense", "superlu", "mumps"]

# Below this size a dense factor costs less than any bookkeeping.
DENSE_BELOW = 240
REFINEMENTS = 2
REFINED = 1e-14
# SuperLU takes pivots off the diagonal where that has less than this share of its column's largest entry.
TINY_PIVOT = 1e-8


def factorise(
    matrix: sparse.csr_array,
    library: Library = "auto",
    mumps: Mumps | None = None,
) -> Factorised:
    """Factor a square matrix; the function returned solves with iterative refinement.

    A singular matrix raises nothing: the solution is then huge or not finite, which the caller
    tests anyway.

    Parameters
    ----------
    matrix : Square, shape (n, n).
    library : Which factor; see ``library_for``.
    mumps : MUMPS for matrices of this pattern, where the caller keeps it.

    Raises
    ------
    InstallationError : MUMPS was asked for and petsc4py is missing.
    """
    n = matrix.shape[0]
    library = library_for(n, library)
    if n == 0:
        return Factorised(matrix, np.copy, lambda: 1)
    if library == "mumps":
        mumps = Mumps(matrix) if mumps is None else mumps
        mumps.hold(matrix)
        return Factorised(matrix, partial(mumps.solve, matrix), partial(mumps.sign, matrix))
    if library == "dense":
        return factorise_dense(matrix.toarray(order="F"), matrix)
    return Factorised(matrix, *_superlu(matrix))


def factorise_dense(matrix: FloatArray, product: Product) -> Factorised:
    """Factor a dense matrix in its own place.

    Parameters
    ----------
    matrix : Shape (n, n), column by column; it is overwritten.
    product : Multiplies by it.
    """
    largest = max(float(matrix.max(initial=0.0)), -float(matrix.min(initial=0.0)))
    factor, pivots, info = linalg.lapack.dgetrf(matrix, overwrite_a=True)
    if info > 0:
        zero = np.nonzero(np.diagonal(factor) == 0)[0]
        factor[zero, zero] = 1e-300 + 1e-16 * largest

    def solve(rhs: FloatArray) -> FloatArray:
        answer: FloatArray = linalg.lapack.dgetrs(factor, pivots, rhs)[0]
        return answer

    def sign() -> int:
        return _parity(int((pivots != np.arange(len(pivots))).sum()) + int((np.diagonal(factor) < 0).sum()))

    return Factorised(product, solve, sign)


def library_for(size: int, library: Library = "auto", *, fills: bool = False) -> Library:
    """The factor that a matrix gets.

    Parameters
    ----------
    size : Its rows n.
    library : What was asked for; "auto" and "direct" leave it to the matrix. "krylov" is the callers'
        (``BodySolver``): what they have no iteration for, or where it failed, is factorised.
    fills : Its factor is made of large dense matrices.
    """
    if library in {"dense", "superlu", "mumps"}:
        return library
    if size < DENSE_BELOW:
        return "dense"
    return "mumps" if fills and petsc() is not None else "superlu"


class Product(Protocol):
    """What multiplies by a matrix."""

    def __matmul__(self, x: FloatArray, /) -> Any:
        """The product with a vector, shape (n,)."""
        ...


@dataclass(frozen=True, slots=True)
class Factorised:
    """Solves with a factor and iterative refinement.

    Attributes
    ----------
    matrix : What was factorised, or what multiplies by it.
    bare : The factor's own solution.
    sign : Gives the sign of the determinant, 1 or -1; 0 where it is zero.
    """

    matrix: Product
    bare: Solve
    sign: Callable[[], int] = lambda: 0

    def __call__(self, rhs: FloatArray) -> FloatArray:
        """Solution x of matrix @ x = rhs, shape (n,)."""
        best = self.bare(rhs)
        if not np.isfinite(best).all():
            return best
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


def _superlu(matrix: sparse.csr_array) -> tuple[Solve, Callable[[], int]]:
    try:
        factor = splu(
            matrix.tocsc(),
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=TINY_PIVOT,
            options={"SymmetricMode": True},
        )
    except RuntimeError:  # exactly singular
        return lambda rhs: np.full_like(rhs, np.inf), lambda: 0

    def sign() -> int:
        swaps = sum(_swaps(order) for order in (factor.perm_r, factor.perm_c))
        return _parity(swaps + int((factor.U.diagonal() < 0).sum()))

    return factor.solve, sign


def _swaps(order: NDArray[np.integer]) -> int:
    """Swaps that make a permutation: its places without its cycles."""
    count = len(order)
    cycles: sparse.csr_array = sparse.csr_array((np.ones(count), order, np.arange(count + 1)))
    return count - int(csgraph.connected_components(cycles, directed=False, return_labels=False))


def _parity(changes: int) -> int:
    """Sign after so many changes of it."""
    return -1 if changes % 2 else 1
