"""Mohr–Coulomb joint: τ = c + μ σ with a tension cut-off, brittle: c and tension are lost for good.

MohrCoulomb(cohesion=0.35e6, friction=0.75, tensile_strength=0.25e6)
MohrCoulomb.of_angle(cohesion=0.35e6, angle=36.87)
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, override

import numpy as np
from msgspec import Meta

from masonry_fem.joints.law import spread
from masonry_fem.joints.laws.parts.rigid_brittle import RigidBrittle
from masonry_fem.joints.parameters import Cohesion, Distance, FloatArray, Friction, Parameter, Strength


@dataclass(frozen=True, slots=True, eq=False)
class MohrCoulomb(RigidBrittle):
    """Cohesion and friction with a tension cut-off; breaks for good by slide or by opening.

    Attributes
    ----------
    cohesion : shear strength c without pressure; the tip of the cone is at the tension c/μ
    tensile_strength : tensile strength f_t, a cut-off; c/μ if left out or if that is less
    residual_friction : friction μ_r once broken; the joint's friction if left out

    Examples
    --------
    kind = "mohr_coulomb"
    cohesion = 0.2e6
    """

    cohesion: Cohesion
    friction: Annotated[Parameter, Meta(gt=0)]
    tensile_strength: Strength | None = None
    residual_friction: Friction | None = None
    critical_slip: Distance = 0.0
    critical_opening: Distance = 0.0

    name: ClassVar[str] = "mohr_coulomb"
    cone: ClassVar[bool] = True

    @classmethod
    def of_angle(cls, cohesion: Parameter, angle: float, **others: Any) -> MohrCoulomb:
        """The law of a friction angle [degrees]."""
        return cls(cohesion=cohesion, friction=math.tan(math.radians(angle)), **others)

    @override
    def apex(self, count: int) -> FloatArray:
        return spread(self.cohesion, count) / spread(self.friction, count)

    @override
    def tension(self, count: int) -> FloatArray:
        apex = self.apex(count)
        return (
            apex if self.tensile_strength is None else np.minimum(spread(self.tensile_strength, count), apex)
        )

    @override
    def frictions(self, count: int) -> tuple[FloatArray, FloatArray]:
        friction = spread(self.friction, count)
        residual = friction if self.residual_friction is None else spread(self.residual_friction, count)
        return friction, residual
