"""Reduced blocks: blocks that deform by the modes of ``reduction`` only.

They are those of ``elastic`` and ``corotational`` with another compliance: frames, loads, energies and
stresses are theirs, and the states hold displacements of all nodes.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from typing import override

import numpy as np

from masonry_fem.bodies.base import FloatArray, Free, Scheme, StressError, StressField
from masonry_fem.fem.condense import Compliance
from masonry_fem.fem.corotational import CorotationalGroup, TurningState
from masonry_fem.fem.deformable import Deformable
from masonry_fem.fem.elastic import ElasticGroup
from masonry_fem.fem.error_estimate import energy_density
from masonry_fem.fem.meshed import ElasticState
from masonry_fem.fem.reduction import Basis, ReducedCompliance


class Reduced[S: ElasticState | TurningState](Deformable[S]):
    """What blocks have in common that deform by modes only; it goes before the class of their kinematics.

    Contacts see the modes alone. Stresses are those of the modes and of what they leave out: the static
    answer of the mesh to the forces of contacts, less that of the modes. It has no mean, and its size is told
    as an error.
    """

    modal = True

    @cached_property
    def basis(self) -> Basis:
        """The modes."""
        return Basis.of(self.operators, self.modes, self.operators.material.degree)

    @cached_property
    def _static(self) -> Compliance:
        return Compliance(self.operators, self.modes, self.free_dofs, Scheme(1.0, 1.0, 0.0))

    @property
    @override
    def unknowns(self) -> int:
        """Modes and rigid velocities that a step solves for, of all blocks."""
        return int(self.count * (len(self.basis.squares) + self.modes.modes.shape[1]))

    @override
    def _factorised(self, scheme: Scheme) -> ReducedCompliance:
        return ReducedCompliance(self.basis, self.operators, scheme)

    @override
    def unbalanced(self, nodal: FloatArray) -> FloatArray:
        """Size of what nodal impulses (b, n) of any origin would change in how blocks deform, (b,) [N s]."""
        size: FloatArray = np.sqrt(self.mass) * np.linalg.norm(nodal @ self.basis.modes, axis=1)
        return size

    @override
    def advance(
        self, state: S, free: Free, rigid_velocity: FloatArray, nodal: FloatArray | None, scheme: Scheme
    ) -> S:
        """The state at the end of the step, with the forces that contacts had in it."""
        made = super().advance(state, free, rigid_velocity, nodal, scheme)
        return replace(made, pushed=None if nodal is None else nodal / scheme.step)

    def left_out(self, state: S) -> FloatArray:
        """Displacements by the forces of contacts that no mode has, shape (b, n) [m]."""
        if state.pushed is None:
            return np.zeros_like(state.displacement)
        own = ((state.pushed @ self.basis.modes) / self.basis.squares) @ self.basis.modes.T
        left: FloatArray = self._static.apply(state.pushed) - own
        return left

    @override
    def _field(self, state: S, rotation: FloatArray) -> StressField:
        whole = replace(state, displacement=state.displacement + self.left_out(state))
        return super()._field(whole, rotation)

    @override
    def stress_error(self, state: S) -> StressError:
        """Estimate of the error of these stresses: that of the mesh, and all that the modes leave out."""
        left = self.left_out(state)
        told = super().stress_error(replace(state, displacement=state.displacement + left))
        density = energy_density(self._recovery.gauss_stress(left), self.operators.material)
        squares = np.einsum("bmp,mp->bm", density, self._recovery.weight)
        return StressError(told.squares + squares, told.norm, told.volume)


class ReducedElasticGroup(Reduced[ElasticState], ElasticGroup):
    """Reduced blocks of small kinematics."""

    @override
    def imbalance(
        self, state: ElasticState, at: ElasticState, after: ElasticState, force: FloatArray,
        impulse: FloatArray, nodal: FloatArray | None, scheme: Scheme,
    ) -> FloatArray:  # fmt: skip
        """Residual of each block's momentum equation over the step, rigid and of the modes, (b,) [N s]."""
        residual = self.balance.residual(state, after, force, scheme)
        rigid = np.sqrt(self.mass) * np.linalg.norm(residual @ self.modes.modes - impulse, axis=1)
        size: FloatArray = np.hypot(rigid, self.unbalanced(residual if nodal is None else residual - nodal))
        return size


class ReducedCorotationalGroup(Reduced[TurningState], CorotationalGroup):
    """Reduced blocks that turn without bound."""
