"""Snapping: where a step of statics ends whose stones find no balance near its start.

snap = snapped(rounds, made)                       # None: none was found
snap.rounds, snap.made                             # a step that goes on from there, and its balanced round

Stone that softens may have no balance next to the last one: if a point cracks further, it gives way more than
its neighbours follow, and if it does not, it bears more than its strength. The structure snaps to another
balance, in which a crack has run. Newton's method goes in circles between the two cases, and shorter steps do
not help. So blocks are given their mass and move from the last balance on, without gathering speed, in time
steps t that are as long as Newton's method converges:

    M (q⁺ − q)/t² + R(q⁺) = 0

R is that of the step, its loads those of the end, and what cracks on the way stays cracked. Once t is so long
that masses hold nothing back, the end is solved for as any other, by Newton's method without mass.

References
----------
Kelley, Keyes, Convergence analysis of pseudo-transient continuation, SIAM J. Numer. Anal. 35 (1998).
"""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from masonry_fem.bodies.base import FloatArray, nonlinear
from masonry_fem.march.rounds import Round, Rounds
from masonry_fem.march.state import SystemState
from masonry_fem.march.yielding import settled_stresses

logger = logging.getLogger(__name__)

MOST = 200  # rounds of motion, those that lead nowhere included
# a time step over the last one: if that was not found, and if so, by how many in a row were
LONGER = (0.25, 1.0, 2.0, 2.0, 4.0, 8.0, 16.0)
ENOUGH = 1e-6  # of balance: what stresses may leave on the way
NEAR = 0.1  # of balance: what its first round may leave; else motion leaps to where it does not lead
RESTING = 1e4  # of a wave's time through a stone: masses hold nothing back in a time step as long
SHORTEST = 1e-4  # of the same: no balance is found in a shorter one


@dataclass(frozen=True, slots=True)
class Snap:
    """A balance that motion has led to.

    Attributes
    ----------
    rounds : Of the step, its material as cracked as it was before that balance was solved for.
    made : The round that balances.
    ends : States of all bodies that motion has led to.
    lost : Energy lost on the way there by each group's blocks, (b,) [J].
    """

    rounds: Rounds
    made: Round
    ends: tuple[Any, ...]
    lost: Sequence[FloatArray | float]

    def ended(self, before: SystemState, after: SystemState) -> SystemState:
        """The state after the step, with what was lost on all of the way.

        Parameters
        ----------
        before : Where the step begins. after : Where it ends.
        """
        lost = _lost(self.rounds, self.ends, after.bodies, self.lost)
        bodies = tuple(
            nonlinear(group).joined(own, end, gone) if group.nonlinear else end
            for group, own, end, gone in zip(
                self.rounds.model.groups, before.bodies, after.bodies, lost, strict=True
            )
        )
        return replace(after, bodies=bodies)


def snapped(rounds: Rounds, made: Round) -> Snap | None:
    """The balance to which a step snaps; None where there is one near its start, or none that motion finds.

    Parameters
    ----------
    rounds : A step of statics. made : Its last round, from the step's start on.
    """
    model = rounds.model
    if rounds.settled(made) or not made.solution.solved or model.control is not None:
        return None
    worst = rounds.worst(made)
    own = [nonlinear(group) for group in model.groups if group.nonlinear and worst in group.blocks]
    if not own[0].softens:
        return None
    ends = tuple(
        group.scale_velocity(body, 0.0) for group, body in zip(model.groups, rounds.state.bodies, strict=True)
    )
    lost: list[FloatArray | float] = [0.0] * len(ends)
    time = wave = own[0].crossing
    row = 1
    for _ in range(MOST):
        moving = _from(rounds, ends, time)
        there = settled_stresses(moving, moving.solved(moving.start, None, ends), enough=ENOUGH, patience=0)
        found = there.solution.solved and there.residuals[-1] <= ENOUGH and there.residuals[0] <= NEAR
        logger.info(
            "t = %.6g: stones move on without speed, by %.1e s: %s",
            rounds.until, time, "in balance with their masses" if found else "no balance",
        )  # fmt: skip
        if found:
            lost = _lost(rounds, ends, there.bodies, lost)
            ends = there.bodies
        if found and time >= RESTING * wave:
            still = _from(rounds, ends, None)
            there = settled_stresses(still, still.solved(still.start, None, ends))
            if there.solution.solved and still.settled(there):
                return Snap(still, there, ends, lost)
            time, found = wave, False
        row = row + 1 if found else 0
        time *= LONGER[min(row, len(LONGER) - 1)]
        if time < SHORTEST * wave:
            break
    return None


def _from(rounds: Rounds, ends: tuple[Any, ...], time: float | None) -> Rounds:
    """The step with its material as in ``ends``, and masses that go on from there for a ``time`` [s].

    Without masses where that is None.
    """
    bodies = tuple(
        group.going_on(own, end)
        for group, own, end in zip(rounds.model.groups, rounds.state.bodies, ends, strict=True)
    )
    inertia = 0.0 if time is None else (rounds.scheme.step / time) ** 2
    scheme = replace(rounds.scheme, inertia=inertia)
    return replace(rounds, state=replace(rounds.state, bodies=bodies), scheme=scheme)


def _lost(
    rounds: Rounds, start: tuple[Any, ...], end: tuple[Any, ...], so_far: Sequence[FloatArray | float]
) -> list[FloatArray | float]:
    """Energy lost by the blocks of each group [J], that on the way from ``start`` to ``end`` added."""
    return [
        lost + (nonlinear(group).lost_between(one, other) if group.nonlinear else 0.0)
        for group, one, other, lost in zip(rounds.model.groups, start, end, so_far, strict=True)
    ]
