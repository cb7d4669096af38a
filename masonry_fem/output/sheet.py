"""Sheet: the page around an image: title, captions, colour bar, scales and legend.

matplotlib sets text around an image that VTK has drawn, so that no label covers the structure and scales are
true: a metre or a newton on the page has the length that the caption states.
"""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from masonry_fem.host.atomic import write_atomic
from masonry_fem.output.render import Stage, View

WIDTH = 1600
SIDE, TOP, BOTTOM, BAR = 48, 132, 116, 190
BAND = 44.0  # length of a band in the legend [pixels]
INK, PALE = "#1d2126", "#5d6670"
HELD, LINE = "#a9adb2", "#33383f"  # blocks without stress, edges
STRESS_COLOURS = "viridis"
PREFIXES = ((1e9, "G"), (1e6, "M"), (1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "µ"), (1e-9, "n"))


@dataclass(frozen=True, slots=True)
class ColourBar:
    """Scale of a coloured field.

    Attributes
    ----------
    label : Name and unit of the field.
    colours : Name of the colour map.
    limits : Values at its ends, in the unit of the label.
    over : Whether values exceed the upper limit.
    """

    label: str
    colours: str
    limits: tuple[float, float]
    over: bool = False


@dataclass(frozen=True, slots=True)
class Key:
    """An entry of the legend.

    Attributes
    ----------
    text : Its words.
    colour : Of the mark.
    mark : Kind of the mark.
    pixels : Length of an arrow or bar, thickness of a band.
    """

    text: str
    colour: str
    mark: str = "dot"  # dot, bar, line, arrow, band (as thick as ``pixels``), none
    pixels: float = 0.0


@dataclass(slots=True)
class Sheet:
    """A page under construction.

    Attributes
    ----------
    title : First line.
    caption : Lines below the image.
    keys : Entries of the legend.
    bar : Colour bar, if there is one.
    """

    title: str
    caption: str
    keys: list[Key] = field(default_factory=list)
    bar: ColourBar | None = None

    @property
    def image_width(self) -> int:
        """Pixels that are left for the image."""
        return WIDTH - 2 * SIDE - (BAR if self.bar else 0)

    def save(self, path: Path, stage: Stage) -> Path:
        """Draw the stage, set the page and write the PNG."""
        from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: PLC0415  half a second
        from matplotlib.figure import Figure  # noqa: PLC0415

        view, scale, (width, height) = stage.view, stage.scale, stage.size
        image = stage.image()
        page = (WIDTH, height + TOP + BOTTOM)
        figure = Figure(figsize=(page[0] / 100, page[1] / 100), dpi=100, facecolor="white")
        FigureCanvasAgg(figure)
        figure.figimage(image[::-1], xo=SIDE, yo=BOTTOM, origin="lower")
        pen = _Pen(figure, page)
        pen.line(SIDE, page[1] - 52, self.title, 27, INK, weight="bold")
        pen.line(SIDE, page[1] - 92, self.caption, 19, PALE)
        x = pen.triad(SIDE + 6, 34, view)
        x = pen.length_scale(x + 36, scale, width)
        pen.legend(x + 44, self.keys)
        if self.bar:
            pen.bar(self.bar, SIDE + width + 40, BOTTOM, height)
        content = io.BytesIO()
        figure.savefig(content, dpi=100)
        write_atomic(path, content.getvalue())
        return path


