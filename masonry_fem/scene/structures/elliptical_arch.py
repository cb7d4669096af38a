"""Elliptical arch: voussoirs along half an ellipse."""

from __future__ import annotations

from collections.abc import Iterator

from masonry_fem.scene.record import Length
from masonry_fem.scene.structures.voussoirs import Cut, VoussoirStructure


class EllipticalArchStructure(VoussoirStructure, frozen=True, kw_only=True, tag="elliptical_arch"):
    """Arch of ``voussoirs`` stones along half an ellipse of ``span`` and ``rise``; springings as supports.

    Radial joints are normal to the ellipse and cut it into equal lengths, vertical ones cut the span of
    the intrados into equal parts. ``straight`` voussoirs have chords for arcs.
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
