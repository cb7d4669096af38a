"""Catenary arch: stones between two curves beside a catenary."""

from __future__ import annotations

from masonry_fem.errors import GeometryError
from masonry_fem.scene.specs import CatenaryArchStructure
from masonry_fem.solid.assembly import Assembly
from masonry_fem.structures.curve import Catenary
from masonry_fem.structures.quarry import arch_of
from masonry_fem.structures.voussoir import cut_line


def build(spec: CatenaryArchStructure, dimension: int) -> Assembly:
    """Voussoirs ``name.v01`` ... from the left, ``name.springing_left`` and ``_right``."""
    line = Catenary.through(spec.span, spec.rise)
    if spec.thickness >= 2 * line.scale:
        raise GeometryError(
            f"structures.{spec.name}.thickness is {spec.thickness} m, expected less than twice the "
            f"catenary's radius at the crown ({line.scale:g} m)"
        )
    half = spec.span / 2
    stones = cut_line(line, -half, half, spec.thickness, spec.voussoirs, spec.cut)
    return arch_of(spec, stones, dimension, spec.straight)
