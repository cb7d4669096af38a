"""Flat arch: stones between two levels, their joints on lines through one point below."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from masonry_fem.scene.specs import FlatArchStructure
from masonry_fem.solid.assembly import Assembly
from masonry_fem.structures.curve import Offset, Segment
from masonry_fem.structures.quarry import arch_of
from masonry_fem.structures.voussoir import Voussoir


def build(spec: FlatArchStructure, dimension: int) -> Assembly:
    """Voussoirs ``name.v01`` ... from the left, ``name.springing_left`` and ``_right``."""
    faces = [Offset(Segment(), by) for by in (0.0, spec.thickness)]
    low = np.linspace(-0.5, 0.5, spec.voussoirs + 1) * spec.span
    spread = 1 + 2 * spec.thickness * np.tan(np.radians(spec.slope)) / spec.span
    joints = np.column_stack([low, spread * low])
    stones = [Voussoir.between(faces, a, b) for a, b in pairwise(joints)]
    return arch_of(spec, stones, dimension, straight=True)
