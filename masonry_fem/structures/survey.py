"""Survey: the measured faces of the stones of a wall."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from masonry_fem.importing import SURVEYS
from masonry_fem.records.record import Axis, FilePath, Length, Positive
from masonry_fem.records.structure import MeshSettings, Structure
from masonry_fem.solid.assembly import Assembly


class SurveyStructure(Structure, frozen=True, kw_only=True, tag="survey"):
    """Wall of stones whose visible faces were measured; each is extruded to the wall's depth.

    The file is a ``.csv`` with the columns ``stone, vertex, x, y, z``, an ``.obj`` with one polygon per
    object, or a ``.dxf`` with a closed polyline around each stone. The wall's plane is fitted. Sides of
    neighbours within ``tolerance`` are moved to one line, so that stones touch without gap or overlap;
    wider gaps stay open. A message reports how far corners were moved. In 2D the polygons themselves are
    the stones. See [import](import.md#surveys).

    Attributes
    ----------
    path : ``.csv``, ``.obj`` or ``.dxf``, relative to the scene file
    depth : length of the stones behind the wall's plane; not used in 2D
    tolerance : gaps and overlaps of joints up to this are closed
    scale : factor from the file's unit of length to the metre
    outward : rough direction out of the wall; by default the side from which most polygons run
        counter-clockwise
    ground : a level support below the lowest stones
    supports : patterns of stones (without ``NAME.``) that are supports

    Examples
    --------
    kind = "survey"
    name = "survey"
    material = "stone"
    path = "wall.csv"
    depth = 0.3
    """

    endings = SURVEYS

    path: FilePath
    depth: Length
    tolerance: Length = 0.01
    scale: Positive = 1.0
    outward: Axis | None = None
    ground: bool = True
    supports: tuple[str, ...] = ()

    @property
    def carries(self) -> bool:
        """Whether it brings its ground or names supports."""
        return self.ground or bool(self.supports)

    @property
    def source(self) -> str:
        """Its path."""
        return self.path

    def faults(self, dimension: int) -> Iterator[tuple[str, str]]:
        """A tolerance beyond a wall's size, a direction without length."""
        if self.tolerance > self.depth / 2:
            yield (
                "tolerance",
                f"less than half the depth ({self.depth / 2:g} m): it is what joints were open by",
            )
        if self.outward is not None and not any(self.outward):
            yield "outward", "a direction out of the wall, such as [0, -1, 0]"


def build(spec: SurveyStructure, dimension: int, base: Path, mesh: MeshSettings) -> Assembly:
    """Blocks ``name.`` and the stones' names, and ``name.ground``; the path is relative to ``base``."""
    from masonry_fem.importing.survey import read  # noqa: PLC0415  surveys are rare

    return read(spec, dimension, base)
