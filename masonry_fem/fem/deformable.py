"""Deformable: what blocks that deform share, however they turn: factors, stresses, energies."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from types import MappingProxyType
from typing import Any, Final, Protocol, Self

import numpy as np

from masonry_fem.bodies.base import FloatArray, Free, IntArray, Scheme, StressError, StressField
from masonry_fem.errors import GeometryError
from masonry_fem.fem.assemble import ShapeOperators
from masonry_fem.fem.condense import Compliance, Condensed, coefficients
from masonry_fem.fem.constitution import Constitution, Memory
from masonry_fem.fem.error_estimate import ErrorEstimate
from masonry_fem.fem.meshed import Meshed
from masonry_fem.fem.modes import RigidModes
from masonry_fem.fem.stress import StressRecovery
from masonry_fem.fem.tangent import TangentCompliance
from masonry_fem.solid.pose import Poses

KEPT_FACTORS = 3  # a march alternates between few schemes
# Of the forces that would hold what heated stones grow by: where these cancel 1e-12 of them is rounding,
# and stresses balance to 1e-9 of this share.
CANCELLED = 1e-3
NONE_YIELDS: Final[Mapping[int, TangentCompliance]] = MappingProxyType({})


class Deformed(Protocol):
    """State of b blocks that deform at a ``time`` [s]: where their nodes have gone, and how they move.

    ``displacement`` (b, n) [m] is the elastic part, ``velocity`` (b, n) [m/s] its rate, ``rigid_velocity``
    (b, m) [kg^½ m/s] the rate of the rigid part, ``memory`` that of the material.
    """

    @property
    def time(self) -> float: ...  # noqa: D102

    @property
    def displacement(self) -> FloatArray: ...  # noqa: D102

    @property
    def rigid_velocity(self) -> FloatArray: ...  # noqa: D102

    @property
    def velocity(self) -> FloatArray: ...  # noqa: D102

    @property
    def memory(self) -> Memory | None: ...  # noqa: D102


@dataclass(slots=True)
class _Tangents:
    """Factors of the blocks that yield, for a scheme, and the moduli that they were made of."""

    moduli: FloatArray
    key: tuple[float, float]
    factors: Mapping[int, TangentCompliance]


class Deformable[S: Deformed](Meshed[S]):
    """b blocks over one mesh that are strained little.

    Parameters
    ----------
    blocks : Their numbers in the assembly, shape (b,).
    names : Their names.
    poses : Where the mesh stands for each.
    operators : Mesh, stiffness and mass.
    modes : Rigid modes of the mesh.
    free_dofs : Those that no clamp holds.
    constitution : Their stresses.
    kind : Name of their fidelity.
    """

    prescribed = False
    deforms = True
    modal = False

    def __init__(
        self,
        blocks: IntArray,
        names: Sequence[str],
        poses: Poses,
        operators: ShapeOperators,
        modes: RigidModes,
        free_dofs: IntArray,
        constitution: Constitution,
        kind: str,
    ) -> None:
        super().__init__(blocks, names, poses, operators, modes)
        self.free_dofs, self.constitution = free_dofs, constitution
        self.kind, self.nonlinear = kind, constitution.nonlinear
        self._tangents: _Tangents | None = None
        self._factors: dict[tuple[float, float], Condensed] = {}
        self.factorisations = 0

    @cached_property
    def _recovery(self) -> StressRecovery:
        own = self.operators
        return StressRecovery.of(own.mesh, own.material, own.plane)

    @cached_property
    def _estimate(self) -> ErrorEstimate:
        own = self.operators
        return ErrorEstimate.of(own.mesh, own.material, own.plane)

    @abstractmethod
    def nodal_motion(self, state: S) -> tuple[FloatArray, FloatArray]:
        """Displacements [m] and velocities [m/s] of all nodes, turns to first order, shape axes, (b, n)."""

    @abstractmethod
    def moved_by(self, state: S, rows: IntArray, displacement: FloatArray, velocity: FloatArray) -> S:
        """The state with blocks ``rows`` (k,) moved as ``nodal_motion`` tells, displacements (k, n)."""

    def clamped_at(self, state: S) -> Self:
        """The same blocks with clamps whose motions go on from where a state has them."""
        return self

    def clamped_as(self, other: Self) -> Self:
        """The same blocks with the clamps of another group of them, which may be of another material."""
        return self

    def strained_as(self, state: S) -> S:
        """The state with the stresses that this material has at strains that were reached with another."""
        memory = self.constitution.followed(state, state.displacement, state.time)
        found: S = replace(state, memory=memory)  # type: ignore[type-var]
        return found

    def clamp_forces(self, state: S, force: FloatArray, nodal: FloatArray) -> FloatArray:
        """What clamps give beside loads and contacts (b, n) in statics, zero at free dofs, (b, n) [N]."""
        return np.zeros_like(force)

    def share(self, other: Deformable[Any]) -> None:
        """Take over factors, and what stresses are read by, of a group with the same matrices and clamps."""
        alike = type(other) is type(self) and np.array_equal(other.free_dofs, self.free_dofs)
        if not alike or other.operators is not self.operators or other.kind != self.kind:
            return
        self._factors = other._factors
        if self.constitution.warming is None and other.constitution.warming is None:
            self.constitution = other.constitution
        for name in ("_recovery", "_estimate"):
            if name in other.__dict__:
                self.__dict__[name] = other.__dict__[name]

    def factor(self, scheme: Scheme) -> Condensed:
        """(M̂⁻¹)_el for a scheme; the last few are kept.

        Parameters
        ----------
        scheme : Coefficients of the step.
        """
        key = coefficients(self.operators, scheme)
        if key not in self._factors:
            self.keep(scheme, self._factorised(scheme))
        return self._factors[key]

    def factored(self, scheme: Scheme) -> bool:
        """Whether there is a factor for a scheme."""
        return coefficients(self.operators, scheme) in self._factors

    def keep(self, scheme: Scheme, factor: Condensed) -> None:
        """Keep a factor for a scheme that there is none for.

        Parameters
        ----------
        scheme : Coefficients of the step. factor : Made for it.
        """
        if self.factored(scheme):  # that of another group with the same matrices
            return
        while len(self._factors) >= KEPT_FACTORS:
            del self._factors[next(iter(self._factors))]
        self._factors[coefficients(self.operators, scheme)] = factor
        self.factorisations += 1

    def _factorised(self, scheme: Scheme) -> Condensed:
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

    def unbalanced(self, nodal: FloatArray) -> FloatArray:
        """Size of what nodal impulses (b, n) of any origin would change in how blocks deform, (b,) [N s]."""
        size: FloatArray = np.linalg.norm(nodal, axis=1)
        return size

    def tangents(self, guess: Deformed | None, scheme: Scheme) -> Mapping[int, TangentCompliance]:
        """(M̂_t⁻¹)_el of the blocks that yield in ``guess``; none where it is None, or none does.

        It is the same mapping as long as guesses have the same tangents.

        Parameters
        ----------
        guess : What the blocks are linearised at; None: they are elastic from the start of the step on.
        scheme : Coefficients of the step.
        """
        if guess is None or guess.memory is None or not len(guess.memory.yielding):
            return NONE_YIELDS
        key, moduli, last = coefficients(self.operators, scheme), guess.memory.moduli, self._tangents
        if last is None or last.moduli is not moduli or last.key != key:
            made = {
                body: TangentCompliance(self.operators, tangent, self.modes, self.free_dofs, scheme)
                for body, tangent in self.constitution.tangents(guess)
            }
            self.factorisations += len(made)
            last = self._tangents = _Tangents(moduli, key, made)
        return last.factors

    def keeping(self, guess: S, other: S | None) -> S:
        """A guess whose tangents are those of another state; the elastic ones where that is None.

        Parameters
        ----------
        guess : What stresses are those of. other : What tangents are those of.
        """
        own, source = guess.memory, None if other is None else other.memory
        if own is None:
            return guess
        yielding, moduli = own.yielding[:0], own.moduli[:0]
        if source is not None:
            yielding, moduli = source.yielding, source.moduli
        kept: S = replace(  # type: ignore[type-var]
            guess, memory=replace(own, yielding=yielding, moduli=moduli)
        )
        return kept

    def holding(self, guess: S) -> S:
        """A guess whose tangents are those of damage that stays; elastic ones where the law has none."""
        own = guess.memory
        if own is None or own.held is None:
            return self.keeping(guess, None)
        held: S = replace(guess, memory=replace(own, moduli=own.held))  # type: ignore[type-var]
        return held

    def compliant(self, nodal: FloatArray, guess: Deformed | None, scheme: Scheme) -> FloatArray:
        """(M̂_t⁻¹)_el of nodal impulses (b, n) [N s], shape (b, n) [m/s].

        Parameters
        ----------
        nodal : Axes of the shape or frame.
        guess : What the blocks are linearised at; None: they are elastic.
        scheme : Coefficients of the step.
        """
        answer = self.factor(scheme).apply(nodal)
        for body, factor in self.tangents(guess, scheme).items():
            answer[body] = factor.apply(nodal[body : body + 1])[0]
        return answer

    def advance(
        self, state: S, free: Free, rigid_velocity: FloatArray, nodal: FloatArray | None, scheme: Scheme
    ) -> S:
        """The state at the end of the step: u⁺ = Φ U⁺ + u_el,free + (M̂⁻¹)_el Gᵀ p, q⁺ by the θ rule."""
        assert free.elastic is not None
        velocity = free.elastic
        if nodal is not None:
            velocity = velocity + self.compliant(nodal, free.guess, scheme)
        return self._reached(state, free.origin, rigid_velocity, velocity, scheme)

    def between(self, state: S, start: S, end: S, share: float, scheme: Scheme) -> S:
        """The state at the end of a step from ``state`` with velocities between those of two others.

        Parameters
        ----------
        state : Where the step begins. start, end : Two guesses of where it ends.
        share : Of the way from the first to the second. scheme : Coefficients of the step.
        """
        rigid = start.rigid_velocity + share * (end.rigid_velocity - start.rigid_velocity)
        velocity = start.velocity + share * (end.velocity - start.velocity)
        return self._reached(state, None, rigid, velocity, scheme)

    @abstractmethod
    def _reached(
        self, state: S, origin: S | None, rigid_velocity: FloatArray, velocity: FloatArray, scheme: Scheme
    ) -> S:
        """The state at the end of a step, its velocities given: U leads on from ``origin``, or the start."""

    def effort(self, after: Deformed, scheme: Scheme) -> FloatArray:
        """Size of the impulses that a block's stresses have on its nodes, shape (b,) [N s].

        Where heated stones are free to expand none are left but for rounding of what would hold them.

        Parameters
        ----------
        after : State at the end of a step. scheme : Its coefficients.
        """
        forces = self.constitution.forces(after, after, scheme.theta)
        least = CANCELLED * self.constitution.confined(after, after).force
        size: FloatArray = scheme.step * np.maximum(np.linalg.norm(forces, axis=1), least)
        return size

    def promoted(self, state: S) -> FloatArray | None:
        """Time from which each block has not been elastic any more, shape (b,) [s]; None: that never changes.

        It is ∞ while a block is elastic.
        """
        return self.constitution.promoted(state)

    def warmed(self, state: S) -> FloatArray | None:
        """Strain by temperature of each block in a state, shape (b,); None where there is none."""
        warming = self.constitution.warming
        return None if warming is None else warming.strain(state.time)

    @property
    def material_name(self) -> str:
        """The law of their material, for reports."""
        return self.constitution.law

    @property
    def softens(self) -> bool:
        """Whether their material loses strength as it is strained further."""
        return self.constitution.softens

    def velocity_parts(self, state: S) -> tuple[FloatArray, FloatArray]:
        """The state's velocity as U (b, m) and u_el (b, n)."""
        return state.rigid_velocity, state.velocity

    def scale_velocity(self, state: S, factor: float) -> S:
        """The state with its velocities multiplied by ``factor``."""
        changed: S = replace(  # type: ignore[type-var]
            state, rigid_velocity=factor * state.rigid_velocity, velocity=factor * state.velocity
        )
        return changed

    def going_on(self, state: S, end: S) -> S:
        """The state with velocities and material of the end."""
        changed: S = replace(  # type: ignore[type-var]
            state, rigid_velocity=end.rigid_velocity, velocity=end.velocity, memory=end.memory
        )
        return changed

    def lost_between(self, state: S, after: S) -> FloatArray:
        """Energy that the material loses on the way from one state to another, shape (b,) [J]."""
        memory = self.constitution.followed(state, after.displacement, after.time)
        return np.zeros(self.count) if memory is None else memory.dissipated

    def joined(self, state: S, after: S, lost: FloatArray | float) -> S:
        """The end of a step from ``state`` that was reached by several, which lost so much, (b,) [J]."""
        changed: S = replace(  # type: ignore[type-var]
            after, memory=self.constitution.joined(state, after, lost)
        )
        return changed

    def material_state(self, state: S) -> Mapping[str, FloatArray]:
        """What the material shows of its memory at Gauss points, each of shape (b, m, p)."""
        return self.constitution.shown(state)

    def strain_energy(self, state: S) -> FloatArray:
        """What the material can give back, shape (b,) [J]."""
        return self.constitution.stored(state)

    def _field(self, state: S, rotation: FloatArray) -> StressField:
        """Stresses of all blocks at Gauss points and nodes, world axes, from axes turned by (b, d, d)."""
        stress = self.constitution.stress(state)
        if stress is None:
            return self._recovery.field(state.displacement, rotation)
        return self._recovery.smoothed(stress, rotation)

    def stress_error(self, state: S) -> StressError:
        """Estimate of the error of these stresses, in the elastic norm: see ``error_estimate``."""
        stress = self.constitution.stress(state)
        squares = self._estimate.squares(
            self._recovery.gauss_stress(state.displacement) if stress is None else stress
        )
        return StressError(squares, 2.0 * self.strain_energy(state), self._estimate.volume.sum(axis=1))
