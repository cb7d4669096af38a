"""Krylov: block matrices by conjugate gradients or GMRES, with an algebraic multigrid preconditioner.

What takes the place of a factor where the factor fills: its cost grows in proportion to the matrix,
in three dimensions too. Everything is done in unknowns in which the partner's diagonal blocks are
the identity; there the residual measures all bodies alike, light or heavy, held firmly or loosely.

    solve = iterated(matrix, partner, motions)     # raises StagnationError now,
    x = solve(rhs)                                 # or here

The *partner* is a symmetric positive definite matrix near the given one, and the same where that is
symmetric. Smoothed aggregation is pyamg's, with nothing random in it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import LinearOperator, cg, gmres

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
Solve = Callable[[FloatArray], FloatArray]

# Residual relative to the right-hand side, in scaled unknowns.
ACCURACY = 1e-10
# Of sliding contacts; what is left of the bodies' balance comes back multiplied by their stiffness.
ACCURACY_SLIDING = 1e-12
# How far from that a solution may end.
ACCEPTED = 1e3
# Products after which it has failed: a symmetric matrix takes 10 to 40, one of sliding contacts 60 to 200,
# which lose too much when GMRES restarts.
ITERATIONS = 200
# Of sliding contacts: sweeps of the smoother, and steps of the prolongator's.
THOROUGH = 2
# Couplings between bodies below this are not followed by aggregates.
STRENGTH = 0.05
# Length of the prolongator's Jacobi step, by Gershgorin's bounds: the longest that never grows.
DAMPING = 2.0
# Bodies of the coarsest level, which is solved densely.
COARSEST = 50
# Asymmetry, relative to the largest entry, that is rounding.
ROUNDING = 1e-12


class StagnationError(ArithmeticError):
    """The iteration did not end, or the partner is not positive definite: a factor is needed."""


def iterated(
    matrix: sparse.bsr_array,
    partner: sparse.bsr_array,
    motions: FloatArray,
    *,
    symmetric: bool,
) -> Solve:
    """A solver of matrix @ x = rhs that only multiplies.

    Parameters
    ----------
    matrix : Blocks (m, m), shape (b m, b m), indices sorted, every diagonal block stored.
    partner : Symmetric positive definite, of the same pattern; the matrix itself where ``symmetric``.
    motions : Near null space of the partner, shape (b, m, m).
    symmetric : Conjugate gradients will do.

    Raises
    ------
    StagnationError : Here where the partner has no multigrid; by the solver where it does not converge.
    """
    # where rounding ends it earlier, up to a thousand times as much is accepted
    accuracy = ACCURACY if symmetric else ACCURACY_SLIDING
    scale = _scale(partner)
    scaled_partner = _scaled(partner, scale)
    scaled = scaled_partner if symmetric else _scaled(matrix, scale)
    slow = np.linalg.solve(scale.transpose(0, 2, 1), motions)
    precondition = _multigrid(scaled_partner, slow, sweeps=1 if symmetric else THOROUGH)
    method = _conjugate if symmetric else _residual

    def solve(rhs: FloatArray) -> FloatArray:
        given = _by_body(scale, rhs)
        if not given.any():
            return np.zeros_like(rhs)
        if not np.isfinite(given).all():
            raise StagnationError("the right-hand side is not finite")
        found = method(scaled, given, precondition, accuracy)
        left = float(np.linalg.norm(given - scaled @ found)) / float(np.linalg.norm(given))
        if not left <= ACCEPTED * accuracy:
            raise StagnationError(f"residual {left:.1e} after {ITERATIONS} products, expected {accuracy:.0e}")
        return _by_body(scale.transpose(0, 2, 1), found)

    return solve


def _conjugate(
    matrix: sparse.bsr_array, rhs: FloatArray, precondition: LinearOperator, accuracy: float
) -> FloatArray:
    found: FloatArray = cg(matrix, rhs, rtol=accuracy, maxiter=ITERATIONS, M=precondition)[0]
    return found


def _residual(
    matrix: sparse.bsr_array, rhs: FloatArray, precondition: LinearOperator, accuracy: float
) -> FloatArray:
    # preconditioned from the right, so that what is measured is the residual itself
    product = LinearOperator(matrix.shape, matvec=lambda x: matrix @ (precondition @ x), dtype=float)
    found = gmres(product, rhs, rtol=accuracy, restart=ITERATIONS, maxiter=1)[0]
    answer: FloatArray = precondition @ found
    return answer


def _multigrid(matrix: sparse.bsr_array, motions: FloatArray, sweeps: int) -> LinearOperator:
    """One V-cycle of smoothed aggregation, symmetric positive definite."""
    from pyamg import smoothed_aggregation_solver  # noqa: PLC0415 - slow to import, for large problems only

    smoother: Any = ("block_gauss_seidel", {"sweep": "symmetric", "iterations": sweeps})
    try:
        levels = smoothed_aggregation_solver(
            sparse.bsr_matrix(matrix),
            B=motions.reshape(matrix.shape[0], -1),
            symmetry="symmetric",
            strength=("symmetric", {"theta": STRENGTH}),
            # weighted by Gershgorin's bounds: pyamg's other weights come from random vectors
            smooth=("jacobi", {"weighting": "local", "omega": DAMPING, "degree": sweeps}),
            presmoother=smoother,
            postsmoother=smoother,
            improve_candidates=None,
            max_coarse=COARSEST,
        )
    except (ValueError, ArithmeticError, np.linalg.LinAlgError) as error:
        raise StagnationError(f"no multigrid: {error}") from error
    operator: LinearOperator = levels.aspreconditioner()
    return operator


def _scale(partner: sparse.bsr_array) -> FloatArray:
    """L⁻¹ of the diagonal blocks L Lᵀ, shape (b, m, m)."""
    rows = np.repeat(np.arange(len(partner.indptr) - 1), np.diff(partner.indptr))
    blocks = partner.data[rows == partner.indices]
    if not np.isfinite(partner.data).all():
        raise StagnationError("the matrix is not finite")
    try:
        inverse: FloatArray = np.linalg.inv(np.linalg.cholesky(blocks))
    except np.linalg.LinAlgError as error:
        raise StagnationError("nothing holds some body") from error
    return inverse


def _scaled(matrix: sparse.bsr_array, scale: FloatArray) -> sparse.bsr_array:
    """L⁻¹ A L⁻ᵀ."""
    rows = np.repeat(np.arange(len(matrix.indptr) - 1), np.diff(matrix.indptr))
    data = scale[rows] @ matrix.data @ scale[matrix.indices].transpose(0, 2, 1)
    indices, pointer = matrix.indices.astype(np.int32), matrix.indptr.astype(np.int32)
    return sparse.bsr_array((data, indices, pointer), shape=matrix.shape, blocksize=matrix.blocksize)


def _by_body(blocks: FloatArray, vector: FloatArray) -> FloatArray:
    product: FloatArray = blocks @ vector.reshape(*blocks.shape[:2], 1)
    return product.ravel()


def nearest_definite(slope: FloatArray) -> tuple[FloatArray, bool]:
    """The partner of each contact's block, and whether all were symmetric.

    A sliding contact resists as K (n − μ t) nᵀ: its symmetric part is indefinite and leads nowhere,
    its right polar factor (SᵀS)^½ ∝ K n nᵀ is the contact without friction. It is S where S is
    symmetric positive semidefinite.

    Parameters
    ----------
    slope : S, shape (k, d, d).
    """
    size = np.abs(slope).max(axis=(1, 2), initial=0.0)
    skew = np.abs(slope - slope.transpose(0, 2, 1)).max(axis=(1, 2), initial=0.0)
    turned = np.flatnonzero(skew > ROUNDING * size)
    if not len(turned):
        return slope, True
    _, values, axes = np.linalg.svd(slope[turned])
    partner = slope.copy()
    partner[turned] = (axes.transpose(0, 2, 1) * values[:, None, :]) @ axes
    return partner, False
