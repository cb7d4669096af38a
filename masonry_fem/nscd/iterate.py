"""The loop of all solvers, written once: assess, keep the best, stop for one of the known reasons.

A *method* is its settings; a *run* is its working memory on one problem. The loop owns the
stopping: only ``assess`` says that a problem is solved. No method ever sees the constant part of
cohesion (``cohesion``).

    class Sweeping:                                   # a Method
        name = "sweeping"; iterations = 1000
        def init(self, problem, start): return SweepingRun(...)

    class SweepingRun:                                # a Run
        def guess(self): return Iterate(p, U, iterations=0)
        def step(self, quality, settings): return Iterate(p, U)
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from masonry_fem.errors import ExtensionError
from masonry_fem.host.phases import At, listener, phase
from masonry_fem.nscd.cohesion import shifted_start, without_offset
from masonry_fem.nscd.outcome import Outcome, Solution
from masonry_fem.nscd.problem import ContactProblem, Products
from masonry_fem.nscd.residuals import Quality, assess
from masonry_fem.nscd.scaling import contact_scale
from masonry_fem.nscd.settings import SolverSettings, Start

FloatArray = NDArray[np.float64]

HUGE = 1e100  # squares of larger numbers soon overflow


@dataclass(frozen=True, slots=True)
class Iterate:
    """What a step of a method offers; the arrays may be reused by the next step.

    Attributes
    ----------
    impulse, rigid_velocity : p (c, d) and U (b, m).
    iterations : Sweeps or Newton steps made since the last offer.
    linear_solves : Linear systems factorised since the last offer.
    verdict : Why the method cannot go on (STALLED, NO_EQUILIBRIUM, FAILED); None: it can.
    products : Of what the method has multiplied last, if it tells them.
    """

    impulse: FloatArray
    rigid_velocity: FloatArray
    iterations: int = 1
    linear_solves: int = 0
    verdict: Outcome | None = None
    products: Products | None = None


class Run(Protocol):
    """A method at work on one problem."""

    def guess(self) -> Iterate:
        """Where it starts."""
        ...

    def step(self, quality: Quality, settings: SolverSettings) -> Iterate:
        """The next offer; ``quality`` is that of the last one."""
        ...


class Method(Protocol):
    """A global solver: its name, its settings."""

    @property
    def name(self) -> str:
        """Its name in settings and reports."""
        ...

    @property
    def iterations(self) -> int:
        """Its own iteration limit."""
        ...

    def init(self, problem: ContactProblem, start: Start | None) -> Run:
        """A run on a problem, from a first guess."""
        ...


@dataclass(slots=True)
class _Best:
    """The best iterate so far."""

    error: float = np.inf
    impulse: FloatArray = field(default_factory=lambda: np.zeros((0, 0)))
    rigid_velocity: FloatArray = field(default_factory=lambda: np.zeros((0, 0)))
    quality: Quality | None = None

    def offer(self, iterate: Iterate, quality: Quality) -> None:
        if self.quality is None or quality.error < self.error:
            self.error, self.quality = quality.error, quality
            self.impulse, self.rigid_velocity = iterate.impulse.copy(), iterate.rigid_velocity.copy()


def _checked(run: Run) -> Run:
    """The run, unless it is none.

    Raises
    ------
    ExtensionError : It lacks what a run owes.
    """
    for owed in ("guess()", "step(quality, settings)"):
        if not callable(getattr(run, owed.partition("(")[0], None)):
            raise ExtensionError(
                f"{type(run).__module__}: {type(run).__name__}, which init makes, lacks {owed}; write it as "
                "masonry_fem.nscd.iterate.Run has it"
            )
    return run


def iterate(
    problem: ContactProblem, method: Method, settings: SolverSettings, start: Start | None = None
) -> Solution:
    """Run a method until the measures hold, or until it cannot or may not go on.

    Parameters
    ----------
    problem : What to solve.
    method : Who offers states.
    settings : How well, and within which limits.
    start : First guess; the method has one of its own.

    Returns
    -------
    The best state that was offered, and why it ended. A mechanism is shown by the last state instead.
    """
    with phase(f"contact problem by {method.name.replace('_', ' ')}", 1.0) as at:
        return _iterated(problem, method, settings, start, at)


def _iterated(
    problem: ContactProblem, method: Method, settings: SolverSettings, start: Start | None, at: At
) -> Solution:
    """The same; ``at`` is told how far it is."""
    cpu, wall = time.process_time(), time.monotonic()
    limit = method.iterations if settings.max_iterations is None else settings.max_iterations
    scale = contact_scale(problem)
    run, known = _begun(problem, method, settings, start, scale)
    best, history = _Best(), []
    made = solves = 0
    offer, outcome = run.guess(), None
    while True:
        made, solves = made + offer.iterations, solves + offer.linear_solves
        if best.quality is not None and _blown_up(offer):
            outcome = Outcome.FAILED
            break
        quality = known or assess(
            problem, offer.impulse, offer.rigid_velocity, scale, settings.least_impulse, offer.products
        )
        known = None
        best.offer(offer, quality)
        history.append((made, quality.error, time.process_time() - cpu))
        _tell(at, made, history[0][1], best.error, settings.tolerance)
        outcome = _ended(quality, offer, settings, made, limit, time.monotonic() - wall)
        if outcome is not None:
            break
        offer = run.step(quality, settings)
    # a mechanism is shown by the last velocities, not by those that balance best
    chosen = offer if outcome is Outcome.NO_EQUILIBRIUM else None
    impulse = best.impulse if chosen is None else chosen.impulse.copy()
    rigid_velocity = best.rigid_velocity if chosen is None else chosen.rigid_velocity.copy()
    assert best.quality is not None  # offered at least once
    return Solution(
        impulse=impulse,
        velocity=_velocity(problem, offer, impulse, rigid_velocity),
        rigid_velocity=rigid_velocity,
        outcome=outcome,
        quality=best.quality if chosen is None else quality,
        iterations=made,
        linear_solves=solves,
        seconds=time.process_time() - cpu,
        method=method.name,
        history=np.array(history, dtype=float).reshape(-1, 3),
    )


def _velocity(
    problem: ContactProblem, offer: Iterate, impulse: FloatArray, rigid_velocity: FloatArray
) -> FloatArray:
    """V of the chosen state, mostly the one that was offered last, shape (c, d)."""
    known = offer.products
    if known is not None and known.are_of(impulse, rigid_velocity):
        return known.velocity
    return problem.velocity(impulse, rigid_velocity)


def _tell(at: At, made: int, first: float, error: float, wanted: float) -> None:
    """Tell who listens how much of the way to the wanted error is gone, by orders of magnitude."""
    if listener() is None:
        return
    known = 0 < wanted < error < first < np.inf
    way = float(np.log(first / error) / np.log(first / wanted)) if known else 0.0
    at(way, f"{made} iterations, error {error:.0e}")


def _begun(
    problem: ContactProblem, method: Method, settings: SolverSettings, start: Start | None, scale: FloatArray
) -> tuple[Run, Quality | None]:
    """A run of the method; or of a guess that is a solution already, and its quality."""
    if start is not None and start.impulse is not None:
        velocity = start.rigid_velocity
        if velocity is None:
            velocity = problem.balanced_velocity(start.impulse)
        start = replace(start, products=problem.products(start.impulse, velocity))
    kept = _kept(problem, settings, start, scale)
    if kept is not None:
        return OneOffer(kept[0]), kept[1]
    run = _checked(method.init(without_offset(problem), shifted_start(problem, start)))
    return (run if problem.cohesion_offset is None else _Unshifted(run, problem.cohesion_offset)), None


def _kept(
    problem: ContactProblem, settings: SolverSettings, start: Start | None, scale: FloatArray
) -> tuple[Iterate, Quality] | None:
    """A guess that is a solution, and its quality: it is kept whatever a method would make of it.

    Sweeps would project its impulses and make the velocities of bodies anew from them: where blocks are
    elastic that blows up a rounding by the ratio of rigid to elastic velocities, 10⁶ and more.
    """
    for guess in _guesses(problem, start):
        quality = assess(
            problem, guess.impulse, guess.rigid_velocity, scale, settings.least_impulse, guess.products
        )
        if quality.error <= settings.tolerance:
            return guess, quality
    return None


def _guesses(problem: ContactProblem, start: Start | None) -> Iterator[Iterate]:
    """What may be the solution already: the first guess as it was given, and flight without impulses.

    No method comes to zero impulses exactly, and errors are relative to them.
    """
    known = None if start is None else start.products
    if known is not None:
        yield Iterate(known.impulse, known.rigid_velocity, iterations=0, products=known)
    if (problem.rigid_mass > 0).all():
        yield Iterate(np.zeros_like(problem.free_velocity), problem.free_rigid_velocity(), iterations=0)


@dataclass(frozen=True, slots=True)
class OneOffer:
    """A run that ends with its guess: a solution already, or one with a verdict."""

    offer: Iterate

    def guess(self) -> Iterate:
        """All that it has."""
        return self.offer

    def step(self, quality: Quality, settings: SolverSettings) -> Iterate:
        """Never called."""
        raise AssertionError("the first offer is the answer or there is none")


class _Unshifted:
    """A run on the problem without the constant part of cohesion, its impulses put back."""

    def __init__(self, run: Run, offset: FloatArray) -> None:
        self._run, self._offset = run, offset

    def guess(self) -> Iterate:
        return self._put_back(self._run.guess())

    def step(self, quality: Quality, settings: SolverSettings) -> Iterate:
        return self._put_back(self._run.step(quality, settings))

    def _put_back(self, offer: Iterate) -> Iterate:
        return replace(offer, impulse=offer.impulse - self._offset)


def _blown_up(offer: Iterate) -> bool:
    """True where an offer is not finite, or soon will not be."""
    return not all(np.abs(part).max(initial=0.0) <= HUGE for part in (offer.impulse, offer.rigid_velocity))


def _ended(
    quality: Quality, offer: Iterate, settings: SolverSettings, made: int, limit: int, wall: float
) -> Outcome | None:
    if quality.error <= settings.tolerance:
        return Outcome.CONVERGED
    if offer.verdict is not None:
        return offer.verdict
    if made >= limit:
        return Outcome.MAX_ITERATIONS
    if settings.time_limit is not None and wall >= settings.time_limit:
        return Outcome.TIME_LIMIT
    return None
