"""Constant threshold (seuil de résistance constant): r_adh,N = r_c until broken (slides 4.3).

Shear strength is μ (r_N + r_c), that is Mohr–Coulomb's with cohesion μ r_c.

    ConstantThreshold(strength=0.25e6, friction=0.6)
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, override

from masonry_fem.joints.law import FloatArray, Parameter, check_non_negative, spread
from masonry_fem.joints.laws.parts.rigid_brittle import RigidBrittle


@dataclass(frozen=True, slots=True, eq=False)
class ConstantThreshold(RigidBrittle):
    """Brittle adhesion of constant strength.

    Attributes
    ----------
    strength : Tensile strength r_c [Pa].
    friction : Coulomb's coefficient μ, intact and broken.
    critical_slip, critical_opening : Slide and opening at the strength that break the joint [m]; more
        than 0 for a joint that yields before it breaks.
    """

    strength: Parameter
    friction: Parameter = 0.6
    critical_slip: Parameter = 0.0
    critical_opening: Parameter = 0.0

    name: ClassVar[str] = "constant_threshold"

    def __post_init__(self) -> None:
        check_non_negative(self, "strength", "friction", "critical_slip", "critical_opening")

    @override
    def apex(self, count: int) -> FloatArray:
        return spread(self.strength, count)

    @override
    def tension(self, count: int) -> FloatArray:
        return spread(self.strength, count)

    @override
    def frictions(self, count: int) -> tuple[FloatArray, FloatArray]:
        friction = spread(self.friction, count)
        return friction, friction
