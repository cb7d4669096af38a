"""Dome: rings of stones about a centre."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated

from msgspec import Meta

from masonry_fem.scene.record import Angle, Count, Length, Point
from masonry_fem.scene.structures.base import Foreseen, Structure


class DomeStructure(Structure, frozen=True, kw_only=True, tag="dome"):
    """Spherical dome about the mean ``radius``: ``rings`` of ``slices`` equal stones, all faces flat.

    ``springing`` and ``oculus`` are the angles [deg] of base and eye from the crown; without an oculus a
    crown stone closes the dome. ``staggered`` turns every other ring by half a stone. A ``sweep`` below
    360 deg makes a sector, from the x axis on, with ``sides`` between two supports.

    A dome that springs at 90 deg may stand on a drum of ``drum_courses``, each of ``drum_stones`` stones, and
    that, or the dome itself, on ``piers``. All are as thick as the dome, or ``drum_width`` from the intrados
    outwards.
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
    drum_courses: Annotated[int, Meta(ge=0)] = 0
    drum_height: Length | None = None
    drum_stones: Count | None = None
    drum_width: Length | None = None
    piers: Annotated[int, Meta(ge=0)] = 0
    pier_height: Length | None = None
    pier_slices: Count | None = None
    pier_courses: Count = 1

    @property
    def carries(self) -> bool:
        """Whether it brings a base or sides."""
        return self.base or self.sides

    @property
    def width(self) -> float:
        """Of drum and piers [m]."""
        return self.thickness if self.drum_width is None else self.drum_width

    @property
    def stones(self) -> int:
        """In a course of the drum."""
        return self.slices if self.drum_stones is None else self.drum_stones

    def foreseen(self, dimension: int) -> Foreseen:
        """The stones of its rings, drum and piers, and what carries them."""
        crown = 0 if self.oculus else 1
        under = self.piers or (self.stones if self.drum_courses else self.slices)
        blocks = self.rings * self.slices + crown + self.drum_courses * self.stones
        blocks += self.piers * self.pier_courses + self.base * under + 2 * self.sides
        keys = ("rings", "slices", "drum_courses", "drum_stones", "piers", "pier_courses")
        return Foreseen(blocks, keys)

    def faults(self, dimension: int) -> Iterator[tuple[str, str]]:
        """Drums and piers without a height, under slopes, or out of step with the dome's stones."""
        if self.drum_height is not None and not self.drum_courses:
            yield "drum_courses", "at least 1 for a drum of that height"
        if self.pier_height is not None and not self.piers:
            yield "piers", "at least 1 of that height"
        if not (self.drum_courses or self.piers):
            return
        if self.springing != 90:
            yield "springing", "90 deg above a drum or piers"
        if self.width < self.thickness:
            yield "drum_width", f"at least the dome's thickness ({self.thickness:g} m)"
        if self.drum_courses and self.drum_height is None:
            yield "drum_height", "a length > 0 in m: the drum's height"
        if self.slices % self.stones:
            yield "drum_stones", f"a divisor of the dome's slices ({self.slices})"
        if self.drum_courses and self.sweep / self.stones > 180:
            yield "drum_stones", "at least 2: a stone of the drum spans half of it at most"
        if self.piers:
            yield from self._pier_faults()

    def _pier_faults(self) -> Iterator[tuple[str, str]]:
        if self.sweep != 360:
            yield "piers", "0 under a sector"
        if self.slices % self.piers:
            yield "piers", f"a divisor of the dome's slices ({self.slices})"
        if self.pier_height is None:
            yield "pier_height", "a length > 0 in m: the piers' height"
        between = self.slices // self.piers
        if self.pier_slices is None or self.pier_slices >= between:
            yield "pier_slices", f"less than the slices from pier to pier ({between})"
        elif self.drum_courses and not self.staggered and self.pier_slices % 2:
            yield "pier_slices", "an even number under a drum, whose joints lie on the middles of piers"
