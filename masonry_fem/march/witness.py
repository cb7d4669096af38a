"""Witness: sees every step of a march, and keeps the worst of what its written results leave open.

witness = Witness(model, bodies)
witness.see(model, made.after)           # each step, with what acts on the blocks
witness.end(model, state)                # looks once more at what has moved a little
witness.told                             # for the certificate
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from masonry_fem.bodies.base import FloatArray
from masonry_fem.march.acting import contact_wrenches, imbalance, relative
from masonry_fem.march.deformation import second_order
from masonry_fem.march.lookout import OVERLAP, Lookout
from masonry_fem.march.model import Model
from masonry_fem.march.standing import Seen, Worst
from masonry_fem.march.state import SystemState


@dataclass(frozen=True, slots=True)
class Written:
    """What the written results leave open, the worst over all steps, as ``Witness`` explains it.

    Attributes
    ----------
    balance : Of a block's balance, relative to its load.
    turning : The same for elastic blocks with points of attack where these have gone to.
    overlap : How far two blocks are in each other [m].
    """

    balance: Worst
    turning: Worst
    overlap: Worst


class Witness:
    """Worst figures of the written results over a march.

    Parameters
    ----------
    model : Of the start. bodies : Its states.

    Attributes
    ----------
    balance : What forces and moments leave, relative to a block's load.
    turning : The same about the points that elastic blocks of small kinematics have gone to: they balance in
        the reference.
    overlap : Deepest overlap of two blocks [m] beyond that of the start and what beds give way; its share is
        of the smaller block's least extent, less what small kinematics does not know of places.
    """

    def __init__(self, model: Model, bodies: tuple[Any, ...]) -> None:
        self._names = model.assembly.blocks.names
        self.balance, self.turning, self.overlap = Worst(), Worst(), Worst()
        self._last = Worst()
        self.lookout = Lookout(model, bodies)

    @property
    def told(self) -> Written:
        """The figures for the certificate."""
        return Written(self.balance, self.turning, self.overlap)

    @property
    def seen(self) -> Seen:
        """All that is kept, for a witness that goes on from here."""
        figures = self.balance, self.turning, self.overlap, self._last
        return Seen(*figures, self.lookout.looked, self.lookout.borne)

    def go_on(self, seen: Seen) -> None:
        """Keep what another witness of the same march has seen."""
        self.balance, self.turning, self.overlap, self._last = (
            seen.balance, seen.turning, seen.overlap, seen.last,
        )  # fmt: skip
        self.lookout.go_on(seen.looked, seen.borne)

    def objection(self, bound: float, drift: float, *, static: bool) -> str:
        """Why a state is no equilibrium whatever its equations say; empty where nothing speaks against it.

        ``bound`` is on the balance, of all steps of statics, of the last one of dynamics. ``drift`` is how
        far speeds below the solver's tolerance may carry blocks in a step [m].
        """
        left = self.balance if static else self._last
        if left.value > bound:
            name, step = left.blocks[0], left.step
            return (
                f"in step {step} block '{name}' is out of balance by {left.value:.2g} of its load, "
                "computed from the written forces"
            )
        if self.overlap.share <= OVERLAP or drift >= self.overlap.value:
            return ""
        first, second = self.overlap.blocks
        return f"'{first}' and '{second}' overlap by {self.overlap.value:.3g} m (step {self.overlap.step})"

    def see(self, model: Model, state: SystemState) -> None:
        """Judge the state that a step reached."""
        acting = state.acting
        assert acting is not None
        largest = float(np.abs(state.reaction).max(initial=0.0))
        left = relative(imbalance(acting.contact + acting.given, acting.centre), acting, largest)
        self._last = self._worse(Worst(), left, state.index)
        self.balance = self._worse(self.balance, left, state.index)
        if acting.small.any():
            arms = np.repeat(state.points[:, None], 2, axis=1)
            moved = contact_wrenches(model.contacts.blocks, arms, state.force, len(left)) + acting.given
            d = arms.shape[2]
            moved[:, d:] += acting.displaced - (acting.load + acting.clamp)[:, d:]
            turned = relative(imbalance(moved, acting.centre), acting, largest)
            self.turning = self._worse(self.turning, np.where(acting.small, turned, 0.0), state.index)
        self._overlaps(model, state)

    def end(self, model: Model, state: SystemState) -> None:
        """Look at the last state, too, where anything has moved since the last look."""
        self.lookout.last_look(state.bodies)
        self._overlaps(model, state)

    def _overlaps(self, model: Model, state: SystemState) -> None:
        found = self.lookout.found
        if found is None or len(found.depth) == 0:
            return
        beyond = found.depth - self.lookout.known(model, state, found.pairs)
        share = beyond / self.lookout.sizes(found.pairs) - second_order(model, state.bodies)
        at = int(share.argmax())
        if share[at] > self.overlap.share:
            names = tuple(self._names[block] for block in found.pairs[at])
            self.overlap = Worst(float(beyond[at]), names, state.index, float(share[at]))

    def _worse(self, known: Worst, values: FloatArray, step: int) -> Worst:
        block = int(values.argmax()) if len(values) else 0
        if not len(values) or values[block] <= known.share:
            return known
        value = float(values[block])
        return Worst(value, (self._names[block],), step, value)
