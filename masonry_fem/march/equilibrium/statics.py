"""Statics: the loads grow in equal steps, without inertia."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from masonry_fem.bodies.base import Scheme
from masonry_fem.march.equilibrium.parts.quasistatic import Quasistatic, equal_parts
from masonry_fem.records.record import Count

if TYPE_CHECKING:
    from masonry_fem.march.step_report import StepReport


class Statics(Quasistatic, frozen=True, kw_only=True, tag="statics"):
    """True statics: no inertia; the loads are applied in equal steps.

    A step in which joints yield or break, or whose contacts are not solved, is halved again and again, into
    at most ``substeps`` parts; where blocks deform and contacts are not solved, into 32 in any case.

    Attributes
    ----------
    load_steps : number of equal steps from no load to the full load
    substeps : largest number of parts that a step is divided into

    Examples
    --------
    kind = "statics"
    load_steps = 10
    """

    load_steps: Count = 1
    substeps: Count = 1

    @property
    def steps(self) -> int:
        """Largest number of load steps, parts of steps counted."""
        return self.load_steps * self.substeps

    @property
    def parts(self) -> int:
        """Most parts of a step in which joints give way."""
        return self.substeps

    def schedule(self) -> Iterator[tuple[Scheme, float]]:
        """One step a load factor."""
        return equal_parts(self.load_steps)

    def settled(self, report: StepReport) -> bool:
        """At rest when the last load factor is reached."""
        return report.time >= 1.0
