"""Portfolio: the one public way into the contact solver, and the choice of a method.

"auto" takes turns (``turns``): methods one after another, each from the best state so far, until one
converges. Only a proof ends the turns early or makes a verdict of no equilibrium: that no impulses can
balance the loads, be it at all contacts, or at those that are closed or close within the step. A state that
none of the turns improves, and that is near enough, is an answer of the accuracy it has.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from masonry_fem.errors import ProblemError
from masonry_fem.nscd.admissible import Admissible, admissible_impulses, falling, weakened
from masonry_fem.nscd.cohesion import onto_cones
from masonry_fem.nscd.iterate import Iterate, Method, OneOffer, iterate
from masonry_fem.nscd.methods import make_method
from masonry_fem.nscd.methods.newton import ProximalNewton
from masonry_fem.nscd.outcome import Outcome, Solution
from masonry_fem.nscd.plane import InPlane
from masonry_fem.nscd.problem import ContactProblem
from masonry_fem.nscd.residuals import Quality, assess, rounding
from masonry_fem.nscd.rest import brought_to_rest, holding_impulses
from masonry_fem.nscd.settings import ACCEPTABLE, TARGET, SolverSettings, Start
from masonry_fem.nscd.solvers.chord import continued, taken_on
from masonry_fem.nscd.threads import one_thread
from masonry_fem.nscd.turns import Case, Turn, turns
from masonry_fem.nscd.unstressed import from_no_stress

FloatArray = NDArray[np.float64]

# Of the loads: where a mechanism proves that more is missing, a state that no method improves is no answer,
# however near it seems. The proof is exact; which state came nearest depends on how the arithmetic rounds.
MISSING = 1e-7
CLOSER_ITERATIONS = 200
# What ends the turns.
_ENDED = {
    Outcome.CONVERGED,
    Outcome.INEXACT,
    Outcome.TIME_LIMIT,
    Outcome.NO_EQUILIBRIUM,
    Outcome.AT_LIMIT,
}
# Share of what pushes contacts together that they may be in each other by.
FOLLOWED = 1e-2
# With the default tolerance solutions are made better than asked for: Newton's method with such an α and goal
# goes on from what the interior point found.
SHARP = 1e-14
SHARP_STEPS = 6


def solve(
    problem: ContactProblem, settings: SolverSettings | None = None, start: Start | None = None
) -> Solution:
    """Solve a contact problem for its impulses and velocities.

    Parameters
    ----------
    problem : What to solve.
    settings : Method and tolerance; None: method "auto", tolerance 1e-10.
    start : First guess; None: zero for the sweeps of "nsgs", all contacts closed and sticking for Newton.

    Returns
    -------
    The best solution found. Whether it converged is said by its ``outcome``, never by an exception.

    Raises
    ------
    ProblemError : ``start`` has the wrong shape, or "nsgs" is asked for without inertia.
    """
    settings = SolverSettings() if settings is None else settings
    _check_start(problem, start)
    with one_thread():
        made = _solve(problem, settings, start)
        if made.converged and settings.tolerance <= TARGET:
            made = taken_on(problem, _sharpened(problem, made, settings), settings)
        if made.solved:
            made = brought_to_rest(problem, made, settings)
        return made if made.converged else replace(made, rounding=_rounding(problem, made, settings))


def _solve(problem: ContactProblem, settings: SolverSettings, start: Start | None) -> Solution:
    if problem.count == 0:
        return iterate(problem, _Free(), settings, start)
    start = continued(problem, start, settings)

    @cache
    def loads() -> Admissible:
        return admissible_impulses(problem)

    if settings.method != "auto":
        method = _with_linear(make_method(settings.method), settings)
        made = _judged(iterate(problem, method, settings, start), loads)
        return _near_enough(problem, made, settings) if made.outcome is Outcome.STALLED else made
    made = _choose(problem, settings, start, loads)
    return made if made.outcome in _ENDED else _without_end(problem, settings, made, loads)


def _sharpened(problem: ContactProblem, made: Solution, settings: SolverSettings) -> Solution:
    """The interior point's state after a few Newton steps with hardly any proximal weight, if that is better.

    Impulses that go round and hardly move anything are what a tolerance says least of; all statuses are
    settled, so that no more than linear equations are left of the problem.
    """
    elastic = problem.body_count > 0 and problem.operator.elastic().all()
    if not made.method.endswith("+interior_point") or not elastic:
        return made
    own = replace(settings, tolerance=SHARP, max_iterations=SHARP_STEPS)
    start = Start(made.impulse, made.rigid_velocity, made.velocity)
    sharp = iterate(problem, _with_linear(ProximalNewton(weight=SHARP), settings), own, start)
    solves = made.linear_solves + sharp.linear_solves
    if sharp.quality.error >= made.quality.error:
        return replace(made, linear_solves=solves)
    return replace(
        made,
        impulse=sharp.impulse,
        velocity=sharp.velocity,
        rigid_velocity=sharp.rigid_velocity,
        quality=sharp.quality,
        linear_solves=solves,
    )


def _without_end(
    problem: ContactProblem, settings: SolverSettings, made: Solution, loads: Callable[[], Admissible]
) -> Solution:
    """What can be said where the turns are used up."""
    static = bool((problem.rigid_mass <= 0).any())
    if static and loads().falls:
        motion = loads().motion
        return made if motion is None else _proven(problem, settings, made, motion)
    if _limited(made, settings):
        return made
    made = _near_enough(problem, made, settings)
    if not static or _rounded(problem, made, settings):
        return made
    motion = None if made.solved else falling(problem, made.impulse)
    if motion is not None:
        return _proven(problem, settings, made, motion)
    limited = _at_limit(problem, settings, made)
    if limited is not None:
        return limited
    return made if made.solved else _without_proof(problem, settings, made, loads)


def _at_limit(problem: ContactProblem, settings: SolverSettings, made: Solution) -> Solution | None:
    """The verdict of a proof that friction fails to hold static bodies, however near a state came; else None.

    What moves is told as for a little less friction: next to a limit many motions are possible. Where that
    holds, too, it is no limit of friction, and as little as is missing may be the rounding of coordinates.
    """
    if admissible_impulses(problem, MISSING, CLOSER_ITERATIONS).motion is None:
        return None
    slipping = weakened(problem).motion
    return None if slipping is None else _proven(problem, settings, made, slipping, Outcome.AT_LIMIT)


def _without_proof(
    problem: ContactProblem, settings: SolverSettings, made: Solution, loads: Callable[[], Admissible]
) -> Solution:
    """What can be said of static bodies that no turn has found a state of, and nothing proves to move."""
    if not loads().stands:
        return made
    made = replace(made, outcome=Outcome.UNDECIDED)
    return made if problem.rigid or problem.cohesive else _unstressed(problem, settings, made)


def _limited(made: Solution, settings: SolverSettings) -> bool:
    """True where it was the user's limit that ended the turns."""
    return settings.max_iterations is not None and made.iterations >= settings.max_iterations


