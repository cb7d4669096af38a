"""Tie marks: ties as bands in a picture, as wide as their force.

mark_ties(stage, sheet, scenery, shape, factor)
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from masonry_fem.output import fields
from masonry_fem.output.marks import bands
from masonry_fem.output.render import Stage
from masonry_fem.output.scenery import DeformedShape, Scenery
from masonry_fem.output.sheet import Key, Sheet, quantity

TIE, SLACK = "#a3123a", "#8b939c"
WIDEST, THINNEST = 6.0, 1.6  # bands [pixels]
LEAST = 1e-9  # of the greatest force of a tie: those that bear less are slack


def mark_ties(stage: Stage, sheet: Sheet, scenery: Scenery, shape: DeformedShape, factor: float) -> None:
    """Draw the ties of a scenery over all else, with a line of the legend.

    Parameters
    ----------
    stage, sheet : The picture.
    scenery : What is drawn; without ties nothing is done.
    shape : Its blocks.
    factor : By which their displacements are amplified.
    """
    if scenery.ties is None:
        return
    starts = np.asarray(scenery.ties.points, float)
    ends = starts + np.asarray(scenery.ties.point_data[fields.TIE], float)
    force = np.linalg.norm(np.asarray(scenery.ties.point_data[fields.REACTION], float), axis=1)
    moved = np.asarray(shape.surface.point_data[fields.DISPLACEMENT], float)
    nearest = cKDTree(np.asarray(shape.surface.points) + moved)
    starts, ends = (at + (factor - 1.0) * moved[nearest.query(at)[1]] for at in (starts, ends))
    top = float(force.max(initial=0.0))
    taut = force > LEAST * top
    wide = np.maximum(WIDEST * force / (top or 1.0), THINNEST) / stage.scale
    for colour, own in ((SLACK, ~taut), (TIE, taut)):
        both = np.repeat(wide[own, None], 2, axis=1)
        stage.mark(bands(stage.view, starts[own], ends[own], both), colour, rank=2)
    if taut.any():
        words = "tie" if len(force) == 1 else "greatest force of a tie"
        sheet.keys.append(Key(f"{quantity(top, scenery.force_unit)}, {words}", TIE, "line", 30))
    if not taut.all():
        sheet.keys.append(Key("tie that is slack", SLACK, "line", 30))
