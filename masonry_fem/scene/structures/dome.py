"""Dome: rings of stones about a centre."""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta

from masonry_fem.scene.record import Angle, Count, Length, Point
from masonry_fem.scene.structures.base import Structure


class DomeStructure(Structure, frozen=True, kw_only=True, tag="dome"):
    """Spherical dome about the mean ``radius``: ``rings`` of ``slices`` equal stones, all faces flat.

    ``springing`` and ``oculus`` are the angles [deg] of base and eye from the crown; without an oculus a
    crown stone closes the dome. ``staggered`` turns every other ring by half a stone. A ``sweep`` below
    360 deg makes a sector, from the x axis on, with ``sides`` between two supports.
    """

    radius: Length
    thickness: Length
    rings: Count
    slices: Count
    springing: Angle = 90.0
    oculus: Annotated[float, Meta(ge=0, lt=180, extra={"unit": "deg"})] = 0.0
    centre: Point | None = None
    staggered: bool = False
    base: bool = True
    sweep: Angle = 360.0
    sides: bool = False

    @property
    def carries(self) -> bool:
        """Whether it brings a base or sides."""
        return self.base or self.sides
