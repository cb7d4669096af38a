"""Flat arch: voussoirs between two levels, the jack arch over an opening."""

from __future__ import annotations

from collections.abc import Iterator
from math import atan, degrees
from typing import Annotated

from msgspec import Meta

from masonry_fem.scene.record import Length
from masonry_fem.scene.structures.voussoirs import VoussoirStructure

DEFAULT_SKEWBACK = 30.0  # [deg], where neither an angle nor a point is given


class FlatArchStructure(VoussoirStructure, frozen=True, kw_only=True, tag="flat_arch"):
    """Jack arch of ``voussoirs`` stones with a level intrados of ``span``; its joints meet in one point.

    ``skewback`` is the angle [deg] of the springing joints to the vertical (30 where nothing is given);
    instead of it, ``focus`` is the depth below the intrados of the point where all joints meet.
    """

    span: Length
    skewback: Annotated[float, Meta(gt=0, lt=80, extra={"unit": "deg"})] | None = None
    focus: Length | None = None

    @property
    def slope(self) -> float:
        """Angle of the springing joints to the vertical [deg]."""
        if self.focus is not None:
            return degrees(atan(self.span / (2 * self.focus)))
        return DEFAULT_SKEWBACK if self.skewback is None else self.skewback

    def faults(self, dimension: int) -> Iterator[tuple[str, str]]:
        """Two forms at once."""
        if self.focus is not None and self.skewback is not None:
            yield "focus", "one of 'skewback' and 'focus'"
