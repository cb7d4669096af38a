"""Step: one θ-step of all blocks with contact, written as Newton-Raphson on the blocks.

Each round linearises the blocks, condenses them to the contacts, solves the contact problem and feeds the
impulses back. With inertia forces balance where the step begins, and one round is all.
Statics is the same step with inertia 0, and forces balance where it ends: rounds go on
until they do, each linearised where the last one led. Where nothing turns one is all.
Stones that yield take rounds in any case: each is linearised at the stresses that the last one led to, until
these balance. What their material remembers is that of the start of the step in all of them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from masonry_fem.bodies.base import FloatArray, Free, Scheme
from masonry_fem.march.clock import Clock
from masonry_fem.march.conditions import ROUNDING, contact_status, shifted_jump
from masonry_fem.march.coupling import Coupling, Placement
from masonry_fem.march.model import Model
from masonry_fem.march.place import Place, begun, relative_velocity
from masonry_fem.march.rounds import NEWTON_TOLERANCE, Round, Rounds
from masonry_fem.march.snapping import snapped
from masonry_fem.march.state import STICK, SystemState, TrendState
from masonry_fem.march.steering import SteeredRounds
from masonry_fem.march.ties import taut_sticks
from masonry_fem.march.turning import Turned, turned, turned_roughly
from masonry_fem.march.yielding import settled_stresses
from masonry_fem.nscd import ContactProblem, Solution, SolverSettings

MOST = 20  # rounds in all


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
    restless : The contact at which most was left open; None: nothing was.
    jammed : Overlaps were held that ``expulsion`` was to drive apart, as no motion does that.
    strayed : Impulses balance where the step begins, and none were found that do where it leads.
    residuals : What stresses of nonlinear blocks left of balance, relative, round by round; () where all
        are linear.
    unsettled : The block of the greatest one, where the last is above the tolerance, or of a control that
        misses its place; None: all balance.
    snapped : Stones found no balance near the start of the step, but one further away.
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
    restless: int | None = None
    jammed: bool = False
    strayed: bool = False
    residuals: tuple[float, ...] = ()
    unsettled: int | None = None
    snapped: bool = False

    @property
    def adhesion_loss(self) -> float:
        """Greatest loss of adhesion of a contact; 0 where joints are dry."""
        return float((self.before.joints.adhesion - self.after.joints.adhesion).max(initial=0.0))


def initial_state(model: Model, coupling: Coupling, bodies: tuple[Any, ...]) -> SystemState:
    """The structure before any step: body states as given, no reactions yet.

    Parameters
    ----------
    model : The structure.
    coupling : Its body groups at their contacts.
    bodies : Body states, one a group.
    """
    start = begun(coupling, bodies)
    here = start.contact
    return SystemState(
        time=0.0,
        index=0,
        bodies=bodies,
        reaction=np.zeros_like(here.points),
        velocity=relative_velocity(coupling, bodies, here, start.rigid_map),
        gap=here.gap,
        status=np.full(model.contacts.count, STICK, dtype=np.int8),
        frame=here.frame,
        points=here.points,
        reaction_frame=here.frame,
        jump=np.zeros_like(here.points),
        joints=replace(
            model.laws.initial(*here.points.shape),
            apart=np.where(here.gap > ROUNDING * model.length, here.gap, 0.0),
        ),
    )


def step(
    model: Model,
    coupling: Coupling,
    state: SystemState,
    scheme: Scheme,
    settings: SolverSettings,
    until: float | None = None,
    clock: Clock | None = None,
    *,
    snaps: bool = False,
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
        Where the model has a ``control``, the share of its distance that is reached instead.
    clock : Gathers CPU times by phase.
    snaps : Look further away for a balance of stones that soften where none is near the start.
    """
    end = state.time + scheme.step if until is None else until
    rounds = _rounds(model, coupling, state, scheme, settings, end, Clock() if clock is None else clock)
    turns = scheme.inertia == 0 and not model.fixed
    found = turned_roughly(rounds) if turns else None
    if found is not None:
        return _ended(rounds, found.made, found.place)
    first = _first(rounds)
    snap = snapped(rounds, first) if snaps else None
    if snap is not None:
        rounds, first = snap.rounds, snap.made
    if _unbalanced(rounds, first):
        return replace(_ended(rounds, first, rounds.start), strayed=True)
    found = (
        turned(rounds, first)
        if turns and first.solution.solved
        else Turned(first, rounds.start, strayed=False)
    )
    ended = replace(_ended(rounds, found.made, found.place), strayed=found.strayed)
    if snap is None:
        return ended
    return replace(ended, before=state, after=snap.ended(state, ended.after), snapped=True)


