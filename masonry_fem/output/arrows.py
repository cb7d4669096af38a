"""Arrows: forces in a picture, and the scale in the legend that tells the length of a force."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from masonry_fem.output import fields
from masonry_fem.output.backdrop import by_depth, faded
from masonry_fem.output.render import Stage
from masonry_fem.output.sheet import round_down

FloatArray = NDArray[np.float64]

SAMPLE = 60  # least length of a scale in the legend [pixels]
LEVEL = 1e-3  # components of normals that count as none


def reactions(contacts: Any) -> FloatArray:
    """Reaction of each contact point on the upper of its two blocks [N], shape (c, 3).

    Which block is the candidate means nothing to a reader, and arrows of like joints would point up and down.
    Of blocks beside each other the one towards +y counts as upper, or else the one towards +x.
    """
    normal = np.asarray(contacts.point_data[fields.NORMAL], float)  # towards the candidate
    _, where = np.unique(np.asarray(contacts.point_data[fields.INTERFACE]), return_inverse=True)
    mean = np.stack([np.bincount(where, n) for n in normal.T], axis=1) / np.bincount(where)[:, None]
    x, y, z = mean.T
    towards = np.where(np.abs(z) > LEVEL, z, np.where(np.abs(y) > LEVEL, y, x))
    force = np.asarray(contacts.point_data[fields.REACTION], float)
    return np.where(towards[where, None] < 0, -force, force)


def interface_resultants(contacts: Any) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Centre of pressure [m], resultant and its friction [N] of the interfaces that carry any, shapes (i, 3).

    Of the reactions on the upper blocks; friction is their part in the planes of contact.
    """
    force = np.asarray(contacts.point_data[fields.REACTION], float)
    normal = np.asarray(contacts.point_data[fields.NORMAL], float)
    _, where = np.unique(np.asarray(contacts.point_data[fields.INTERFACE]), return_inverse=True)
    pressure = np.maximum(np.einsum("ci,ci->c", force, normal), 0.0)
    total = np.bincount(where, pressure)
    upper = reactions(contacts)
    along = upper - np.einsum("ci,ci->c", upper, normal)[:, None] * normal
    resultant, friction = (np.stack([np.bincount(where, f) for f in own.T], axis=1) for own in (upper, along))
    points = np.asarray(contacts.points, float)
    moment = np.stack([np.bincount(where, pressure * x) for x in points.T], axis=1)
    loaded = total > 1e-12 * total.max(initial=0.0)
    return moment[loaded] / total[loaded, None], resultant[loaded], friction[loaded]


def add_arrows(stage: Stage, points: FloatArray, vectors: FloatArray, colour: str, *, fine: bool) -> None:
    """Draw arrows; many in space are paler the farther they are (``depth``).

    Parameters
    ----------
    stage : The picture.
    points : Where they begin, shape (n, 3) [m].
    vectors : From begin to tip, shape (n, 3) [m].
    colour : Of all of them.
    fine : Round sections rather than hexagonal ones, which need less memory.
    """
    import pyvista as pv  # noqa: PLC0415

    if not len(points):
        return
    corners = 12 if fine else 6  # of an arrow's section: a large cloud needs memory
    arrow = pv.Arrow(
        tip_length=0.28,
        tip_radius=0.085,
        shaft_radius=0.028,
        tip_resolution=corners,
        shaft_resolution=corners,
    )
    for own, strength in by_depth(stage.view, points):
        cloud = pv.PolyData(points[own])
        cloud["_force"] = vectors[own]
        glyphs = cloud.glyph(orient="_force", scale="_force", factor=1.0, geom=arrow)
        stage.solid(glyphs, faded(colour, strength))


def legend_sample(top: float, pixels: float) -> tuple[float, float]:
    """A round value for the legend's sample arrow, and its length in pixels.

    Parameters
    ----------
    top : Largest value in the picture.
    pixels : Length of that value's arrow.
    """
    sample = round_down(top * max(1.0, 2 * SAMPLE / pixels))
    return sample, sample / top * pixels
