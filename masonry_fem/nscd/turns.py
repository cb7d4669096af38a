"""Turn: one method's go at a problem; "auto" is the list ``TURNS``, of which a problem takes what suits it.

- Static problems and elastic blocks: a few Newton steps, which is all that most need; where it is proven that
  nothing can balance the loads, or could with a little less friction, as many as show what moves; else rigid
  blocks at rest, and what is done for many rigid blocks. After that elastic ones search along Newton's steps,
  or begin at the impulses of that rest.
- Rigid blocks: the interior-point method, which nothing stops but rounding, and sweeps that mend what
  is local in its result, and Newton to polish it. It cannot start from the step before: there a few Newton
  steps from the bonded state come first, which is all that sticking walls need. Fewer contacts begin with
  more of them, from the step before with sweeps.
- What is left goes to Newton with other weights, where it is small, and to the following of a path where
  rigid blocks move in a plane.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

from masonry_fem.nscd.admissible import Admissible, at_limit
from masonry_fem.nscd.iterate import Method
from masonry_fem.nscd.methods import make_method
from masonry_fem.nscd.modal import has_form
from masonry_fem.nscd.plane import InPlane, PlaneForm, plane_form
from masonry_fem.nscd.problem import ContactProblem
from masonry_fem.nscd.rest import Rest
from masonry_fem.nscd.settings import ACCEPTABLE, SolverSettings, Start
from masonry_fem.nscd.solvers.elastic_krylov import FACTORED, iteration_pays
from masonry_fem.nscd.solvers.elastic_krylov import MANY as MANY_ELASTIC

# Sweeps before the next turn takes over, and the same of many rigid contacts that may slide: of 48 768 a
# Newton step costs as much as 80, and what 300 sweeps leave falls by a third to a half in the next 1200.
SWEEPS, SLIDING_SWEEPS = 1_500, 300
# Rigid contacts from which the interior point is faster than Newton's method from cold.
MANY = 500
# Newton steps in which blocks show whether they stick: then they are enough.
BRIEF = 10
# Newton steps of elastic blocks in statics from the round before, and of many from cold: a dome whose stones
# have turned a little takes 17, and the interior point and its polish six times as long; a wall of 1600
# bricks takes 10 to 20.
LED_STEPS = 40
# The same where no factor fits, so that no other turn would end: a wall of 10 000 bricks, whose uppermost
# courses slide, takes 130, and 1600 that rebound up to 115 a step of dynamics.
LARGE_STEPS = 200
# Newton steps on few contacts before another turn takes over.
NEWTON_STEPS = 120
# Newton steps of elastic blocks from what would hold them if they were rigid: chains take fifty.
HELD_STEPS = 60
# Proximal weight that leads few contacts out of a cycle; a tenth and ten times of it decide nothing more.
# Twenty steps of elastic walls that rebound take 530 Newton steps from it on, and 730 from 1e-4 on.
FIRM = 1e-2
# Share of friction with which a structure at its limit moves fast enough to be seen.
WEAK = 0.97
# Error below which patience costs more than it brings on many contacts: 240 steps bring a wall that slides
# from 5.5e-9 to 3.5e-10.
NEAR = 1e-8
# Error of an interior point's state that leads Newton's method on: the last steps to it are few, and from
# 1e-3 a wall with one loaded brick takes forty without an end.
LEADING = 1e-5
# Newton steps that polish: what takes more seldom ends. Many rigid contacts that slide take 10 to 25.
POLISH, SLIDING_POLISH = 25, 60


class Case:
    """What turns ask of a problem; each answer is found when it is first asked for.

    Attributes
    ----------
    problem : What to solve. settings : How well.
    start : The caller's first guess.
    loads : Tells whether any impulses balance the loads.
    """

    def __init__(
        self,
        problem: ContactProblem,
        settings: SolverSettings,
        start: Start | None,
        loads: Callable[[], Admissible],
    ) -> None:
        self.problem, self.settings, self.start, self.loads = problem, settings, start, loads
        self.rigid, self.plain = problem.rigid, not problem.body_count
        self.elastic = not self.rigid and not self.plain
        self.few = problem.count < MANY

    @cached_property
    def many(self) -> bool:
        """True for many elastic contacts in statics, of reduced stones too: other turns take longer."""
        return self.static and (self._iterates or has_form(self.problem))

    @property
    def sliding(self) -> bool:
        """True for many rigid contacts of bodies that move, which may all be at the edges of their cones."""
        return self.rigid and not self.few and not self.static

    @property
    def large(self) -> bool:
        """True for more elastic contacts than a factor would take over from."""
        return self._iterates and self.problem.count > FACTORED

    @cached_property
    def _iterates(self) -> bool:
        """True for many elastic contacts that iterations are worth a try for."""
        if not self.elastic or self.problem.count < MANY_ELASTIC or has_form(self.problem):
            return False
        return iteration_pays(self.problem)

    @cached_property
    def static(self) -> bool:
        """True where some body in contact has no inertia."""
        still = (self.problem.rigid_mass <= 0).any(axis=1)
        return bool(still.any() and still[self.problem.bodies[self.problem.bodies >= 0]].any())

    @property
    def warm(self) -> bool:
        """True where the caller knows of impulses."""
        return self.start is not None and self.start.impulse is not None

    @property
    def led(self) -> bool:
        """True for elastic blocks of which the caller knows how they moved in a problem nearly like this."""
        return self.elastic and self.static and self.start is not None and self.start.velocity is not None

    @cached_property
    def falls(self) -> bool:
        """True where it is proven that nothing can balance the loads."""
        return self.static and self.loads().falls

    @cached_property
    def at_limit(self) -> bool:
        """True where many elastic blocks are proven to be next to their limit."""
        return self.static and self.elastic and not self.few and not self.falls and at_limit(self.problem)

    @property
    def open(self) -> bool:
        """True where nothing is proven yet."""
        return not self.falls and not self.at_limit

    @property
    def followable(self) -> bool:
        """True where a path can be followed: rigid blocks that move in a plane."""
        from masonry_fem.nscd.solvers.path import followable  # noqa: PLC0415 - Numba is slow to import

        return self.rigid and followable(self.problem if self.plane is None else self.plane.problem)

    @cached_property
    def plane(self) -> PlaneForm | None:
        """The plane that blocks move in, where there is one."""
        return plane_form(self.problem, self.settings.tolerance)


@dataclass(frozen=True, slots=True)
class Turn:
    """A method's turn.

    Attributes
    ----------
    name : What tables call it.
    when : Tells whether a problem takes it.
    make : Makes the method.
    iterations : Its limit, or what tells it of a problem; None: its own.
    origin : What it starts from: "given" (the caller's first guess), "best" (the best state so far), "held"
        (impulses that balance the loads, see ``rest``) or "cold".
    twin : Share of friction of the rigid twin that is asked instead, of a problem, which shows what moves.
    above : Error down to which it is worth its time where no tolerance was set, or what tells it of a
        problem.
    leading : Error that elastic blocks are solved to where the tolerance is looser.
    """

    name: str
    when: Callable[[Case], bool]
    make: Callable[[Case], Method]
    iterations: int | Callable[[Case], int] | None = None
    origin: Literal["given", "best", "held", "cold"] = "given"
    twin: Callable[[Case], float] | None = None
    above: float | Callable[[Case], float] = 0.0
    leading: float = 1.0

    def most(self, case: Case) -> int | None:
        """Its limit of iterations on a problem."""
        return self.iterations(case) if callable(self.iterations) else self.iterations

    def enough(self, case: Case) -> float:
        """Error of a problem's best state that makes it superfluous."""
        return self.above(case) if callable(self.above) else self.above


def turns(case: Case) -> Iterator[Turn]:
    """Who has a go at a problem, in order; what decides a turn is found out only when it comes.

    Parameters
    ----------
    case : The problem, and what is known of it.
    """
    return (turn for turn in TURNS if turn.when(case))


def _newton(case: Case) -> Method:
    return make_method("newton")


def _patient_newton(case: Case) -> Method:
    from masonry_fem.nscd.methods.newton import ProximalNewton  # noqa: PLC0415

    return ProximalNewton(weight=2e-3, adaptive=True, accuracy=0.3, round_steps=10, patience=60)


def _searching_newton(case: Case) -> Method:
    """Full steps diverge where joints open widely; a search along each is slower, but holds."""
    from masonry_fem.nscd.methods.newton import ProximalNewton  # noqa: PLC0415

    return ProximalNewton(full_steps=0)


def _hinging_newton(case: Case) -> Method:
    """The same for stiff blocks that hinge: contacts are scaled as these move, of which W_el says nothing."""
    from masonry_fem.nscd.methods.newton import ProximalNewton  # noqa: PLC0415

    return ProximalNewton(full_steps=0, moving=True)


def _moving_newton(case: Case) -> Method:
    from masonry_fem.nscd.methods.newton import ProximalNewton  # noqa: PLC0415

    # Reduced stones that hit and part need a search from the first step on: full ones go round, some for
    # ever. With another weight, or one that does not adapt, four of eight steps of 20×20 bricks that 0.3 g
    # makes rebound fall back on slower turns, and not all of them are solved.
    if has_form(case.problem):
        return ProximalNewton(weight=1.0, adaptive=True, full_steps=0)
    return ProximalNewton(moving=True, weight=FIRM, decrease=0.3)


def _firm_newton(case: Case) -> Method:
    from masonry_fem.nscd.methods.newton import ProximalNewton  # noqa: PLC0415

    return ProximalNewton(weight=FIRM, decrease=0.3)


def _interior_point(case: Case) -> Method:
    from masonry_fem.nscd.methods.interior_point import InteriorPoint  # noqa: PLC0415

    return InteriorPoint(align=0.0)  # Newton polishes


def _sweeps(case: Case) -> Method:
    from masonry_fem.nscd.methods.nsgs import GaussSeidel  # noqa: PLC0415 - Numba is slow to import

    return GaussSeidel(iterations=SLIDING_SWEEPS if case.sliding else SWEEPS)


def _polish(case: Case) -> Method:
    """Newton's method next to the solution; many rigid blocks that slide take the patient one.

    With a fixed path of α their statuses go round: 64×64 of them take 25 steps for nothing.
    """
    return _patient_newton(case) if case.sliding else _newton(case)


def _path(case: Case) -> Method:
    from masonry_fem.nscd.solvers.path import PathFollowing  # noqa: PLC0415 - Numba is slow to import

    return PathFollowing() if case.plane is None else InPlane(PathFollowing(), case.plane)


def _in_plane(make: Callable[[Case], Method]) -> Callable[[Case], Method]:
    """A method's maker, in the plane that many blocks move in, where there is one."""

    def within(case: Case) -> Method:
        # few contacts need no help, and what they always did goes on giving the same bits
        return make(case) if case.few or case.plane is None else InPlane(make(case), case.plane)

    return within


def _moving(case: Case) -> float:
    """Error from which many elastic blocks that move are near enough where no tolerance was set.

    What is left there are impulses that go round where stones meet and move next to nothing. To take that
    away takes twenty times as long as all before: 10 to 28 s for a step of 12×12 bricks that rebound.
    """
    moving = case.elastic and not (case.static or case.few) and bool(case.problem.operator.elastic().all())
    return ACCEPTABLE if moving else 0.0


def _first_steps(case: Case) -> int:
    """Newton steps after which another turn takes over."""
    if case.large and case.static:
        return LARGE_STEPS
    if case.led or case.many:
        return LED_STEPS
    return BRIEF if case.static or case.elastic or not (case.few or case.plain) else NEWTON_STEPS


TURNS = (
    # what the step before leaves to a few rigid blocks is a few sweeps
    Turn("first sweeps", lambda at: at.warm and at.few and at.rigid and not at.static, _sweeps),
    Turn(
        "first newton steps",
        lambda at: at.static or at.elastic or at.warm or at.few or at.plain,
        _newton,
        _first_steps,
    ),
    Turn(
        "moving newton",
        lambda at: at.elastic and not at.static,
        _moving_newton,
        lambda at: LARGE_STEPS if at.large else NEWTON_STEPS,
    ),
    # what moves, rigid blocks show at a fifth of the cost
    Turn(
        "rigid twin",
        lambda at: not at.rigid and not at.open,
        _newton,
        twin=lambda at: 1.0 if at.falls else WEAK,
    ),
    Turn("newton", lambda at: at.falls, _newton),
    Turn("rest", lambda at: at.static and at.open and at.rigid, lambda at: Rest()),
    Turn(
        "interior point",
        lambda at: at.open and not at.plain,
        _in_plane(_interior_point),
        origin="cold",
        above=_moving,
        leading=LEADING,
    ),
    # where the interior point meets a fold of its path the error is local: sweeps get across
    Turn("sweeps", lambda at: (at.rigid or at.plain) and not at.static, _in_plane(_sweeps), origin="best"),
    Turn(
        "polish",
        lambda at: at.open,
        _in_plane(_polish),
        lambda at: SLIDING_POLISH if at.sliding else POLISH,
        "best",
        above=_moving,
    ),
    Turn("searching newton", lambda at: at.open and at.few and at.elastic, _searching_newton, NEWTON_STEPS),
    Turn(
        "newton from held impulses",
        lambda at: at.static and at.open and not (at.rigid or at.led or at.problem.cohesive),
        _newton,
        HELD_STEPS,
        "held",
    ),
    Turn(
        "hinging newton",
        lambda at: at.static and at.open and at.few and at.elastic,
        _hinging_newton,
        NEWTON_STEPS,
        "held",
    ),
    # the step before leads astray where rigid stones jolt against what gives way, as bars
    Turn(
        "newton from cold",
        lambda at: at.warm and at.elastic and not at.static,
        _moving_newton,
        NEWTON_STEPS,
        "cold",
        above=_moving,
    ),
    Turn("firm newton", lambda at: at.open and at.few and not at.plain, _firm_newton, NEWTON_STEPS, "cold"),
    Turn("path", lambda at: at.open and not at.plain and at.followable, _path, origin="best", above=NEAR),
    Turn(
        "patient newton",
        lambda at: at.open and not at.plain,
        _in_plane(_patient_newton),
        origin="best",
        above=lambda at: max(_moving(at), 0.0 if at.few else NEAR),
    ),
)
