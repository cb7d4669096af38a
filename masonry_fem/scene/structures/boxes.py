"""Boxes: a single block, and a stack of them."""

from __future__ import annotations

from collections.abc import Iterator

from masonry_fem.scene.record import Axis, Count, Degrees, Distance, Metres, Point, Sizes
from masonry_fem.scene.structures.base import Foreseen, Structure


class BlockStructure(Structure, frozen=True, kw_only=True, tag="block"):
    """One box, ``size`` [m] along the axes, lower corner at ``position``, turned by ``rotation``.

    ``rotation`` is an angle [deg] about ``axis`` (2D: about z) through the lower corner.
    """

    size: Sizes
    position: Point | None = None
    rotation: Degrees = 0.0
    axis: Axis | None = None
    support: bool = False

    @property
    def carries(self) -> bool:
        """Whether it is a support."""
        return self.support

    def foreseen(self, dimension: int) -> Foreseen:
        """One."""
        return Foreseen(1, ())

    def faults(self, dimension: int) -> Iterator[tuple[str, str]]:
        """An axis that means nothing, or that lacks."""
        if dimension == 2 and self.axis is not None:
            yield "axis", "no axis in a 2D scene (rotation is about z)"
        if dimension == 3 and self.rotation and self.axis is None:
            yield "axis", "3 numbers: in 3D a rotation has an axis"
        if self.axis is not None and not any(self.axis):
            yield "axis", "an axis that is not zero"


class StackStructure(Structure, frozen=True, kw_only=True, tag="stack"):
    """``count`` boxes one on another, each moved by ``offset`` along x over the one below."""

    size: Sizes
    count: Count
    position: Point | None = None
    offset: Metres = 0.0
    gap: Distance = 0.0
    ground: bool = True

    @property
    def carries(self) -> bool:
        """Whether it brings its ground."""
        return self.ground

    def foreseen(self, dimension: int) -> Foreseen:
        """Its boxes, and the ground."""
        return Foreseen(self.count + self.ground, ("count",))
