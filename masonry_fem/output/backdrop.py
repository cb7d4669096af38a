"""Backdrop: the blocks behind the subject of a picture, and its title."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from masonry_fem.output.depth import by_depth
from masonry_fem.output.render import Stage

STONE, GHOST = "#ebe5d8", "#8b939c"
GLASS_CELLS = 30_000  # faces of elements


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
