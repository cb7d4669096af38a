"""Cut: stresses on a plane through a 3D structure, seen along the plane's normal.

    plane = Plane("middle", (0.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    draw_cut(scenery, plane, Path("out"))           # out/cut_middle_von_mises.png

The undeformed structure is cut; the section is drawn displaced, as in the other pictures. Stresses are the
nodal ones, interpolated to the plane. Rigid blocks have no stresses.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from masonry_fem.output import fields
from masonry_fem.output.backdrop import small, title_of
from masonry_fem.output.render import Stage, View
from masonry_fem.output.scenery import DeformedShape, Scenery, surface_of
from masonry_fem.output.sheet import (
    HELD,
    LINE,
    STRESS_COLOURS,
    ColourBar,
    Key,
    Sheet,
    colour_end,
    prefix_of,
    quantity,
)
from masonry_fem.records.remark import remark

FloatArray = NDArray[np.float64]

# words of the title, label, column of the array (None: it is a scalar)
SHOWN: dict[str, tuple[str, str, str, int | None]] = {
    "von_mises": ("von Mises stress", "von Mises", fields.VON_MISES, None),
    "vertical": ("vertical stress", "vertical\nstress", fields.STRESS, 2),
    "greatest": ("greatest principal stress", "greatest\nprincipal", fields.PRINCIPAL, 0),
    "least": ("least principal stress", "least\nprincipal", fields.PRINCIPAL, 2),
}
SIGNED_COLOURS = "RdBu_r"  # compression blue, tension red, as bars in other pictures


BEHIND = 1e-7  # of the structure's size: how far behind its plane a cut is made


@dataclass(frozen=True, slots=True)
class Plane:
    """Where to cut and what to show.

    Attributes
    ----------
    name : Part of the pictures' names.
    point : On the plane [m]. normal : Across it, towards the eye; any length but 0.
    show : Of ``von_mises``, ``vertical``, ``greatest``, ``least``.
    """

    name: str
    point: tuple[float, ...]
    normal: tuple[float, ...]
    show: tuple[str, ...] = ("von_mises",)


def draw_cut(
    scenery: Scenery, plane: Plane, directory: Path, amplification: float | None = None
) -> list[Path]:
    """Draw one picture per field; if the plane meets no block there is a warning and no picture.

    Parameters
    ----------
    scenery : What to draw.
    plane : Name, point, normal and fields of the cut.
    directory : Folder for the pictures.
    amplification : Of displacements; None to choose one.

    Returns
    -------
    Paths of the pictures.
    """
    section = section_of(scenery.blocks, plane)
    if not section.n_cells:
        points = np.asarray(scenery.blocks.points)
        ends = np.round(points.min(axis=0), 4).tolist(), np.round(points.max(axis=0), 4).tolist()
        remark(
            "empty_cut",
            f"cut '{plane.name}' through {plane.point} meets no block: no picture; expected a "
            f"point in the structure, which reaches from {ends[0]} to {ends[1]}",
        )
        return []
    folder = Path(directory)
    return [
        _draw(scenery, plane, section, field, folder / f"cut_{plane.name}_{field}.png", amplification)
        for field in plane.show
    ]


def section_of(grid: Any, plane: Plane) -> Any:
    """Where a plane cuts the cells of a grid: polygons with the arrays of points and cells."""
    import pyvista as pv  # noqa: PLC0415
    from vtkmodules.vtkCommonDataModel import vtkNonMergingPointLocator, vtkPlane  # noqa: PLC0415
    from vtkmodules.vtkFiltersCore import vtkCutter  # noqa: PLC0415

    where = vtkPlane()
    # a plane that runs along joints cuts the blocks behind it, not now these and now those
    across = np.array(plane.normal, float) / np.linalg.norm(plane.normal)
    size = float(np.linalg.norm(np.ptp(np.asarray(grid.points), axis=0)))
    where.SetOrigin(*(np.array(plane.point, float) - BEHIND * size * across))
    where.SetNormal(*across)
    cutter = vtkCutter()
    cutter.SetInputData(grid)
    cutter.SetCutFunction(where)
    cutter.SetLocator(vtkNonMergingPointLocator())  # points of two blocks that touch move apart
    cutter.Update()
    return pv.wrap(cutter.GetOutput())


def area_of(section: Any) -> float:
    """Area of a section [m²]."""
    return float(np.abs(section.compute_cell_sizes(length=False, volume=False).cell_data["Area"]).sum())


def _draw(
    scenery: Scenery, plane: Plane, section: Any, field: str, path: Path, amplification: float | None
) -> Path:
    words, label, array, column = SHOWN[field]
    shape = DeformedShape(scenery, amplification)
    surface = _moved(section, shape.factor)
    outline = _moved(section_of(surface_of(_bare(scenery.blocks)), plane), shape.factor)
    values = np.full(section.n_points, np.nan)
    if array in section.point_data:
        field_values = np.asarray(section.point_data[array], float)
        values = field_values if column is None else field_values[:, column]
    sheet = Sheet(title_of(scenery.title, f"{words}, cut '{plane.name}'"), "")
    look = _colours(sheet, surface, values, label, signed=field != "von_mises")
    stage = Stage(_view(surface, plane), sheet.image_width, scenery.length)
    stage.surface(surface, lighting=False, **look)
    stage.lines(outline, LINE, 2.0, rank=2)
    place, across = (
        ", ".join(f"{x:g}".replace("-", "−") for x in vector) for vector in (plane.point, plane.normal)
    )
    where = f"Plane through ({place}) m, normal ({across}), cuts {area_of(section):.4g} m²"
    sheet.caption = f"{where}; {_range(values, sheet.bar)}{small(shape.caption())}"
    return sheet.save(path, stage)


def _colours(sheet: Sheet, surface: Any, values: FloatArray, label: str, *, signed: bool) -> dict[str, Any]:
    """How the section is coloured; the sheet gets its bar and its key."""
    if np.isnan(values).any():
        sheet.keys.append(Key("rigid, no stress", HELD))
    if np.isnan(values).all():
        return {"color": HELD}
    _, limit, over = colour_end(np.abs(values))
    factor, prefix = prefix_of(limit)
    surface.point_data["_value"] = values / factor
    end = max(limit / factor, 1e-12)
    colours = SIGNED_COLOURS if signed else STRESS_COLOURS
    limits = (-end if signed else 0.0, end)
    sheet.bar = ColourBar(f"{label}\n[{prefix}Pa]", colours, limits, over)
    return {"scalars": "_value", "cmap": colours, "clim": limits, "nan_color": HELD, "n_colors": 256}


def _range(values: FloatArray, bar: ColourBar | None) -> str:
    """What the caption says of the values."""
    if bar is None:
        return "no elastic block is cut; "
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    told = f"from {quantity(low, 'Pa')} to {quantity(high, 'Pa')}"
    if bar.limits[0] < 0:
        told += " (tension positive)"
    if bar.over:
        told += f", colours end at {quantity(colour_end(np.abs(values))[1], 'Pa')}"
    return told + "; "


def _bare(grid: Any) -> Any:
    """A grid with its displacement only."""
    bare = grid.copy()
    bare.clear_data()
    bare.point_data[fields.DISPLACEMENT] = grid.point_data[fields.DISPLACEMENT]
    return bare


def _moved(mesh: Any, factor: float) -> Any:
    moved = mesh.copy()
    moved.points = mesh.points + factor * np.asarray(mesh.point_data[fields.DISPLACEMENT])
    return moved


def _view(section: Any, plane: Plane) -> View:
    """From the side of the normal; z upwards, in a horizontal plane y."""
    towards = np.array(plane.normal, float)
    towards /= np.linalg.norm(towards)
    up = np.array([0.0, 0.0, 1.0]) if abs(towards[2]) < 0.999 else np.array([0.0, 1.0, 0.0])
    return View.along(np.asarray(section.points, float), towards, up)