def _rounds(
    model: Model,
    coupling: Coupling,
    state: SystemState,
    scheme: Scheme,
    settings: SolverSettings,
    end: float,
    clock: Clock,
) -> Rounds:
    """The rounds of a step that ends at a time [s], a load factor, or a share of the control's distance."""
    kind = Rounds if model.control is None else SteeredRounds
    start = begun(coupling, state.bodies, gathered=bool(scheme.inertia))
    return kind(model, coupling, state, scheme, settings, end, clock, start)


def _first(rounds: Rounds) -> Round:
    """The round that is linearised where the step begins; more only where blocks are not linear."""
    made, last = rounds.solved(rounds.start, None), np.inf
    if rounds.nonlinear:
        return settled_stresses(rounds, made)
    for _ in range(MOST):
        if made.solution.outcome.moves or made.solution.outcome.late:
            break
        left = rounds.residual(made)
        if left <= NEWTON_TOLERANCE or left > 0.5 * last:
            break  # holds, or as far as rounding lets it go
        made, last = rounds.solved(rounds.start, made), left
    return made


def _unbalanced(rounds: Rounds, made: Round) -> bool:
    """Whether stones that nothing lets fall are not in balance with their own stresses."""
    falls = made.solution.outcome.moves and rounds.model.control is None
    return not (falls or rounds.settled(made))


def _ended(rounds: Rounds, made: Round, place: Place) -> Increment:
    """The step, its impulses written at ``place``."""
    state, scheme, coupling = rounds.state, rounds.scheme, rounds.coupling
    there = place.contact if place.bodies is made.bodies else coupling.placement(made.bodies)
    pressed = np.zeros_like(made.impulse)  # what Signorini and Coulomb hold for
    pressed[made.active] = made.problem.contact_part(made.solution.impulse, made.solution.velocity)
    friction = np.zeros(len(pressed))
    friction[made.active] = made.problem.friction
    after = SystemState(
        time=made.loading.end,
        index=state.index + 1,
        bodies=made.bodies,
        reaction=made.impulse / scheme.step,
        velocity=made.velocity,
        gap=there.gap,
        status=taut_sticks(rounds.model, contact_status(pressed, friction, made.impulse)),
        frame=there.frame,
        points=there.points,
        reaction_frame=place.contact.frame,
        jump=shifted_jump(state, scheme) + scheme.step * scheme.theta * made.velocity,
        joints=made.joints.committed(),
        rigid_velocity=made.solution.rigid_velocity,
        trend=None if scheme.inertia else _trend(rounds, made),
    )
    rigid_impulse = coupling.rigid_impulses(made.impulse, place.rigid_map)
    nodal = made.nodal
    if place is not made.place:
        nodal = coupling.nodal_impulses(made.impulse, place.contact)
    rounds.clock.lap("step")
    forces = rounds.at(made.loading, place).forces
    unsettled = rounds.worst(made) if _unbalanced(rounds, made) else None
    return Increment(
        state, after, made.problem, made.solution, made.active, made.impulse, forces, scheme,
        made.free, made.rigid, rigid_impulse, nodal, place.contact, place.rigid_map, made.change,
        restless=made.restless, residuals=made.residuals, unsettled=unsettled,
    )  # fmt: skip


def _trend(rounds: Rounds, made: Round) -> TrendState:
    """How a step of statics went on."""
    h = rounds.scheme.step
    parts = [group.velocity_parts(own) for group, own in zip(rounds.model.groups, made.bodies, strict=True)]
    growth = (made.impulse / h - rounds.state.reaction) / h
    return TrendState(growth, tuple(rigid for rigid, _ in parts), tuple(elastic for _, elastic in parts))