class _Pen:
    """Strokes and words on a page measured in pixels from its lower left corner."""

    def __init__(self, figure: Any, page: tuple[int, int]) -> None:
        self._figure, self._page = figure, page
        self._axes = figure.add_axes((0, 0, 1, 1), facecolor="none")
        self._axes.set(xlim=(0, page[0]), ylim=(0, page[1]))
        self._axes.axis("off")

    def text(self, x: float, y: float, words: str, size: float, colour: str, **options: Any) -> float:
        """Write and return the right end of the words."""
        artist = self._axes.text(x, y, words, fontsize=size * 0.72, color=colour, va="center", **options)
        return float(artist.get_window_extent(self._figure.canvas.get_renderer()).x1)

    def _width(self, words: str, size: float, **options: Any) -> float:
        artist = self._axes.text(0, 0, words, fontsize=size * 0.72, **options)
        width = artist.get_window_extent(self._figure.canvas.get_renderer()).width
        artist.remove()
        return float(width)

    def stroke(self, x: float, y: float, dx: float, dy: float, colour: str, width: float, tip: str) -> None:
        style = {"arrowstyle": tip, "color": colour, "lw": width, "shrinkA": 0, "shrinkB": 0}
        self._axes.annotate("", (x + dx, y + dy), (x, y), arrowprops=style)

    def triad(self, x: float, y: float, view: View) -> float:
        """World axes as the eye sees them; returns the right end."""
        ends = [46 * view.axes[:2, i] for i in range(2 if view.flat else 3)]
        x -= min(0.0, *(float(e[0]) for e in ends))
        for end, name in zip(ends, "xyz", strict=False):
            if np.linalg.norm(end) < 4:  # it points at the eye
                continue
            self.stroke(x, y, end[0], end[1], INK, 1.6, "-|>")
            tip = end * (1 + 13 / max(float(np.linalg.norm(end)), 1.0))
            self.text(x + tip[0], y + tip[1], name, 18, INK, ha="center")
        return x + max(float(e[0]) for e in ends) + 18

    def length_scale(self, x: float, scale: float, width: int) -> float:
        """Bar of a round number of metres."""
        metres = round_down(0.16 * width / scale)
        pixels = metres * scale
        self._axes.plot([x, x + pixels], [46, 46], color=INK, lw=2.2, solid_capstyle="butt")
        for end in (x, x + pixels):
            self._axes.plot([end, end], [40, 52], color=INK, lw=1.4)
        right = self.text(
            x + pixels / 2,
            70,
            f"{metres:g} m" if metres >= 0.01 else quantity(metres, "m"),
            18,
            INK,
            ha="center",
        )
        return max(x + pixels, right)

    def line(self, x: float, y: float, words: str, size: float, colour: str, **options: Any) -> None:
        """Write a line, smaller where it would leave the page."""
        room = 0.97 * (self._page[0] - SIDE - x)  # hinting widens small letters
        need = self._width(words, size, **options)
        self.text(x, y, words, size * min(1.0, room / need), colour, **options)

    def legend(self, x: float, keys: Sequence[Key]) -> None:
        """Keys side by side, in two rows where one is too short; what then finds no room is dropped."""
        end = self._page[0] - SIDE
        starts, at, row = [], x, 0
        for key in keys:
            mark = {"dot": 14.0, "band": BAND}.get(key.mark, key.pixels)
            need = mark + 12 + self._width(key.text, 18)
            if at + need > end and at > x:
                at, row = x, row + 1
            starts.append((at, row))
            at += need + 44
        heights = (46.0,) if row == 0 else (66.0, 26.0)
        for key, (at, row) in zip(keys, starts, strict=True):
            if row < len(heights):
                self.key(at, heights[row], key)

    def key(self, x: float, y: float, key: Key) -> float:
        """Mark and words of one key; returns the right end."""
        if key.mark == "dot":
            self._axes.plot([x + 7], [y], "o", color=key.colour, ms=9)
            x += 14
        elif key.mark == "arrow":
            self.stroke(x, y, key.pixels, 0, key.colour, 2.6, "-|>,head_width=.3,head_length=.6")
            x += key.pixels
        elif key.mark == "band":
            box = [y - key.pixels / 2, y + key.pixels / 2]
            self._axes.fill_between([x, x + BAND], *box, color=key.colour, lw=0)
            x += BAND
        elif key.mark != "none":
            width = 4.0 if key.mark == "bar" else 1.6
            self._axes.plot([x, x + key.pixels], [y, y], color=key.colour, lw=width, solid_capstyle="butt")
            x += key.pixels
        return self.text(x + 12, y, key.text, 18, INK)

    def bar(self, bar: ColourBar, x: float, y: float, height: int) -> None:
        from matplotlib.cm import ScalarMappable  # noqa: PLC0415
        from matplotlib.colors import Normalize  # noqa: PLC0415

        lines = 1 + bar.label.count("\n")
        lift = (32 if bar.over else 12) + 12 * lines
        room = height - lift - 14 * lines  # what the label leaves below the caption
        tall = min(room - 20, 520)
        low = y + (room - tall) / 2
        box = (x / self._page[0], low / self._page[1], 26 / self._page[0], tall / self._page[1])
        axes = self._figure.add_axes(box)
        field = ScalarMappable(Normalize(*bar.limits), bar.colours)
        scale = self._figure.colorbar(
            field, cax=axes, extend="max" if bar.over else "neither", extendfrac=0.04
        )
        scale.outline.set_linewidth(0.6)
        scale.ax.tick_params(labelsize=17 * 0.72, colors=INK, length=4)
        self.text(x - 4, low + tall + lift, bar.label, 18, INK)


def colour_end(values: NDArray[np.float64]) -> tuple[float, float, bool]:
    """Greatest of the values that are not NaN, where a scale of colours ends, whether some lie beyond it.

    Corners in contact are singular: a scale that reaches their value shows nothing else.
    """
    top, most = float(np.nanmax(values)), float(np.nanquantile(values, 0.995))
    over = top > 1.1 * most > 0
    return top, most if over else top, over


def prefix_of(value: float) -> tuple[float, str]:
    """Factor and letter of the SI prefix that suits a value."""
    size = abs(value) * (1 + 1e-12)
    return next(((f, p) for f, p in PREFIXES if size >= f), (1.0, "") if size == 0 else PREFIXES[-1])


def quantity(value: float, unit: str, digits: int = 3) -> str:
    """A value with its unit, such as ``12.5 kPa``.

    Parameters
    ----------
    value : In SI units.
    unit : Without prefix.
    digits : Significant digits.
    """
    factor, prefix = prefix_of(value)
    return f"{value / factor:.{digits}g} {prefix}{unit}".replace("-", "−")


def round_down(value: float) -> float:
    """Greatest of 1, 2, 5 times a power of ten that does not exceed a positive value."""
    power = 10.0 ** np.floor(np.log10(value) + 1e-12)
    return float(max(step for step in (1, 2, 5) if step * power <= value * (1 + 1e-9)) * power)
