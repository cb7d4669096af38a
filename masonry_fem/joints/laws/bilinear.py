"""Bilinear joint: stress falls on a straight line from the strength to nothing.

Bilinear(normal_stiffness=82e9, tangential_stiffness=36e9, normal_strength=0.25e6,
         tangential_strength=0.35e6, normal_energy=18.0, tangential_energy=125.0, friction=0.75)
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, override

import numpy as np

from masonry_fem.joints.laws.parts.softening import Softening
from masonry_fem.joints.parameters import FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Bilinear(Softening):
    """Springs up to separate strengths, then a linear loss of stress.

    β λ = (γ − λ)/(γ − 1): gone at λ = γ.

    Examples
    --------
    kind = "bilinear"
    normal_stiffness = 2e10
    tangential_stiffness = 1e10
    normal_strength = 0.25e6
    tangential_strength = 0.35e6
    normal_energy = 18.0
    tangential_energy = 60.0
    """

    name: ClassVar[str] = "bilinear"

    @override
    def shape(self, stretch: FloatArray, ductility: FloatArray) -> FloatArray:
        return np.maximum(ductility - stretch, 0.0) / (stretch * (ductility - 1.0))

    @override
    def reached(self, adhesion: FloatArray, ductility: FloatArray) -> FloatArray:
        return ductility / (1.0 + adhesion * (ductility - 1.0))

    @override
    def area(self, stretch: FloatArray, ductility: FloatArray) -> FloatArray:
        left = ductility - np.minimum(stretch, ductility)
        return 0.5 * (ductility - left**2 / (ductility - 1.0))
