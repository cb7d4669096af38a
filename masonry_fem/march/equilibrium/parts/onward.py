"""Onward: a strategy once more, from the time at which another march ended."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

from masonry_fem.bodies.base import Scheme
from masonry_fem.march.equilibrium.parts.base import Strategy

if TYPE_CHECKING:
    from masonry_fem.march.step_report import StepReport


class Onward(Strategy, frozen=True, kw_only=True):
    """The steps of a strategy after another march.

    Attributes
    ----------
    strategy : what to do once more
    since : when the other march ended [s]; the load factor in statics
    """

    strategy: Strategy
    since: float

    @property
    def steps(self) -> int:
        """Largest number of steps, parts of steps counted."""
        return self.strategy.steps

    @property
    def end(self) -> float:
        """Time at the end of the last step [s]."""
        return self.since + self.strategy.end

    @property
    def parts(self) -> int:
        """Most parts of a step in which joints give way."""
        return self.strategy.parts

    @property
    def inertia(self) -> bool:
        """As the strategy's."""
        return self.strategy.inertia

    @property
    def seeks_equilibrium(self) -> bool:
        """As the strategy's."""
        return self.strategy.seeks_equilibrium

    @property
    def kept(self) -> float:
        """As the strategy's."""
        return self.strategy.kept

    def schedule(self) -> Iterator[tuple[Scheme, float]]:
        """The strategy's steps, later."""
        for scheme, until in self.strategy.schedule():
            yield scheme, self.since + until

    def settled(self, report: StepReport) -> bool:
        """Whether the strategy would be, by the time since the start."""
        # sums of times are rounded, and a load factor of 1 is met exactly
        elapsed = round(report.time - self.since, 12)
        return self.strategy.settled(replace(report, time=elapsed))
