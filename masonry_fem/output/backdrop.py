"""Backdrop: the blocks behind the subject of a picture, its title, and depth.

for own, share in by_depth(stage.view, points):
    add(points[own], faded(colour, share))

In a crowd in space what is far behind something else is drawn pale, so that this can be read.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from masonry_fem.output.render import Stage, View

FloatArray = NDArray[np.float64]

CROWD = 100  # arrows or crosses from which on those behind others confuse
CELLS = 16  # along each side of the picture, in each of which the nearest is found
BANDS = ((0.12, 1.0), (0.3, 0.5), (np.inf, 0.25))  # strength up to how far behind, in sizes of the whole

STONE, GHOST = "#ebe5d8", "#8b939c"
GLASS_CELLS = 30_000  # faces of elements


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


def draw_pale(stage: Stage, surface: Any, outline: Any) -> None:
    """Draw blocks as a background, transparent so that bars and arrows inside them can be seen.

    Parameters
    ----------
    stage : The picture.
    surface, outline : Of the blocks, as pyvista meshes.
    """
    # through many layers of glass nothing is seen: many blocks are drawn opaque
    opaque = stage.view.flat or surface.n_cells > GLASS_CELLS
    stage.surface(surface, color=STONE, opacity=1.0 if opaque else 0.16)
    if opaque or not outline.n_points:
        stage.lines(outline, GHOST, 1.4)
        return
    for own, strength in by_depth(stage.view, np.asarray(outline.cell_centers().points, float)):
        stage.lines(_some(outline, own), GHOST, 1.4, opacity=0.8 * strength)


def title_of(title: str, what: str) -> str:
    """First line of a picture.

    Parameters
    ----------
    title : Of the scene; may be empty.
    what : What is shown.
    """
    return f"{title}: {what}" if title else what[0].upper() + what[1:]


def small(sentence: str) -> str:
    """A sentence that goes on after a semicolon."""
    return sentence[:1].lower() + sentence[1:]


def _some(lines: Any, own: NDArray[np.int64]) -> Any:
    """Some of the segments of an outline."""
    import pyvista as pv  # noqa: PLC0415  only where pictures are drawn

    return pv.PolyData(lines.points, lines=np.asarray(lines.lines).reshape(-1, 3)[own].ravel())
