"""Arch: voussoirs about a centre."""

from __future__ import annotations

from collections.abc import Iterator

from masonry_fem.scene.record import Angle, Count, Length, Point
from masonry_fem.scene.structures.base import Foreseen, Structure
from masonry_fem.scene.structures.voussoirs import Cut


class ArchStructure(Structure, frozen=True, kw_only=True, tag="arch"):
    """Circular arch of ``voussoirs`` equal stones about the mean ``radius``; springings as supports.

    ``embrace`` is the full opening angle [deg]. ``straight`` voussoirs have chords for arcs. Joints are
    radial, or between the springings vertical: then they cut the span of the intrados into equal parts.
    """

    radius: Length
    thickness: Length
    voussoirs: Count
    embrace: Angle = 180.0
    depth: Length = 1.0
    centre: Point | None = None
    straight: bool = False
    springings: bool = True
    cut: Cut = "radial"

    @property
    def carries(self) -> bool:
        """Whether it brings its springings."""
        return self.springings

    def foreseen(self, dimension: int) -> Foreseen:
        """Its voussoirs, and two springings."""
        return Foreseen(self.voussoirs + 2 * self.springings, ("voussoirs",))

    def faults(self, dimension: int) -> Iterator[tuple[str, str]]:
        """Stones without an intrados, or of more than half a circle; upright joints that miss a face."""
        if self.thickness >= 2 * self.radius:
            yield "thickness", f"less than twice the mean radius ({2 * self.radius:g} m)"
        if self.embrace / self.voussoirs >= 180:
            least = f"{self.embrace / 180:g}"
            yield "voussoirs", f"more than {least}, so that a stone spans less than half a circle"
        if self.cut == "vertical" and self.embrace > 180:
            yield "embrace", "at most 180 with vertical joints"
