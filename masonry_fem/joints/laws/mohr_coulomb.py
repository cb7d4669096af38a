"""Mohr–Coulomb joint: τ = c + μ σ with a tension cut-off, brittle: c and tension are lost for good.

MohrCoulomb(cohesion=0.35e6, friction=0.75, tension_strength=0.25e6)
MohrCoulomb.of_angle(cohesion=0.35e6, angle=36.87)
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar, override

import numpy as np

from masonry_fem.joints.law import FloatArray, Parameter, check_non_negative, check_positive, spread
from masonry_fem.joints.laws.parts.rigid_brittle import RigidBrittle


@dataclass(frozen=True, slots=True, eq=False)
class MohrCoulomb(RigidBrittle):
    """Cohesion and friction with brittle rupture by slide, by opening or by the tension cut-off.

    Attributes
    ----------
    cohesion : c [Pa]. friction : μ = tan φ > 0; the cone's tip lies at the tension c/μ.
    tension_strength : Tensile strength [Pa]; None, or more than c/μ: c/μ.
    residual_friction : Coulomb's coefficient once broken; None: μ.
    critical_slip, critical_opening : Slide and opening that break the joint [m].
    """

    cohesion: Parameter
    friction: Parameter
    tension_strength: Parameter | None = None
    residual_friction: Parameter | None = None
    critical_slip: Parameter = 0.0
    critical_opening: Parameter = 0.0

    name: ClassVar[str] = "mohr_coulomb"

    def __post_init__(self) -> None:
        check_positive(self, "friction")
        check_non_negative(self, "cohesion", "critical_slip", "critical_opening")
        for optional in ("tension_strength", "residual_friction"):
            if getattr(self, optional) is not None:
                check_non_negative(self, optional)

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
            apex if self.tension_strength is None else np.minimum(spread(self.tension_strength, count), apex)
        )

    @override
    def frictions(self, count: int) -> tuple[FloatArray, FloatArray]:
        friction = spread(self.friction, count)
        residual = friction if self.residual_friction is None else spread(self.residual_friction, count)
        return friction, residual
