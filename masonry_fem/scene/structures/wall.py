"""Wall: bricks in courses."""

from __future__ import annotations

from typing import Annotated, Literal

from msgspec import Meta

from masonry_fem.scene.record import Count, Point, Sizes
from masonry_fem.scene.structures.base import Structure


class WallStructure(Structure, frozen=True, kw_only=True, tag="wall"):
    """Running-bond wall: ``courses`` courses of ``columns`` bricks, half bricks closing every other.

    Where ``columns`` ends in a half, each course has one half brick, at alternate ends. With ``cut`` each
    brick is two halves whose joint, labelled ``brick``, lets it crack in the middle.
    """

    brick: Sizes
    columns: Annotated[float, Meta(ge=1, multiple_of=0.5)]
    courses: Count
    position: Point | None = None
    half_bricks: Literal["even", "odd", "none"] = "even"
    cut: bool = False
    ground: bool = True

    @property
    def carries(self) -> bool:
        """Whether it brings its ground."""
        return self.ground
