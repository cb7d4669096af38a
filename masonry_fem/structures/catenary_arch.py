"""Catenary arch: stones between two curves at equal distances from a catenary."""

from __future__ import annotations

from masonry_fem.errors import GeometryError
from masonry_fem.records.record import Length
from masonry_fem.solid.assembly import Assembly
from masonry_fem.structures.parts.curve import Catenary
from masonry_fem.structures.parts.quarry import arch_of
from masonry_fem.structures.parts.voussoir import cut_line
from masonry_fem.structures.parts.voussoir_row import Cut, VoussoirStructure


class CatenaryArchStructure(VoussoirStructure, frozen=True, kw_only=True, tag="catenary_arch"):
    """Arch of ``voussoirs`` stones along a catenary of ``span`` and ``rise``; springings as supports.

    The catenary is the line of thrust under the arch's own weight. Radial joints are normal to it and divide
    it into equal lengths. Vertical ones divide the span of the intrados into equal parts.

    Attributes
    ----------
    thickness : distance between intrados and extrados, normal to the catenary
    span : span of the mean line
    rise : rise of the mean line
    cut : ``radial`` joints are normal to the mean line, or all joints between the springings are vertical
    straight : voussoirs have chords in place of arcs

    Examples
    --------
    kind = "catenary_arch"
    name = "catenary_arch"
    material = "stone"
    span = 4.0
    rise = 2.0
    thickness = 0.4
    voussoirs = 11
    """

    span: Length
    rise: Length
    cut: Cut = "radial"
    straight: bool = False


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