def _near_enough(problem: ContactProblem, made: Solution, settings: SolverSettings) -> Solution:
    """A state that nothing improves, as an answer where its error is acceptable and contacts follow.

    Where supports close in on rigid blocks that have no way out, no state follows them, and the impulses that
    stand for it mean nothing; beside the speed of free fall that may be an error of 1e-7.
    """
    firm = problem.operator.diagonal()[:, 0, 0] == 0  # nothing gives way there
    pushed = float(np.maximum(-problem.free_velocity[firm, 0], 0.0).max(initial=0.0))
    bounds = _rounding(problem, made, settings)
    follows = pushed <= bounds.max_penetration or made.quality.max_penetration <= FOLLOWED * pushed
    # a tolerance that was set is held to; but of rigid blocks there is no other model that rounds less
    near = made.quality.error <= settings.acceptable or (problem.rigid and _rounded(problem, made, settings))
    return replace(made, outcome=Outcome.INEXACT if near and follows else Outcome.STALLED)


def _choose(
    problem: ContactProblem,
    settings: SolverSettings,
    start: Start | None,
    loads: Callable[[], Admissible],
) -> Solution:
    """Turns until one converges; the best of their states."""
    began = time.monotonic()
    total: Solution | None = None
    case = Case(problem, settings, start, loads)
    for turn in turns(case):
        if total is not None and settings.acceptable > 0 and total.quality.error <= turn.enough(case):
            continue
        spent = 0 if total is None else total.iterations
        own = _share(turn.most(case), settings, spent, time.monotonic() - began)
        if own is None:
            break
        made = _judged(_made(turn, case, own, _origin(turn, problem, total, start)), loads)
        total = made if total is None else _joined(total, made)
        if not case.static:
            total = brought_to_rest(problem, total, settings)
        if total.outcome in _ENDED:
            break
        if _rounded(problem, total, settings):
            return _near_enough(problem, total, settings)
    assert total is not None  # there is always a first turn
    return total


def _rounded(problem: ContactProblem, made: Solution, settings: SolverSettings) -> bool:
    """True where an error that is small is no more than rounding makes: no other method would do better."""
    if made.quality.error > ACCEPTABLE:
        return False
    return made.quality.bounded_by(_rounding(problem, made, settings), settings.tolerance)


def _rounding(problem: ContactProblem, made: Solution, settings: SolverSettings) -> Quality:
    return rounding(problem, made.impulse, made.rigid_velocity, least_impulse=settings.least_impulse)


def _share(
    most: int | None, settings: SolverSettings, iterations: int, seconds: float
) -> SolverSettings | None:
    """What is left of the limits for a turn of so many; None where the iterations are used up."""
    limit = settings.time_limit
    if settings.max_iterations is not None:
        left = settings.max_iterations - iterations
        if left <= 0:
            return None
        most = left if most is None else min(most, left)
    if limit is not None:
        limit = max(limit - seconds, 1e-3)
    if (most, limit) == (settings.max_iterations, settings.time_limit):
        return settings
    return replace(settings, max_iterations=most, time_limit=limit)


