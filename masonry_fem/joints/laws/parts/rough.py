"""Rough: sliding that opens the joint (dilatancy), on any joint law.

    u_N ≥ d(‖u_T‖),    d(s) = bound (1 − exp(−tan ψ · s/bound))

The asperities are geometry: sliding back closes what sliding opened (contractance), and pressure gets
its work back. What friction burns is μ r̃_N s less the work against pressure, hence tan ψ ≤ μ. Cohesion
acts on u itself: it is stretched where the faces ride up, and asperities that do not touch do nothing to it.

    Rough(MohrCoulomb(cohesion=0.35e6, friction=0.75), dilatancy=0.1, bound=1e-3)
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar, override

import numpy as np

from masonry_fem.errors import LawError
from masonry_fem.joints.law import Layer, pressure
from masonry_fem.joints.parameters import Factor, FloatArray, Length, check_ranges
from masonry_fem.joints.reduction import Reduction
from masonry_fem.joints.state import JointState
from masonry_fem.nscd.graphs import tangential_norm


@dataclass(frozen=True, slots=True, eq=False)
class Rough(Layer):
    """Bounded dilatancy.

    Attributes
    ----------
    dilatancy : tan ψ at the start of sliding, at most the law's friction.
    bound : Opening after much sliding [m].
    """

    dilatancy: Factor
    bound: Length

    name: ClassVar[str] = "rough"

    def __post_init__(self) -> None:
        check_ranges(self)
        friction = self._least_friction()
        steep = np.asarray(self.dilatancy) > friction
        if steep.any():
            raise LawError(
                f"law '{self.name}': dilatancy is {np.max(self.dilatancy):g}, expected at most the friction "
                f"{np.min(friction):g}; sliding would create energy"
            )

    def _least_friction(self) -> FloatArray:
        """The smallest coefficient that the law may have, intact or broken, at rest or sliding."""
        if getattr(self.law, "friction_mode", "constant") == "damage":
            return np.zeros(1)  # of a sound joint
        given = [getattr(self.law, f"{kind}friction", None) for kind in ("", "dynamic_", "residual_")]
        least = np.full(1, np.inf)
        for friction in given:
            if friction is not None:
                least = np.minimum(least, np.asarray(friction, dtype=float))
        return least

    def _raise(self, jump: FloatArray) -> FloatArray:
        """Opening d of a jump, shape (c,)."""
        return -np.asarray(self.bound) * np.expm1(
            -np.asarray(self.dilatancy) * tangential_norm(jump) / self.bound
        )

    @override
    def reduce(self, state: JointState, jump: FloatArray, area: FloatArray, step: float) -> Reduction:
        inner = self.law.reduce(state, jump, area, step)
        lift = (state.dilation - state.raised) / step
        shift = inner.shift.copy()
        shift[:, 0] -= lift
        # v_c is that of the faces less the lift; cohesion goes with the faces
        offset = inner.offset + inner.stiffness[:, :, 0] * lift[:, None]
        return replace(inner, offset=offset, shift=shift, closure=inner.closure + state.raised)

    @override
    def update(
        self, state: JointState, trial: JointState, jump: FloatArray, reaction: FloatArray,
        velocity: FloatArray, area: FloatArray, step: float,
    ) -> JointState:  # fmt: skip
        dilation = self._raise(jump + step * velocity)
        after = self.law.update(state, trial, jump, reaction, velocity, area, step)
        lifted = pressure(reaction, self.law.adhesive_reaction(after, area)) * (dilation - state.dilation)
        return replace(after, dilation=dilation, raised=state.dilation, rubbed=after.rubbed - lifted)
