"""TangentCompliance: (M̂⁻¹)_el of a block that yields; its tangent need not be symmetric.

    compliance = TangentCompliance(operators, tangent, modes, free, scheme)
    compliance.apply(impulse)
    compliance.block(dofs)

M̂ = c_m M + c_k K + h²θ² (K_t − K), as the tangent takes the place of the stiffness but not of the damping.
Non-associated flow makes K_t unsymmetric, and with it the compliance and the W of the contacts: contact
methods that solve for W as it is (Newton) converge as fast; nothing of theirs but speed depends on symmetry.

Perfect plasticity leaves motions without stiffness. A share of the elastic stiffness is added to the tangent
of the iteration; the residual is not touched.
"""

from __future__ import annotations

from dataclasses import replace
from typing import override

import numpy as np
from numpy.typing import NDArray
from scipy import linalg, sparse

from masonry_fem.bodies.base import Scheme
from masonry_fem.fem.assemble import ShapeOperators
from masonry_fem.fem.condense import Compliance, Factor, SparseFactor, coefficients
from masonry_fem.fem.modes import RigidModes

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

# Of the elastic stiffness: added to the tangent, which may have none in a direction. With less, what contacts
# are solved to (1e-10) is not enough for the residual of a stone that flows; with more, rounds take longer.
SOFTEST = 2e-6


class DenseLU(Factor):
    """LU of M̂ + σ M Φ Φᵀ M, with the projections Π and Πᵀ on both sides."""

    @override
    def _factorise(self, effective: sparse.csr_array, sigma: float) -> None:
        matrix = effective.toarray() + sigma * (self._momentum @ self._momentum.T)
        self._factor = linalg.lu_factor(matrix, overwrite_a=True, check_finite=False)

    @override
    def solve(self, impulses: FloatArray) -> FloatArray:
        deflated = impulses - self._momentum @ (self._modes.T @ impulses)
        answer: FloatArray = linalg.lu_solve(self._factor, deflated, check_finite=False)
        answer -= self._modes @ (self._momentum.T @ answer)
        return answer


class SparseLU(SparseFactor):
    """The same by a sparse LU, on springs."""

    symmetric = False


class TangentCompliance(Compliance):
    """(M̂⁻¹)_el of one block with a tangent of its own, for one scheme; zero at clamped dofs.

    Parameters
    ----------
    operators : Mass and elastic stiffness. tangent : K_t, shape (n, n) [N/m].
    modes : Rigid modes; neither K_t nor its transpose has forces for them.
    free : Dofs that are not clamped, shape (n_free,). scheme : Coefficients of the step.
    """

    kinds = (DenseLU, SparseLU)

    def __init__(
        self,
        operators: ShapeOperators,
        tangent: sparse.csr_array,
        modes: RigidModes,
        free: IntArray,
        scheme: Scheme,
    ) -> None:
        c_k = coefficients(operators, scheme)[1]
        share = (1 - SOFTEST) * (scheme.step * scheme.theta) ** 2 / c_k
        effective = sparse.csr_array(operators.stiffness + share * (tangent - operators.stiffness))
        self.stiffness = effective  # that has the tangent's place in M̂
        super().__init__(replace(operators, stiffness=effective), modes, free, scheme)

    @override
    def block(self, dofs: IntArray) -> FloatArray:
        """Dense block of (M̂⁻¹)_el on some dofs, as unsymmetric as the tangent."""
        return self.columns(dofs)
