"""Increments: the steps of a strategy one after another, divided where joints give way.

for coupling, made in increments(coupling, strategy, state, settings, clock, lookout, Headway()):
    coupling.model, made.after, made.adhesion_loss
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import islice
from typing import TYPE_CHECKING, Any

import numpy as np

from masonry_fem.bodies.base import Scheme
from masonry_fem.march.clock import Clock
from masonry_fem.march.coupling import Coupling, connect
from masonry_fem.march.encounter import meeting_step
from masonry_fem.march.lookout import Lookout
from masonry_fem.march.model import Model
from masonry_fem.march.renewal import renewed
from masonry_fem.march.state import SystemState
from masonry_fem.march.step import Increment
from masonry_fem.nscd import SolverSettings
from masonry_fem.nscd.settings import ACCEPTABLE
from masonry_fem.records.tree import contiguous

if TYPE_CHECKING:
    from masonry_fem.march.equilibrium import Strategy

# Of the largest impulses of a march: errors below the first are rounding, whatever is left of the
# impulses; and these count as never less than the second.
ROUNDING = 1e-12
LEAST_SHARE = 1e-2
# a contact that loses more adhesion than this in one step gave way between two known states
ABRUPT = 0.5
# into how many parts at most a step is divided that leads to where nothing balances
PIECES = 32


type _Part = tuple[Coupling, Increment, float]  # of a step, and the time at its end


@dataclass(slots=True)
class Headway:
    """How far the increments of a march have come.

    Attributes
    ----------
    done : Number of steps of the schedule that are made.
    largest : Norm of the largest impulses so far [N s].
    whole : Whether the last increment was the last part of its step.
    more : Whether the schedule has further steps.
    seams : Whether each step begins as one that goes on from a file: what the contact solver keeps from step
        to step, which decides on rounding, is left.
    """

    done: int = 0
    largest: float = 0.0
    whole: bool = True
    more: bool = True
    seams: bool = False


def increments(
    coupling: Coupling,
    strategy: Strategy,
    state: SystemState,
    settings: SolverSettings,
    clock: Clock,
    lookout: Lookout,
    headway: Headway,
) -> Iterator[tuple[Coupling, Increment]]:
    """Every step that ``strategy`` schedules from ``state`` on, each from where the last one ended.

    Each comes with the coupling that it was made with, since contacts may be found anew on the way.

    Parameters
    ----------
    coupling : Body groups at the contacts of the start.
    strategy : Which steps are made, and what of velocities is kept between them.
    state : Where the march begins.
    settings : Of the contact solver.
    clock : Gathers CPU times by phase.
    lookout : Finds blocks that meet.
    headway : Which steps are made already; told of each one.
    """
    share = min(ROUNDING / settings.tolerance, LEAST_SHARE)
    schedule = islice(strategy.schedule(), headway.done, None)
    following = next(schedule, None)
    while following is not None:
        (scheme, until), following = following, next(schedule, None)
        number, headway.more = headway.done, following is not None
        if scheme.inertia:
            coupling.structure.factored = False  # what made iterations fail in a step passes
        if headway.seams:
            coupling.structure.empty()
            state = contiguous(state)
        before, (coupling, state) = coupling, renewed(coupling, state, scheme, lookout)
        clock.lap("step" if coupling is before else "detect")
        measured = replace(settings, least_impulse=share * headway.largest)
        most = strategy.parts, PIECES
        parts = _parts(coupling, strategy, state, scheme, until, most, measured, clock, lookout)
        for met, made, end in parts:
            coupling = met
            if made.solution.solved:  # what was not solved may be any size
                headway.largest = max(headway.largest, float(np.linalg.norm(made.impulse)))
            state = rested(coupling.model, made.after, strategy.kept)
            headway.whole = end == until
            headway.done = number + headway.whole
            yield coupling, made


def _parts(
    coupling: Coupling,
    strategy: Strategy,
    state: SystemState,
    scheme: Scheme,
    until: float,
    parts: tuple[int, int],
    settings: SolverSettings,
    clock: Clock,
    lookout: Lookout,
) -> Iterator[_Part]:
    """A step as it is, or each half of it in turn where joints give way or nothing was found.

    Each comes with the time at its end.

    ``parts`` is into how many it may be divided for the joints' sake, and for that of blocks that turn.
    """
    coupling, state = _aged(coupling, state, until)
    # the shortest part alone, so that the load at which stones snap is known as well as any
    snaps = parts[1] == 1 and scheme.inertia == 0
    met, made = meeting_step(coupling, state, scheme, settings, until, clock, lookout, snaps=snaps)
    found = made.solution.solved and made.joint_change == 0
    doubtful = made.adhesion_loss > ABRUPT or not found
    divided = _halves(coupling, strategy, state, scheme, until, parts, settings, clock, lookout)
    if made.solution.outcome.late:  # so would each half be
        yield met, made, until
    elif doubtful and parts[0] > 1:
        yield from divided
    elif (made.strayed or _lost(met, made)) and made.joint_change == 0 and parts[1] > 1:
        yield from _decided((met, made, until), list(divided))
    else:
        yield met, made, until


def _decided(whole: _Part, halves: list[_Part]) -> list[_Part]:
    """The halves of a step, or the whole if it moves and they are too near to their limit for a verdict."""
    last = halves[-1][1].solution
    undecided = not (last.solved or last.outcome.moves)
    return [whole] if undecided and whole[1].solution.outcome.moves else halves


def _aged(coupling: Coupling, state: SystemState, until: float) -> tuple[Coupling, SystemState]:
    """The stones of the materials that they have at a time, strained as they are."""
    model = coupling.model
    aged = model if model.ageing is None else model.ageing(model, until)
    if aged is model:
        return coupling, state
    anew: tuple[Any, ...] = aged.groups
    bodies = tuple(
        own if new is old else new.strained_as(own)
        for new, old, own in zip(anew, model.groups, state.bodies, strict=True)
    )
    return connect(aged), replace(state, bodies=bodies)


def _lost(coupling: Coupling, made: Increment) -> bool:
    """Whether statics of blocks that deform was left far from solved: half a step begins nearer its end."""
    solution = made.solution
    found = solution.solved or solution.outcome.moves or solution.quality.error <= ACCEPTABLE
    return made.scheme.inertia == 0 and bool(coupling.soft.any()) and not found


def _halves(
    coupling: Coupling,
    strategy: Strategy,
    state: SystemState,
    scheme: Scheme,
    until: float,
    parts: tuple[int, int],
    settings: SolverSettings,
    clock: Clock,
    lookout: Lookout,
) -> Iterator[_Part]:
    """Both halves of a step, and their halves."""
    half, fewer = replace(scheme, step=0.5 * scheme.step), (parts[0] // 2, parts[1] // 2)
    for end in (until - half.step, until):
        for now, part, there in _parts(coupling, strategy, state, half, end, fewer, settings, clock, lookout):
            coupling = now
            yield now, part, there
            if scheme.inertia == 0 and not (part.solution.solved and part.unsettled is None):
                return  # statics ends there
            state = rested(now.model, part.after, strategy.kept)


def rested(model: Model, state: SystemState, factor: float) -> SystemState:
    """The state with velocities scaled between steps.

    Parameters
    ----------
    model : The structure. state : Where a step has led.
    factor : What velocities are multiplied by.
    """
    if factor == 1.0:
        return state
    bodies = tuple(
        group.scale_velocity(own, factor) for group, own in zip(model.groups, state.bodies, strict=True)
    )
    return replace(state, bodies=bodies, velocity=factor * state.velocity)
