"""Witness: sees every step of a march, and keeps the worst of what its written results leave open.

witness = Witness(model)
made = witness.see(model, made)          # each step; its state has what acts on the blocks
witness.told                             # for the certificate
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from masonry_fem.bodies.base import FloatArray
from masonry_fem.dynamics.acting import acting_on, imbalance, relative
from masonry_fem.dynamics.model import Model
from masonry_fem.dynamics.step import Increment


@dataclass(frozen=True, slots=True)
class Worst:
    """The worst value of a figure, of which blocks, and in which step."""

    value: float = 0.0
    blocks: tuple[str, ...] = ()
    step: int = 0

    def told(self) -> dict[str, Any]:
        """For ``summary.json``."""
        return {"value": self.value, "blocks": list(self.blocks), "step": self.step}


class Witness:
    """Worst figures of the written results over a march.

    Parameters
    ----------
    model : Of the start.

    Attributes
    ----------
    balance : What forces and moments leave, relative to a block's load.
    turning : The same about the points that elastic blocks have gone to: they balance in the reference.
    """

    def __init__(self, model: Model) -> None:
        assembly = model.assembly
        extent = np.array(
            [float(np.linalg.norm(np.ptp(shape.solid.vertices, axis=0))) for shape in assembly.shapes]
        )
        self._size: FloatArray = extent[[block.shape for block in assembly.blocks]]
        self._names = [block.name for block in assembly.blocks]
        self.balance, self.turning = Worst(), Worst()

    @property
    def told(self) -> dict[str, Any]:
        """The figures for the certificate."""
        return {"balance": self.balance.told(), "turning": self.turning.told()}

    def see(self, model: Model, made: Increment) -> Increment:
        """Judge a step; the same with what acts on the blocks in its state."""
        acting, state = acting_on(model, made, self._size), made.after
        force = np.einsum("cij,ci->cj", state.reaction_frame, state.reaction)
        blocks, d = model.contacts.blocks, force.shape[1]
        left = relative(imbalance(blocks, acting.arms, force, acting.given, acting.centre), acting, force)
        self.balance = self._worse(self.balance, left, state.index)
        if acting.elastic.any():
            moved = acting.given.copy()
            moved[:, d:] = acting.displaced - acting.inertia[:, d:]
            arms = np.repeat(state.points[:, None], 2, axis=1)
            turned = relative(imbalance(blocks, arms, force, moved, acting.centre), acting, force)
            self.turning = self._worse(self.turning, np.where(acting.elastic, turned, 0.0), state.index)
        return replace(made, after=replace(state, acting=acting))

    def _worse(self, known: Worst, values: FloatArray, step: int) -> Worst:
        block = int(values.argmax()) if len(values) else 0
        if not len(values) or values[block] <= known.value:
            return known
        return Worst(float(values[block]), (self._names[block],), step)
