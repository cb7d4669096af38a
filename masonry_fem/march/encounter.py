"""Encounter: a step of blocks that meet in it is done again with the contacts that they make.

    coupling, made = meeting_step(coupling, state, scheme, settings, until, clock, lookout)

An active set of pairs: blocks that no contact keeps apart and that are in each other at the end of the step
get contacts with the gaps that they had at its start, until none are left. They take the place of those that
the pair had: a contact is of one corner and one face, and where blocks slide and tilt others bear. Overlaps
are driven apart where there is a way, and held where there is none.
"""

from __future__ import annotations

import logging
from dataclasses import replace

import numpy as np

from masonry_fem.bodies.base import Scheme
from masonry_fem.march.clock import Clock
from masonry_fem.march.coupling import Coupling, connect
from masonry_fem.march.lookout import Lookout
from masonry_fem.march.model import Model
from masonry_fem.march.renewal import carried, continued
from masonry_fem.march.state import SystemState
from masonry_fem.march.step import Increment, step
from masonry_fem.nscd import SolverSettings
from masonry_fem.records.remark import first_few

SHOWN = 3  # pairs of blocks that a message names

logger = logging.getLogger(__name__)


def expelling_step(
    model: Model,
    coupling: Coupling,
    state: SystemState,
    scheme: Scheme,
    settings: SolverSettings,
    until: float,
    clock: Clock,
    *,
    snaps: bool = False,
) -> Increment:
    """A ``step``; where driving overlaps apart leaves no solution, the same step with overlaps held.

    Rigid blocks between others have no way out of them. The solver needs all its work to find that out, so
    expulsion is tried again only after 1, 2, 4, ... further steps.

    Parameters
    ----------
    model : The structure.
    coupling : Its body groups at their contacts.
    state : Where the step begins.
    scheme : Length and weights of the step.
    settings : Of the contact solver.
    until : Time at the end of the step [s]; the load factor in statics.
    clock : Gathers CPU times by phase.
    snaps : Whether stones that soften may snap to a balance further away.
    """
    wait, span = state.held
    if model.expulsion <= 0 or wait == 0:
        made = step(model, coupling, state, scheme, settings, until, clock, snaps=snaps)
        overlaps = model.expulsion > 0 and bool((made.here.gap < 0).any())
        if made.solution.solved or not overlaps:
            return made
    held_model = replace(model, expulsion=0.0)
    made = step(held_model, coupling, state, scheme, settings, until, clock, snaps=snaps)
    held = (wait - 1, span) if wait > 0 else (max(1, 2 * span), max(1, 2 * span))
    jammed = made.solution.solved and bool((made.here.gap < 0).any())
    return replace(made, after=replace(made.after, held=held), jammed=jammed)


def meeting_step(
    coupling: Coupling,
    state: SystemState,
    scheme: Scheme,
    settings: SolverSettings,
    until: float,
    clock: Clock,
    lookout: Lookout,
    *,
    snaps: bool = False,
) -> tuple[Coupling, Increment]:
    """A step with the contacts of all blocks that meet in it, and the coupling that has these contacts.

    Parameters
    ----------
    coupling : Body groups at the contacts that are known.
    state : Where the step begins.
    scheme : Length and weights of the step.
    settings : Of the contact solver.
    until : Time at the end of the step [s]; the load factor in statics.
    clock : Gathers CPU times by phase.
    lookout : Finds blocks that are in each other without a contact.
    snaps : Whether stones that soften may snap to a balance further away.
    """
    made = expelling_step(coupling.model, coupling, state, scheme, settings, until, clock, snaps=snaps)
    lookout.look(made.after.bodies, static=scheme.inertia == 0)
    met = np.zeros(0, dtype=np.int64)
    while made.solution.solved:
        model = coupling.model
        pairs = lookout.strangers(model, made.after)
        fresh = pairs[~np.isin(lookout.keys(pairs), met)]
        if model.meet is None or len(fresh) == 0:
            lookout.bear(pairs)
            break
        met = np.concatenate([met, lookout.keys(fresh)])
        found, kept = model.meet(model, state.bodies, made.after.bodies, fresh, ~state.joints.broken)
        if found is model:
            continue
        _tell(coupling, fresh, until)
        coupling = connect(found)
        here = coupling.placement(state.bodies)
        old = continued(model, state, found, here, kept)
        state = carried(model, found, coupling, here, state, old)
        clock.lap("detect")
        made = expelling_step(found, coupling, state, scheme, settings, until, clock, snaps=snaps)
        lookout.look(made.after.bodies, always=True)
    clock.lap("detect")
    return coupling, made


def _tell(coupling: Coupling, pairs: np.ndarray, until: float) -> None:
    blocks = coupling.model.assembly.blocks
    named = [f"'{blocks[a].name}' and '{blocks[b].name}'" for a, b in pairs.tolist()]
    logger.info("%s meet at t = %.6g", first_few(named, SHOWN, noun="pairs"), until)
