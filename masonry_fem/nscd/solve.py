"""Solve: the one public way into the contact solver, and the choice of a method.

"auto" takes *turns*: methods one after another, each from the best state so far, until one converges.

- Static problems and elastic blocks: a few Newton steps, which is all that most need; where nothing
  can balance the loads, as many as show what moves; else as for many rigid blocks.
- Many rigid blocks: the interior-point method, which nothing stops but rounding, and Newton to polish
  its result. It cannot start from the step before: there a few Newton steps from the bonded state come
  first, which is all that sticking walls need.
- What is left goes to pivoting, where the problem is plane and small, and to ADMM, which is slow but
  does not depend on a good guess of the active set.
- Other problems are swept first, as long as the contraction seen promises an end.

A verdict of no equilibrium stands only where no impulses at all can balance the loads.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from masonry_fem.errors import ProblemError
from masonry_fem.nscd.admissible import admissible_impulses
from masonry_fem.nscd.graphs import project_cone
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
# Rigid contacts from which Newton goes first.
MANY = 500
# To a tolerance this loose, so many sweeps mend the last step's impulses of a wall, which Newton takes
# ten to a hundred steps for.
LOOSE = 1e-6
FEW = 300
# Newton steps in which a wall of rigid blocks shows whether it sticks: then they are enough.
BRIEF = 10
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


@dataclass(frozen=True, slots=True)
class _Turn:
    """A method's turn: how it is made, its iterations, and what it starts from.

    ``origin`` is "given" (the caller's first guess), "best" (the best state so far, projected on the
    cones), "close" (the best state where that is close to a solution, else nothing) or "cold".
    """

    make: Callable[[], Method]
    iterations: int | None = None
    origin: Literal["given", "best", "close", "cold"] = "given"


def _turns(problem: ContactProblem, settings: SolverSettings, start: Start | None) -> Iterator[_Turn]:
    """Who has a go at a problem, in order; what a turn needs is found out only when it comes."""
    touched = np.unique(problem.bodies[problem.bodies >= 0])
    static = bool((problem.rigid_mass[touched] <= 0).any())
    if static:
        yield _Turn(_newton, BRIEF)
        if admissible_impulses(problem).unbalanced > BALANCED:
            yield _Turn(_newton)  # shows what moves
            return
        yield from _thorough(problem)
    elif problem.body_count and not problem.rigid:
        yield _Turn(_newton, BRIEF)
        yield from _thorough(problem)
        yield _Turn(_sweeps, origin="best")
    elif not problem.body_count:
        yield _Turn(_brief_sweeps(HORIZON))
        yield _Turn(_newton, origin="close")
        yield from _exact(problem)
        yield _Turn(_sweeps, origin="best")
    elif problem.count < MANY:
        yield _Turn(_brief_sweeps(HORIZON_OF_BODIES))
        yield _Turn(_newton, NEWTON_STEPS, "close")
        yield from _thorough(problem)
    else:
        if start is not None and start.impulse is not None:
            if settings.tolerance >= LOOSE:
                yield _Turn(_few_sweeps)
            yield _Turn(_newton, BRIEF)
        yield from _thorough(problem)


def _thorough(problem: ContactProblem) -> Iterator[_Turn]:
    """What carries where joints slide and open: interior point, its polish, and two that go elsewhere."""
    yield _Turn(_interior_point, origin="cold")
    yield _Turn(_polish, NEWTON_STEPS, origin="best")
    yield from _exact(problem)
    yield _Turn(_splitting, origin="best")


def _exact(problem: ContactProblem) -> Iterator[_Turn]:
    """Pivoting, where the problem is plane and small enough."""
    from masonry_fem.nscd.solvers.pivoting import MOST_CONTACTS  # noqa: PLC0415

    if problem.dimension == 2 and problem.count <= MOST_CONTACTS:
        yield _Turn(lambda: make_method("pivoting"), origin="cold")


def _choose(problem: ContactProblem, settings: SolverSettings, start: Start | None) -> Solution:
    """Turns until one converges; the best of their states."""
    began = time.monotonic()
    total: Solution | None = None
    for turn in _turns(problem, settings, start):
        own = settings
        if settings.max_iterations is None:
            own = replace(own, max_iterations=turn.iterations)
        if settings.time_limit is not None:
            left = settings.time_limit - (time.monotonic() - began)
            own = replace(own, time_limit=max(left, 1e-3))
        made = _judged(problem, iterate(problem, turn.make(), own, _origin(turn, problem, total, start)))
        total = made if total is None else _joined(total, made)
        if total.outcome in {Outcome.CONVERGED, Outcome.NO_EQUILIBRIUM, Outcome.TIME_LIMIT}:
            break
    assert total is not None  # there is always a first turn
    return total


def _origin(
    turn: _Turn, problem: ContactProblem, state: Solution | None, start: Start | None
) -> Start | None:
    """Where a turn starts.

    On walls of rigid blocks the bonded start needs a third to a half of the steps that a half-swept
    state does; on plain problems sweeps lead Newton to the right active set.
    """
    if turn.origin == "cold":
        return None
    if state is None or turn.origin == "given":
        return start
    close = CLOSE_OF_BODIES if problem.body_count else CLOSE
    if turn.origin == "close" and state.quality.error > close:
        return None
    return Start(project_cone(state.impulse, problem.friction), state.rigid_velocity)


def _judged(problem: ContactProblem, made: Solution) -> Solution:
    """The solution, its verdict withdrawn where impulses that balance the loads exist after all."""
    if made.outcome is not Outcome.NO_EQUILIBRIUM or problem.count == 0:
        return made
    if admissible_impulses(problem).unbalanced > BALANCED:
        return made
    return replace(made, outcome=Outcome.UNDECIDED)


def _newton() -> Method:
    return make_method("newton")


def _polish() -> Method:
    from masonry_fem.nscd.solvers.newton import ProximalNewton  # noqa: PLC0415

    # statuses are nearly right: little regularisation, and no patience with any round
    return ProximalNewton(weight=1e-4, accuracy=0.9, patience=12)


def _interior_point() -> Method:
    return make_method("interior_point")


def _splitting() -> Method:
    return make_method("admm")


def _sweeps() -> Method:
    return make_method("nsgs")


def _few_sweeps() -> Method:
    from masonry_fem.nscd.solvers.gauss_seidel import GaussSeidel  # noqa: PLC0415 - Numba is slow to import

    return GaussSeidel(iterations=FEW)


def _brief_sweeps(horizon: int) -> Callable[[], Method]:
    def make() -> Method:
        from masonry_fem.nscd.solvers.gauss_seidel import GaussSeidel  # noqa: PLC0415 - Numba is slow to import

        return GaussSeidel(iterations=horizon, patience=PATIENCE, horizon=horizon)

    return make


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
    if first.outcome is Outcome.UNDECIDED:
        return replace(first, **counted)
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
