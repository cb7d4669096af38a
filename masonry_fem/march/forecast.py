"""Forecast: where a step of statics leads if it goes on as the last one did.

Statics is often a load that grows in equal steps. What the last step did is then nearly what the next one
does, and its first round is made there. Whether a forecast is better than the start of the step is told by
what its impulses leave of balance there; what it leads to is told by the rounds.

forecast = foreseen(rounds)          # None: the start of the step is a better guess
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from masonry_fem.bodies.base import FloatArray, Free
from masonry_fem.march.place import Forecast, reached
from masonry_fem.march.state import Trend

if TYPE_CHECKING:
    from masonry_fem.march.rounds import Rounds

NEAR = 1e-3
BETTER = 0.5  # of what the impulses of the last step leave of balance: what those of a forecast may leave


def foreseen(rounds: Rounds) -> Forecast | None:
    """Where a step leads if it goes on as the last one did; None where it does not seem to.

    Parameters
    ----------
    rounds : A step of statics. Impulses between its blocks are unique.
    """
    state, h = rounds.state, rounds.scheme.step
    trend = state.trend
    # which of two balances stone that softens takes depends on where rounds begin
    softens = any(group.softens for group in rounds.model.groups if group.nonlinear)
    if trend is None or softens or state.rigid_velocity is None:
        return None
    forces = rounds.loaded(rounds.until).forces
    now = h * state.reaction
    impulse = now + h * h * trend.growth
    if _missing(rounds, forces, impulse) > BETTER * _missing(rounds, forces, now):
        return None
    bodies = _moved_on(rounds, forces, trend)
    place, loading = reached(rounds.coupling, rounds.start, bodies, h), rounds.loaded(rounds.until)
    nodal = rounds.coupling.nodal_impulses(impulse, place.contact)
    left = [part for part, _ in rounds.unbalanced(bodies, impulse, nodal, place, loading)]
    return Forecast(impulse, place, max(left, default=0.0) <= NEAR)


def _missing(rounds: Rounds, forces: tuple[FloatArray, ...], impulse: FloatArray) -> float:
    """What impulses miss of the balance of all blocks where the step begins [N s]."""
    pushes = rounds.coupling.rigid_impulses(impulse, rounds.start.rigid_map)
    rows = zip(rounds.model.groups, rounds.start.bodies, forces, pushes, strict=True)
    squares = [
        float((group.mass * ((push + rounds.scheme.step * group.generalised(own, force)) ** 2).sum(axis=1)).sum())
        for group, own, force, push in rows
        if not group.prescribed
    ]
    return float(np.sqrt(sum(squares)))


def _moved_on(rounds: Rounds, forces: tuple[FloatArray, ...], trend: Trend) -> tuple[Any, ...]:
    """States at the end of the step, supports where they are to be."""
    scheme, found = rounds.scheme, []
    rows = zip(rounds.model.groups, rounds.state.bodies, forces, trend.rigid, trend.elastic, strict=True)
    for group, own, force, rigid, elastic in rows:
        if group.prescribed:
            free = group.free(own, own, force, scheme)
            found.append(group.advance(own, free, free.rigid_velocity, None, scheme))
        else:
            found.append(group.advance(own, Free(rigid, rigid, rigid, elastic), rigid, None, scheme))
    return tuple(found)
