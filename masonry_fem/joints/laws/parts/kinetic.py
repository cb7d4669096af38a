"""Kinetic: any joint law, the dry one too, with what faces do that move: slide more easily, and rebound.

    Kinetic(Bilinear(..., friction=0.75), dynamic_friction=0.6)
    Kinetic(Dry(0.75), restitution=0.2)

A contact that slid in the step before has μ_d/μ_s of the friction that the law gives it. While a rigid
joint holds (``RigidBrittle``) its friction is the slope of what it resists, cohesion included; there μ_d
counts from rupture on.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar, override

import numpy as np

from masonry_fem.errors import LawError
from masonry_fem.joints.law import Layer, rub, spread
from masonry_fem.joints.laws.parts.rigid_brittle import RigidBrittle
from masonry_fem.joints.parameters import Factor, FloatArray, Friction, Parameter, check_ranges
from masonry_fem.joints.reduction import Reduction
from masonry_fem.joints.state import JointState


@dataclass(frozen=True, slots=True, eq=False)
class Kinetic(Layer):
    """Dynamic friction and restitution; the friction of ``law`` is the static one.

    Attributes
    ----------
    dynamic_friction : Coulomb's coefficient μ_d of a contact that slid in the step before; None: the law's.
    restitution : Newton's coefficient of the normal velocity, 0 to stop; contact is then written in
        velocities. None: it is written in gaps.
    tangential_restitution : The same of the tangential velocity; counts where there is a restitution.
    """

    dynamic_friction: Friction | None = None
    restitution: Factor | None = None
    tangential_restitution: Factor = 0.0

    name: ClassVar[str] = "kinetic"
    plain: ClassVar[bool] = True

    def __post_init__(self) -> None:
        check_ranges(self)
        if self.dynamic_friction is None:
            return
        if getattr(self.law, "friction", None) is None:
            raise LawError(f"law '{self.law.name}' has no friction, expected one beside a dynamic friction")
        if ((self._static() == 0) & (np.asarray(self.dynamic_friction) > 0)).any():
            raise LawError(
                f"law '{self.name}': dynamic_friction is {np.max(self.dynamic_friction):g} beside a friction "
                "of 0, expected a static friction > 0; give it or leave the dynamic one out"
            )

    @override
    def rebound(self, count: int) -> FloatArray | None:
        if self.restitution is None:
            return None
        return np.stack([spread(self.restitution, count), spread(self.tangential_restitution, count)], axis=1)

    @property
    def friction(self) -> Parameter:
        """The law's coefficient at rest."""
        friction: Parameter = self.law.friction  # type: ignore[attr-defined] # checked above
        return friction

    @property
    def residual_friction(self) -> Parameter | None:
        """That of a broken joint at rest, where the law tells them apart."""
        return getattr(self.law, "residual_friction", None)

    @property
    def friction_mode(self) -> str:
        """How the law's friction hangs on its adhesion."""
        return str(getattr(self.law, "friction_mode", "constant"))

    def _static(self) -> FloatArray:
        """Friction of a joint at rest, broken."""
        residual = self.residual_friction
        return np.asarray(self.friction if residual is None else residual, dtype=float)

    def _slowed(self, state: JointState, friction: FloatArray) -> FloatArray:
        """What is left of the law's friction, shape (c,)."""
        if self.dynamic_friction is None:
            return friction
        static, dynamic = spread(self._static(), state.count), spread(self.dynamic_friction, state.count)
        share = np.divide(dynamic, static, out=np.ones(state.count), where=static > 0)
        loose = state.broken if isinstance(self.law, RigidBrittle) else np.ones(state.count, dtype=bool)
        slowed: FloatArray = friction * np.where(state.sliding & loose, share, 1.0)
        return slowed

    @override
    def reduce(self, state: JointState, jump: FloatArray, area: FloatArray, step: float) -> Reduction:
        reduction = self.law.reduce(state, jump, area, step)
        return replace(reduction, friction=self._slowed(state, reduction.friction))

    @override
    def update(
        self, state: JointState, trial: JointState, jump: FloatArray, reaction: FloatArray,
        velocity: FloatArray, area: FloatArray, step: float,
    ) -> JointState:  # fmt: skip
        after = self.law.update(state, trial, jump, reaction, velocity, area, step)
        if self.dynamic_friction is None:
            return after
        friction = self.reduce(after, jump, area, step).friction
        return rub(self, state, after, friction, reaction, velocity, area, step)
