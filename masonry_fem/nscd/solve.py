"""Solve: the one public way into the contact solver, and the choice of a method.

"auto" means Newton where blocks are elastic or static, or rigid and many. Other problems are swept first;
Newton takes over from the best sweep where the contraction seen would need too many of them.
Newton's failures go back to sweeps where there is inertia, and the best state of all is returned.
A verdict of no equilibrium stands only where no impulses at all can balance the loads.
"""

from __future__ import annotations

import time
from dataclasses import replace
from typing import Any

import numpy as np

from masonry_fem.errors import ProblemError
from masonry_fem.nscd.admissible import admissible_impulses
from masonry_fem.nscd.iterate import Iterate, Method, iterate
from masonry_fem.nscd.outcome import Outcome, Solution
from masonry_fem.nscd.problem import ContactProblem
from masonry_fem.nscd.residuals import Quality
from masonry_fem.nscd.settings import SolverSettings, Start
from masonry_fem.nscd.solvers import make_method
from masonry_fem.nscd.threads import one_thread

# Sweeps that may precede Newton: where more are foreseen after PATIENCE of them, it takes over.
# One Newton step costs as much as 500 to 1000 sweeps; rigid walls need more of either.
HORIZON = 5_000
HORIZON_OF_BODIES = 20_000
PATIENCE = 300
# Rigid contacts from which Newton goes first: warm steps of a wall end at once, cold ones in ten.
MANY = 500
# To a tolerance this loose, so many sweeps mend the last step's impulses of a wall, which Newton takes
# ten to a hundred steps for.
LOOSE = 1e-6
FEW = 300
# Newton steps on rigid blocks before sweeps have another try.
NEWTON_STEPS = 120
# Error of a swept state from which Newton may start: of a plain problem, of rigid blocks.
CLOSE = 1e-2
CLOSE_OF_BODIES = 1e-5
# Unbalanced part of the loads below which they can be carried.
BALANCED = 1e-5


def solve(
    problem: ContactProblem, settings: SolverSettings | None = None, start: Start | None = None
) -> Solution:
    """Impulses and velocities of a contact problem.

    Parameters
    ----------
    problem : What to solve.
    settings : How, and how well; default: "auto" to 1e-10.
    start : First guess; default: zero for sweeps, all contacts closed and sticking for Newton.

    Returns
    -------
    The best state found. Not converging is in its ``outcome``, never an exception.

    Raises
    ------
    ProblemError : A start of another shape, or sweeps asked for without inertia.
    """
    settings = SolverSettings() if settings is None else settings
    _check_start(problem, start)
    with one_thread():
        return _solve(problem, settings, start)


def _solve(problem: ContactProblem, settings: SolverSettings, start: Start | None) -> Solution:
    if problem.count == 0:
        return iterate(problem, _Free(), settings, start)
    if settings.method != "auto":
        return _judged(problem, iterate(problem, make_method(settings.method), settings, start))
    return _choose(problem, settings, start)


def _choose(problem: ContactProblem, settings: SolverSettings, start: Start | None) -> Solution:
    """Methods in turn until one converges; the best of their states."""
    began = time.monotonic()
    static = bool((problem.rigid_mass[np.unique(problem.bodies[problem.bodies >= 0])] <= 0).any())
    elastic = problem.body_count > 0 and not problem.rigid
    newton_first = elastic or (problem.body_count > 0 and problem.count >= MANY)
    turns = ["newton"] if static else ["newton", "nsgs"] if newton_first else ["brief nsgs", "newton", "nsgs"]
    warm = start is not None and start.impulse is not None
    if newton_first and not elastic and warm and settings.tolerance >= LOOSE:
        turns = ["few nsgs", *turns]
    total: Solution | None = None
    for turn in turns:
        method = _method_of(turn, problem)
        remaining = settings
        rigid = not (static or elastic) and problem.body_count > 0
        if turn == "newton" and rigid and settings.max_iterations is None:
            remaining = replace(settings, max_iterations=NEWTON_STEPS)
        if settings.time_limit is not None:
            left = settings.time_limit - (time.monotonic() - began)
            remaining = replace(remaining, time_limit=max(left, 1e-3))
        made = iterate(problem, method, remaining, start if total is None else _from(problem, total, turn))
        total = made if total is None else _joined(total, made)
        if total.outcome in {Outcome.CONVERGED, Outcome.NO_EQUILIBRIUM, Outcome.TIME_LIMIT}:
            break
    assert total is not None  # there is always a first turn
    return _judged(problem, total)


