"""True statics: the loads grow in equal steps and inertia is left out (formulation 2b)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from masonry_fem.bodies.base import Scheme
from masonry_fem.march.step_report import StepReport


@dataclass(frozen=True, slots=True, kw_only=True)
class Statics:
    """``load_steps`` equal steps of the load factor from 0 to 1, divided where joints give way."""

    load_steps: int = 1
    parts: int = 1
    seeks_equilibrium: bool = True
    velocity_factor: float = 0.0

    @property
    def steps(self) -> int:
        """Largest number of load steps, parts of steps counted."""
        return self.load_steps * self.parts

    def schedule(self) -> Iterator[tuple[Scheme, float]]:
        """One step a load factor; the step length is 1/n so that time is the load factor."""
        for index in range(1, self.load_steps + 1):
            yield Scheme(1.0 / self.load_steps, 1.0, 0.0), index / self.load_steps

    def settled(self, report: StepReport) -> bool:
        """Statics is at rest when the last load factor is reached."""
        return report.time >= 1.0
