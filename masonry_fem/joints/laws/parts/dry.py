"""Dry joint (joint vif): Signorini's and Coulomb's graphs alone, r_adh = 0.

    Dry(friction=0.6)

A friction of its own for contacts that slide, and what impacts give back, are those of ``Kinetic``.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, override

import numpy as np

from masonry_fem.joints.law import Law, rub, spread
from masonry_fem.joints.parameters import FloatArray, Friction
from masonry_fem.joints.reduction import Reduction
from masonry_fem.joints.state import JointState


@dataclass(frozen=True, slots=True, eq=False)
class Dry(Law):
    """Unilateral contact with friction.

    Attributes
    ----------
    friction : Coulomb's coefficient μ.
    """

    friction: Friction = 0.6

    name: ClassVar[str] = "dry"
    plain: ClassVar[bool] = True

    @override
    def initial(self, count: int, dimension: int) -> JointState:
        return JointState.dry(count, dimension)

    @override
    def reduce(self, state: JointState, jump: FloatArray, area: FloatArray, step: float) -> Reduction:
        return Reduction.dry(spread(self.friction, state.count), state.dimension)

    @override
    def update(
        self, state: JointState, trial: JointState, jump: FloatArray, reaction: FloatArray,
        velocity: FloatArray, area: FloatArray, step: float,
    ) -> JointState:  # fmt: skip
        friction, moved = spread(self.friction, state.count), jump + step * velocity
        return rub(self, state, state, friction, reaction, velocity, area, step, jump=moved)

    @override
    def adhesive_reaction(self, state: JointState, area: FloatArray) -> FloatArray:
        return np.zeros(state.jump.shape)

    @override
    def stored(self, state: JointState, area: FloatArray) -> FloatArray:
        return np.zeros(state.count)
