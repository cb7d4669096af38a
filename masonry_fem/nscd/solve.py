"""Solve: the one public way into the contact solver, and the choice of a method."""

from __future__ import annotations

import numpy as np

from masonry_fem.errors import ProblemError
from masonry_fem.nscd.iterate import Iterate, iterate
from masonry_fem.nscd.outcome import Outcome, Solution
from masonry_fem.nscd.problem import ContactProblem
from masonry_fem.nscd.residuals import Quality
from masonry_fem.nscd.settings import SolverSettings, Start
from masonry_fem.nscd.solvers import make_method


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
    if problem.count == 0:
        return iterate(problem, _Free(), settings, start)
    if settings.method != "auto":
        return iterate(problem, make_method(settings.method), settings, start)
    return iterate(problem, make_method("newton" if _prefers_newton(problem) else "nsgs"), settings, start)


def _prefers_newton(problem: ContactProblem) -> bool:
    return bool(problem.body_count) and (not problem.rigid or bool((problem.rigid_mass <= 0).any()))


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
