"""BodySolver: solves with the matrices of one problem's bodies, by a factor or by iteration.

"auto" takes what costs less: the factor of a wall that is one brick thick is cheap at any size, that
of a mass of masonry fills. An iteration that fails is followed by the factor, and after two in a row by
factors only.

    bodies = BodySolver(body_matrix, library)
    solve = bodies.solver(slope, contacts, diagonal, factorised)
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from masonry_fem.nscd.krylov import StagnationError, iterated, nearest_definite
from masonry_fem.nscd.linear import Library, Solve
from masonry_fem.nscd.linear_cost import LinearCost
from masonry_fem.nscd.solvers.body_matrix import BodyMatrix
from masonry_fem.nscd.solvers.common_motion import common_motions

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

logger = logging.getLogger(__name__)

# Failures in a row after which it is factors only.
FAILURES = 2


class BodySolver:
    """Which solver the bodies' matrices get, and what it keeps from one to the next.

    Parameters
    ----------
    body_matrix : What makes the matrices.
    library : "auto", "krylov", or one of the factors.
    """

    def __init__(self, body_matrix: BodyMatrix, library: Library) -> None:
        self.body_matrix, self.library = body_matrix, library
        self.failures = 0

    @cached_property
    def cost(self) -> LinearCost:
        """What either way is expected to cost."""
        pattern = self.body_matrix.pattern
        return LinearCost.foreseen(pattern.indices, pattern.pointer, self.body_matrix.size)

    def iterates(self, *, symmetric: bool) -> bool:
        """True where a matrix is to be solved by iteration."""
        if self.failures >= FAILURES:
            return False
        if self.library == "auto":
            return self.cost.iteration_pays(symmetric=symmetric)
        return self.library == "krylov"

    @cached_property
    def motions(self) -> FloatArray:
        """What the coarse levels hold, (b, m, m)."""
        pattern = self.body_matrix.pattern
        return common_motions(pattern.bodies, self.body_matrix.maps, pattern.count)

    def solver(
        self,
        slope: FloatArray,
        contacts: IntArray,
        diagonal: FloatArray,
        factorised: Callable[[sparse.bsr_array], Solve],
    ) -> Solve:
        """A solver of −(Diag + Bᵀ S B).

        Parameters
        ----------
        slope, contacts, diagonal : As for ``BodyMatrix.assemble``, positive.
        factorised : Makes the factor's solver of a matrix.
        """
        matrix = self.body_matrix.assemble(slope, contacts, diagonal)
        # the test for symmetry costs something, too
        if not self.iterates(symmetric=True):
            return factorised(-matrix)
        partner, symmetric = nearest_definite(slope)
        if not self.iterates(symmetric=symmetric):
            return factorised(-matrix)
        near = matrix if symmetric else self.body_matrix.assemble(partner, contacts, diagonal)
        factor: Solve | None = None
        try:
            quick = iterated(matrix, near, self.motions, symmetric=symmetric)
        except (StagnationError, np.linalg.LinAlgError) as failure:
            self._note(failure)
            return factorised(-matrix)

        def solve(rhs: FloatArray) -> FloatArray:
            nonlocal factor
            if factor is None:
                try:
                    answer = quick(-rhs)
                except StagnationError as failure:
                    self._note(failure)
                    factor = factorised(-matrix)
                else:
                    self.failures = 0
                    return answer
            return factor(rhs)

        return solve

    def _note(self, failure: Exception) -> None:
        self.failures += 1
        then = "this matrix is" if self.failures < FAILURES else "this matrix and all further ones are"
        logger.info("Krylov iteration failed (%s); %s factorised", failure, then)
