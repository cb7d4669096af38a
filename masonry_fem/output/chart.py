"""Chart: the paper of plots of lines and points: size, frame, head and colours.

figure = blank(8.0, 5.0)
panel = figure.subplots()
frame(panel)
head(figure, "Column", "bars: records")
save(figure, path)

matplotlib, which takes half a second to load, is loaded by the first of these.
"""

from __future__ import annotations

import io
import logging
from pathlib import Path
from typing import Any

from masonry_fem.host import installation
from masonry_fem.host.atomic import write_atomic
from masonry_fem.output.sheet import INK, PALE

logger = logging.getLogger(__name__)

GRID = "#dfe3e7"
COLOURS = ("#0b6e99", "#d1603d", "#5f8f3e", "#7b5ea7", "#b8860b", "#3d3d3d")


def can_draw(what: str) -> bool:
    """Whether ``what`` can be drawn: its library is installed; a warning says how to install it."""
    if lack := installation.lacking("pictures"):
        logger.warning("no %s: %s", what, lack)
    return not lack


def blank(width: float, height: float) -> Any:
    """An empty matplotlib figure, which no window is opened for.

    Parameters
    ----------
    width, height : Its size [inches].
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: PLC0415
    from matplotlib.figure import Figure  # noqa: PLC0415

    figure = Figure(figsize=(width, height), dpi=110, facecolor="white")
    FigureCanvasAgg(figure)
    return figure


def frame(panel: Any) -> None:
    """Give a panel two axes and a grid behind what is drawn."""
    for side in ("top", "right"):
        panel.spines[side].set_visible(False)
    for side in ("left", "bottom"):
        panel.spines[side].set_color(PALE)
    panel.grid(which="major", color=GRID, lw=0.8)
    panel.tick_params(which="both", colors=PALE, labelsize=9)
    panel.set_axisbelow(True)


def head(figure: Any, title: str, words: str) -> None:
    """Write the title, and below it a line that says what is drawn, smaller where it is long.

    Parameters
    ----------
    figure : With 0.8 inches of room at its top. title, words : What is written.
    """
    tall = figure.get_figheight()
    figure.text(0.012, 1 - 0.26 / tall, title, fontsize=14, weight="bold", color=INK, va="center")
    line = figure.text(0.012, 1 - 0.58 / tall, words, fontsize=9, color=PALE, va="center")
    wide = line.get_window_extent().width / figure.bbox.width
    line.set_fontsize(9 * min(1.0, 0.976 / wide) if words else 9)


def save(figure: Any, path: Path) -> Path:
    """Write a figure as PNG.

    Parameters
    ----------
    figure : What is drawn. path : Of the file, which is returned.

    Raises
    ------
    OutputError : The disk is full, or the place may not be written to.
    """
    content = io.BytesIO()
    figure.savefig(content)
    write_atomic(path, content.getvalue())
    return path
