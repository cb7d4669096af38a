"""Rounds: the solves of one step, each linearised at a place, and what its end leaves of balance.

rounds = Rounds(model, coupling, state, scheme, settings, until, clock, begun(coupling, state.bodies))
made = rounds.solved(rounds.start, None)           # linearised where the step begins
made = rounds.solved(there, made)                  # and where that has led
"""

from __future__ import annotations

import logging
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from masonry_fem.bodies.base import FloatArray, Free, Scheme, nonlinear
from masonry_fem.joints.fold import Turn, solve_with_laws
from masonry_fem.joints.state import JointState
from masonry_fem.march.clock import Clock
from masonry_fem.march.conditions import first_guess, joint_step
from masonry_fem.march.coupling import Coupling
from masonry_fem.march.loads import blend, blend_following, dead_forces, followed, following_forces
from masonry_fem.march.model import Model
from masonry_fem.march.place import Forecast, Place
from masonry_fem.march.state import SystemState
from masonry_fem.march.ties import snapped_ties
from masonry_fem.nscd import ContactProblem, Solution, SolverSettings, Start
from masonry_fem.nscd.graphs import lengths

logger = logging.getLogger(__name__)

NEWTON_TOLERANCE = 1e-9  # of a block's impulse, on the volume residual
NEAR = 1e-3  # the same where full steps of Newton's method lead to balance
SHARE = 1e-2  # of what a round leaves of balance: error of the contacts in the next one
KEPT = 0.5  # of the residual: what a round may leave of that of the last one where tangents are kept


@dataclass(frozen=True, slots=True)
class Loading:
    """What acts in a step.

    Attributes
    ----------
    end : Time at its end [s], in statics the load factor.
    forces : F_θ by group, with blocks where they were taken to be (``Rounds.at``).
    dead : The part that keeps its direction. following : The part that turns with blocks, in the reference.
    """

    end: float
    forces: tuple[FloatArray, ...]
    dead: tuple[FloatArray, ...]
    following: tuple[FloatArray | None, ...]


@dataclass(frozen=True, slots=True)
class Round:
    """One solve of the contacts, linearised at ``place``, and where it leads.

    Attributes
    ----------
    velocity : At the contacts, local frames, (c, d) [m/s]. joints : Their state; change : Left open of it.
    restless : The contact at which most is left open of it; None: nothing is.
    impulse : Of all contacts, (c, d) [N s]. nodal : Gᵀ p by group. bodies : States at the end.
    loading : What acts.
    residuals : What stresses of nonlinear blocks left of balance after each round so far.
    tangents : States whose tangents nonlinear blocks had in it, by group.
    slope : Of a control over the load factor [m]. missed : By how much it missed its end, over what it may.
    """

    place: Place
    problem: ContactProblem
    solution: Solution
    active: NDArray[np.int64]
    joints: JointState
    change: float
    free: tuple[Free, ...]
    impulse: FloatArray
    rigid: tuple[FloatArray, ...]
    nodal: tuple[FloatArray | None, ...]
    bodies: tuple[Any, ...]
    velocity: FloatArray
    loading: Loading
    residuals: tuple[float, ...] = ()
    tangents: tuple[Any, ...] = ()
    slope: float = 0.0
    missed: float = 0.0
    restless: int | None = None


