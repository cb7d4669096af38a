"""Step: one θ-step of all blocks with contact, written as Newton-Raphson on the blocks.

Each round linearises the blocks, condenses them to the contacts, solves the contact problem and feeds the
impulses back. With inertia forces balance where the step begins, and one round is all.
Statics is the same step with inertia 0, and forces balance where it ends: rounds go on
until they do, each linearised where the last one led. Where nothing turns one is all.
Stones that yield take rounds in any case: each is linearised at the stresses that the last one led to, until
these balance. What their material remembers is that of the start of the step in all of them.
"""

from __future__ import annotations

import logging
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from masonry_fem.bodies.base import FloatArray, Free, Scheme, nonlinear
from masonry_fem.joints.fold import solve_with_laws
from masonry_fem.joints.state import JointState
from masonry_fem.march.clock import Clock
from masonry_fem.march.conditions import (
    contact_status,
    first_guess,
    joint_step,
    shifted_jump,
)
from masonry_fem.march.coupling import Coupling, Placement
from masonry_fem.march.loads import blend, external_forces
from masonry_fem.march.model import Model
from masonry_fem.march.place import Place, begun, reached, relative_velocity, rounding, turning
from masonry_fem.march.state import STICK, SystemState
from masonry_fem.nscd import ContactProblem, Outcome, Solution, SolverSettings, Start

logger = logging.getLogger(__name__)

ROUNDS = 20
NEWTON_TOLERANCE = 1e-9  # of a block's impulse, on the volume residual
PATIENCE = 4  # rounds that bring forces no nearer to balance
SUFFICIENT, SHARES = 0.9, (0.5, 0.25, 0.125, 0.0625)  # of a line search: less of the residual is left
YIELDING_ROUNDS, YIELDING_PATIENCE = 40, 8  # the same of stones that yield
BALANCED = 1e-6  # of the largest load or impulse: what rounds that come no nearer may leave
ROUNDING = 1e-12  # of the model's length: a way that is none


@dataclass(frozen=True, slots=True)
class Increment:
    """Everything that one step computed, for reports and checks.

    Attributes
    ----------
    before, after : System states at both ends.
    problem : The contact problem of the last round.
    solution : Its solution, with the efforts of all rounds.
    contacts : Numbers of the contacts that took part in it, shape (k,).
    impulse : Contact impulses of all contacts, local frames [N s], shape (c, d).
    forces : F_θ by group. scheme : Its coefficients.
    free : Steps of the groups without contact. rigid : U⁺ by group.
    rigid_impulse, nodal_impulse : Bᵀ p and Gᵀ p by group.
    here : Contact geometry that the impulses balance in: that of the end in statics; of the start where
        there is inertia, or no equilibrium. rigid_map : B there, of all contacts, supports too.
    joint_change : What the joint laws' turns left open of the joints' state; 0 where they settled.
    jammed : Overlaps were held that ``expulsion`` was to drive apart, as no motion does that.
    strayed : Impulses balance where the step begins, and none were found that do where it leads.
    residuals : What stresses of nonlinear blocks left of balance, relative, round by round; () where all
        are linear.
    unsettled : The block of the greatest one, where the last is above the tolerance; None: all balance.
    """

    before: SystemState
    after: SystemState
    problem: ContactProblem
    solution: Solution
    contacts: NDArray[np.int64]
    impulse: FloatArray
    forces: tuple[FloatArray, ...]
    scheme: Scheme
    free: tuple[Free, ...]
    rigid: tuple[FloatArray, ...]
    rigid_impulse: tuple[FloatArray, ...]
    nodal_impulse: tuple[FloatArray | None, ...]
    here: Placement
    rigid_map: FloatArray
    joint_change: float = 0.0
    jammed: bool = False
    strayed: bool = False
    residuals: tuple[float, ...] = ()
    unsettled: int | None = None

    @property
    def adhesion_loss(self) -> float:
        """Greatest loss of adhesion of a contact; 0 where joints are dry."""
        return float((self.before.joints.adhesion - self.after.joints.adhesion).max(initial=0.0))


def initial_state(model: Model, coupling: Coupling, bodies: tuple[Any, ...], at: float = 0.0) -> SystemState:
    """The structure before any step: body states as given, no reactions yet.

    Parameters
    ----------
    model : The structure.
    coupling : Its body groups at their contacts.
    bodies : Body states, one a group.
    at : Time [s]; the load factor in statics.
    """
    start = begun(coupling, bodies)
    here = start.contact
    return SystemState(
        time=at,
        index=0,
        bodies=bodies,
        reaction=np.zeros_like(here.points),
        velocity=relative_velocity(model, coupling, bodies, here, start.rigid_map),
        gap=here.gap,
        status=np.full(model.contacts.count, STICK, dtype=np.int8),
        frame=here.frame,
        points=here.points,
        reaction_frame=here.frame,
        jump=np.zeros_like(here.points),
        joints=model.laws.initial(*here.points.shape),
    )


