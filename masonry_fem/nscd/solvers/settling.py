"""Settling: bodies that are far from where they rest come to rest by themselves, and the whole goes on then.

Where stones lie loosely, as in the uppermost courses of a wall, all contacts of a stone may slide, and a
Newton step moves it much too far. Shortened until no stone goes too far, steps bring a wall of ten thousand
on by a thousandth. So such bodies and those around them are solved for as a problem of their own (``part``)
while all others stay; then the next step of the whole is a full one. That is nonlinear elimination of what
is most nonlinear.

    settling = Settling(problem, held)
    settled = settling.settle(residual, impulse, rigid_velocity, error, wanted)
    if settled is not None:
        impulse, rigid_velocity = settled

References
----------
X.-C. Cai and X. Li, "Inexact Newton methods with restricted additive Schwarz based nonlinear elimination for
problems with high local nonlinearity", SIAM Journal on Scientific Computing 33 (2011).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from time import monotonic
from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from masonry_fem.host.ranks import Leader, Member, dealt, team
from masonry_fem.nscd.iterate import iterate
from masonry_fem.nscd.outcome import Outcome, Solution
from masonry_fem.nscd.part import Part, touched, unsettled
from masonry_fem.nscd.problem import ContactProblem, Products
from masonry_fem.nscd.residuals import assess
from masonry_fem.nscd.settings import ACCEPTABLE, SolverSettings, Start, time_left
from masonry_fem.nscd.solvers.elastic_krylov import FACTORED, MANY

if TYPE_CHECKING:
    from masonry_fem.nscd.methods.newton import ProximalNewton

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
Mask = NDArray[np.bool_]

# A part is made of the bodies without which no more of the residual is left than at the best state so far, if
# they have no more than the first share of all contacts. Else a share of the residual is left: the first one
# that makes a part of no more than the second share of them. Near the end a few contacts are far off after
# each step: a tenth of their residual is more than all that was left before, and the error would not fall.
FEW, MOST = 0.2, 0.5
LEFT = (0.1, 0.3, 0.6)
# Error that is wanted of a part over that of the whole, as the whole sees it; its bounds, of the part's own,
# and the least over that at which the whole ends. With 1e-4 for the coarsest rounding decides whether two
# ranks take 22 or 31 s for 100×100 bricks; with 1e-5 to 5e-5 they take 20 to 24.
SHARE, FINEST, COARSEST, FINER = 1e-2, 1e-7, 5e-5, 0.1
# The same of what is good enough, which is at most ACCEPTABLE at the end; and linear systems from there on,
# unless the part is large: loose stones at a fold keep their error for ten steps, and come to rest after 50.
ENOUGH, LEAST, FURTHER = 0.1, 0.5, 50
# Of the error that a part had: what is taken where it does not come to what is good enough.
BETTER = 0.1
# Where steps with slip held stall: first α of steps in which impulses are held instead, and its factor after
# each round; and linear systems after which they have failed, those of the part's own parts included.
# Where they lead somewhere they take up to 200; where not, they took up to 18 000.
FIRM, SOFTER, MOST_SYSTEMS = 0.1, 0.3, 400
# What each further rank adds to the speed of one where ranks solve for a group together: two take two thirds
# of the time for 16 500 contacts, five sixths for 12 600, and as long as one for 4 500. With 0.2 one of them
# solved for 14 900 alone, in 4.3 s for 3.1, beside one that had next to nothing to do.
GAIN = 0.4
# Outcomes after which impulses are not held instead: slip held goes on, but there is no more time for it.
UNFINISHED = {Outcome.MAX_ITERATIONS, Outcome.TIME_LIMIT}


class Settles(Protocol):
    """What brings parts of a problem to rest: ``Settling``, or what calls on it."""

    linear_solves: int

    def settle(
        self,
        residual: FloatArray,
        impulse: FloatArray,
        rigid_velocity: FloatArray,
        error: float,
        wanted: float,
        until: float | None = None,
        best: float = np.inf,
        known: Products | None = None,
    ) -> tuple[FloatArray, FloatArray] | None:
        """As ``Settling.settle``."""
        ...


class Settling:
    """What it takes to bring parts of a problem to rest.

    Parameters
    ----------
    problem : The whole.
    held : The method that solves parts: one that holds slip back from the start.
    """

    def __init__(self, problem: ContactProblem, held: ProximalNewton) -> None:
        self.problem, self.held = problem, held
        self.linear_solves = 0  # of all parts so far

    def settle(
        self,
        residual: FloatArray,
        impulse: FloatArray,
        rigid_velocity: FloatArray,
        error: float,
        wanted: float,
        until: float | None = None,
        best: float = np.inf,
        known: Products | None = None,
    ) -> tuple[FloatArray, FloatArray] | None:
        """Impulses (c, d) and U (b, m) with what was far from settled at rest; None where that fails.

        Parameters
        ----------
        residual : At each contact, as an impulse, shape (c, d).
        impulse, rigid_velocity : The state, shapes (c, d) and (b, m).
        error : Norm of the residual over that of the impulses. wanted : Error at which the whole ends.
        until : Monotonic clock after which parts stay as far as they have come [s]; None: no limit.
        best : Least error of the whole after a round or after parts so far; inf before the first.
        known : Products of the problem with the state; None: they are not known.
        """
        missed, size = float(np.linalg.norm(residual)), float(np.linalg.norm(impulse)) or 1.0
        first = min(best * size, LEFT[0] * missed)
        for least, most in ((first, FEW), *((left * missed, MOST) for left in LEFT)):
            chosen = unsettled(self.problem, residual, least)
            if touched(self.problem, chosen).mean() <= most:
                break
        else:
            return None
        part = Part.of(self.problem, chosen, impulse, rigid_velocity, known)
        aim = Aim(self.held, size, error, wanted)
        groups = list(part.groups())
        impulse, rigid_velocity, settled = impulse.copy(), rigid_velocity.copy(), False
        for group, found in zip(groups, _rested(groups, residual, aim, until), strict=True):
            self.linear_solves += found.linear_solves
            impulse[group.contacts], rigid_velocity[group.bodies] = found.impulse, found.rigid_velocity
            settled = settled or found.settled
        return (impulse, rigid_velocity) if settled else None


@dataclass(frozen=True, slots=True)
class Aim:
    """How parts are brought to rest.

    Attributes
    ----------
    held : The method, which holds slip back.
    size : Norm of the impulses of the whole.
    error, least : Error of the whole, and the one at which it ends.
    """

    held: ProximalNewton
    size: float
    error: float
    least: float

    def errors(self, part: Part) -> tuple[float, float]:
        """Error that is wanted of a part, and the one that will do: of a small part the whole sees little."""
        share = float(np.linalg.norm(part.impulse)) / self.size or 1.0
        error, least = self.error / share, self.least / share
        wanted = np.clip(SHARE * error, min(FINEST, FINER * least), COARSEST)
        return float(wanted), float(np.clip(ENOUGH * error, min(ACCEPTABLE, LEAST * least), ENOUGH))

    def work(self, part: Part, residual: FloatArray) -> float:
        """What a part is taken to cost: it grows with its contacts, and with the decades that it has to go.

        Parameters
        ----------
        part : The part. residual : At each of its contacts, shape (k, d).
        """
        wanted = self.errors(part)[0] * float(np.linalg.norm(part.impulse))
        left = float(np.linalg.norm(residual)) / wanted if wanted > 0 else 1.0
        return part.problem.count * (1.0 + float(np.log10(max(left, 1.0))))


class Rested(NamedTuple):
    """A group's state, (k, d) and (n, m), whether some of it came to rest, and the linear systems it took."""

    impulse: FloatArray
    rigid_velocity: FloatArray
    settled: bool
    linear_solves: int


