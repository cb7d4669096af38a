"""Corbel: boxes that stand out one over another."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

from masonry_fem.scene.record import Count, Metres, Point, Sizes
from masonry_fem.scene.structures.base import Foreseen, Structure


class CorbelStructure(Structure, frozen=True, kw_only=True, tag="corbel"):
    """``count`` boxes one on another, each standing out along x over the one below.

    All stand out by the same ``offset``, or in a ``harmonic`` profile the topmost by it, the next ones down
    by its half, third ... With a ``table`` the ground ends where the lowest box begins to stand out.
    Rigid boxes of length L stand up to an offset of L / count (L / (count + 1) on a table), and in the
    harmonic profile on a table up to L / 2: the greatest overhang that a stack can have.
    """

    size: Sizes
    count: Count
    offset: Metres
    profile: Literal["equal", "harmonic"] = "equal"
    position: Point | None = None
    table: bool = False
    ground: bool = True

    @property
    def carries(self) -> bool:
        """Whether it brings its ground."""
        return self.ground

    def foreseen(self, dimension: int) -> Foreseen:
        """Its boxes, and the ground."""
        return Foreseen(self.count + self.ground, ("count",))

    def faults(self, dimension: int) -> Iterator[tuple[str, str]]:
        """Boxes that do not lie on one another, a table without ground."""
        if abs(self.offset) >= self.size[0]:
            yield "offset", f"less than the length of a box ({self.size[0]:g} m)"
        if self.table and not self.ground:
            yield "table", "false without a ground"
