"""Error picture: where the elements' stress is least accurate, element by element."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from masonry_fem.output import fields
from masonry_fem.output.backdrop import title_of
from masonry_fem.output.render import Stage, View
from masonry_fem.output.scenery import Scenery, element_edges_of, outline_of, surface_of
from masonry_fem.output.sheet import HELD, LINE, ColourBar, Sheet, colour_end

COLOURS = "magma_r"


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
    sheet.bar = ColourBar("error / mean error", COLOURS, limits, over)
    surface = surface_of(blocks)
    stage = Stage(View.of(surface.points, scenery.dimension), sheet.image_width, scenery.length)
    stage.surface(surface, scalars="_error", preference="cell", cmap=COLOURS, clim=limits, nan_color=HELD)
    stage.lines(element_edges_of(blocks), LINE, 0.7, opacity=0.3)
    stage.lines(outline_of(surface), LINE, 1.6, rank=2)
    return sheet.save(path, stage)
