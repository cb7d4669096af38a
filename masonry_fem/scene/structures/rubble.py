"""Rubble: irregular stones that fill a rectangle or a box."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated

from msgspec import Meta

from masonry_fem.scene.record import Count, Distance, Point, Positive, Sizes
from masonry_fem.scene.structures.base import Foreseen, Structure


class RubbleStructure(Structure, frozen=True, kw_only=True, tag="rubble"):
    """Rubble masonry (*blocage*): a box of ``size`` in ``stones`` convex stones, drawn with a ``seed``.

    Stones are Voronoi cells of random points; ``relaxation`` moves each point to its cell's centroid so
    many times, which makes the stones more equal. Then no edge is shorter than ``shortest`` of the stones'
    mean size. ``elongation`` is the stones' length over their height. A ``joint`` is cut out between the
    stones, half from each: then they are paired only where ``contact.reach`` exceeds it, and dry stones bear
    on each other only once they have closed it. The same seed makes the same stones.
    """

    size: Sizes
    stones: Count
    seed: Annotated[int, Meta(ge=0)] = 0
    relaxation: Annotated[int, Meta(ge=0, le=100)] = 2
    shortest: Annotated[float, Meta(ge=0, le=0.2)] = 0.1
    elongation: Positive = 1.0
    joint: Distance = 0.0
    position: Point | None = None
    ground: bool = True

    @property
    def carries(self) -> bool:
        """Whether it brings its ground."""
        return self.ground

    @property
    def stone_size(self) -> float:
        """Mean size of a stone [m], before it is flattened to its elongation."""
        volume = self.elongation
        for length in self.size:
            volume *= length
        return float((volume / self.stones) ** (1 / len(self.size)))

    def foreseen(self, dimension: int) -> Foreseen:
        """Its stones, of some 14 faces in space, and the ground."""
        return Foreseen(self.stones + self.ground, ("stones",), sides=6 if dimension == 2 else 14)

    def faults(self, dimension: int) -> Iterator[tuple[str, str]]:
        """Joints that leave no stones between them."""
        height = self.stone_size / max(1.0, self.elongation)
        if self.joint > height / 4:
            yield "joint", f"at most a quarter of the stones' mean size ({height / 4:.3g} m)"
