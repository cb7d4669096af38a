"""DXF: outlines of stones from a drawing of a wall: closed polylines, those in inserted blocks too.

    stones = read_dxf(Path("facade.dxf"), "structures.facade.path 'facade.dxf'", 0.001)

A stone is called like its layer where this has no other, else the layer and a number from left to right and
upwards. A flat drawing is an elevation: its y is upwards. Arcs become chains of short sides. Needs ezdxf.
"""

from __future__ import annotations

import re
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

from masonry_fem.errors import GeometryError
from masonry_fem.host import installation
from masonry_fem.importing.naming import UNSPACED, Names, tell_renamed, unlike
from masonry_fem.records.remark import remark
from masonry_fem.solid.pose import FloatArray

SAG = 2e-3  # of a stone's size: how far a side may be from the arc that it stands for
METRES = {1: 0.0254, 2: 0.3048, 4: 1e-3, 5: 1e-2, 6: 1.0, 7: 1e3, 14: 0.1}  # by the drawing's $INSUNITS


def read_dxf(path: Path, title: str, scale: float) -> list[tuple[str, FloatArray]]:
    """Names and corners of the stones, shape (k, 3) [unit of the drawing].

    Parameters
    ----------
    path : The drawing. title : Name of the file in messages.
    scale : From its unit to the metre, as the scene says; a drawing that says otherwise is remarked.

    Raises
    ------
    InstallationError : ezdxf is missing.
    GeometryError : The file is no drawing, or has no closed polyline.
    """
    installation.require_extra("dxf", f"{title} cannot be read")
    import ezdxf  # noqa: PLC0415

    try:
        drawing = ezdxf.readfile(str(path))
    except (OSError, ezdxf.DXFError, ValueError, UnicodeError) as error:
        raise GeometryError(f"{title} is no DXF that ezdxf can read ({error}); save it again") from error
    _tell_unit(int(drawing.units), scale, title)
    found, open_ones = _outlines(drawing.modelspace())
    if open_ones:
        remark(
            "open_outlines",
            f"{title}: {open_ones} polylines are open and left out; close those that are outlines of stones",
        )
    if not found:
        kinds = Counter(entity.dxftype() for entity in drawing.modelspace())
        said = ", ".join(f"{count} {kind}" for kind, count in kinds.most_common(4)) or "nothing"
        raise GeometryError(
            f"{title} has no closed polyline but {said}, expected one around each stone; join its lines"
        )
    return _named(_upright(found), title)


def _tell_unit(unit: int, scale: float, title: str) -> None:
    metres = METRES.get(unit)
    if metres is not None and not np.isclose(metres, scale, rtol=1e-6):
        remark(
            "drawing_unit",
            f"{title}: by its header ($INSUNITS = {unit}) its unit is {metres:g} m, but the scene's scale is "
            f"{scale:g}; write scale = {metres:g} if the header is right",
        )


def _outlines(space: Any) -> tuple[list[tuple[str, FloatArray]], int]:
    """Layer and corners of the closed polylines, and how many are open."""
    from ezdxf.disassemble import recursive_decompose  # noqa: PLC0415
    from ezdxf.path import make_path  # noqa: PLC0415

    found, open_ones = [], 0
    for entity in recursive_decompose(space):
        if entity.dxftype() not in ("LWPOLYLINE", "POLYLINE"):
            continue
        outline = make_path(entity)
        corners = np.array([tuple(point) for point in outline.control_vertices()], dtype=float)
        if outline.has_curves:
            sag = SAG * float(np.linalg.norm(np.ptp(corners, axis=0)))
            corners = np.array([tuple(point) for point in outline.flattening(sag)], dtype=float)
        if len(corners) and np.allclose(corners[0], corners[-1]):
            found.append((str(entity.dxf.layer), corners[:-1]))
        else:
            open_ones += 1
    return found, open_ones


def _upright(found: list[tuple[str, FloatArray]]) -> list[tuple[str, FloatArray]]:
    """The outlines with the drawing's y as height, where it is flat; from left to right and upwards."""
    points = np.concatenate([corners for _, corners in found])
    if np.ptp(points[:, 2]) <= 1e-9 * np.ptp(points, axis=0).max():
        # seen from the front, at negative y: what runs anticlockwise in the drawing does so there
        found = [(layer, corners[:, [0, 2, 1]] * [1.0, 0.0, 1.0]) for layer, corners in found]
    size = float(np.ptp(points, axis=0).max())
    return sorted(found, key=lambda one: tuple(np.round(one[1].mean(axis=0)[[2, 0, 1]] / size, 3)))


def _named(found: list[tuple[str, FloatArray]], title: str) -> list[tuple[str, FloatArray]]:
    """The outlines by names that selectors can use."""
    names = Names(UNSPACED)
    many = Counter(layer for layer, _ in found)
    count: Counter[str] = Counter()
    made = []
    for layer, _ in found:
        count[layer] += 1
        own = names.of(layer, prefix="s" if re.match(r"[\W_]*\d", layer) else "") or "stone"
        made.append(own if many[layer] == 1 else f"{own}_{count[layer]}")
    tell_renamed(title, names.changed)
    return [(name, corners) for name, (_, corners) in zip(unlike(made), found, strict=True)]
