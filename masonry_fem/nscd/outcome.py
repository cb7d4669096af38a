"""Outcome: how a solution ended; Solution: what it found.

Not converging is an answer, not an exception: the caller decides what to do with it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from masonry_fem.nscd.residuals import Quality
from masonry_fem.nscd.settings import ACCEPTABLE, SolverSettings

FloatArray = NDArray[np.float64]


class Outcome(Enum):
    """How a solution ended; each has a sentence for the user and advice."""

    CONVERGED = "converged"
    INEXACT = "inexact"
    STALLED = "stalled"
    MAX_ITERATIONS = "max_iterations"
    TIME_LIMIT = "time_limit"
    NO_EQUILIBRIUM = "no_equilibrium"
    AT_LIMIT = "at_limit"
    UNSTRESSED = "unstressed"
    UNDECIDED = "undecided"
    FAILED = "failed"

    @property
    def solved(self) -> bool:
        """True where the state is an answer."""
        return self is Outcome.CONVERGED or self is Outcome.INEXACT

    @property
    def moves(self) -> bool:
        """True where the velocities of a static problem show a mechanism."""
        return self is Outcome.NO_EQUILIBRIUM or self is Outcome.AT_LIMIT or self is Outcome.UNSTRESSED

    @property
    def late(self) -> bool:
        """True where there was no more time."""
        return self is Outcome.TIME_LIMIT

    @property
    def sentence(self) -> str:
        """What happened, in a sentence."""
        return _SENTENCES[self]

    def advice(self, settings: SolverSettings) -> str:
        """What to do next that was not done already ("" where there is nothing to do)."""
        return " ".join(_advice(self, settings))


_SENTENCES = {
    Outcome.CONVERGED: "All measures of the contact problem are within the tolerance.",
    Outcome.INEXACT: "The measures of the contact problem end above the tolerance; it came no nearer.",
    Outcome.STALLED: "The iteration no longer improves; the best state found is returned.",
    Outcome.MAX_ITERATIONS: "The iteration limit was reached before the tolerance.",
    Outcome.TIME_LIMIT: "The time limit was reached before the tolerance.",
    Outcome.NO_EQUILIBRIUM: "No impulses within the friction cones of contacts that close within the step"
    " balance the loads: a part slides, tips or falls.",
    Outcome.AT_LIMIT: "The loads are at the limit: with 0.1 % less friction no impulses balance them,"
    " and the blocks, as they deform, find no rest at any finite slip.",
    Outcome.UNSTRESSED: "Impulses within the friction cones balance the loads, but the loads alone do not"
    " lead to them: from a start without stress the blocks move away.",
    Outcome.UNDECIDED: "Impulses within the friction cones can balance the loads, but the solver found no"
    " state of sticking and sliding contacts that does.",
    Outcome.FAILED: "The numbers broke down (not finite, or a singular linear system).",
}


def _advice(outcome: Outcome, settings: SolverSettings) -> Iterator[str]:
    """Sentences on what may still be tried."""
    see = "Look at the rigid velocities: they show"
    if outcome is Outcome.NO_EQUILIBRIUM:
        yield f"{see} the mechanism. Add supports or friction, or run dynamics."
    elif outcome is Outcome.AT_LIMIT:
        yield f"{see} what is about to move. Lower a load, or raise friction."
    elif outcome is Outcome.UNSTRESSED:
        yield f"{see} the mechanism. Press the joints together, or support the blocks."
    elif outcome is Outcome.FAILED:
        yield "Check masses, stiffnesses and units; save the problem (run --save-contact) and report it."
    elif outcome is Outcome.TIME_LIMIT:
        yield f"Raise time_limit ({settings.time_limit} s), or use fewer contact points."
    elif not outcome.solved:
        yield from _more_effort(outcome, settings)


def _more_effort(outcome: Outcome, settings: SolverSettings) -> Iterator[str]:
    """What may bring a solution that ended too early nearer."""
    if settings.method != "auto":
        yield f"Try method 'auto', which goes on where '{settings.method}' ends."
    if outcome is Outcome.MAX_ITERATIONS and settings.max_iterations is not None:
        yield f"Raise max_iterations ({settings.max_iterations})."
    elif settings.method == "auto":
        yield (
            "Take shorter steps (more analysis.load_steps in statics, a smaller analysis.step in time), "
            "or march by a damped strategy."
        )
    if settings.acceptable == 0:
        yield f"Loosen the tolerance ({settings.tolerance:g}) where the error reached is small enough."


@dataclass(frozen=True, slots=True)
class Solution:
    """Solution of a contact problem of c contacts, with its accuracy.

    Attributes
    ----------
    impulse : p in the contact frames, component 0 normal [N s], shape (c, d).
    velocity : v, including the problem's gap term [m/s], shape (c, d).
    rigid_velocity : U of the rigid bodies, shape (b, m).
    outcome : How the iteration ended.
    quality : Error measures, computed from the problem and (p, U) alone.
    iterations : Number of sweeps or Newton steps.
    linear_solves : Number of linear systems solved.
    seconds : CPU time [s].
    method : Methods used, in order: "nsgs+newton" if it switched from one to the other.
    history : Iterations made, ``Quality.error`` and CPU seconds at each check, shape (k, 3).
    rounding : Size of each error measure that rounding alone may cause; None: not needed, as the tolerance
        was met.
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
    rounding: Quality | None = None

    @property
    def converged(self) -> bool:
        """True where all measures are within the tolerance."""
        return self.outcome is Outcome.CONVERGED

    @property
    def solved(self) -> bool:
        """True where this is an answer, within the tolerance or as near to it as anything comes."""
        return self.outcome.solved

    @property
    def rounded(self) -> bool:
        """True where the tolerance was missed by what rounding alone may make: nothing would come nearer."""
        if self.rounding is None or self.solved or self.outcome.moves:
            return False
        return self.quality.error <= min(ACCEPTABLE, self.rounding.error)
