"""Utilisation picture: what share of its strength the stone uses at each point, on the deformed shape."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from masonry_fem.output import fields
from masonry_fem.output.backdrop import title_of
from masonry_fem.output.render import Stage, View
from masonry_fem.output.scenery import DeformedShape, Scenery
from masonry_fem.output.sheet import HELD, LINE, ColourBar, Key, Sheet, colour_end

COLOURS, BEYOND = "YlOrRd", "#3b0764"


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
        f"{shape.caption()}; stress smoothed to the nodes, greatest there {top:.3g}"
        + (f", colours end at {limit:.3g}" if over else ""),
    )
    sheet.bar = ColourBar("utilisation\nat nodes [-]", COLOURS, limits, over)
    options = {"cmap": COLOURS, "clim": limits, "nan_color": HELD, "n_colors": 256}
    if top > 1:
        options["above_color"] = BEYOND
        sheet.keys.append(Key("more than the strength", BEYOND))
    if np.isnan(used).any():
        sheet.keys.append(Key("rigid or of unknown strength", HELD))
    stage = Stage(View.of(shape.extent(), scenery.dimension), sheet.image_width, scenery.length)
    stage.surface(shape.deformed(), scalars=fields.UTILISATION, **options)
    stage.lines(shape.deformed_elements(), LINE, 0.9, opacity=0.3)
    stage.lines(shape.deformed_outline(), LINE, 1.6)
    return sheet.save(path, stage)
