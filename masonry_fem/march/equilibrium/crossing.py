"""Crossing: statics in which loads that move go along their paths, from place to place."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated

from msgspec import Meta

from masonry_fem.bodies.base import Scheme
from masonry_fem.march.equilibrium.parts.base import Strategy
from masonry_fem.march.equilibrium.parts.quasistatic import Quasistatic, equal_parts
from masonry_fem.march.equilibrium.statics import Statics
from masonry_fem.records.record import Count

if TYPE_CHECKING:
    from masonry_fem.march.step_report import StepReport


class Crossing(Quasistatic, frozen=True, kw_only=True, tag="crossing"):
    """True statics of [loads that move](moving.md), which go along their paths slowly.

    All loads are applied in equal steps, as in statics, while the moving ones stand where they begin. Then
    these move to the ends of their paths, place by place, each reached from the one before. Time in results
    is the load factor up to 1, and from there on 1 plus the share of the path that is covered.

    Attributes
    ----------
    places : number of places, equally far from each other, the first and the last among them
    load_steps : number of equal steps from no load to the full load at the first place
    substeps : largest number of parts that a step is divided into

    Examples
    --------
    kind = "crossing"
    places = 21
    """

    places: Annotated[int, Meta(ge=2)] = 21
    load_steps: Count = 1
    substeps: Count = 1

    @property
    def steps(self) -> int:
        """Largest number of steps, parts of steps counted."""
        return (self.load_steps + self.places - 1) * self.substeps

    @property
    def end(self) -> float:
        """The full load, at the ends of the paths."""
        return 2.0

    @property
    def ramp(self) -> float:
        """The full load."""
        return 1.0

    @property
    def parts(self) -> int:
        """Most parts of a step in which joints give way."""
        return self.substeps

    @property
    def loading(self) -> Strategy:
        """Statics of the loads where they begin."""
        return Statics(start=self.start, load_steps=self.load_steps, substeps=self.substeps)

    def travelled(self, time: float) -> float:
        """Share of its way that a load has gone at a time of this analysis."""
        return min(max(time - 1.0, 0.0), 1.0)

    def schedule(self) -> Iterator[tuple[Scheme, float]]:
        """One step a load factor, then one a place."""
        yield from self.loading.schedule()
        yield from equal_parts(self.places - 1, since=1.0)

    def settled(self, report: StepReport) -> bool:
        """At rest at the last place."""
        return report.time >= self.end
