"""Elliptical arch: stones between two curves at equal distances from half an ellipse."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from masonry_fem.records.record import Length
from masonry_fem.solid.assembly import Assembly
from masonry_fem.structures.parts.curve import Ellipse
from masonry_fem.structures.parts.quarry import arch_of
from masonry_fem.structures.parts.voussoir import cut_line
from masonry_fem.structures.parts.voussoir_row import Cut, VoussoirStructure


class EllipticalArchStructure(VoussoirStructure, frozen=True, kw_only=True, tag="elliptical_arch"):
    """Arch of ``voussoirs`` stones along half an ellipse of ``span`` and ``rise``; springings as supports.

    Radial joints are normal to the ellipse and divide it into equal lengths; vertical ones divide the span of
    the intrados into equal parts.

    Attributes
    ----------
    thickness : distance between intrados and extrados, normal to the ellipse
    span : span of the mean line
    rise : rise of the mean line
    cut : ``radial`` joints are normal to the mean line, or all joints between the springings are vertical
    straight : voussoirs have chords in place of arcs

    Examples
    --------
    kind = "elliptical_arch"
    name = "elliptical_arch"
    material = "stone"
    span = 4.0
    rise = 1.5
    thickness = 0.4
    voussoirs = 11
    """

    span: Length
    rise: Length
    cut: Cut = "radial"
    straight: bool = False

    def faults(self, dimension: int) -> Iterator[tuple[str, str]]:
        """Stones thicker than the ellipse is round."""
        small, large = sorted((self.span / 2, self.rise))
        least = small**2 / large
        if self.thickness >= 2 * least:
            yield "thickness", f"less than twice the ellipse's least radius of curvature ({least:g} m)"


def build(spec: EllipticalArchStructure, dimension: int) -> Assembly:
    """Voussoirs ``name.v01`` ... from the left, ``name.springing_left`` and ``_right``."""
    line = Ellipse(spec.span / 2, spec.rise)
    stones = cut_line(line, -np.pi / 2, np.pi / 2, spec.thickness, spec.voussoirs, spec.cut)
    return arch_of(spec, stones, dimension, spec.straight)
