"""Snapping: where a step of statics ends whose stones find no balance near its start.

snap = snapped(rounds, made)                       # None: none was found
snap.rounds, snap.made                             # a step that goes on from there, and its balanced round

Stone that softens may have no balance next to the last one: if a point cracks further, it gives way more than
its neighbours follow, and if it does not, it bears more than its strength. The structure snaps to another
balance, in which a crack has run. Newton's method goes in circles between the two cases, and shorter steps do
not help. So the two are separated: blocks balance with damage that stays as it is, by tangents that have no
slope downwards, and damage then grows by the strains there, and stays. Turn by turn cracks run until they
stop. A turn need not balance, nor its contacts be solved to the end, as the next one goes on from it.
Whenever stresses have come nearer to balance by half Newton's method is tried from there, which converges
once it is near.

References
----------
Bourdin, Francfort, Marigo, Numerical experiments in revisited brittle fracture, J. Mech. Phys. Solids 48
(2000), for alternate minimisation.
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

MOST = 1000  # turns
NEARER = 0.5  # of what stresses have left of balance at most since Newton's method was last tried
CLOSE = 1e-3  # error of contacts at most from which the next turn goes on; one of 1e-5 was met
STEPS = 30  # of it in the contacts' problem of a round: where they do not do, the balance is not near


@dataclass(frozen=True, slots=True)
class Snap:
    """A balance that cracks have led to.

    Attributes
    ----------
    rounds : Of the step, its material as cracked as it was before that balance was solved for.
    made : The round that balances.
    ends : States of all bodies from which it was solved for.
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
    """The balance to which a step snaps; None where there is one near its start, or none that cracks lead to.

    Parameters
    ----------
    rounds : A step of statics. made : Its last round, from the step's start on.
    """
    if not _may_snap(rounds, made):
        return None
    groups = rounds.model.groups
    ends = tuple(
        group.scale_velocity(body, 0.0) for group, body in zip(groups, rounds.state.bodies, strict=True)
    )
    brief = replace(rounds.settings, method="newton", max_iterations=STEPS, acceptable=0.0)
    lost: list[FloatArray | float] = [0.0] * len(ends)
    most = 0.0
    for turn in range(MOST):
        here = _from(rounds, ends)
        there = here.solved(here.start, None, _held(rounds, ends))
        solved = there.solution.solved
        if not solved and not there.solution.quality.error <= CLOSE:
            return None
        if solved and here.settled(there):
            return Snap(here, there, ends, lost)
        lost, ends = _lost(rounds, ends, there.bodies, lost), there.bodies
        left = there.residuals[-1]
        most = max(most, left)
        logger.info("t = %.6g, turn %d: cracks run", rounds.until, turn + 1)
        if left <= NEARER * most:
            still, most = _from(rounds, ends), left
            near = replace(still, settings=brief)
            there = settled_stresses(near, near.solved(still.start, None, ends))
            if there.solution.solved and still.settled(there):
                return Snap(still, there, ends, lost)
    return None


def _may_snap(rounds: Rounds, made: Round) -> bool:
    """Whether a round that is not settled is farthest from that in a stone that softens.

    By slopes downwards its contacts may have no solution, either: those of damage that stays then have one.
    """
    if rounds.settled(made) or made.solution.outcome.moves or rounds.model.control is not None:
        return False
    worst = rounds.worst(made)
    own = [nonlinear(group) for group in rounds.model.groups if group.nonlinear and worst in group.blocks]
    return own[0].softens


def _held(rounds: Rounds, ends: tuple[Any, ...]) -> tuple[Any, ...]:
    """Guesses whose tangents are those of damage that stays."""
    return tuple(
        nonlinear(group).holding(end) if group.nonlinear else end
        for group, end in zip(rounds.model.groups, ends, strict=True)
    )


def _from(rounds: Rounds, ends: tuple[Any, ...]) -> Rounds:
    """The step with its material as in ``ends``."""
    bodies = tuple(
        group.going_on(own, end)
        for group, own, end in zip(rounds.model.groups, rounds.state.bodies, ends, strict=True)
    )
    return replace(rounds, state=replace(rounds.state, bodies=bodies))


def _lost(
    rounds: Rounds, start: tuple[Any, ...], end: tuple[Any, ...], so_far: Sequence[FloatArray | float]
) -> list[FloatArray | float]:
    """Energy lost by the blocks of each group [J], that on the way from ``start`` to ``end`` added."""
    return [
        lost + (nonlinear(group).lost_between(one, other) if group.nonlinear else 0.0)
        for group, one, other, lost in zip(rounds.model.groups, start, end, so_far, strict=True)
    ]
