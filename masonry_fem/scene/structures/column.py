"""Column: drums one on another, between a plinth and a capital."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated

from msgspec import Meta

from masonry_fem.scene.record import Count, Distance, Length, Point
from masonry_fem.scene.structures.base import Foreseen, Structure


class ColumnStructure(Structure, frozen=True, kw_only=True, tag="column"):
    """Column of ``drums`` equally high drums, on a square ``plinth`` and under a square ``capital``.

    A drum is a prism of ``sides`` that has the area of the circle. The ``diameter`` goes straight from foot
    to ``top_diameter``; an ``entasis`` adds a parabola to it, greatest at half height. In 2D it is the
    column's section through the axis, one metre deep.
    """

    drums: Count
    height: Length
    diameter: Length
    top_diameter: Length | None = None
    entasis: Distance = 0.0
    sides: Annotated[int, Meta(ge=3)] = 12
    plinth: Length | None = None
    capital: Length | None = None
    projection: Distance = 0.0
    centre: Point | None = None
    ground: bool = True

    @property
    def carries(self) -> bool:
        """Whether it brings its ground."""
        return self.ground

    def foreseen(self, dimension: int) -> Foreseen:
        """Its drums, prisms of so many sides, and what lies above and below them."""
        added = (self.plinth is not None) + (self.capital is not None) + self.ground
        sides = 4 if dimension == 2 else self.sides + 2
        return Foreseen(self.drums + added, ("drums", "sides"), sides=sides)

    def faults(self, dimension: int) -> Iterator[tuple[str, str]]:
        """A projection of nothing, more drums than tell an entasis apart."""
        if self.projection and self.plinth is None and self.capital is None:
            yield "projection", "0 without a plinth or a capital that could stand out"
        if self.entasis and self.drums == 1:
            yield "entasis", "0 for a single drum, whose sides are straight"
