"""Expulsion: steps that drive overlaps apart where there is a way, and hold them where there is none.

made = expelling_step(model, coupling, state, scheme, settings, until, clock)
"""

from __future__ import annotations

from dataclasses import replace

from masonry_fem.bodies.base import Scheme
from masonry_fem.march.clock import Clock
from masonry_fem.march.coupling import Coupling
from masonry_fem.march.model import Model
from masonry_fem.march.state import SystemState
from masonry_fem.march.step import Increment, step
from masonry_fem.nscd import SolverSettings


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
    jammed = made.solution.solved
    return replace(made, after=replace(made.after, held=held), jammed=jammed)
