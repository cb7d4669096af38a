"""Deformable: what blocks of linear elasticity share, however they turn: factors, stresses, energies."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any, Protocol

import numpy as np

from masonry_fem.bodies.base import FloatArray, IntArray, Scheme, StressError
from masonry_fem.errors import GeometryError
from masonry_fem.fem.assemble import ShapeOperators
from masonry_fem.fem.balance import dot
from masonry_fem.fem.condense import Compliance, coefficients
from masonry_fem.fem.error_estimate import ErrorEstimate
from masonry_fem.fem.meshed import Meshed
from masonry_fem.fem.modes import RigidModes
from masonry_fem.fem.stress import StressRecovery
from masonry_fem.solid.pose import Pose

KEPT_FACTORS = 3  # a march alternates between few schemes


class Deformed(Protocol):
    """State of b blocks that deform: where their nodes have gone, and how they move.

    ``displacement`` (b, n) [m] is the elastic part, ``velocity`` (b, n) [m/s] its rate, ``rigid_velocity``
    (b, m) [kg^½ m/s] the rate of the rigid part.
    """

    @property
    def displacement(self) -> FloatArray: ...  # noqa: D102

    @property
    def rigid_velocity(self) -> FloatArray: ...  # noqa: D102

    @property
    def velocity(self) -> FloatArray: ...  # noqa: D102


class Deformable[S: Deformed](Meshed[S]):
    """b blocks of linear elasticity over one mesh.

    Parameters
    ----------
    blocks : Their numbers in the assembly, shape (b,).
    names : Their names.
    poses : Where the mesh stands for each.
    operators : Mesh, stiffness and mass.
    modes : Rigid modes of the mesh.
    free_dofs : Those that no clamp holds.
    """

    kind = "elastic"
    prescribed = False
    deforms = True
    nonlinear = False

    def __init__(
        self,
        blocks: IntArray,
        names: Sequence[str],
        poses: Sequence[Pose],
        operators: ShapeOperators,
        modes: RigidModes,
        free_dofs: IntArray,
    ) -> None:
        super().__init__(blocks, names, poses, operators, modes)
        self.free_dofs = free_dofs
        self._factors: dict[tuple[float, float], Compliance] = {}
        self.factorisations = 0

    @cached_property
    def _recovery(self) -> StressRecovery:
        own = self.operators
        return StressRecovery.of(own.mesh, own.material, own.plane)

    @cached_property
    def _estimate(self) -> ErrorEstimate:
        return ErrorEstimate.of(self.operators.mesh, self.operators.material)

    def share(self, other: Deformable[Any]) -> None:
        """Take over factors, and what stresses are read by, of a group with the same matrices and clamps."""
        alike = type(other) is type(self) and np.array_equal(other.free_dofs, self.free_dofs)
        if not alike or other.operators is not self.operators:
            return
        self._factors = other._factors
        for name in ("_recovery", "_estimate"):
            if name in other.__dict__:
                self.__dict__[name] = other.__dict__[name]

    def factor(self, scheme: Scheme) -> Compliance:
        """(M̂⁻¹)_el for a scheme; the last few are kept."""
        key = coefficients(self.operators, scheme)
        if key not in self._factors:
            while len(self._factors) >= KEPT_FACTORS:
                del self._factors[next(iter(self._factors))]
            self._factors[key] = self._factorised(scheme)
            self.factorisations += 1
        return self._factors[key]

    def _factorised(self, scheme: Scheme) -> Compliance:
        try:
            return Compliance(self.operators, self.modes, self.free_dofs, scheme)
        except np.linalg.LinAlgError as error:
            size = np.ptp(self.mesh.points, axis=0)
            raise GeometryError(
                f"block '{self.names[0]}': its stiffness is singular to rounding, with sides of "
                f"{', '.join(f'{side:.2g}' for side in size)} m, ν = {self.operators.material.poisson:.17g}; "
                "expected a block at most some 1e7 times as long as thick, and ν not so near 1/2; change "
                "them, or make the block rigid"
            ) from error

    def velocity_parts(self, state: S) -> tuple[FloatArray, FloatArray]:
        """The state's velocity as U (b, m) and u_el (b, n)."""
        return state.rigid_velocity, state.velocity

    def scale_velocity(self, state: S, factor: float) -> S:
        """The state with its velocities multiplied by ``factor``."""
        changed: S = replace(  # type: ignore[type-var]
            state, rigid_velocity=factor * state.rigid_velocity, velocity=factor * state.velocity
        )
        return changed

    def material_state(self, state: S) -> Mapping[str, FloatArray]:
        """Nothing: linear stones have no memory."""
        return {}

    def strain_energy(self, state: S) -> FloatArray:
        """½ qᵀ K q, shape (b,) [J]."""
        return 0.5 * dot(state.displacement @ self.operators.stiffness, state.displacement)

    def stress_error(self, state: S) -> StressError:
        """Zienkiewicz and Zhu's estimate of the error of these stresses."""
        squares = self._estimate.squares(self._recovery.gauss_stress(state.displacement))
        return StressError(squares, 2.0 * self.strain_energy(state), self._estimate.volume.sum(axis=1))
