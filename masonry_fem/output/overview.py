"""Overview: one sheet with the deformed shape, its von Mises stress and the resultants of the joints.

    draw_overview(Scenery.of(model, state, title="Arch of 11 voussoirs"), Path("arch.png"), 3e4)

It is the picture to show first; each of its parts has a sheet of its own in ``picture``.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from masonry_fem.output import fields
from masonry_fem.output.arrows import add_arrows, interface_resultants, legend_sample
from masonry_fem.output.marks import mark_ties
from masonry_fem.output.render import Stage, View
from masonry_fem.output.scenery import DeformedShape, Scenery
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

THRUST = "#e0218a"  # a colour that the stress scale has not
LONGEST = 0.8  # length of the longest arrow over a block's size


def draw_overview(scenery: Scenery, path: Path, amplification: float | None = None) -> Path:
    """Draw von Mises stress on the deformed shape, with the joints' resultants at their displaced places.

    Parameters
    ----------
    scenery : What to draw.
    path : The picture.
    amplification : Of displacements; None to choose one.

    Raises
    ------
    KeyError : No block has stresses.
    """
    shape = DeformedShape(scenery, amplification)
    mises = np.asarray(shape.surface.point_data[fields.VON_MISES])
    top, limit, over = colour_end(mises)
    factor, prefix = prefix_of(limit)
    shape.surface["_mises"] = mises / factor
    points, force, _ = interface_resultants(scenery.contacts)
    _, nearest = cKDTree(shape.surface.points).query(points)
    points = points + shape.factor * np.asarray(shape.surface.point_data[fields.DISPLACEMENT])[nearest]
    size = np.linalg.norm(force, axis=1)
    greatest = float(size.max(initial=0.0)) or 1.0
    vectors = force * (LONGEST * scenery.length / greatest)

    caption = f"{shape.caption()}; stress smoothed to the nodes, greatest there {quantity(top, 'Pa')}"
    if over:
        caption += f", colours end at {quantity(limit, 'Pa')}"
    sheet = Sheet(scenery.title or "Overview", caption)
    label, limits = f"von Mises\nat nodes [{prefix}Pa]", (0.0, max(limit / factor, 1e-12))
    sheet.bar = ColourBar(label, STRESS_COLOURS, limits, over)
    extent = np.concatenate([shape.deformed().points, points + vectors])
    stage = Stage(View.of(extent, scenery.dimension), sheet.image_width, scenery.length)
    look = {"cmap": STRESS_COLOURS, "clim": sheet.bar.limits, "nan_color": HELD, "n_colors": 256}
    stage.surface(shape.deformed(), scalars="_mises", **look)
    stage.lines(shape.deformed_elements(), LINE, 0.8, opacity=0.35)
    stage.lines(shape.deformed_outline(), LINE, 1.8)
    mark_ties(stage, sheet, scenery, shape, shape.factor)
    shown = size > 1e-6 * greatest
    add_arrows(stage, points[shown], vectors[shown], THRUST, fine=len(points) < 500)
    sample, pixels = legend_sample(greatest, LONGEST * scenery.length * stage.scale)
    sheet.keys.append(
        Key(
            f"{quantity(sample, scenery.force_unit)}, resultant of a joint on the upper block",
            THRUST,
            "arrow",
            pixels,
        )
    )
    if np.isnan(mises).any():
        sheet.keys.append(Key("rigid, no stress", HELD))
    return sheet.save(path, stage)
