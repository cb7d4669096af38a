"""Material picture: where stones have yielded or cracked, element by element, on the deformed shape."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from masonry_fem.output import fields
from masonry_fem.output.backdrop import title_of
from masonry_fem.output.render import Stage, View
from masonry_fem.output.scenery import DeformedShape, Scenery
from masonry_fem.output.sheet import HELD, LINE, ColourBar, Key, Sheet, colour_end

COLOURS = "inferno_r"
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
    sheet.bar = ColourBar(f"{word} [-]", COLOURS, limits, over)
    if np.isnan(values).any():
        sheet.keys.append(Key("neither yields nor cracks", HELD))
    stage = Stage(View.of(shape.extent(), scenery.dimension), sheet.image_width, scenery.length)
    options = {"cmap": COLOURS, "clim": limits, "nan_color": HELD, "preference": "cell"}
    stage.surface(shape.deformed(), scalars=measure, **options)
    stage.lines(shape.deformed_elements(), LINE, 0.7, opacity=0.3)
    stage.lines(shape.deformed_outline(), LINE, 1.6, rank=2)
    return sheet.save(path, stage)