def _judged(problem: ContactProblem, made: Solution) -> Solution:
    """The solution, its verdict withdrawn where impulses that balance the loads exist after all."""
    if made.outcome is not Outcome.NO_EQUILIBRIUM or problem.count == 0:
        return made
    if admissible_impulses(problem).unbalanced > BALANCED:
        return made
    return replace(made, outcome=Outcome.UNDECIDED)


def _from(problem: ContactProblem, state: Solution, turn: str) -> Start | None:
    """Where the next turn starts: the best state, or cold where that misleads Newton.

    On walls of rigid blocks the bonded start needs a third to a half of the steps that a half-swept
    state does; on plain problems sweeps lead Newton to the right active set.
    """
    close = CLOSE_OF_BODIES if problem.body_count else CLOSE
    if turn == "newton" and state.quality.error > close:
        return None
    return Start(state.impulse, state.rigid_velocity)


def _method_of(turn: str, problem: ContactProblem) -> Method:
    if turn == "brief nsgs":
        return _brief_sweeps(problem)
    if turn == "few nsgs":
        from masonry_fem.nscd.solvers.gauss_seidel import GaussSeidel  # noqa: PLC0415 - Numba is slow to import

        return GaussSeidel(iterations=FEW)
    return make_method(turn)


def _brief_sweeps(problem: ContactProblem) -> Method:
    from masonry_fem.nscd.solvers.gauss_seidel import GaussSeidel  # noqa: PLC0415 - Numba is slow to import

    horizon = HORIZON_OF_BODIES if problem.body_count else HORIZON
    return GaussSeidel(iterations=horizon, patience=PATIENCE, horizon=horizon)


def _joined(first: Solution, second: Solution) -> Solution:
    """Two turns as one: the better state, the efforts of both."""
    effort = np.array([first.iterations, 0.0, first.seconds])
    counted: dict[str, Any] = {
        "iterations": first.iterations + second.iterations,
        "linear_solves": first.linear_solves + second.linear_solves,
        "seconds": first.seconds + second.seconds,
        "method": f"{first.method}+{second.method}",
        "history": np.concatenate([first.history, second.history + effort]),
    }
    if second.outcome is Outcome.NO_EQUILIBRIUM or second.quality.error <= first.quality.error:
        return replace(second, **counted)
    return replace(first, outcome=second.outcome, **counted)


def _check_start(problem: ContactProblem, start: Start | None) -> None:
    if start is None:
        return
    for name, expected in (
        ("impulse", problem.free_velocity.shape),
        ("rigid_velocity", problem.rigid_velocity.shape),
    ):
        values = getattr(start, name)
        if values is not None and values.shape != expected:
            raise ProblemError(f"start {name} has shape {values.shape}, expected {expected}")
        if values is not None and not np.isfinite(values).all():
            raise ProblemError(f"start {name} is not finite; start without it")


class _Free:
    """Bodies without contacts: they fly, or, without inertia, nothing holds them."""

    name = "free"
    iterations = 1

    def init(self, problem: ContactProblem, start: Start | None) -> _FreeRun:
        return _FreeRun(problem)


class _FreeRun:
    def __init__(self, problem: ContactProblem) -> None:
        self._problem = problem

    def guess(self) -> Iterate:
        problem = self._problem
        return Iterate(
            np.zeros_like(problem.free_velocity),
            problem.free_rigid_velocity(),
            iterations=0,
            verdict=Outcome.NO_EQUILIBRIUM,
        )

    def step(self, quality: Quality, settings: SolverSettings) -> Iterate:
        raise AssertionError("the first guess is the answer or there is none")
