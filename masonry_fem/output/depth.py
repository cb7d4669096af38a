"""Depth: in a crowd in space what is far behind something else is drawn pale, so that this can be read.

for own, share in by_depth(stage.view, points):
    add(points[own], faded(colour, share))
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from masonry_fem.output.render import View

FloatArray = NDArray[np.float64]

CROWD = 100  # arrows or crosses from which on those behind others confuse
CELLS = 16  # along each side of the picture, in each of which the nearest is found
BANDS = ((0.12, 1.0), (0.3, 0.5), (np.inf, 0.25))  # strength up to how far behind, in sizes of the whole


def by_depth(view: View, points: FloatArray) -> list[tuple[NDArray[np.int64], float]]:
    """Rows of points by how far they are behind the nearest in their part of the picture, the farthest first.

    Parameters
    ----------
    view : Whence they are seen. points : Shape (n, 3) [m].

    Returns
    -------
    Rows and the strength that they are drawn with; all at full strength where they are few, or in a plane.
    """
    if view.flat or len(points) < CROWD:
        return [(np.arange(len(points)), 1.0)]
    seen = points @ view.axes.T
    low, size = seen.min(axis=0), np.maximum(np.ptp(seen, axis=0), 1e-300)
    column, row = np.minimum(CELLS * (seen[:, :2] - low[:2]) / size[:2], CELLS - 1).astype(np.int64).T
    nearest = np.full(CELLS * CELLS, -np.inf)
    np.maximum.at(nearest, CELLS * row + column, seen[:, 2])
    behind = (nearest[CELLS * row + column] - seen[:, 2]) / float(np.linalg.norm(size))
    band = np.searchsorted([end for end, _ in BANDS], behind, side="right")
    rows = [(np.flatnonzero(band == number), strength) for number, (_, strength) in enumerate(BANDS)]
    return [(own, strength) for own, strength in reversed(rows) if len(own)]


def faded(colour: str, strength: float) -> str:
    """A colour such as ``#1f5fa8``, mixed with white.

    Parameters
    ----------
    colour : Six hexadecimal digits. strength : 1 leaves it as it is, 0 makes it white.
    """
    parts = (int(colour[i : i + 2], 16) for i in (1, 3, 5))
    return "#" + "".join(f"{round(255 - strength * (255 - part)):02x}" for part in parts)
