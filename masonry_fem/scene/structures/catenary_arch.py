"""Catenary arch: voussoirs along a hanging chain turned over."""

from __future__ import annotations

from masonry_fem.scene.record import Length
from masonry_fem.scene.structures.voussoirs import Cut, VoussoirStructure


class CatenaryArchStructure(VoussoirStructure, frozen=True, kw_only=True, tag="catenary_arch"):
    """Arch of ``voussoirs`` stones along a catenary of ``span`` and ``rise``; springings as supports.

    Radial joints are normal to the catenary and cut it into equal lengths: the line of thrust under the
    arch's own weight. Vertical ones cut the span of the intrados into equal parts.
    """

    span: Length
    rise: Length
    cut: Cut = "radial"
    straight: bool = False
