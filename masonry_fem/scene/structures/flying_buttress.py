"""Flying buttress: voussoirs that lean from a foot against a wall."""

from __future__ import annotations

from collections.abc import Iterator
from math import asin, cos, degrees, radians
from typing import Annotated, Literal

from msgspec import Meta

from masonry_fem.scene.record import Count, Distance, Length, Point
from masonry_fem.scene.structures.base import Foreseen, Structure


class FlyingButtressStructure(Structure, frozen=True, kw_only=True, tag="flying_buttress"):
    """Flyer of ``voussoirs`` stones that rises at ``inclination`` [deg] over ``span`` to a wall.

    Its axis is straight, or with a ``camber`` the arc that rises so far above its chord; joints are normal
    to it and part it equally. It lies on one ``side`` of the wall that its head pushes. Ends are ``square``
    to the axis or ``vertical``, or only the one at the head is. ``head`` and ``foot`` bring supports; without
    them it leans on other blocks, such as a portal's pier and a buttress.
    """

    span: Length
    inclination: Annotated[float, Meta(ge=0, lt=90, extra={"unit": "deg"})]
    thickness: Length
    voussoirs: Count
    camber: Distance = 0.0
    depth: Length = 1.0
    position: Point | None = None
    side: Literal["left", "right"] = "right"
    ends: Literal["square", "vertical", "vertical_head"] = "square"
    head: bool = True
    foot: bool = True

    @property
    def carries(self) -> bool:
        """Whether it brings a head or a foot."""
        return self.head or self.foot

    @property
    def chord(self) -> float:
        """Length between the ends of the axis [m]."""
        return self.span / cos(radians(self.inclination))

    @property
    def radius(self) -> float:
        """Of the axis, where it has a camber [m]."""
        return self.chord**2 / (8 * self.camber) + self.camber / 2

    @property
    def opening(self) -> float:
        """Half the angle of the axis [deg], 0 where it is straight."""
        return degrees(asin(self.chord / (2 * self.radius))) if self.camber else 0.0

    def foreseen(self, dimension: int) -> Foreseen:
        """Its voussoirs, and a support at either end."""
        return Foreseen(self.voussoirs + self.head + self.foot, ("voussoirs",))

    def faults(self, dimension: int) -> Iterator[tuple[str, str]]:
        """More than half a circle, stones without an intrados, vertical ends of a vertical axis."""
        if self.camber >= self.chord / 2:
            yield "camber", f"less than half the chord ({self.chord / 2:g} m)"
        elif self.camber and self.thickness >= 2 * self.radius:
            yield "thickness", f"less than twice the radius of the axis ({2 * self.radius:g} m)"
        elif self.ends == "vertical" and self.inclination + self.opening >= 80:
            steep = f"{self.inclination + self.opening:.3g}"
            yield "ends", f"another where the axis is as steep as {steep} degrees at its foot"
