"""Marks: flat figures that face the viewer: bands of any width, discs. They lie over all else in a picture.

    stage.mark(bands(stage.view, starts, ends, widths), "#1f5fa8")
    stage.mark(discs(stage.view, points, radius), "#c8352b", rank=5)

Sizes are in metres; ``stage.scale`` is the number of pixels per metre.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from masonry_fem.output.render import View

FloatArray = NDArray[np.float64]

CORNERS = 24  # of a disc


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


def polygons(corners: FloatArray) -> Any:
    """Polygons by their corners, shape (n, k, 3); points follow in this order."""
    import pyvista as pv  # noqa: PLC0415

    count, k, _ = corners.shape
    if not count:
        return pv.PolyData()
    faces = np.concatenate([np.full((count, 1), k), np.arange(count * k).reshape(count, k)], axis=1)
    return pv.PolyData(corners.reshape(-1, 3), faces=faces.ravel())
