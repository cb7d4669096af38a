"""Stone pictures: how much of their strength stones use, where they yield or crack, errors of the stress."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from masonry_fem.output import fields
from masonry_fem.output.backdrop import title_of
from masonry_fem.output.marks import rings
from masonry_fem.output.render import Stage, View
from masonry_fem.output.scenery import DeformedShape, Scenery, element_edges_of, outline_of, surface_of
from masonry_fem.output.sheet import HELD, LINE, ColourBar, Key, Sheet, colour_end

MEASURE_COLOURS, ERROR_COLOURS, USED_COLOURS, BEYOND = "inferno_r", "magma_r", "YlOrRd", "#3b0764"
ALIKE = 0.99  # of the greatest utilisation: as great
RING, RING_LINE = 26.0, 4.0  # about the worst point: radius and breadth of its line [pixels]
WHOLE = {"damage": 1.0}  # measures that end at a value of their own, and their colours with it


def measures_of(blocks: Any) -> list[str]:
    """Names of what material laws measure, where some stone has any of it: ``plastic_strain``, ``damage``.

    Parameters
    ----------
    blocks : A scenery's, of a model or read from a field file.
    """
    return [
        name
        for name, values in blocks.cell_data.items()
        if name not in fields.CELLS and values.dtype.kind == "f" and np.nanmax(values, initial=0.0) > 0
    ]


def draw_measure(scenery: Scenery, measure: str, path: Path, amplification: float | None = None) -> Path:
    """Draw each element's mean of what a material law measures.

    Parameters
    ----------
    scenery : What to draw.
    measure : Name of the cell field.
    path : The picture.
    amplification : Of displacements; None to choose one.
    """
    shape = DeformedShape(scenery, amplification)
    values = np.asarray(scenery.blocks.cell_data[measure], float)
    top, limit, over = colour_end(values)
    if measure in WHOLE:
        limit, over = WHOLE[measure], False
    limits = (0.0, max(limit, 1e-12))
    word = measure.replace("_", " ")
    sheet = Sheet(
        title_of(scenery.title, f"{word} of the stones"),
        f"{shape.caption()}; mean of each element, greatest {top:.3g}"
        + (f", colours end at {limit:.3g}" if over else ""),
    )
    sheet.bar = ColourBar(f"{word} [-]", MEASURE_COLOURS, limits, over)
    if np.isnan(values).any():
        sheet.keys.append(Key("neither yields nor cracks", HELD))
    stage = Stage(View.of(shape.extent(), scenery.dimension), sheet.image_width, scenery.length)
    options = {"cmap": MEASURE_COLOURS, "clim": limits, "nan_color": HELD, "preference": "cell"}
    stage.surface(shape.deformed(), scalars=measure, **options)
    stage.lines(shape.deformed_elements(), LINE, 0.7, opacity=0.3)
    stage.lines(shape.deformed_outline(), LINE, 1.6, rank=2)
    return sheet.save(path, stage)


def draw_error(scenery: Scenery, path: Path) -> Path:
    """Draw each element's estimated stress error over the mean of all, on the undeformed mesh.

    Parameters
    ----------
    scenery : What to draw.
    path : The picture.
    """
    blocks = scenery.blocks.copy(deep=False)
    density = np.asarray(blocks.cell_data[fields.STRESS_ERROR], float)
    sizes = blocks.compute_cell_sizes(length=False)
    volume = np.abs(np.asarray(sizes.cell_data["Volume" if scenery.dimension == 3 else "Area"], float))
    known = np.isfinite(density)
    mean = float((density * volume)[known].sum() / volume[known].sum())
    blocks.cell_data["_error"] = np.sqrt(density / mean) if mean > 0 else 0.0 * density
    top, limit, over = colour_end(np.asarray(blocks.cell_data["_error"]))
    blocks.clear_point_data()
    limits = (0.0, max(limit, 1e-12))
    sheet = Sheet(
        title_of(scenery.title, "error of the stress"),
        f"Estimated error of each element over the mean (in the energy norm, by volume), greatest {top:.3g}"
        + (f", colours end at {limit:.3g}" if over else "")
        + "; structure undeformed",
    )
    sheet.bar = ColourBar("error / mean error", ERROR_COLOURS, limits, over)
    surface = surface_of(blocks)
    stage = Stage(View.of(surface.points, scenery.dimension), sheet.image_width, scenery.length)
    stage.surface(
        surface, scalars="_error", preference="cell", cmap=ERROR_COLOURS, clim=limits, nan_color=HELD
    )
    stage.lines(element_edges_of(blocks), LINE, 0.7, opacity=0.3)
    stage.lines(outline_of(surface), LINE, 1.6, rank=2)
    return sheet.save(path, stage)


def draw_utilisation(scenery: Scenery, path: Path, amplification: float | None = None) -> Path:
    """Draw the utilisation of the stress smoothed to the nodes; what is above 1 has a colour of its own.

    Parameters
    ----------
    scenery : What to draw.
    path : The picture.
    amplification : Of displacements; None to choose one.
    """
    shape = DeformedShape(scenery, amplification)
    used = np.asarray(shape.surface.point_data[fields.UTILISATION], float)
    top, limit, over = colour_end(used)
    if top > 1:
        limit, over = 1.0, True
    limits = (0.0, max(limit, 1e-12))
    sheet = Sheet(
        title_of(scenery.title, "utilisation of the strength"),
        f"{shape.caption()}; stress smoothed to the nodes, greatest there {top:.3g} (ringed, also if hidden)"
        + (f", colours end at {limit:.3g}" if over else ""),
    )
    sheet.bar = ColourBar("utilisation\nat nodes [-]", USED_COLOURS, limits, over)
    options = {"cmap": USED_COLOURS, "clim": limits, "nan_color": HELD, "n_colors": 256}
    if top > 1:
        options["above_color"] = BEYOND
        sheet.keys.append(Key("more than the strength", BEYOND))
    if np.isnan(used).any():
        sheet.keys.append(Key("rigid or of unknown strength", HELD))
    stage = Stage(View.of(shape.extent(), scenery.dimension), sheet.image_width, scenery.length)
    surface = shape.deformed()
    stage.surface(surface, scalars=fields.UTILISATION, **options)
    stage.lines(shape.deformed_elements(), LINE, 0.9, opacity=0.3)
    stage.lines(shape.deformed_outline(), LINE, 1.6)
    if np.isfinite(used).any():
        points = np.asarray(surface.points, float)
        alike = np.flatnonzero(used >= ALIKE * top)  # of mirror images the one in front
        worst = alike[np.argmax(points[alike] @ stage.view.axes[2])]
        stage.mark(rings(stage.view, points[[worst]], RING / stage.scale, RING_LINE / stage.scale), LINE)
    return sheet.save(path, stage)
