"""Joint maps: how far joints have opened and slid, in colours on the deformed shape.

    draw_opening(scenery, Path("opening.png"))       # a map of cracks
    draw_sliding(scenery, Path("sliding.png"))

In 2D joints are thick lines, in 3D their faces; joints that neither opened nor slid are pale.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from masonry_fem.output import fields, interface_fields
from masonry_fem.output.backdrop import STONE, small, title_of
from masonry_fem.output.marks import bands
from masonry_fem.output.render import Stage, View
from masonry_fem.output.scenery import DeformedShape, Scenery, outline_of, surface_of
from masonry_fem.output.sheet import ColourBar, Key, Sheet, prefix_of, quantity

FloatArray = NDArray[np.float64]

COLOURS = "YlOrRd"
REST, EDGE = "#b9bec4", "#7d858d"
ROUNDING = 1e-10  # of a structure's size: what a solver's tolerance leaves between rigid blocks
SHOWN = 1e-3  # of the greatest: what opened or slid less stays pale


def draw_opening(scenery: Scenery, path: Path, amplification: float | None = None) -> Path:
    """Draw openings, normal to the joints.

    Parameters
    ----------
    scenery : What to draw.
    path : The picture.
    amplification : Of displacements; None to choose one.
    """
    return _draw(scenery, path, amplification, interface_fields.OPENING, "opening", "open")


def draw_sliding(scenery: Scenery, path: Path, amplification: float | None = None) -> Path:
    """Draw slides since the start, along the joints.

    Parameters
    ----------
    scenery : What to draw.
    path : The picture.
    amplification : Of displacements; None to choose one.
    """
    return _draw(scenery, path, amplification, interface_fields.SLIDING, "sliding", "have slid")


def _draw(scenery: Scenery, path: Path, amplification: float | None, name: str, what: str, verb: str) -> Path:
    faces, shape = scenery.interfaces, DeformedShape(scenery, amplification)
    value, most = np.asarray(faces.point_data[name], float), np.asarray(faces.cell_data[name], float)
    greatest = float(most.max(initial=0.0))
    rounding = ROUNDING * float(np.linalg.norm(np.ptp(np.asarray(scenery.blocks.points), axis=0)))
    shown = (most > SHOWN * greatest) & (greatest > rounding)
    factor, prefix = prefix_of(greatest if shown.any() else 0.0)
    moved = faces.copy()
    moved.points = faces.points + shape.factor * np.asarray(faces.point_data[fields.DISPLACEMENT])
    moved.point_data["_value"] = value / factor
    sheet = Sheet(title_of(scenery.title, f"{what} of the joints"), "")
    joint = np.asarray(faces.cell_data[fields.INTERFACE])
    counts = f"{len(np.unique(joint[shown]))} of {len(np.unique(joint))} joints"
    told = f"{counts} {verb}, greatest {quantity(greatest, 'm')}"
    told = told if shown.any() else f"No joint {'opens' if what == 'opening' else 'slides'} beyond rounding"
    sheet.caption = f"{told}; {small(shape.caption())}"
    limits = (0.0, max(greatest / factor, 1e-12))
    if shown.any():
        sheet.bar = ColourBar(f"{what} [{prefix}m]", COLOURS, limits)
    if scenery.dimension == 2:
        sheet.keys.append(Key("closed" if what == "opening" else "has not slid", REST, "line", 44))
    stage = Stage(View.of(shape.extent(), scenery.dimension), sheet.image_width, scenery.length)
    stage.surface(shape.deformed(), color=STONE, opacity=1.0)
    stage.lines(shape.deformed_outline(), EDGE, 1.0)
    draw = _lines if scenery.dimension == 2 else _patches
    draw(stage, moved, shown, limits, scenery.length)
    return sheet.save(path, stage)


def _lines(
    stage: Stage, faces: Any, shown: NDArray[np.bool_], limits: tuple[float, float], length: float
) -> None:
    """Joints of a plane structure as bands of a few pixels, coloured along them."""
    offsets, points = _offsets(faces), np.asarray(faces.points, float)
    order = np.asarray(faces.cell_connectivity)
    ends = np.stack([order[offsets[:-1]], order[offsets[1:] - 1]], axis=1)
    pixels = float(np.clip(0.07 * length * stage.scale, 2.5, 9.0))
    values = np.asarray(faces.point_data["_value"])
    for mask, width in ((~shown, 0.35), (shown, 1.0)):
        pair = ends[mask]
        if not len(pair):
            continue
        wide = np.full(pair.shape, width * pixels / stage.scale)
        mesh = bands(stage.view, points[pair[:, 0]], points[pair[:, 1]], wide)
        if width < 1:
            stage.mark(mesh, REST)
        else:
            mesh.point_data["_value"] = np.repeat(values[pair], 2, axis=1).ravel()
            stage.mark(mesh, rank=5, scalars="_value", cmap=COLOURS, clim=limits)


def _patches(
    stage: Stage, faces: Any, shown: NDArray[np.bool_], limits: tuple[float, float], length: float
) -> None:
    """Faces of the joints, drawn over the blocks so that inner ones are visible, too."""
    if shown.any():
        opened = surface_of(faces.extract_cells(np.flatnonzero(shown)))
        stage.mark(opened, scalars="_value", cmap=COLOURS, clim=limits, opacity=0.85)
        _, joint, parts = np.unique(
            faces.cell_data[fields.INTERFACE], return_inverse=True, return_counts=True
        )
        whole = shown & (parts[joint] == 1)  # edges between the parts of a round joint would cut it up
        if whole.any():
            edges = outline_of(surface_of(faces.extract_cells(np.flatnonzero(whole))))
            stage.mark(edges, EDGE, rank=5, line_width=1.0)


def _offsets(faces: Any) -> NDArray[np.int64]:
    """Where each face starts and ends in the connectivity, shape (faces + 1,); by VTK, for any pyvista."""
    from vtkmodules.util.numpy_support import vtk_to_numpy  # noqa: PLC0415

    offsets: NDArray[np.int64] = vtk_to_numpy(faces.GetCells().GetOffsetsArray()).astype(np.int64)
    return offsets