def _rested(groups: Sequence[Part], residual: FloatArray, aim: Aim, until: float | None) -> list[Rested]:
    """The states of parts that have nothing to do with each other.

    Several ranks share them: large ones are solved for by all together.

    Parameters
    ----------
    groups : The parts. residual : At each contact of the whole, as an impulse, shape (c, d).
    aim : What is asked of them. until : As for ``Settling.settle``.
    """
    leader = team()
    if not isinstance(leader, Leader) or leader.busy:  # at work on a part of which these are parts
        return [_in_turn(group, aim, until) for group in groups]
    sizes = np.array([group.problem.count for group in groups])
    large = _large(sizes, leader.size)
    found = {number: _in_turn(groups[number], aim, until) for number in np.flatnonzero(large).tolist()}
    others = np.flatnonzero(~large)
    works = np.array([aim.work(group, residual[group.contacts]) for group in groups])
    its = [others[own].tolist() for own in dealt(works[others], leader.size)]
    shares = [([groups[number] for number in own], aim, time_left(until)) for own in its]
    if len(others):
        for own, states in zip(its, leader.call(_on_rank, shares), strict=True):
            found |= dict(zip(own, states, strict=True))
    return [found[number] for number in range(len(groups))]


def _large(sizes: IntArray, ranks: int) -> Mask:
    """Groups that all ranks solve for together, so that the last rank ends soonest, shape (n,).

    Parameters
    ----------
    sizes : Contacts of each group, shape (n,): work is taken to grow as they do. ranks : How many there are.
    """
    order = np.argsort(-sizes, kind="stable")
    iterated = int((sizes >= MANY).sum())  # fewer are solved for sooner by one rank
    speed = 1 + GAIN * (ranks - 1)
    least = int((sizes > FACTORED).sum())  # these have parts of their own, which ranks share
    ends = [
        sizes[order[:count]].sum() / speed + _load(sizes[order[count:]], ranks).max()
        for count in range(least, iterated + 1)
    ]
    large = np.zeros(len(sizes), dtype=bool)
    large[order[: least + int(np.argmin(ends))]] = True
    return large


