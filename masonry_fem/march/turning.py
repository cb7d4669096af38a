"""Turning: rounds of a step of statics whose blocks turn, until impulses balance where the step ends.

rounds = Rounds(model, coupling, state, scheme, ...)
turned(rounds, rounds.solved(rounds.start, None))   # the last round, where it leads, and what is left there
turned_roughly(rounds)                              # the same, sooner; None where it is not found so

A round solves the contacts at a place and leads to another; the step ends at the place that leads to itself.
Dead loads and impulses have a *geometric* stiffness on blocks that turn and bend. By as much as that is of
the stiffness of blocks and joints, where a round leads changes with its place. What bends far has as much
of the one as of the other, and rounds that each went on from where the last one led would come to no end.
So this change is taken from the rounds, as secants: combinations of the places so far lead to the same
combinations of where these led, to first order, and the next round is made where the combination leads that
comes nearest to itself.

Contacts of a round need to be solved no more exactly than its place is known. Between blocks that deform
impulses are unique, and the first rounds solve them roughly: the first to ``ROUGH`` (or ``FINER``), the
others to a share of what the last one left of balance, and the last to the tolerance. Stones that yield need
rounds anyway: as soon as their stresses are near to balance, blocks turn in the same rounds. Where steps of
statics are alike, the first round is made where the last step leads on to (``forecast``). Where that leads to
no end, or nothing balances, all rounds are made again to the tolerance, and what these say counts.

References
----------
R. S. Dembo, S. C. Eisenstat, T. Steihaug, "Inexact Newton methods", SIAM Journal on Numerical Analysis 19
(1982).
H. F. Walker, P. Ni, "Anderson acceleration for fixed-point iterations", SIAM Journal on Numerical Analysis 49
(2011).
"""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np

from masonry_fem.bodies.base import FloatArray
from masonry_fem.march.forecast import foreseen
from masonry_fem.march.place import Place, reached, rounding, turning
from masonry_fem.march.rounds import NEAR, NEWTON_TOLERANCE, SHARE, Round, Rounds
from masonry_fem.march.yielding import ROUGH_PATIENCE, settled_stresses
from masonry_fem.nscd import Outcome

logger = logging.getLogger(__name__)

MOST = 30  # rounds in all
PATIENCE = 4  # rounds that bring forces no nearer to balance
DEPTH = 5  # earlier rounds that the next place is made of
BALANCED = 1e-6  # of the largest load or impulse: what rounds that come no nearer may leave
ROUNDING = 1e-12  # of the model's length: a way that is none
ROUGH = 1e-3  # error of the contacts in a first round
# The same of so many contacts. With 1e-3 loose stones of large walls have not settled yet, and the next round
# begins with steps that come out too short: 100×100 bricks take 57 s to solve for 43.
FINER, MANY = 1e-4, 20_000
FORESEEN, STEPS = 1e-7, 8  # error and most Newton steps of one that begins next to its end


@dataclass(frozen=True, slots=True)
class Turned:
    """How the rounds of a step ended.

    Attributes
    ----------
    made : The round that came nearest. place : Where it led, and where its impulses balance.
    strayed : Impulses balance where the step begins, and none were found that do where it leads.
    """

    made: Round
    place: Place
    strayed: bool

    def counting(self, last: Round) -> Self:
        """The same with the efforts of all rounds, up to the ``last`` one."""
        spent = {name: getattr(last.solution, name) for name in ("iterations", "linear_solves", "seconds")}
        return replace(self, made=replace(self.made, solution=replace(self.made.solution, **spent)))


def turned_roughly(rounds: Rounds) -> Turned | None:
    """Rounds of which only the last is exact; None where impulses are not unique, or were not found so.

    Where there was no more time they end with what was found.

    Parameters
    ----------
    rounds : The step.
    """
    soft = rounds.coupling.soft
    steered = rounds.model.control is not None
    if steered or not rounds.model.laws.all_plain or not (soft.any() and soft.all()):
        return None
    rounds, first, error = _begun(rounds)
    if first.solution.outcome.late:
        return Turned(first, first.place, strayed=False)
    if rounds.nonlinear:
        enough = NEWTON_TOLERANCE if rounds.softens else NEAR
        first = settled_stresses(rounds, first, error, patience=ROUGH_PATIENCE, enough=enough)
        if first.residuals[-1] > enough:
            return None
    if not first.solution.solved:
        return None
    begun = [first]  # held by no name here, so that it can be freed once another round is nearer
    del first
    found = turned(rounds, begun.pop(), error)
    solution = found.made.solution
    return found if solution.outcome.late or (solution.solved and not found.strayed) else None