@dataclass(frozen=True, slots=True)
class Rounds:
    """A step of a model, and what its rounds have in common.

    Attributes
    ----------
    model, coupling : The structure and its body groups at the contacts.
    state : Where the step begins. scheme : Its length and weights.
    settings : Of the contact solver.
    until : Time at its end [s], in statics the load factor.
    clock : Gathers CPU times by phase.
    start : Place of the contacts where it begins.
    forecast : Where it may lead; None: the first round begins as the last step ended.
    """

    model: Model
    coupling: Coupling
    state: SystemState
    scheme: Scheme
    settings: SolverSettings
    until: float
    clock: Clock
    start: Place
    forecast: Forecast | None = None

    @property
    def nonlinear(self) -> bool:
        """Whether some blocks are."""
        return any(group.nonlinear for group in self.model.groups)

    @property
    def softens(self) -> bool:
        """Whether some blocks may: which of two balances these take depends on where rounds begin."""
        return any(nonlinear(group).softens for group in self.model.groups if group.nonlinear)

    @property
    def balanced(self) -> float:
        """What stresses may leave of balance: with less precise contacts they come no nearer."""
        return max(NEWTON_TOLERANCE, self.settings.tolerance)

    def roughly(self, error: float) -> Self:
        """The same rounds with contacts solved to an error, or to the tolerance where that is larger."""
        settings = replace(self.settings, tolerance=max(error, self.settings.tolerance))
        return replace(self, settings=settings)

    def solved(self, place: Place, last: Round | None, ends: tuple[Any, ...] | None = None) -> Round:
        """The contact problem at a place, from where the last round ended.

        Parameters
        ----------
        place : Of the contacts.
        last : The round before; None: this is the first.
        ends : States that nonlinear blocks are linearised at; None: those that the last round led to, in the
            first one that where the step begins.
        """
        self.clock.lap("step")
        if ends is None:
            ends = self._first_ends() if last is None else last.bodies
        if not self.nonlinear:
            return self._solved(place, last, ends)
        tangents, before = self._tangents(last, ends), self._factorisations
        made = self._solved(place, last, self._with(tangents, ends))
        left = max(self.unbalanced(made.bodies, made.impulse, made.nodal, made.place, made.loading))
        logger.info(
            "t = %.6g, round %d: %d linear solves so far; %d tangents condensed anew; "
            "stresses leave %.1e of balance",
            made.loading.end, len(made.residuals) + 1, made.solution.linear_solves,
            self._factorisations - before, left[0],
        )  # fmt: skip
        return replace(made, residuals=(*made.residuals, left[0]), tangents=tangents)

    @property
    def _factorisations(self) -> int:
        """Of all nonlinear blocks so far."""
        return sum(group.factorisations for group in self.model.groups if group.nonlinear)

    def _tangents(self, last: Round | None, ends: tuple[Any, ...]) -> tuple[Any, ...]:
        """States whose tangents the next round has: those of its ends, or of the last round.

        Where the model keeps tangents, that is as long as they bring balance nearer at some rate.
        """
        if last is None or not self.model.keeps_tangents:
            return ends
        before = last.residuals[-2] if len(last.residuals) > 1 else np.inf
        slow = last.residuals[-1] > max(KEPT * before, NEWTON_TOLERANCE)
        return ends if slow else last.tangents

    def _with(self, tangents: tuple[Any, ...], ends: tuple[Any, ...]) -> tuple[Any, ...]:
        """What nonlinear blocks are linearised at, with the tangents of other states."""
        if tangents is ends:
            return ends
        return tuple(
            nonlinear(group).keeping(end, source) if group.nonlinear else end
            for group, end, source in zip(self.model.groups, ends, tangents, strict=True)
        )

    def _first_ends(self) -> tuple[Any, ...]:
        """What the first round is linearised at: what yielded in the step before goes on yielding.

        With inertia blocks are elastic from the start of the step on, as they go on moving without forces.
        """
        if self.forecast is not None:
            return self.forecast.place.bodies
        if self.scheme.inertia:
            return (None,) * len(self.model.groups)
        return tuple(
            group.scale_velocity(own, 0.0) if group.nonlinear else own
            for group, own in zip(self.model.groups, self.state.bodies, strict=True)
        )

    def loaded(self, end: float) -> Loading:
        """What acts in a step that ends at a time [s], in statics at a load factor."""
        model, since, theta = self.model, self.state.time, self.scheme.theta
        dead = blend(dead_forces(model, since), dead_forces(model, end), theta)
        following = blend_following(following_forces(model, since), following_forces(model, end), theta)
        return Loading(end, dead, dead, following)

    def at(self, loading: Loading, place: Place) -> Loading:
        """What acts where blocks have gone to a place: some loads turn with them."""
        forces = followed(self.model, loading.dead, loading.following, place.bodies)
        return loading if forces is loading.dead else replace(loading, forces=forces)

    def _solved(self, place: Place, last: Round | None, ends: tuple[Any, ...]) -> Round:
        """The round as its contacts make it."""
        return self._under(self.loaded(self.until) if last is None else last.loading, place, last, ends)

    def _under(self, loading: Loading, place: Place, last: Round | None, ends: tuple[Any, ...]) -> Round:
        """The round with given loads."""
        loading = self.at(loading, place)
        free, taken, active = self._taken(loading, place, last, ends)
        return self._led(loading, place, last, free, taken, active)

    def _taken(
        self, loading: Loading, place: Place, last: Round | None, ends: tuple[Any, ...]
    ) -> tuple[tuple[Free, ...], Turn, NDArray[np.int64]]:
        """Steps without contact, the contact problem's solution, and the contacts that took part.

        Where ties snap it is solved again without them: what they held finds its balance within the step.
        """
        model, coupling, state, scheme = self.model, self.coupling, self.state, self.scheme
        guesses = tuple(
            end if group.nonlinear else None for group, end in zip(model.groups, ends, strict=True)
        )
        compliance = coupling.compliance(place.contact, scheme, guesses)
        self.clock.lap("factorise" if compliance.nnz else "step")  # rigid blocks have no compliance
        free = tuple(
            group.free(own, at, force, scheme, guess)
            for group, own, at, guess, force in zip(
                model.groups, state.bodies, place.bodies, guesses, loading.forces, strict=True
            )
        )
        trial = state.joints if last is None else last.joints
        begun: Solution | None = None
        while True:
            conditions = joint_step(
                model, coupling, state, scheme, free, self.start.contact, place, compliance, trial
            )
            self.clock.lap("step")
            taken = solve_with_laws(
                model.laws, state.joints, conditions, self.settings, self._guess(conditions.active, last)
            )
            self.clock.lap("solve")
            if begun is not None:
                taken = replace(taken, solution=_summed(begun, taken.solution))
            trial, begun = taken.trial, taken.solution
            if not snapped_ties(model, trial)[conditions.active].any():
                return free, taken, conditions.active

    def _guess(self, active: NDArray[np.int64], last: Round | None) -> Start | None:
        """What the contacts' solution starts from."""
        if last is None:
            guess = first_guess(self.state, self.scheme, active)
            if guess is None or self.forecast is None:
                return guess
            told = None if self.forecast.near else guess.velocity  # near its end each contact tells itself
            return replace(guess, impulse=self.forecast.impulse[active], velocity=told)
        told = last.solution.velocity if np.array_equal(active, last.active) else None
        return Start(last.impulse[active], last.solution.rigid_velocity, told)

    def _led(
        self,
        loading: Loading,
        place: Place,
        last: Round | None,
        free: tuple[Free, ...],
        taken: Turn,
        active: NDArray[np.int64],
    ) -> Round:
        """The round that the contacts' solution makes."""
        coupling, solution = self.coupling, taken.solution
        impulse = np.zeros_like(place.contact.points)
        impulse[active] = solution.impulse
        rigid = coupling.scatter(solution.rigid_velocity, free)
        nodal = coupling.nodal_impulses(impulse, place.contact)
        bodies = tuple(
            group.advance(own, part, velocity, push, self.scheme)
            for group, own, part, velocity, push in zip(
                self.model.groups, self.state.bodies, free, rigid, nodal, strict=True
            )
        )
        elastic = tuple(
            group.velocity_parts(moved)[1] for group, moved in zip(self.model.groups, bodies, strict=True)
        )
        velocity = place.bend + coupling.rigid_velocity(rigid, place.rigid_map)
        velocity += coupling.elastic_velocity(elastic, place.contact)
        if last is not None:
            solution = _summed(last.solution, solution)
        return Round(
            place, taken.problem, solution, active, taken.trial, taken.change, free, impulse, rigid, nodal,
            bodies, velocity, loading, () if last is None else last.residuals, restless=taken.restless,
        )  # fmt: skip

    def settled(self, made: Round) -> bool:
        """Whether the stresses of all nonlinear blocks balance, and a control is where it is to be."""
        return made.missed <= 1 and (not made.residuals or made.residuals[-1] <= self.balanced)

    def unbalanced(
        self,
        bodies: tuple[Any, ...],
        impulse: FloatArray,
        nodal: tuple[FloatArray | None, ...],
        place: Place,
        loading: Loading,
    ) -> Iterator[tuple[float, int]]:
        """What stresses leave of balance in nonlinear blocks, relative to the largest impulses, and where.

        Greatest residual and its block of each group.
        """
        pushes = self.coupling.rigid_impulses(impulse, place.rigid_map)
        scale = float(lengths(impulse).max(initial=0.0))
        found = []
        rows = zip(
            self.model.groups,
            self.state.bodies,
            place.bodies,
            bodies,
            loading.forces,
            pushes,
            nodal,
            strict=True,
        )
        for group, old, at, new, force, push, field in rows:
            if not group.nonlinear:
                continue
            d = self.model.assembly.dimension
            residual = group.imbalance(old, at, new, force, push, field, self.scheme)
            given = self.scheme.step * lengths(group.resultant(force)[:, :d])
            largest = max(given.max(initial=0.0), nonlinear(group).effort(new, self.scheme).max(initial=0.0))
            scale = max(scale, float(largest))
            worst = int(np.argmax(residual))
            found.append((float(residual[worst]), int(group.blocks[worst])))
        for left, block in found:
            yield left / scale if scale > 0 else left, block

    def worst(self, made: Round) -> int:
        """The block that is furthest from balance with its own stresses."""
        left = self.unbalanced(made.bodies, made.impulse, made.nodal, made.place, made.loading)
        return max(left)[1]

    def residual(self, made: Round) -> float:
        """Largest momentum residual of a block relative to the largest impulse on any."""
        worst, scale, d = 0.0, 0.0, self.model.assembly.dimension
        pushes = self.coupling.rigid_impulses(made.impulse, made.place.rigid_map)
        for group, old, new, at, force, push, field in zip(
            self.model.groups,
            self.state.bodies,
            made.bodies,
            made.place.bodies,
            made.loading.forces,
            pushes,
            made.nodal,
            strict=True,
        ):
            if group.prescribed:
                continue
            residual = group.imbalance(old, at, new, force, push, field, self.scheme)
            worst = max(worst, float(np.abs(residual).max(initial=0.0)))
            given = self.scheme.step * lengths(group.resultant(force)[:, :d])
            scale = max(scale, float(given.max(initial=0.0)))
        return worst / scale if scale > 0 else worst


def _summed(first: Solution, second: Solution) -> Solution:
    """The second of two rounds, with the efforts of both."""
    return replace(
        second,
        iterations=first.iterations + second.iterations,
        linear_solves=first.linear_solves + second.linear_solves,
        seconds=first.seconds + second.seconds,
    )
