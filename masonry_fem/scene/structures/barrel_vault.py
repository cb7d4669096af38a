"""Barrel vault: courses of voussoirs along an axis."""

from __future__ import annotations

from collections.abc import Iterator

from masonry_fem.scene.record import Angle, Count, Length
from masonry_fem.scene.structures.base import Foreseen
from masonry_fem.scene.structures.voussoirs import VoussoirStructure


class BarrelVaultStructure(VoussoirStructure, frozen=True, kw_only=True, tag="barrel_vault"):
    """Circular vault about the mean ``radius`` of ``voussoirs`` courses along y; springings as supports.

    A course has ``stones`` equal stones with flat faces over the vault's ``depth``. In ``staggered`` ones
    every other course is moved by half a stone, and half stones close it at both ends.
    """

    radius: Length
    embrace: Angle = 180.0
    stones: Count
    staggered: bool = True

    def foreseen(self, dimension: int) -> Foreseen:
        """Its stones, in every other staggered course one more, and two springings."""
        more = self.voussoirs // 2 if self.staggered else 0
        blocks = self.voussoirs * self.stones + more + 2 * self.springings
        return Foreseen(blocks, ("voussoirs", "stones"))

    def faults(self, dimension: int) -> Iterator[tuple[str, str]]:
        """Stones without an intrados, or of more than half a circle."""
        if self.thickness >= 2 * self.radius:
            yield "thickness", f"less than twice the mean radius ({2 * self.radius:g} m)"
        if self.embrace / self.voussoirs >= 180:
            least = f"{self.embrace / 180:g}"
            yield "voussoirs", f"more than {least}, so that a course spans less than half a circle"