def _begun(rounds: Rounds) -> tuple[Rounds, Round, float]:
    """The rounds from a forecast on if there is one, the first of them, and the error of its contacts."""
    forecast, rough = foreseen(rounds), ROUGH if len(rounds.coupling.soft) < MANY else FINER
    if forecast is None:
        return rounds, rounds.roughly(rough).solved(rounds.start, None), rough
    ahead, settings = replace(rounds, forecast=forecast), rounds.settings
    if not forecast.near or settings.method not in ("auto", "newton"):
        return ahead, ahead.roughly(rough).solved(forecast.place, None), rough
    brief = replace(settings, method="newton", max_iterations=STEPS, acceptable=0.0)
    first = replace(ahead, settings=brief).roughly(FORESEEN).solved(forecast.place, None)
    if first.solution.solved:
        return ahead, first, FORESEEN
    return rounds, rounds.roughly(rough).solved(rounds.start, None), rough


def turned(rounds: Rounds, first: Round, error: float = 0.0) -> Turned:
    """Rounds until impulses balance where the step ends, or come no nearer.

    Parameters
    ----------
    rounds : The step. first : Its first round.
    error : That the contacts of the first round were solved to, where that is more than the tolerance.
    """
    made, places, idle, count = first, _Places(rounds), 0, 0
    tolerance, least, best = rounds.settings.tolerance, np.inf, Turned(first, rounds.start, strayed=True)
    del first
    while True:
        there = reached(rounds.coupling, rounds.start, made.bodies, rounds.scheme.step)
        left, missed = _left(rounds, made, there)
        logger.info(
            "t = %.6g, round %d: %d linear solves so far; where it leads %.1e of balance is left",
            made.loading.end, count + 1, made.solution.linear_solves, left,
        )  # fmt: skip
        felt = max(left, _yielding(made))
        exact = error <= tolerance
        rest = _rest(rounds, made, there, left, missed) if exact else max(felt, error) / tolerance
        strayed = max(left, missed) > BALANCED or not rounds.settled(made) or not exact
        nearer, idle, count = rest < least, 0 if rest <= 0.5 * least else idle + 1, count + 1
        if nearer:
            least, best = rest, Turned(made, there, strayed)
        if rest <= 1 or idle > PATIENCE or count > MOST or made.change > 0:
            break  # holds, or as far as rounding lets it go, or round in circles, of joint laws too
        error = max(tolerance, min(error, SHARE * felt))
        following = rounds.roughly(error).solved(places.following(made, there, nearer=nearer), made)
        if not following.solution.solved:
            return _lost(rounds, following)
        made = following
    return best.counting(made)


def _rest(rounds: Rounds, made: Round, there: Place, left: float, missed: float) -> float:
    """What an exact round leaves open, over what may be left open: at most 1 where it holds."""
    nothing = max(ROUNDING, rounding(there.contact) / rounds.model.length)
    asked = max(rounds.settings.tolerance, made.solution.quality.block_balance)
    return max(left / asked, missed / nothing, _yielding(made) / rounds.balanced)


def _yielding(made: Round) -> float:
    """What stresses of nonlinear blocks leave of balance."""
    return made.residuals[-1] if made.residuals else 0.0


def _left(rounds: Rounds, made: Round, there: Place) -> tuple[float, float]:
    """What the impulses of a round leave of balance where it leads, and how far velocities miss that.

    The first relative to the largest load or impulse, the second to the model's length.
    """
    forces = rounds.at(made.loading, there).forces
    left = turning(rounds.coupling, there, made.free, forces, rounds.scheme, made.impulse, made.place)
    way = there.contact.offset - rounds.start.contact.offset - rounds.scheme.step * made.velocity
    return left, float(np.abs(way).max(initial=0.0)) / rounds.model.length


