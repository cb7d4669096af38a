"""Marks: flat figures that face the viewer: bands of any width, discs. They lie over all else in a picture.

    stage.mark(bands(stage.view, starts, ends, widths), "#1f5fa8")
    stage.mark(discs(stage.view, points, radius), "#c8352b", rank=5)
    mark_ties(stage, sheet, scenery, shape, factor)             # bands as wide as their force

Sizes are in metres; ``stage.scale`` is the number of pixels per metre.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from masonry_fem.output import fields
from masonry_fem.output.render import Stage, View
from masonry_fem.output.scenery import DeformedShape, Scenery
from masonry_fem.output.sheet import Key, Sheet, quantity

FloatArray = NDArray[np.float64]

CORNERS = 24  # of a disc

TIE, SLACK = "#a3123a", "#8b939c"
WIDEST, THINNEST = 6.0, 1.6  # bands [pixels]
LEAST = 1e-9  # of the greatest force of a tie: those that bear less are slack
NAMED = 2  # ties in the legend, which has two rows for all


def bands(view: View, starts: FloatArray, ends: FloatArray, widths: FloatArray) -> Any:
    """Quadrangles along segments.

    Parameters
    ----------
    view : Direction of view.
    starts, ends : Of the segments, shape (n, 3) [m].
    widths : At start and end, shape (n, 2) [m].
    """
    along = (ends - starts) @ view.axes[:2].T
    length = np.linalg.norm(along, axis=1)
    unit = np.divide(along, length[:, None], out=np.zeros_like(along), where=length[:, None] > 0)
    across = np.stack([-unit[:, 1], unit[:, 0]], axis=1) @ view.axes[:2]
    half = 0.5 * widths[:, :, None] * across[:, None]
    corners = np.stack(
        [starts + half[:, 0], starts - half[:, 0], ends - half[:, 1], ends + half[:, 1]], axis=1
    )
    return polygons(corners)


def discs(view: View, points: FloatArray, radius: float | FloatArray) -> Any:
    """Discs about points.

    Parameters
    ----------
    view : Direction of view.
    points : Centres, shape (n, 3) [m].
    radius : One for all, or shape (n,) [m].
    """
    angle = np.linspace(0, 2 * np.pi, CORNERS, endpoint=False)
    rim = np.cos(angle)[:, None] * view.axes[0] + np.sin(angle)[:, None] * view.axes[1]
    size = np.broadcast_to(radius, len(points))
    return polygons(points[:, None] + size[:, None, None] * rim)


def rings(view: View, points: FloatArray, radius: float, width: float) -> Any:
    """Rings about points.

    Parameters
    ----------
    view : Direction of view.
    points : Centres, shape (n, 3) [m].
    radius : Of the middle of the line [m]. width : Of the line [m].
    """
    inner, outer = (discs(view, points, radius + side * width / 2).points for side in (-1, 1))
    corners = [ring.reshape(len(points), CORNERS, 3) for ring in (inner, outer)]
    following = [np.roll(ring, -1, axis=1) for ring in corners]
    return polygons(np.stack([*corners, *following[::-1]], axis=2).reshape(-1, 4, 3))


def polygons(corners: FloatArray) -> Any:
    """Polygons by their corners, shape (n, k, 3); points follow in this order."""
    import pyvista as pv  # noqa: PLC0415

    count, k, _ = corners.shape
    if not count:
        return pv.PolyData()
    faces = np.concatenate([np.full((count, 1), k), np.arange(count * k).reshape(count, k)], axis=1)
    return pv.PolyData(corners.reshape(-1, 3), faces=faces.ravel())


def mark_ties(stage: Stage, sheet: Sheet, scenery: Scenery, shape: DeformedShape, factor: float) -> None:
    """Draw the ties of a scenery over all else; the legend tells the most used ones.

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
    words = _tie_words(scenery, force, taut)
    sheet.keys += [Key(one, TIE, "line", 30) for one in words[:NAMED]]
    if len(words) > NAMED:
        sheet.keys.append(Key(f"{len(words) - NAMED} more, none used more", TIE, "line", 30))
    if not taut.all():
        sheet.keys.append(Key("tie that is slack", SLACK, "line", 30))


def _tie_words(scenery: Scenery, force: FloatArray, taut: NDArray[np.bool_]) -> list[str]:
    """Name, force, elongation and utilisation of the ties that are taut, the most used first."""
    data, held = scenery.ties.point_data, scenery.ties.field_data
    # field files of earlier versions have neither
    names = bytes(np.asarray(held["tie_names"])).decode().splitlines() if "tie_names" in held else []
    unknown = np.full(len(force), np.nan)
    longer, used = (
        np.asarray(data[name], float) if name in data else unknown
        for name in (fields.TIE_ELONGATION, fields.TIE_UTILISATION)
    )
    told = []
    # rounding does not decide between ties that bear the same
    share, size = ([float(f"{value:.4g}") for value in values] for values in (np.nan_to_num(used), force))
    for k in sorted(range(len(force)), key=lambda k: (-share[k], -size[k])):
        if taut[k]:
            words = f"{names[k] if names else 'tie'}: {quantity(force[k], scenery.force_unit)}"
            words += "" if np.isnan(longer[k]) else f", longer by {quantity(longer[k], 'm')}"
            told.append(words + ("" if np.isnan(used[k]) else f", {100 * used[k]:.3g} % of yield"))
    return told