def step(
    model: Model,
    coupling: Coupling,
    state: SystemState,
    scheme: Scheme,
    settings: SolverSettings,
    until: float | None = None,
    clock: Clock | None = None,
) -> Increment:
    """Advance a state by one step.

    Parameters
    ----------
    model : The structure.
    coupling : Its body groups at their contacts.
    state : Where the step begins.
    scheme : Length and weights of the step.
    settings : Of the contact solver.
    until : Time at the end [s], in statics the load factor; by default the time of ``state`` plus the length.
    clock : Gathers CPU times by phase.
    """
    end = state.time + scheme.step if until is None else until
    before, after = external_forces(model, state.time), external_forces(model, end)
    work = _Work(
        model, coupling, state, scheme, settings, blend(before, after, scheme.theta), end,
        Clock() if clock is None else clock, begun(coupling, state.bodies),
    )  # fmt: skip
    first = work.first()
    if not work.settled(first):
        return replace(work.ended(first, work.start), strayed=True)
    if scheme.inertia == 0 and first.solution.solved and not model.fixed:
        return work.turned(first)
    return work.ended(first, work.start)


@dataclass(frozen=True, slots=True)
class _Round:
    """One solve of the contacts, linearised at ``place``, and where it leads.

    Attributes
    ----------
    velocity : At the contacts, local frames, (c, d) [m/s]. joints : Their state; change : Left open of it.
    impulse : Of all contacts, (c, d) [N s]. nodal : Gᵀ p by group. bodies : States at the end.
    residuals : What stresses of nonlinear blocks left of balance after each round so far.
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
    residuals: tuple[float, ...] = ()


@dataclass(frozen=True, slots=True)
class _Guess:
    """What nonlinear blocks are linearised at, and what their stresses leave of balance there.

    Attributes
    ----------
    place : Of the contacts. bodies : States. impulse : Of all contacts, (c, d) [N s]. left : Relative.
    """

    place: Place
    bodies: tuple[Any, ...]
    impulse: FloatArray
    left: float

    @classmethod
    def of(cls, made: _Round) -> Self:
        """The end of a round."""
        return cls(made.place, made.bodies, made.impulse, made.residuals[-1])


@dataclass(frozen=True, slots=True)
class _Work:
    """A step and what it is made with; ``end`` is its time at the end, ``start`` where it begins."""

    model: Model
    coupling: Coupling
    state: SystemState
    scheme: Scheme
    settings: SolverSettings
    forces: tuple[FloatArray, ...]
    end: float
    clock: Clock
    start: Place

    def first(self) -> _Round:
        """The round that is linearised where the step begins; more only where blocks are not linear."""
        made, last = self.solved(self.start, None), np.inf
        if self.nonlinear:
            return self.yielded(made)
        for _ in range(ROUNDS):
            if made.solution.outcome.moves:
                break
            left = self.residual(made)
            if left <= NEWTON_TOLERANCE or left > 0.5 * last:
                break  # holds, or as far as rounding lets it go
            made, last = self.solved(self.start, made), left
        return made

    @property
    def nonlinear(self) -> bool:
        """Whether some blocks are."""
        return any(group.nonlinear for group in self.model.groups)

    def yielded(self, made: _Round) -> _Round:
        """Rounds of Newton's method until the stresses of all nonlinear blocks balance, or come no nearer.

        Each is linearised where the last one led, or part of the way there if that is nearer to balance:
        points that yield in one round and not in the next would make rounds go in circles.
        """
        at, least, idle = _Guess.of(made), np.inf, 0
        while made.solution.solved and len(made.residuals) < YIELDING_ROUNDS:
            left = made.residuals[-1]
            idle, least = 0 if left <= 0.5 * least else idle + 1, min(left, least)
            if left <= NEWTON_TOLERANCE or idle > YIELDING_PATIENCE:
                break
            at = self.nearest(at, _Guess.of(made))
            made = self.solved(self.start, made, at)
        return made

    def nearest(self, start: _Guess, end: _Guess) -> _Guess:
        """The end of a round, or the point on the way there whose stresses leave least of balance."""
        if start is end or end.left <= SUFFICIENT * start.left:
            return end
        best = end
        for share in SHARES:
            tried = self.between(start, end, share)
            if tried.left >= best.left and best is not end:
                break  # it gets worse again
            if tried.left < best.left:
                best = tried
            if best.left <= SUFFICIENT * start.left:
                break
        return best

    def between(self, start: _Guess, end: _Guess, share: float) -> _Guess:
        """A ``share`` of the way from one guess to another, its material by the law."""
        impulse = start.impulse + share * (end.impulse - start.impulse)
        bodies = tuple(
            nonlinear(group).between(own, one, other, share, self.scheme) if group.nonlinear else other
            for group, own, one, other in zip(
                self.model.groups, self.state.bodies, start.bodies, end.bodies, strict=True
            )
        )
        nodal = self.coupling.nodal_impulses(impulse, end.place.contact)
        left = max(self.unbalanced(bodies, impulse, nodal, end.place))[0]
        return _Guess(end.place, bodies, impulse, left)

    def settled(self, made: _Round) -> bool:
        """Whether the stresses of all nonlinear blocks balance."""
        return not made.residuals or made.residuals[-1] <= NEWTON_TOLERANCE

    def solved(self, place: Place, last: _Round | None, at: _Guess | None = None) -> _Round:
        """The contact problem at ``place``, from where the ``last`` round ended.

        Nonlinear blocks are linearised ``at`` a guess; None: at the end of the last round.
        """
        model, coupling, state, scheme = self.model, self.coupling, self.state, self.scheme
        self.clock.lap("step")
        ends = (None,) * len(model.groups) if last is None else last.bodies if at is None else at.bodies
        guess_of = tuple(
            end if group.nonlinear else None for group, end in zip(model.groups, ends, strict=True)
        )
        compliance = coupling.compliance(place.contact, scheme, guess_of)
        self.clock.lap("factorise" if compliance.nnz else "step")  # rigid blocks have no compliance
        free = tuple(
            group.free(own, guessed if group.nonlinear else at, force, scheme)
            for group, own, at, guessed, force in zip(
                model.groups, state.bodies, place.bodies, guess_of, self.forces, strict=True
            )
        )
        trial = state.joints if last is None else last.joints
        conditions = joint_step(
            model, coupling, state, scheme, free, self.start.contact, place, compliance, trial
        )
        self.clock.lap("step")
        active, guess = conditions.active, first_guess(state, scheme, conditions.active)
        if last is not None:
            told = last.solution.velocity if np.array_equal(active, last.active) else None
            guess = Start(last.impulse[active], last.solution.rigid_velocity, told)
        taken = solve_with_laws(model.laws, state.joints, conditions, self.settings, guess)
        solution = taken.solution
        self.clock.lap("solve")
        impulse = np.zeros_like(place.contact.points)
        impulse[active] = solution.impulse
        rigid = coupling.scatter(solution.rigid_velocity, free)
        nodal = coupling.nodal_impulses(impulse, place.contact)
        bodies = tuple(
            group.advance(own, part, velocity, push, scheme)
            for group, own, part, velocity, push in zip(
                model.groups, state.bodies, free, rigid, nodal, strict=True
            )
        )
        elastic = tuple(
            group.velocity_parts(moved)[1] for group, moved in zip(model.groups, bodies, strict=True)
        )
        velocity = place.bend + coupling.rigid_velocity(rigid, place.rigid_map)
        velocity += coupling.elastic_velocity(elastic, place.contact)
        if last is not None:
            solution = _summed(last.solution, solution)
        made = _Round(
            place, taken.problem, solution, active, taken.trial, taken.change, free, impulse, rigid, nodal,
            bodies, velocity, () if last is None else last.residuals,
        )  # fmt: skip
        if self.nonlinear:
            left = max(self.unbalanced(made.bodies, made.impulse, made.nodal, made.place))
            logger.debug("round %d: stresses leave %.3e of balance", len(made.residuals) + 1, left[0])
            made = replace(made, residuals=(*made.residuals, left[0]))
        return made

    def unbalanced(
        self,
        bodies: tuple[Any, ...],
        impulse: FloatArray,
        nodal: tuple[FloatArray | None, ...],
        place: Place,
    ) -> Iterator[tuple[float, int]]:
        """What stresses leave of balance in nonlinear blocks, relative to the largest impulses, and where.

        Greatest residual and its block of each group.
        """
        pushes = self.coupling.rigid_impulses(impulse, place.rigid_map)
        scale = float(np.linalg.norm(impulse, axis=1).max(initial=0.0))
        found = []
        for group, old, new, force, push, field in zip(
            self.model.groups, self.state.bodies, bodies, self.forces, pushes, nodal, strict=True
        ):
            if not group.nonlinear:
                continue
            d = self.model.assembly.dimension
            residual = group.imbalance(old, new, new, force, push, field, self.scheme)
            given = self.scheme.step * np.linalg.norm(group.resultant(force)[:, :d], axis=1)
            largest = max(given.max(initial=0.0), nonlinear(group).effort(new, self.scheme).max(initial=0.0))
            scale = max(scale, float(largest))
            worst = int(np.argmax(residual))
            found.append((float(residual[worst]), int(group.blocks[worst])))
        for left, block in found:
            yield left / scale if scale > 0 else left, block

    def turned(self, first: _Round) -> Increment:
        """Rounds until impulses balance where the step ends, each linearised where the last one led."""
        made, least, idle, rounds = first, np.inf, 0, 0
        while True:
            there = reached(self.coupling, self.start, made.bodies, self.scheme.step)
            left, missed = self._left(made, there)
            nothing = max(ROUNDING, rounding(there.contact) / self.model.length)
            asked = max(self.settings.tolerance, made.solution.quality.block_balance)
            rest = max(left / asked, missed / nothing)
            if made.residuals:
                rest = max(rest, made.residuals[-1] / NEWTON_TOLERANCE)
            idle, rounds = 0 if rest <= 0.5 * least else idle + 1, rounds + 1
            least = min(least, rest)
            if rest <= 1 or idle > PATIENCE or rounds > ROUNDS:
                break  # holds, or as far as rounding lets it go, or round in circles
            following = self.solved(there, made)
            if not following.solution.solved:
                return self._strayed(following)
            made = following
        strayed = max(left, missed) > BALANCED or not self.settled(made)
        return replace(self.ended(made, there), strayed=strayed)

    def _left(self, made: _Round, there: Place) -> tuple[float, float]:
        """What the impulses of a round leave of balance where it leads, and how far velocities miss that.

        The first relative to the largest load or impulse, the second to the model's length.
        """
        left = turning(
            self.coupling, self.start, there, made.free, self.forces, self.scheme, made.impulse, made.place
        )
        way = there.contact.offset - self.start.contact.offset - self.scheme.step * made.velocity
        return left, float(np.abs(way).max(initial=0.0)) / self.model.length

    def _strayed(self, made: _Round) -> Increment:
        """A round that found nothing; the velocities of a mechanism are its own, whatever came before.

        Where only rounding was left of its error, or the loads are next to their limit, shorter steps would
        find no more.
        """
        there = self.start
        if not made.solution.outcome.moves:
            there = reached(self.coupling, self.start, made.bodies, self.scheme.step)
        final = made.solution.rounded or made.solution.outcome is Outcome.AT_LIMIT
        return replace(self.ended(made, there), strayed=not final)

    def ended(self, made: _Round, place: Place) -> Increment:
        """The step, its impulses written at ``place``."""
        state, scheme, coupling = self.state, self.scheme, self.coupling
        there = place.contact if place.bodies is made.bodies else coupling.placement(made.bodies)
        pressed = np.zeros_like(made.impulse)  # what Signorini and Coulomb hold for
        pressed[made.active] = made.problem.contact_part(made.solution.impulse, made.solution.velocity)
        friction = np.zeros(len(pressed))
        friction[made.active] = made.problem.friction
        after = SystemState(
            time=self.end,
            index=state.index + 1,
            bodies=made.bodies,
            reaction=made.impulse / scheme.step,
            velocity=made.velocity,
            gap=there.gap,
            status=contact_status(pressed, friction, made.impulse),
            frame=there.frame,
            points=there.points,
            reaction_frame=place.contact.frame,
            jump=shifted_jump(state, scheme) + scheme.step * scheme.theta * made.velocity,
            joints=made.joints.committed(),
            rigid_velocity=made.solution.rigid_velocity,
        )
        rigid_impulse = coupling.rigid_impulses(made.impulse, place.rigid_map)
        nodal = made.nodal
        if place is not made.place:
            nodal = coupling.nodal_impulses(made.impulse, place.contact)
        self.clock.lap("step")
        unsettled = None
        if not self.settled(made):
            unsettled = max(self.unbalanced(made.bodies, made.impulse, made.nodal, made.place))[1]
        return Increment(
            state, after, made.problem, made.solution, made.active, made.impulse, self.forces, scheme,
            made.free, made.rigid, rigid_impulse, nodal, place.contact, place.rigid_map, made.change,
            residuals=made.residuals, unsettled=unsettled,
        )  # fmt: skip

    def residual(self, made: _Round) -> float:
        """Largest momentum residual of a block relative to the largest impulse on any."""
        worst, scale, d = 0.0, 0.0, self.model.assembly.dimension
        pushes = self.coupling.rigid_impulses(made.impulse, made.place.rigid_map)
        for group, old, new, at, force, push, field in zip(
            self.model.groups,
            self.state.bodies,
            made.bodies,
            made.place.bodies,
            self.forces,
            pushes,
            made.nodal,
            strict=True,
        ):
            if group.prescribed:
                continue
            residual = group.imbalance(old, at, new, force, push, field, self.scheme)
            worst = max(worst, float(np.abs(residual).max(initial=0.0)))
            given = self.scheme.step * np.linalg.norm(group.resultant(force)[:, :d], axis=1)
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
