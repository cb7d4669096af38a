"""Elliptical arch: stones between two curves beside half an ellipse."""

from __future__ import annotations

import numpy as np

from masonry_fem.scene.specs import EllipticalArchStructure
from masonry_fem.solid.assembly import Assembly
from masonry_fem.structures.curve import Ellipse
from masonry_fem.structures.quarry import arch_of
from masonry_fem.structures.voussoir import cut_line


def build(spec: EllipticalArchStructure, dimension: int) -> Assembly:
    """Voussoirs ``name.v01`` ... from the left, ``name.springing_left`` and ``_right``."""
    line = Ellipse(spec.span / 2, spec.rise)
    stones = cut_line(line, -np.pi / 2, np.pi / 2, spec.thickness, spec.voussoirs, spec.cut)
    return arch_of(spec, stones, dimension, spec.straight)
