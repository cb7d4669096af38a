"""Buttress: a pier whose outer face is upright, sloping or stepped, and that may lean."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated

from msgspec import Meta

from masonry_fem.scene.record import Count, Length, Point
from masonry_fem.scene.structures.base import Foreseen, Structure


class ButtressStructure(Structure, frozen=True, kw_only=True, tag="buttress"):
    """Pier of ``courses`` equal courses, ``width`` wide at its foot and ``top`` at its top.

    Its left face is plane; its right one slopes where ``top`` is less than ``width``, or goes back at
    set-offs between so many equal ``stages``. Both faces ``lean`` to the right, the bed joints stay level.
    A course is one stone, or about so many ``stones`` at the foot, their joints lapped by half a stone.
    """

    width: Length
    height: Length
    courses: Count = 1
    top: Length | None = None
    stages: Annotated[int, Meta(ge=2)] | None = None
    lean: Annotated[float, Meta(gt=-60, lt=60, extra={"unit": "deg"})] = 0.0
    stones: Count = 1
    depth: Length = 1.0
    position: Point | None = None
    ground: bool = True

    @property
    def carries(self) -> bool:
        """Whether it brings its ground."""
        return self.ground

    def foreseen(self, dimension: int) -> Foreseen:
        """Its courses, all as long as that at the foot, and the ground."""
        return Foreseen(self.courses * self.stones + self.ground, ("courses", "stones"))

    def faults(self, dimension: int) -> Iterator[tuple[str, str]]:
        """A top wider than the foot, stages that do not differ or have no course."""
        if self.top is not None and self.top > self.width:
            yield "top", f"at most the width at the foot ({self.width:g} m)"
        if self.stages is None:
            return
        if self.top is None:
            yield "top", "the width of the uppermost stage in m"
        elif self.top == self.width:
            yield "top", f"less than the width at the foot ({self.width:g} m), for stages to differ"
        if self.stages > self.courses:
            yield "stages", f"at most as many as courses ({self.courses})"
