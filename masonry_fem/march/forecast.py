"""Forecast: where a step of statics leads if it goes on as the last one did.

Statics is often a load that grows in equal steps. What the last step did is then nearly what the next one
does, and its first round is made there. Whether a forecast is better than the start of the step is told by
what its impulses leave of balance there; where loads stay and supports alone move that says nothing, and
supports that go on as they did lead on. What it leads to is told by the rounds.

forecast = foreseen(rounds)          # None: the start of the step is a better guess
"""

from __future__ import annotations

from typing import Any

import numpy as np

from masonry_fem.bodies.base import FloatArray, Free
from masonry_fem.march.place import Forecast, reached
from masonry_fem.march.rounds import NEAR, Rounds
from masonry_fem.march.state import TrendState

# Of what the impulses of the last step leave of balance: what those of a forecast may leave. Of how far
# supports went in it: by what they may go otherwise now.
BETTER = 0.5


def foreseen(rounds: Rounds) -> Forecast | None:
    """Where a step leads if it goes on as the last one did; None where it does not seem to.

    Parameters
    ----------
    rounds : A step of statics. Impulses between its blocks are unique.
    """
    state, h = rounds.state, rounds.scheme.step
    trend = state.trend
    if trend is None or rounds.softens or state.rigid_velocity is None:
        return None
    loading = rounds.loaded(rounds.until)
    now = h * state.reaction
    impulse = now + h * h * trend.growth
    if not _led_by_supports(rounds, loading.forces, trend):
        before, ahead = (_missing(rounds, loading.forces, some) for some in (now, impulse))
        if ahead > BETTER * before:
            return None
    bodies = _moved_on(rounds, loading.forces, trend)
    place = reached(rounds.coupling, rounds.start, bodies, h)
    if not rounds.nonlinear:
        return Forecast(impulse, place)
    nodal = rounds.coupling.nodal_impulses(impulse, place.contact)
    left = max(rounds.unbalanced(bodies, impulse, nodal, place, loading))[0]
    return Forecast(impulse, place, left <= NEAR)


def _missing(rounds: Rounds, forces: tuple[FloatArray, ...], impulse: FloatArray) -> float:
    """What impulses miss of the balance of all blocks where the step begins [N s]."""
    pushes = rounds.coupling.rigid_impulses(impulse, rounds.start.rigid_map)
    rows = zip(rounds.model.groups, rounds.start.bodies, forces, pushes, strict=True)
    left = [
        np.sqrt(group.mass)[:, None] * (push + rounds.scheme.step * group.generalised(own, force))
        for group, own, force, push in rows
        if not group.prescribed
    ]
    return float(np.linalg.norm(np.concatenate(left)))


def _led_by_supports(rounds: Rounds, forces: tuple[FloatArray, ...], trend: TrendState) -> bool:
    """Whether loads stay as they are, and supports go on as they did."""
    held = rounds.loaded(rounds.state.time).forces
    if not all(np.array_equal(one, other) for one, other in zip(held, forces, strict=True)):
        return False
    gone = off = 0.0
    for group, own, force, last in zip(
        rounds.model.groups, rounds.state.bodies, forces, trend.rigid, strict=True
    ):
        if group.prescribed:
            free = group.free(own, own, force, rounds.scheme)
            now = group.advance(own, free, free.rigid_velocity, None, rounds.scheme)
            gone += float(np.linalg.norm(last))
            off += float(np.linalg.norm(group.velocity_parts(now)[0] - last))
    return gone > 0 and off <= BETTER * gone


def _moved_on(rounds: Rounds, forces: tuple[FloatArray, ...], trend: TrendState) -> tuple[Any, ...]:
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