def _made(turn: Turn, case: Case, settings: SolverSettings, start: Start | None) -> Solution:
    """What a turn's method makes of the problem."""
    problem, method = case.problem, _with_linear(turn.make(case), settings)
    if turn.twin is None:
        if not case.elastic or turn.leading >= settings.tolerance:
            return iterate(problem, method, settings, start)
        made = iterate(problem, method, replace(settings, tolerance=turn.leading), start)
        enough = not made.outcome.moves and made.quality.error <= settings.tolerance
        return replace(made, outcome=Outcome.CONVERGED) if enough else made
    share = turn.twin(case)
    twin = replace(problem.without_compliance(), friction=share * problem.friction)
    made = iterate(twin, method, settings, start)
    velocity = problem.velocity(made.impulse, made.rigid_velocity)
    quality = assess(problem, made.impulse, made.rigid_velocity, least_impulse=settings.least_impulse)
    # a verdict holds for both, convergence does not
    outcome = Outcome.STALLED if made.solved else made.outcome
    if share < 1 and outcome is Outcome.NO_EQUILIBRIUM:
        outcome = Outcome.AT_LIMIT
    return replace(made, velocity=velocity, quality=quality, outcome=outcome)


def _with_linear(method: Method, settings: SolverSettings) -> Method:
    """The method, its linear systems solved as the settings say, where it has any."""
    if isinstance(method, InPlane):
        return replace(method, inner=_with_linear(method.inner, settings))
    if settings.linear == "auto" or not hasattr(method, "library"):
        return method
    changed: Method = replace(method, library=settings.linear)  # type: ignore[type-var]
    return changed


def _origin(turn: Turn, problem: ContactProblem, state: Solution | None, start: Start | None) -> Start | None:
    """Where a turn starts."""
    if turn.origin == "cold":
        return None
    if turn.origin == "held":
        return Start(holding_impulses(problem))
    if state is None or turn.origin == "given":
        return start
    return Start(onto_cones(problem, state.impulse, state.velocity), state.rigid_velocity)


def _judged(made: Solution, loads: Callable[[], Admissible]) -> Solution:
    """The solution, its verdict withdrawn where nothing proves that the loads cannot be balanced."""
    if made.outcome is Outcome.NO_EQUILIBRIUM and not loads().falls:
        return replace(made, outcome=Outcome.UNDECIDED)
    return made


def _proven(
    problem: ContactProblem,
    settings: SolverSettings,
    made: Solution,
    motion: FloatArray,
    outcome: Outcome = Outcome.NO_EQUILIBRIUM,
) -> Solution:
    """The verdict that a mechanism proves where no method came to its velocities."""
    # fast enough to be seen beside motions of supports: what the loads give to blocks of unit mass
    motion = float(np.linalg.norm(problem.rigid_impulse) / np.linalg.norm(motion)) * motion
    quality = assess(problem, made.impulse, motion, least_impulse=settings.least_impulse)
    velocity = problem.velocity(made.impulse, motion)
    return replace(made, velocity=velocity, rigid_velocity=motion, quality=quality, outcome=outcome)


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
    if second.outcome.moves or second.quality.error <= first.quality.error:
        return replace(second, **counted)
    if first.outcome is Outcome.UNDECIDED:
        return replace(first, **counted)
    return replace(first, outcome=second.outcome, **counted)


def _unstressed(problem: ContactProblem, settings: SolverSettings, made: Solution) -> Solution:
    """The verdict that elastic blocks run off from where they are, although impulses could hold them."""
    limit = settings.time_limit
    until = None if limit is None else time.monotonic() + max(limit - made.seconds, 0.0)
    found = from_no_stress(problem, until=until)
    if found.reached is None and until is not None and time.monotonic() > until:
        return replace(made, outcome=Outcome.TIME_LIMIT)
    if found.reached is not False or not found.motion.any():
        return made
    solves = made.linear_solves + found.solves
    dragged = replace(made, impulse=found.impulse, method=f"{made.method}+drag", linear_solves=solves)
    return _proven(problem, settings, dragged, found.motion, Outcome.UNSTRESSED)


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
    """Bodies without contacts: they fly, or, without inertia, nothing holds them against their loads."""

    name = "free"
    iterations = 1

    def init(self, problem: ContactProblem, start: Start | None) -> OneOffer:
        # without inertia the motion is that of a unit mass, which shows where the loads drive the body
        driven = problem.rigid_velocity + problem.rigid_impulse
        motion = np.where(problem.rigid_mass > 0, problem.free_rigid_velocity(), driven)
        impulse = np.zeros_like(problem.free_velocity)
        return OneOffer(Iterate(impulse, motion, iterations=0, verdict=Outcome.NO_EQUILIBRIUM))
