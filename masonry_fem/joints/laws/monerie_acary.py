"""Monerie–Acary joint: stress falls on a parabola, flat at the strength.

    MonerieAcary(normal_stiffness=82e9, tangential_stiffness=36e9, normal_strength=0.25e6,
                 tangential_strength=0.35e6, normal_energy=18.0, tangential_energy=125.0)

In one mode β = (δ_c/δ)(1 − ((δ − δ_c)/δ_t)²) with δ_c = s/c and δ_t = 3/2 (G/s − δ_c/2).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, override

import numpy as np

from masonry_fem.joints.laws.parts.softening import Softening
from masonry_fem.joints.parameters import FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class MonerieAcary(Softening):
    """Springs up to separate strengths, then a parabolic loss of stress (Monerie and Acary).

    β λ = 1 − ((λ − 1)/τ)² with τ = 3/4 (γ − 1).

    Examples
    --------
    kind = "monerie_acary"
    normal_stiffness = 2e10
    tangential_stiffness = 1e10
    normal_strength = 0.25e6
    tangential_strength = 0.35e6
    normal_energy = 18.0
    tangential_energy = 60.0
    """

    name: ClassVar[str] = "monerie_acary"

    @override
    def shape(self, stretch: FloatArray, ductility: FloatArray) -> FloatArray:
        fallen = (stretch - 1.0) / (0.75 * (ductility - 1.0))
        return np.maximum(1.0 - fallen**2, 0.0) / stretch

    @override
    def reached(self, adhesion: FloatArray, ductility: FloatArray) -> FloatArray:
        # x² + β τ x − (1 − β) = 0 for x = (λ − 1)/τ, without cancellation
        tail = 0.75 * (ductility - 1.0)
        half, rest = 0.5 * adhesion * tail, 1.0 - adhesion
        fallen = rest / (half + np.sqrt(half**2 + rest))
        return 1.0 + tail * fallen

    @override
    def area(self, stretch: FloatArray, ductility: FloatArray) -> FloatArray:
        tail = 0.75 * (ductility - 1.0)
        fallen = np.minimum((stretch - 1.0) / tail, 1.0)
        return 0.5 + tail * (fallen - fallen**3 / 3.0)