def _lost(rounds: Rounds, made: Round) -> Turned:
    """A round that found nothing; the velocities of a mechanism are its own, whatever came before.

    Where only rounding was left of its error, or the loads are next to their limit, shorter steps would
    find no more.
    """
    there = rounds.start
    if not made.solution.outcome.moves:
        there = reached(rounds.coupling, rounds.start, made.bodies, rounds.scheme.step)
    final = made.solution.rounded or made.solution.outcome is Outcome.AT_LIMIT
    return Turned(made, there, strayed=not final)


@dataclass(frozen=True, slots=True)
class _Motion:
    """Motions that lead from the start of a step somewhere, or sums of such.

    Attributes
    ----------
    rigid : U of each group, (b, m). elastic : u_el, (b, n); None where blocks do not deform.
    """

    rigid: tuple[FloatArray, ...]
    elastic: tuple[FloatArray | None, ...]

    @classmethod
    def of(cls, rounds: Rounds, bodies: tuple[Any, ...]) -> Self:
        """Velocities in the states of all groups."""
        parts = [group.velocity_parts(own) for group, own in zip(rounds.model.groups, bodies, strict=True)]
        return cls(tuple(rigid for rigid, _ in parts), tuple(elastic for _, elastic in parts))

    @classmethod
    def combined(cls, weights: FloatArray, motions: Sequence[Self]) -> Self:
        """The sum of motions, each with its weight."""

        def summed(*parts: FloatArray) -> FloatArray:
            return sum((weight * part for weight, part in zip(weights, parts, strict=True)), np.zeros(()))

        rigid = tuple(summed(*parts) for parts in zip(*(one.rigid for one in motions), strict=True))
        elastic = zip(*(one.elastic for one in motions), strict=True)
        return cls(rigid, tuple(None if parts[0] is None else summed(*parts) for parts in elastic))


class _Places:
    """Where the rounds of a step were made and led to, and where the next is to be made.

    Parameters
    ----------
    rounds : The step.
    """

    def __init__(self, rounds: Rounds) -> None:
        self._rounds = rounds
        self._solved = [index for index, group in enumerate(rounds.model.groups) if not group.prescribed]
        self._to: list[_Motion] = []
        self._gone: list[FloatArray] = []  # how far each round led from its own place
        self._closed = np.zeros(0, dtype=bool)

    def following(self, made: Round, there: Place, *, nearer: bool) -> Place:
        """Where the next round is to be made.

        That is where the first one led, then the combination of places that is nearest to leading to itself.
        Secants begin anew with a round that came no nearer and closed other contacts than the one before.

        Parameters
        ----------
        made : The last round. there : Where it led. nearer : It left less of balance than all before.
        """
        to = _Motion.of(self._rounds, made.bodies)
        gone = self._unknowns(to.rigid)
        if made.place is not self._rounds.start:  # where statics is at rest
            gone = gone - self._unknowns(_Motion.of(self._rounds, made.place.bodies).rigid)
        closed = made.impulse.any(axis=1)
        alone = not self._to or not (nearer or np.array_equal(closed, self._closed))
        self._closed = closed
        self._to = [to] if alone else [*self._to[-DEPTH:], to]
        self._gone = [gone] if alone else [*self._gone[-DEPTH:], gone]
        return there if alone else self._reached(made, _Motion.combined(self._weights(), self._to))

    def _unknowns(self, rigid: tuple[FloatArray, ...]) -> FloatArray:
        """Rigid velocities of the blocks that are free, in a row."""
        return np.concatenate([rigid[index].ravel() for index in self._solved])

    def _weights(self) -> FloatArray:
        """Shares, of sum 1, of the rounds so far, by which the distances that they went cancel best."""
        gone = np.array(self._gone)
        shares = np.linalg.lstsq((gone[1:] - gone[:-1]).T, gone[-1], rcond=None)[0]
        weights = np.zeros(len(gone))
        weights[-1] = 1.0
        weights[1:] -= shares
        weights[:-1] += shares
        return weights

    def _reached(self, made: Round, motion: _Motion) -> Place:
        """The place that a motion leads to."""
        rounds = self._rounds
        whole = (
            replace(part, elastic=bent, origin=None, guess=None)
            for part, bent in zip(made.free, motion.elastic, strict=True)
        )
        bodies = tuple(
            group.advance(own, free, rigid, None, rounds.scheme)
            for group, own, free, rigid in zip(
                rounds.model.groups, rounds.state.bodies, whole, motion.rigid, strict=True
            )
        )
        return reached(rounds.coupling, rounds.start, bodies, rounds.scheme.step)
