"""Encounter: a step of blocks that meet in it is done again with the contacts that they make.

    coupling, made = meeting_step(coupling, state, scheme, settings, until, clock, lookout)

An active set of pairs: blocks that no contact pairs and that are in each other at the end of the step get
contacts with the gaps that they had at its start, until none are left.
"""

from __future__ import annotations

import logging

import numpy as np

from masonry_fem.bodies.base import Scheme
from masonry_fem.march.clock import Clock
from masonry_fem.march.coupling import Coupling, connect
from masonry_fem.march.expulsion import expelling_step
from masonry_fem.march.lookout import Lookout
from masonry_fem.march.renewal import carried
from masonry_fem.march.state import SystemState
from masonry_fem.march.step import Increment
from masonry_fem.nscd import SolverSettings

SHOWN = 3  # pairs of blocks that a message names

logger = logging.getLogger(__name__)


def meeting_step(
    coupling: Coupling,
    state: SystemState,
    scheme: Scheme,
    settings: SolverSettings,
    until: float,
    clock: Clock,
    lookout: Lookout,
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
    """
    made = expelling_step(coupling.model, coupling, state, scheme, settings, until, clock)
    lookout.look(made.after.bodies, static=scheme.inertia == 0)
    while made.solution.solved:
        model = coupling.model
        pairs = lookout.strangers(model, made.after)
        if model.meet is None or len(pairs) == 0:
            break
        found = model.meet(model, state.bodies, made.after.bodies, pairs)
        if found is model:
            lookout.dismiss(model, pairs)
            break
        _tell(coupling, pairs, until)
        coupling = connect(found)
        count = model.contacts.count
        old = np.concatenate([np.arange(count), np.full(found.contacts.count - count, -1)])
        state = carried(model, found, coupling, coupling.placement(state.bodies), state, old)
        clock.lap("detect")
        made = expelling_step(found, coupling, state, scheme, settings, until, clock)
        lookout.look(made.after.bodies, always=True)
    clock.lap("detect")
    return coupling, made


def _tell(coupling: Coupling, pairs: np.ndarray, until: float) -> None:
    blocks = coupling.model.assembly.blocks
    named = [f"'{blocks[a].name}' and '{blocks[b].name}'" for a, b in pairs[:SHOWN].tolist()]
    more = f" and {len(pairs) - SHOWN} more pairs" if len(pairs) > SHOWN else ""
    logger.info("%s%s meet at t = %.6g", ", ".join(named), more, until)
