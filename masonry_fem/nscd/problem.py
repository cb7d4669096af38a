"""ContactProblem: one step's unilateral contact with friction, in split form.

Find the impulses p and the rigid velocities U with

    v = W_el p + q + B U,    K* ∋ v + μ‖v_T‖ n ⊥ p ∈ K,    Bᵀ p + f_r − M_r (U − U_0) = 0

(formulation 2b). A rigid block has no compliance W_el, a static one no rigid mass M_r; a plain
problem v = W p + q has all of W as compliance and no bodies.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class ContactProblem:
    """One step's contact problem. c contacts, d = 2 or 3, b rigid bodies of m velocities each.

    Attributes
    ----------
    friction : Coulomb coefficients μ, shape (c,).
    free_velocity : Velocity without impulses and without rigid motion q: elastic free velocity,
        prescribed motion of supports and the gap term on the normal component [m/s], (c, d).
    compliance : Elastic part W_el of the Delassus operator [1/kg], block-sparse with (d, d)
        blocks, shape (c d, c d); stored symmetric. No stored blocks where all bodies are rigid.
    bodies : Rigid bodies on the two sides of each contact (candidate, antagonist), −1 where that
        side has no rigid freedom, shape (c, 2).
    rigid_map : B by contact and side, in the contact's frame, signs included, so that
        v = Σ_s rigid_map[:, s] @ U[bodies[:, s]], shape (c, 2, d, m).
    rigid_mass : Diagonal of M_r (1 in dynamics with mass-orthonormal modes, 0 in statics), (b, m).
    rigid_impulse : f_r, impulse of the loads on the rigid modes, shape (b, m).
    rigid_velocity : U_0, rigid velocities before the step, shape (b, m).
    """

    friction: FloatArray
    free_velocity: FloatArray
    compliance: sparse.bsr_array
    bodies: IntArray
    rigid_map: FloatArray
    rigid_mass: FloatArray
    rigid_impulse: FloatArray
    rigid_velocity: FloatArray

    @property
    def count(self) -> int:
        """Number of contacts c."""
        return int(self.free_velocity.shape[0])

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return int(self.free_velocity.shape[1])
