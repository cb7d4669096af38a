"""Turn: one method's go at a problem; "auto" is a list of them.

- Static problems and elastic blocks: a few Newton steps, which is all that most need; where it is proven that
  nothing can balance the loads, or could with a little less friction, as many as show what moves; else rigid
  blocks at rest, elastic ones from the impulses of that rest, and what is done for many rigid blocks.
- Many rigid blocks: the interior-point method, which nothing stops but rounding, sweeps that mend what
  is local in its result, and Newton to polish it. It cannot start from the step before: there a few
  Newton steps from the bonded state come first, which is all that sticking walls need.
- What is left goes to pivoting, where the problem is plane and small, to Newton with other weights,
  where it is small, and to the following of a path where rigid blocks move in a plane.
- Other problems are swept first, as long as the contraction seen promises an end.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np

from masonry_fem.nscd.admissible import Admissible, at_limit
from masonry_fem.nscd.in_plane import InPlane
from masonry_fem.nscd.iterate import Method
from masonry_fem.nscd.methods import make_method
from masonry_fem.nscd.plane import PlaneForm, plane_form
from masonry_fem.nscd.problem import ContactProblem
from masonry_fem.nscd.rest import Rest
from masonry_fem.nscd.scaling import contact_scale
from masonry_fem.nscd.settings import SolverSettings, Start

# Sweeps that may precede Newton: where more are foreseen after PATIENCE of them, it takes over.
# One Newton step costs as much as 500 to 1000 sweeps; rigid walls need more of either.
HORIZON = 5_000
HORIZON_OF_BODIES = 20_000
PATIENCE = 300
# Rigid contacts from which sweeps from cold are not worth a try.
MANY = 500
# Sweeps after the interior point, where PATIENCE of them foretell an end.
ENDING = 1_500
# Newton steps in which blocks show whether they stick: then they are enough.
BRIEF = 10
# Newton steps on few rigid blocks before the interior point takes over.
NEWTON_STEPS = 120
# Newton steps of elastic blocks from what would hold them if they were rigid: chains take fifty.
HELD_STEPS = 60
# Proximal weights to try on few contacts: which leads out of a cycle differs from problem to problem.
WEIGHTS = (1e-2, 1e-1, 1e-3)
# Share of friction with which a structure at its limit moves fast enough to be seen.
WEAK = 0.97
# Newton steps that polish: what takes more seldom ends.
POLISH = 25


@dataclass(frozen=True, slots=True)
class Turn:
    """A method's turn.

    Attributes
    ----------
    make : Makes the method.
    iterations : Its limit; None: its own.
    origin : What it starts from: "given" (the caller's first guess), "best" (the best state so far), "held"
        (impulses that balance the loads, see ``rest``), "close" (the best state where that is close to a
        solution, else none) or "cold".
    twin : Share of friction of the rigid twin that is asked instead, which shows what moves.
    """

    make: Callable[[], Method]
    iterations: int | None = None
    origin: Literal["given", "best", "close", "held", "cold"] = "given"
    twin: float | None = None


def turns(
    problem: ContactProblem, settings: SolverSettings, start: Start | None, loads: Callable[[], Admissible]
) -> Iterator[Turn]:
    """Who has a go at a problem, in order; what a turn needs is found out only when it comes.

    Parameters
    ----------
    problem : What to solve.
    settings : How well.
    start : The caller's first guess.
    loads : Tells whether any impulses balance the loads.
    """
    if _static(problem):
        yield Turn(_newton, BRIEF)
        if _uneven(problem):
            yield Turn(_slender_newton, BRIEF, "cold")
        if loads().falls:
            # what moves, it shows as rigid blocks at a fifth of the cost
            if not problem.rigid:
                yield Turn(_newton, twin=1.0)
            yield Turn(_newton)
            return
        if not problem.rigid and problem.count >= MANY and at_limit(problem):
            yield Turn(_newton, twin=WEAK)
            return
        if problem.rigid:
            yield Turn(Rest)
        elif not problem.cohesive:
            yield Turn(_newton, HELD_STEPS, "held")
        yield from _thorough(problem, settings.tolerance)
    elif problem.body_count and not problem.rigid:
        yield Turn(_newton, BRIEF)
        if problem.count < MANY and not _coupled(problem):
            yield Turn(_brief_sweeps(HORIZON_OF_BODIES))
            yield Turn(_newton, NEWTON_STEPS, "close")
        yield from _thorough(problem, settings.tolerance)
    elif not problem.body_count:
        yield Turn(_brief_sweeps(HORIZON))
        yield Turn(_newton, origin="close")
        yield from _exact(problem)
    elif problem.count < MANY:
        yield Turn(_brief_sweeps(HORIZON_OF_BODIES))
        yield Turn(_newton, NEWTON_STEPS, "close")
        yield from _thorough(problem, settings.tolerance)
    else:
        if start is not None and start.impulse is not None:
            yield Turn(_newton, BRIEF)
        yield from _thorough(problem, settings.tolerance)


def _thorough(problem: ContactProblem, tolerance: float) -> Iterator[Turn]:
    """What carries where joints slide and open: interior point, its polish, and some that go elsewhere."""
    # few contacts need no help, and what they always did goes on giving the same bits
    flat = plane_form(problem, tolerance) if problem.count >= MANY else None
    yield Turn(_within(flat, _interior_point), origin="cold")
    if problem.rigid and not _static(problem):
        # where the interior point meets a fold of its path the error is local: sweeps get across
        yield Turn(_within(flat, _brief_sweeps(ENDING)), origin="best")
    yield Turn(_within(flat, _newton), POLISH, origin="best")
    yield from _exact(problem)
    if problem.count < MANY:
        if not problem.rigid:
            yield Turn(_searching_newton, NEWTON_STEPS)
        for weight in WEIGHTS:
            yield Turn(_firm_newton(weight), NEWTON_STEPS)
        flat = plane_form(problem, tolerance)
    if problem.rigid and _followable(problem if flat is None else flat.problem):
        yield Turn(_within(flat, _path), origin="best")
    flat = flat if problem.count >= MANY else None
    yield Turn(_within(flat, _patient_newton), origin="best")


def _within(form: PlaneForm | None, make: Callable[[], Method]) -> Callable[[], Method]:
    """A method's maker, in the plane that blocks move in, where there is one."""
    return make if form is None else lambda: InPlane(make(), form)


def _static(problem: ContactProblem) -> bool:
    """True where some body in contact has no inertia."""
    touched = np.unique(problem.bodies[problem.bodies >= 0])
    return bool((problem.rigid_mass[touched] <= 0).any())


def _uneven(problem: ContactProblem) -> bool:
    """True where elastic contacts lie so far apart in scale that some block may be slender."""
    from masonry_fem.nscd.methods.newton import SLENDER  # noqa: PLC0415
    from masonry_fem.nscd.solvers.newton_system import block_rows  # noqa: PLC0415

    if problem.rigid:
        return False
    scale = contact_scale(problem, fold=False)[block_rows(problem.compliance)]
    return bool(scale.max() > SLENDER * scale.min())


def _coupled(problem: ContactProblem) -> bool:
    """True where blocks deform; beds of mortar soften their own contacts alone, which sweeps like."""
    compliance = problem.compliance
    row = np.repeat(np.arange(problem.count), np.diff(compliance.indptr))
    return bool(compliance.data[compliance.indices != row].any())


def _exact(problem: ContactProblem) -> Iterator[Turn]:
    """Pivoting, where the problem is plane and small enough."""
    from masonry_fem.nscd.methods.pivoting import MOST_CONTACTS  # noqa: PLC0415

    if problem.dimension == 2 and problem.count <= MOST_CONTACTS:
        yield Turn(lambda: make_method("pivoting"), origin="cold")


def _newton() -> Method:
    return make_method("newton")


def _slender_newton() -> Method:
    from masonry_fem.nscd.methods.newton import ProximalNewton  # noqa: PLC0415

    return ProximalNewton(slender=True)


def _patient_newton() -> Method:
    from masonry_fem.nscd.methods.newton import ProximalNewton  # noqa: PLC0415

    return ProximalNewton(weight=2e-3, adaptive=True, accuracy=0.3, round_steps=10, patience=60)


def _searching_newton() -> Method:
    """Full steps diverge where joints open widely; a search along each is slower, but holds."""
    from masonry_fem.nscd.methods.newton import ProximalNewton  # noqa: PLC0415

    return ProximalNewton(full_steps=0)


def _firm_newton(weight: float) -> Callable[[], Method]:
    def make() -> Method:
        from masonry_fem.nscd.methods.newton import ProximalNewton  # noqa: PLC0415

        return ProximalNewton(weight=weight, decrease=0.3)

    return make


def _interior_point() -> Method:
    from masonry_fem.nscd.methods.interior_point import InteriorPoint  # noqa: PLC0415

    return InteriorPoint(align=0.0)  # Newton polishes


def _followable(problem: ContactProblem) -> bool:
    from masonry_fem.nscd.solvers.path import followable  # noqa: PLC0415 - Numba is slow to import

    return followable(problem)


def _path() -> Method:
    from masonry_fem.nscd.solvers.path import PathFollowing  # noqa: PLC0415 - Numba is slow to import

    return PathFollowing()


def _brief_sweeps(horizon: int) -> Callable[[], Method]:
    def make() -> Method:
        from masonry_fem.nscd.methods.nsgs import GaussSeidel  # noqa: PLC0415 - Numba is slow to import

        return GaussSeidel(iterations=horizon, patience=PATIENCE, horizon=horizon)

    return make
