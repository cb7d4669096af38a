"""Balance: momentum and energy of a θ-step of elastic blocks, from the two states alone.

It uses nothing of the code that makes the step, so that it is an independent check.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from masonry_fem.bodies.base import FloatArray, Scheme, StepEnergy
from masonry_fem.fem.assemble import ShapeOperators
from masonry_fem.fem.clamp import Holds
from masonry_fem.fem.constitution import Constitution, dot, times
from masonry_fem.fem.meshed import ElasticState
from masonry_fem.fem.modes import RigidModes

if TYPE_CHECKING:
    from masonry_fem.fem.deformable import Deformed


@dataclass(frozen=True, slots=True)
class Balance:
    """The operators that a step is judged by.

    Attributes
    ----------
    operators : Stiffness and mass. constitution : Forces of stresses, and what they take.
    modes : Rigid modes. holds : Dofs that clamps hold.
    """

    operators: ShapeOperators
    constitution: Constitution
    modes: RigidModes
    holds: Holds

    def residual(
        self, before: ElasticState, after: ElasticState, force: FloatArray, scheme: Scheme
    ) -> FloatArray:
        """M (u⁺ − u) + h C u_θ + h ∫Bᵀσ_θ − h F_θ of all nodes, shape (b, n) [N s]."""
        h, theta, inertia, own = scheme.step, scheme.theta, scheme.inertia, self.operators
        total, rate = -h * force, None
        if inertia:
            total += self.inertia(before, after, scheme)
            rate = inertia * own.material.stiffness_damping * mean_velocity(before, after, theta)[1]
        residual: FloatArray = total + h * self.constitution.forces(before, after, theta, rate)
        return residual

    def inertia(self, before: ElasticState, after: ElasticState, scheme: Scheme) -> FloatArray:
        """M (u⁺ − u + h α u_θ) of all nodes, α the mass damping; 0 in statics, shape (b, n) [N s]."""
        h, own = scheme.step, self.operators
        alpha = own.material.mass_damping
        rigid_mean, elastic_mean = mean_velocity(before, after, scheme.theta)
        rigid = after.rigid_velocity - before.rigid_velocity + h * alpha * rigid_mean
        elastic = after.velocity - before.velocity + h * alpha * elastic_mean
        taken: FloatArray = scheme.inertia * times(rigid @ self.modes.modes.T + elastic, own.mass)
        return taken

    def imbalance(self, residual: FloatArray, impulse: FloatArray, nodal: FloatArray | None) -> FloatArray:
        """Size of what impulses Bᵀ p (b, m) and Gᵀ p (b, n) leave of a residual, shape (b,) [N s].

        The rigid part, √m times a residual in U, and the nodal residual that is left, in one norm.
        """
        modes, free = self.modes.modes, self.holds.free
        # M_ff Φ: Φ vanishes at held dofs
        momentum = self.modes.momentum[free]
        rigid = residual @ modes - impulse
        elastic = (residual if nodal is None else residual - nodal)[:, free]
        elastic = elastic - (elastic @ modes[free]) @ momentum.T
        size: FloatArray = np.hypot(
            np.sqrt(self.mass) * np.linalg.norm(rigid, axis=1), np.linalg.norm(elastic, axis=1)
        )
        return size

    @property
    def mass(self) -> float:
        """Mass of one block [kg]."""
        d = self.operators.mesh.dimension
        return float(self.operators.mass.sum() / d)

    def mass_square(self, rigid: FloatArray, elastic: FloatArray) -> FloatArray:
        """uᵀ M u of u = Φ U + u_el, shape (b,)."""
        held = self.holds.dofs
        # Φ and u_el are M-orthogonal but for what clamps move
        crossed = dot(rigid, elastic[:, held] @ self.modes.momentum[held])
        return dot(rigid, rigid) + 2 * crossed + dot(times(elastic, self.operators.mass), elastic)

    def energy(
        self, before: ElasticState, after: ElasticState, force: FloatArray, given: FloatArray | None,
        scheme: Scheme,
    ) -> StepEnergy:  # fmt: skip
        """Work of F_θ and of the impulses that moving clamps give (b, n); what damping, stone and θ took.

        ``given`` is read at held dofs only; None: no clamp moves.
        """
        h, theta, inertia, own = scheme.step, scheme.theta, scheme.inertia, self.operators
        rigid, elastic = mean_velocity(before, after, theta)
        external = h * (dot(force @ self.modes.modes, rigid) + dot(force, elastic))
        held = self.holds.dofs
        support = np.zeros(len(force)) if given is None else dot(given[:, held], elastic[:, held])
        numerical, lost = self.constitution.lost(before, after, theta)
        damping = np.zeros(len(force))
        if inertia:
            change = after.rigid_velocity - before.rigid_velocity, after.velocity - before.velocity
            numerical = numerical + (theta - 0.5) * inertia * self.mass_square(*change)
            damping = own.material.mass_damping * self.mass_square(rigid, elastic)
            damping += own.material.stiffness_damping * dot(times(elastic, own.stiffness), elastic)
        heat = self.constitution.heat(before, after, theta)
        loaded = h * (dot(abs(force @ self.modes.modes), abs(rigid)) + dot(abs(force), abs(elastic)))
        summed = loaded + products(own, self.constitution, before, after, inertia)
        return StepEnergy(external, support, inertia * h * damping, numerical, lost, heat, summed)


def products(
    operators: ShapeOperators, constitution: Constitution, before: Deformed, after: Deformed, inertia: float
) -> FloatArray:
    """Absolute values of the products that energies of motion and strain in two states are sums of, (b,) [J].

    With the sizes s = |q| + |q⁺| of displacements sᵀ |K| s ≤ Σ_i s_i² Σ_j |K_ij| bounds what strains store
    and lose, as K is symmetric, and the same of velocities and M what moves. What would hold strains by
    temperature cancels where stones are free to expand.

    Parameters
    ----------
    operators : Stiffness and mass. constitution : Of the blocks.
    before, after : Their states.
    inertia : 0 in statics, where nothing moves.
    """
    stretch = abs(before.displacement) + abs(after.displacement)
    summed = stretch**2 @ operators.row_sums + constitution.confined(before, after).energy
    if inertia:
        rigid = abs(before.rigid_velocity) + abs(after.rigid_velocity)
        elastic = abs(before.velocity) + abs(after.velocity)
        summed += inertia * (dot(rigid, rigid) + dot(times(elastic, operators.mass), elastic))
    return np.asarray(summed)


def mean_velocity(before: ElasticState, after: ElasticState, theta: float) -> tuple[FloatArray, FloatArray]:
    """u_θ = (1 − θ) u + θ u⁺ in rigid (b, m) and elastic part (b, n)."""
    rigid = (1 - theta) * before.rigid_velocity + theta * after.rigid_velocity
    return rigid, (1 - theta) * before.velocity + theta * after.velocity
