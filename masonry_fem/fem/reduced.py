"""Reduced blocks: blocks that deform by the modes of ``reduction`` only.

They are those of ``elastic`` and ``corotational`` with another compliance: frames, loads, energies and
stresses are theirs, and the states hold displacements of all nodes.
"""

from __future__ import annotations

from functools import cached_property
from typing import override

import numpy as np

from masonry_fem.bodies.base import FloatArray, IntArray, Scheme
from masonry_fem.fem.assemble import ShapeOperators
from masonry_fem.fem.corotational import CorotationalGroup
from masonry_fem.fem.elastic import ElasticGroup
from masonry_fem.fem.meshed import ElasticState
from masonry_fem.fem.modes import RigidModes
from masonry_fem.fem.reduction import Basis, ReducedCompliance


class Reduced:
    """What blocks have in common that deform by modes only; it goes before the class of their kinematics."""

    modal = True
    operators: ShapeOperators
    modes: RigidModes
    mass: FloatArray

    @cached_property
    def basis(self) -> Basis:
        """The modes."""
        return Basis.of(self.operators, self.modes, self.operators.material.degree)

    @property
    def unknowns(self) -> int:
        """Modes and rigid velocities that a step solves for, of all blocks."""
        return int(len(self.mass) * (len(self.basis.squares) + self.modes.modes.shape[1]))

    def _factorised(self, scheme: Scheme, surface: IntArray | None) -> ReducedCompliance:
        return ReducedCompliance(self.basis, self.operators, scheme)

    def unbalanced(self, nodal: FloatArray) -> FloatArray:
        """Size of what nodal impulses (b, n) of any origin would change in how blocks deform, (b,) [N s]."""
        size: FloatArray = np.sqrt(self.mass) * np.linalg.norm(nodal @ self.basis.modes, axis=1)
        return size


class ReducedElasticGroup(Reduced, ElasticGroup):
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


class ReducedCorotationalGroup(Reduced, CorotationalGroup):
    """Reduced blocks that turn without bound."""
