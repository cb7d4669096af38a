"""Yielding: rounds of Newton's method in a step whose stones are not linear.

made = settled_stresses(rounds, rounds.solved(rounds.start, None))
rounds.settled(made)                               # whether the stresses of all stones balance
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from masonry_fem.bodies.base import FloatArray, nonlinear
from masonry_fem.march.place import Place
from masonry_fem.march.rounds import NEWTON_TOLERANCE, SHARE, Loading, Round, Rounds

SUFFICIENT, SHARES = 0.9, (0.5, 0.25, 0.125, 0.0625)  # of a line search: less of the residual is left
MOST, PATIENCE = 40, 8  # rounds in all, and rounds that bring stresses no nearer to balance
# The same where contacts were solved roughly: stone that flows goes far for small errors of impulses, so that
# exact contacts take fewer rounds; and where there is no balance, fewer are lost.
ROUGH_PATIENCE = 1


@dataclass(frozen=True, slots=True)
class _Guess:
    """What nonlinear blocks are linearised at, and what their stresses leave of balance there.

    Attributes
    ----------
    place : Of the contacts. bodies : States. impulse : Of all contacts, (c, d) [N s]. left : Relative.
    loading : What acts.
    """

    place: Place
    bodies: tuple[Any, ...]
    impulse: FloatArray
    left: float
    loading: Loading

    @classmethod
    def of(cls, made: Round) -> Self:
        """The end of a round."""
        return cls(made.place, made.bodies, made.impulse, made.residuals[-1], made.loading)


def settled_stresses(
    rounds: Rounds,
    made: Round,
    error: float = 0.0,
    *,
    patience: int = PATIENCE,
    enough: float = NEWTON_TOLERANCE,
) -> Round:
    """Rounds until the stresses of all nonlinear blocks balance, or come no nearer.

    Each is linearised where the last one led, or part of the way there if that is nearer to balance:
    points that yield in one round and not in the next would make rounds go in circles.

    Parameters
    ----------
    rounds : The step. made : Its first round.
    error : That the contacts of the first round were solved to, where that is more than the tolerance; those
        of the others are to ``SHARE`` of what the last one left, as long as that is less.
    patience : Rounds that may bring stresses no nearer to balance.
    enough : What they leave of it where rounds end. Where they leave no more than ``balanced``, rounds end
        with the first one that brings them no nearer, too.
    """
    at: _Guess | None = None
    least, idle = np.inf, 0
    while made.solution.solved and len(made.residuals) < MOST:
        left = made.residuals[-1]
        idle, least = 0 if left <= 0.5 * least else idle + 1, min(left, least)
        if left <= enough or idle > (0 if left <= rounds.balanced else patience):
            break
        end = _Guess.of(made)
        at = end if at is None else _nearest(rounds, at, end)
        error = min(error, SHARE * left)
        made = rounds.roughly(error).solved(made.place, made, at.bodies)
    return made


def _nearest(rounds: Rounds, start: _Guess, end: _Guess) -> _Guess:
    """The end of a round, or the point on the way there whose stresses leave least of balance."""
    if end.left <= SUFFICIENT * start.left:
        return end
    best = end
    for share in SHARES:
        tried = _between(rounds, start, end, share)
        if tried.left >= best.left and best is not end:
            break  # it gets worse again
        if tried.left < best.left:
            best = tried
        if best.left <= SUFFICIENT * start.left:
            break
    return best


def _between(rounds: Rounds, start: _Guess, end: _Guess, share: float) -> _Guess:
    """A ``share`` of the way from one guess to another, its material by the law."""
    impulse = start.impulse + share * (end.impulse - start.impulse)
    bodies = tuple(
        nonlinear(group).between(own, one, other, share, rounds.scheme) if group.nonlinear else other
        for group, own, one, other in zip(
            rounds.model.groups, rounds.state.bodies, start.bodies, end.bodies, strict=True
        )
    )
    nodal = rounds.coupling.nodal_impulses(impulse, end.place.contact)
    loading = end.loading
    if start.loading is not loading:
        between = start.loading.end + share * (loading.end - start.loading.end)
        loading = rounds.at(rounds.loaded(between), end.place)
    left = max(rounds.unbalanced(bodies, impulse, nodal, end.place, loading))[0]
    return _Guess(end.place, bodies, impulse, left, loading)
