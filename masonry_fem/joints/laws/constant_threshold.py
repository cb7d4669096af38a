"""Constant threshold (seuil de résistance constant): r_adh,N = r_c until broken.

Shear strength is μ (r_N + r_c), that is Mohr–Coulomb's with cohesion μ r_c.

    ConstantThreshold(strength=0.25e6, friction=0.6)
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, override

from masonry_fem.joints.law import spread
from masonry_fem.joints.laws.parts.rigid_brittle import RigidBrittle
from masonry_fem.joints.parameters import Distance, FloatArray, Friction, Strength


@dataclass(frozen=True, slots=True, eq=False)
class ConstantThreshold(RigidBrittle):
    """Adhesion of constant strength until it breaks, then none.

    Attributes
    ----------
    strength : tensile strength r_c

    Examples
    --------
    kind = "constant_threshold"
    strength = 0.2e6
    """

    strength: Strength
    friction: Friction = 0.6
    critical_slip: Distance = 0.0
    critical_opening: Distance = 0.0

    name: ClassVar[str] = "constant_threshold"

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
