"""Tie: a bar, a cable or a chain between points of blocks."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Annotated

from msgspec import Meta

from masonry_fem.records.record import BlockSelector, Length, Name, Point, Positive, Pressure, Spec

Section = Annotated[float, Meta(gt=0, extra={"unit": "m^2"})]
Tension = Annotated[float, Meta(ge=0, extra={"unit": "N"})]


class TiePoint(Spec, frozen=True, kw_only=True):
    """A point where a tie is fixed to a block.

    Attributes
    ----------
    block : selector that matches one block
    point : where it is fixed, in world coordinates of the undeformed structure; the block's centroid by
        default
    """

    block: BlockSelector
    point: Point | None = None


class Tie(Spec, frozen=True, kw_only=True):
    """A [tie](ties.md): a bar, cable or chain that bears tension only, straight between its points.

    In 2D forces and sections are those of one metre of depth.

    Attributes
    ----------
    name : name of its line in tables; that of a tie through several points is followed by the number of the
        part
    points : blocks and supports that it is fixed to, in this order
    closed : whether it leads from the last point back to the first
    section : area of its cross-section
    diameter : diameter of a round bar, in place of ``section``
    young : Young's modulus; that of steel by default
    pretension : its force while its points are where they are at the start, or where they have gone when a
        stage brings it
    yield_stress : stress at which it begins to yield; if left out it never does
    hardening : slope of the stress over the plastic strain; ``young``/1000 if left out
    rupture_strain : strain, plastic and elastic, at which it snaps; if left out it never does
    """

    name: Name
    points: Annotated[tuple[TiePoint, ...], Meta(min_length=2)]
    closed: bool = False
    section: Section | None = None
    diameter: Length | None = None
    young: Pressure = 200e9
    pretension: Tension = 0.0
    yield_stress: Pressure | None = None
    hardening: Pressure | None = None
    rupture_strain: Positive | None = None

    @property
    def area(self) -> float:
        """Of the cross-section [m²]."""
        if self.section is not None:
            return self.section
        return 0.25 * math.pi * (self.diameter or 0.0) ** 2

    @property
    def parts(self) -> list[str]:
        """Names of its straight parts."""
        count = len(self.points) - (not self.closed)
        return [self.name] if count == 1 else [f"{self.name}.{number}" for number in range(1, count + 1)]

    def faults(self, dimension: int) -> Iterator[tuple[str, str]]:
        """Section, ends and strengths that contradict each other."""
        yield from self._section_faults()
        if self.closed and len(self.points) < 3:
            yield "closed", "false: what leads back to its first point has three points at least"
        if self.hardening is not None and self.yield_stress is None:
            yield "hardening", "none without a 'yield_stress'"
        if self.yield_stress is not None and self.pretension > self.yield_stress * self.area > 0:
            yield "pretension", f"at most yield_stress × section = {self.yield_stress * self.area:g} N"
        start = self.pretension / (self.young * self.area) if self.area else 0.0
        if self.rupture_strain is not None and start >= self.rupture_strain:
            yield "rupture_strain", f"more than the strain of the pretension, {start:g}"

    def _section_faults(self) -> Iterator[tuple[str, str]]:
        if self.section is None and self.diameter is None:
            yield "section", "the area of its cross-section, or a diameter"
        if self.section is not None and self.diameter is not None:
            yield "diameter", "none beside 'section', which is the area itself"