def _load(sizes: IntArray, ranks: int) -> IntArray:
    """Contacts of all that each rank is dealt, shape (r,)."""
    return np.array([sizes[own].sum() for own in dealt(sizes, ranks)])


def _on_rank(member: Member, share: tuple[list[Part], Aim, float | None]) -> list[Rested]:
    """The states of the parts that a rank has got, and the time that is left for all [s]."""
    groups, aim, seconds = share
    until = None if seconds is None else monotonic() + seconds
    with member.on("parts"):
        found: list[Rested] = member.together(lambda: [_in_turn(group, aim, until) for group in groups])
    return found


def _in_turn(group: Part, aim: Aim, until: float | None) -> Rested:
    """The state of a part whose clusters come to rest in turn: they feel each other by what they touch.

    Parameters
    ----------
    group : The part. aim : What is asked of it. until : As for ``Settling.settle``.
    """
    impulse, rigid_velocity, settled, solves = group.impulse.copy(), group.rigid_velocity.copy(), False, 0
    for chosen in group.clusters():
        cluster = Part.of(group.problem, chosen, impulse, rigid_velocity)
        wanted, enough = aim.errors(cluster)
        rest = _Rest(cluster, aim, SolverSettings(tolerance=wanted, time_limit=time_left(until)), enough)
        found = rest.best()
        solves += rest.linear_solves
        if found.quality.error <= enough or found.quality.error <= BETTER * _error(cluster):
            impulse[cluster.contacts], settled = found.impulse, True
            rigid_velocity[cluster.bodies] = found.rigid_velocity
    return Rested(impulse, rigid_velocity, settled, solves)


def _error(part: Part) -> float:
    """Of the state that a part was in."""
    return assess(part.problem, part.impulse, part.rigid_velocity).error


class _Rest:
    """A part on the way to rest.

    Parameters
    ----------
    part : With the state that it is in. aim : The method. settings : With what is wanted.
    enough : Error that will do.
    """

    def __init__(self, part: Part, aim: Aim, settings: SolverSettings, enough: float) -> None:
        self.part, self.held = part, aim.held
        self.settings, self.enough = settings, enough
        self.linear_solves = 0

    def best(self) -> Solution:
        """Its best state: one that is good enough, and unless it is large more steps to what is wanted."""
        found = self._enough(replace(self.settings, tolerance=self.enough))
        large = self.part.problem.count > FACTORED
        if found.converged and found.quality.error > self.settings.tolerance and not large:
            further = replace(self.held, systems=FURTHER)
            found = _better(found, self._solved(further, self.settings, _ahead(found)))
        return found

    def _enough(self, settings: SolverSettings) -> Solution:
        """Its best state: with slip held; else with impulses held, as helps where contacts part and meet."""
        found = self._solved(self.held, settings, self.part.start)
        if found.converged or found.outcome in UNFINISHED:
            return found
        firm = replace(self.held, weight=FIRM, decrease=SOFTER, grip=0.0, systems=MOST_SYSTEMS)
        return _better(found, self._solved(firm, settings, self.part.start))

    def _solved(self, method: ProximalNewton, settings: SolverSettings, start: Start) -> Solution:
        solution = iterate(self.part.problem, method, settings, start)
        self.linear_solves += solution.linear_solves
        return solution


def _ahead(solution: Solution) -> Start:
    """What goes on from a solution."""
    return Start(solution.impulse, solution.rigid_velocity)


def _better(one: Solution, other: Solution) -> Solution:
    """The one with the smaller error."""
    return min(one, other, key=lambda solution: solution.quality.error)
