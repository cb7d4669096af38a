"""Trapezoidal joint (Tvergaard–Hutchinson): the strength holds on a plateau, then falls on a line.

Trapezoidal(normal_stiffness=82e9, tangential_stiffness=36e9, normal_strength=0.25e6,
            tangential_strength=0.35e6, normal_energy=18.0, tangential_energy=125.0, plateau=0.5)
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar, override

import numpy as np
from msgspec import Meta

from masonry_fem.joints.laws.parts.softening import Softening
from masonry_fem.joints.parameters import FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Trapezoidal(Softening):
    """Springs up to separate strengths, a plateau, then a linear loss (Tvergaard and Hutchinson).

    β λ = 1 up to λ_p = 1 + plateau (γ − 1)/2, then a line to λ_u = γ + 1 − λ_p.

    Attributes
    ----------
    plateau : length of the plateau at the strength, as a share of the way from there to rupture

    Examples
    --------
    kind = "trapezoidal"
    normal_stiffness = 2e10
    tangential_stiffness = 1e10
    normal_strength = 0.25e6
    tangential_strength = 0.35e6
    normal_energy = 18.0
    tangential_energy = 60.0
    plateau = 0.4
    """

    plateau: Annotated[float, Meta(ge=0, lt=1)] = 0.5

    name: ClassVar[str] = "trapezoidal"

    def _ends(self, ductility: FloatArray) -> tuple[FloatArray, FloatArray]:
        plateau = 1.0 + 0.5 * self.plateau * (ductility - 1.0)
        return plateau, ductility + 1.0 - plateau

    @override
    def shape(self, stretch: FloatArray, ductility: FloatArray) -> FloatArray:
        plateau, end = self._ends(ductility)
        stress = np.clip((end - stretch) / (end - plateau), 0.0, 1.0)
        return stress / stretch

    @override
    def reached(self, adhesion: FloatArray, ductility: FloatArray) -> FloatArray:
        plateau, end = self._ends(ductility)
        on_plateau = 1.0 / np.maximum(adhesion, 1.0 / plateau)
        falling = end / (1.0 + adhesion * (end - plateau))
        return np.where(adhesion * plateau >= 1.0, on_plateau, falling)

    @override
    def area(self, stretch: FloatArray, ductility: FloatArray) -> FloatArray:
        plateau, end = self._ends(ductility)
        left = end - np.clip(stretch, plateau, end)
        flat = np.minimum(stretch, plateau) - 0.5
        return flat + 0.5 * ((end - plateau) - left**2 / (end - plateau))
