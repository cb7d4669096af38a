"""Exponential joint: stress decays as exp(−φ δ) after the strength and never quite ends.

Exponential(normal_stiffness=82e9, tangential_stiffness=36e9, normal_strength=0.25e6,
            tangential_strength=0.35e6, normal_energy=18.0, tangential_energy=125.0)
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, override

import numpy as np

from masonry_fem.joints.laws.parts.softening import Softening
from masonry_fem.joints.parameters import FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Exponential(Softening):
    """Springs up to separate strengths, then an exponential loss of stress.

    β λ = exp(−φ (λ − 1)) with φ = 2/(γ − 1).

    Examples
    --------
    kind = "exponential"
    normal_stiffness = 2e10
    tangential_stiffness = 1e10
    normal_strength = 0.25e6
    tangential_strength = 0.35e6
    normal_energy = 18.0
    tangential_energy = 60.0
    """

    name: ClassVar[str] = "exponential"

    @override
    def shape(self, stretch: FloatArray, ductility: FloatArray) -> FloatArray:
        decay = 2.0 / (ductility - 1.0)
        return np.exp(-decay * (stretch - 1.0)) / stretch

    @override
    def reached(self, adhesion: FloatArray, ductility: FloatArray) -> FloatArray:
        from scipy.special import wrightomega  # noqa: PLC0415 - every run loads this file, few need it

        # φ λ exp(φ λ) = φ exp(φ)/β: Lambert's function of a large number, by its logarithm
        decay = 2.0 / (ductility - 1.0)
        reached: FloatArray = wrightomega(np.log(decay) + decay - np.log(adhesion)) / decay
        return reached

    @override
    def area(self, stretch: FloatArray, ductility: FloatArray) -> FloatArray:
        decay = 2.0 / (ductility - 1.0)
        return 0.5 - np.expm1(-decay * (stretch - 1.0)) / decay
