"""Onward: a strategy once more, from the time at which another march ended."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from masonry_fem.bodies.base import Scheme
from masonry_fem.march.equilibrium.base import Strategy
from masonry_fem.march.step_report import StepReport


@dataclass(frozen=True, slots=True)
class Onward:
    """The steps of ``strategy`` after the time ``since`` [s] (load factor in statics)."""

    strategy: Strategy
    since: float

    @property
    def steps(self) -> int:
        """Largest number of steps, parts of steps counted."""
        return self.strategy.steps

    @property
    def parts(self) -> int:
        """Most parts of a step in which joints give way."""
        return self.strategy.parts

    @property
    def seeks_equilibrium(self) -> bool:
        """As the strategy's."""
        return self.strategy.seeks_equilibrium

    @property
    def velocity_factor(self) -> float:
        """As the strategy's."""
        return self.strategy.velocity_factor

    def schedule(self) -> Iterator[tuple[Scheme, float]]:
        """The strategy's steps, later."""
        for scheme, until in self.strategy.schedule():
            yield scheme, self.since + until

    def settled(self, report: StepReport) -> bool:
        """Whether the strategy would be, by the time since the start."""
        # sums of times are rounded, and a load factor of 1 is met exactly
        elapsed = round(report.time - self.since, 12)
        return self.strategy.settled(replace(report, time=elapsed))
