"""Transient: a plain march in time, from 0 to a given duration."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from masonry_fem.bodies.base import Scheme
from masonry_fem.march.step_report import StepReport


@dataclass(frozen=True, slots=True, kw_only=True)
class Transient:
    """Steps of ``step`` [s] to ``duration`` [s] with the θ-scheme."""

    step: float
    duration: float
    theta: float = 0.5
    seeks_equilibrium: bool = False
    velocity_factor: float = 1.0
    parts: int = 1

    @property
    def steps(self) -> int:
        """Number of steps; the last one ends at or just after the duration."""
        return max(1, math.ceil(self.duration / self.step * (1 - 1e-12)))

    def schedule(self) -> Iterator[tuple[Scheme, float]]:
        """Equal steps; times are multiples of the step, not sums of rounded ones."""
        for index in range(1, self.steps + 1):
            yield Scheme(self.step, self.theta), index * self.step

    def settled(self, report: StepReport) -> bool:
        """A transient march ends with its duration only."""
        return False
