"""Portal: an arch on two piers."""

from __future__ import annotations

from collections.abc import Iterator
from math import isclose
from typing import Literal

from masonry_fem.scene.record import Count, Length, Point
from masonry_fem.scene.structures.base import Foreseen, Structure
from masonry_fem.scene.structures.pointed_arch import PointedArchStructure


class PortalStructure(Structure, frozen=True, kw_only=True, tag="portal"):
    """Arch of ``voussoirs`` stones on two piers, their inner faces flush with the intrados.

    The ``form`` of its mean line over ``span`` is half a circle, or pointed or elliptical with a ``rise``.
    A pier is one block, or ``courses`` equal ones.
    """

    span: Length
    thickness: Length
    voussoirs: Count
    pier_width: Length
    pier_height: Length
    form: Literal["circular", "pointed", "elliptical"] = "circular"
    rise: Length | None = None
    courses: Count = 1
    depth: Length = 1.0
    centre: Point | None = None
    straight: bool = False
    ground: bool = True

    @property
    def carries(self) -> bool:
        """Whether it brings the ground below its piers."""
        return self.ground

    def foreseen(self, dimension: int) -> Foreseen:
        """Its voussoirs and the blocks of two piers, each with its ground."""
        blocks = self.voussoirs + 2 * (self.courses + self.ground)
        return Foreseen(blocks, ("voussoirs", "courses"))

    @property
    def pointed(self) -> PointedArchStructure:
        """Its arch alone where that is pointed, about the middle between the piers' tops."""
        return PointedArchStructure(
            name=self.name,
            material=self.material,
            span=self.span,
            rise=self.rise,
            thickness=self.thickness,
            voussoirs=self.voussoirs,
        )

    def faults(self, dimension: int) -> Iterator[tuple[str, str]]:
        """A form without its rise, and what its arch cannot be."""
        half = self.span / 2
        if self.form == "circular" and self.rise is not None and not isclose(self.rise, half):
            yield "rise", f"half the span ({half:g} m) in a circular portal, or none"
        elif self.form != "circular" and self.rise is None:
            yield "rise", f"a length > 0 in m: a portal that is {self.form} has a rise"
        elif self.form == "pointed":
            yield from self.pointed.faults(dimension)
        elif self.rise is not None and self.thickness >= 2 * min(half**2 / self.rise, self.rise**2 / half):
            least = min(half**2 / self.rise, self.rise**2 / half)
            yield "thickness", f"less than twice the ellipse's least radius of curvature ({least:g} m)"
        elif self.thickness >= self.span:
            yield "thickness", f"less than the span ({self.span:g} m)"
