"""Voussoirs: what all rows of wedge-shaped stones between two springings have."""

from __future__ import annotations

from typing import Annotated, Literal

from msgspec import Meta

from masonry_fem.records.record import Count, Length, Point
from masonry_fem.records.structure import Foreseen, Structure

Cut = Literal["radial", "vertical"]
Slope = Annotated[float, Meta(ge=0, lt=90, extra={"unit": "deg"})]


class VoussoirStructure(Structure, frozen=True, kw_only=True):
    """Row of ``voussoirs`` stones of one ``thickness``; springings as supports.

    Attributes
    ----------
    thickness : distance between intrados and extrados
    voussoirs : number of stones, numbered from the left
    depth : length along y; not used in 2D
    centre : middle between the springings of the mean line, at the front; the origin by default
    springings : a support at each end
    """

    thickness: Length
    voussoirs: Count
    depth: Length = 1.0
    centre: Point | None = None
    springings: bool = True

    @property
    def carries(self) -> bool:
        """Whether it brings its springings."""
        return self.springings

    def foreseen(self, dimension: int) -> Foreseen:
        """Its voussoirs, and two springings."""
        return Foreseen(self.voussoirs + 2 * self.springings, ("voussoirs",))
