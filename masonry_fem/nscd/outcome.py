"""Outcome: how a solution ended; Solution: what it found.

Not converging is an answer, not an exception: the caller decides what to do with it.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from masonry_fem.nscd.residuals import Quality

FloatArray = NDArray[np.float64]


class Outcome(Enum):
    """How a solution ended; each has a sentence for the user and advice."""

    CONVERGED = "converged"
    STALLED = "stalled"
    MAX_ITERATIONS = "max_iterations"
    TIME_LIMIT = "time_limit"
    NO_EQUILIBRIUM = "no_equilibrium"
    AT_LIMIT = "at_limit"
    UNSTRESSED = "unstressed"
    UNDECIDED = "undecided"
    FAILED = "failed"

    @property
    def moves(self) -> bool:
        """True where the velocities of a static problem show a mechanism."""
        return self in {Outcome.NO_EQUILIBRIUM, Outcome.AT_LIMIT, Outcome.UNSTRESSED}

    @property
    def sentence(self) -> str:
        """What happened, in a sentence."""
        return _TEXTS[self][0]

    @property
    def advice(self) -> str:
        """What to do next ("" where there is nothing to do)."""
        return _TEXTS[self][1]


_TEXTS = {
    Outcome.CONVERGED: ("All measures of the contact problem are within the tolerance.", ""),
    Outcome.STALLED: (
        "The iteration no longer improves; the best state found is returned.",
        "Compare the error reached with what you need; set the tolerance above it, or try method 'auto' or "
        "one that has not run.",
    ),
    Outcome.MAX_ITERATIONS: (
        "The iteration limit was reached before the tolerance.",
        "Raise max_iterations, loosen the tolerance, or try method 'auto' or one that has not run.",
    ),
    Outcome.TIME_LIMIT: (
        "The time limit was reached before the tolerance.",
        "Raise time_limit, loosen the tolerance, or use fewer contact points.",
    ),
    Outcome.NO_EQUILIBRIUM: (
        "No impulses within the friction cones balance the loads: a part slides, tips or falls.",
        "Look at the rigid velocities: they show the mechanism. Add supports or friction, or run dynamics.",
    ),
    Outcome.AT_LIMIT: (
        "The loads can just be carried: with 0.1 % less friction no impulses balance them, and the blocks, "
        "as they deform, find no rest at any finite slip.",
        "Look at the rigid velocities: they show what is about to move. Lower a load, or raise friction.",
    ),
    Outcome.UNSTRESSED: (
        "Impulses within the friction cones balance the loads, but nothing that the loads do brings them "
        "about: from a start without stress the blocks run off.",
        "Look at the rigid velocities: they show the mechanism. Press the joints together, or support the "
        "blocks.",
    ),
    Outcome.UNDECIDED: (
        "Impulses within the friction cones can balance the loads, yet no state of sticking and sliding that "
        "does was found.",
        "Apply the loads in more steps (analysis.load_steps), or march by a damped strategy.",
    ),
    Outcome.FAILED: (
        "The numbers broke down (not finite, or a singular linear system).",
        "Check masses, stiffnesses and units; save the problem (run --save-contact) and report it.",
    ),
}


@dataclass(frozen=True, slots=True)
class Solution:
    """Answer to a contact problem of c contacts, with its accuracy.

    Attributes
    ----------
    impulse : p in the contact frames, component 0 normal [N s], shape (c, d).
    velocity : v, with the problem's gap term [m/s], shape (c, d).
    rigid_velocity : U of the rigid bodies, shape (b, m).
    outcome : How the iteration ended.
    quality : Error measures, made from the problem and (p, U) alone.
    iterations : Sweeps or Newton steps. linear_solves : Factorised linear systems.
    seconds : CPU time [s].
    method : Name of the method that ended it ("nsgs+newton" where it was switched).
    history : Iterations made, ``Quality.error`` and CPU seconds at each test, shape (k, 3).
    """

    impulse: FloatArray
    velocity: FloatArray
    rigid_velocity: FloatArray
    outcome: Outcome
    quality: Quality
    iterations: int
    linear_solves: int
    seconds: float
    method: str
    history: FloatArray

    @property
    def converged(self) -> bool:
        """True where all measures are within the tolerance."""
        return self.outcome is Outcome.CONVERGED
