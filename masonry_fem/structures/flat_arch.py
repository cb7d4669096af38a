"""Flat arch: stones between two horizontal planes, with joints along lines through one point below."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from math import atan, degrees
from typing import Annotated

import numpy as np
from msgspec import Meta

from masonry_fem.records.record import Length
from masonry_fem.solid.assembly import Assembly
from masonry_fem.structures.parts.curve import Offset, Segment
from masonry_fem.structures.parts.quarry import arch_of
from masonry_fem.structures.parts.voussoir import Voussoir
from masonry_fem.structures.parts.voussoir_row import VoussoirStructure

DEFAULT_SKEWBACK = 30.0  # [deg], where neither an angle nor a point is given


class FlatArchStructure(VoussoirStructure, frozen=True, kw_only=True, tag="flat_arch"):
    """Jack arch of ``voussoirs`` stones with a level intrados of ``span``; its joints meet in one point.

    Attributes
    ----------
    thickness : height of the arch
    centre : middle of the intrados at the front; the origin by default
    span : span of the intrados between the springings
    skewback : angle of the springing joints to the vertical; 30 if no ``focus`` is given
    focus : depth below the intrados of the point where joints meet, in place of ``skewback``

    Examples
    --------
    kind = "flat_arch"
    name = "flat_arch"
    material = "stone"
    span = 2.0
    thickness = 0.4
    voussoirs = 7
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


def build(spec: FlatArchStructure, dimension: int) -> Assembly:
    """Voussoirs ``name.v01`` ... from the left, ``name.springing_left`` and ``_right``."""
    faces = [Offset(Segment(), by) for by in (0.0, spec.thickness)]
    low = np.linspace(-0.5, 0.5, spec.voussoirs + 1) * spec.span
    spread = 1 + 2 * spec.thickness * np.tan(np.radians(spec.slope)) / spec.span
    joints = np.column_stack([low, spread * low])
    stones = [Voussoir.between(faces, a, b) for a, b in pairwise(joints)]
    return arch_of(spec, stones, dimension, straight=True)
