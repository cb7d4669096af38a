"""Sheet: the page around an image: title, captions, colour bar, scales and legend.

matplotlib sets text around an image that VTK has drawn, so that no label covers the structure and scales are
true: a metre or a newton on the page has the length that the caption states.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from masonry_fem.host.atomic import write_atomic
from masonry_fem.output.png import png
from masonry_fem.output.render import Stage, View

WIDTH = 1600
SIDE, TOP, BOTTOM, BAR = 48, 132, 116, 190
ARM, LETTER = 46.0, 13.0  # of the axes' arrows: length, distance of the letter from its tip [pixels]
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
        write_atomic(path, png(np.asarray(self.page(stage))))
        return path

    def page(self, stage: Stage) -> Any:
        """The page with the drawn stage, as a Pillow image; the stage is empty afterwards."""
        from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: PLC0415  half a second
        from matplotlib.figure import Figure  # noqa: PLC0415
        from PIL import Image  # noqa: PLC0415

        view, scale, (width, height) = stage.view, stage.scale, stage.size
        page = (WIDTH, height + TOP + BOTTOM)
        figure = Figure(figsize=(page[0] / 100, page[1] / 100), dpi=100, facecolor="white")
        canvas = FigureCanvasAgg(figure)
        pen = _Pen(figure, page)
        pen.line(SIDE, page[1] - 52, self.title, 27, INK, weight="bold")
        pen.line(SIDE, page[1] - 92, self.caption, 19, PALE)
        x = pen.triad(SIDE + 6, 34, view)
        x = pen.length_scale(x + 36, scale, width)
        pen.legend(x + 44, self.keys)
        if self.bar:
            pen.bar(self.bar, SIDE + width + 40, BOTTOM, height)
        canvas.draw()
        whole = Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB")
        whole.paste(Image.fromarray(stage.image()), (SIDE, TOP))
        return whole


class _Pen:
    """Strokes and words on a page measured in pixels from its lower left corner."""

    def __init__(self, figure: Any, page: tuple[int, int]) -> None:
        from matplotlib.transforms import IdentityTransform  # noqa: PLC0415

        self._figure, self._page, self._pixels = figure, page, IdentityTransform()

    def text(self, x: float, y: float, words: str, size: float, colour: str, **options: Any) -> float:
        """Write and return the right end of the words."""
        return float(self._words(x, y, words, size, color=colour, va="center", **options)[1].x1)

    def _width(self, words: str, size: float, **options: Any) -> float:
        artist, box = self._words(0, 0, words, size, **options)
        artist.remove()
        return float(box.width)

    def _words(self, x: float, y: float, words: str, size: float, **options: Any) -> tuple[Any, Any]:
        """The words on the page, and the box they fill."""
        look = {"fontsize": size * 0.72, "transform": self._pixels}
        artist = self._figure.text(x, y, words, **look, **options)
        return artist, artist.get_window_extent(self._figure.canvas.get_renderer())

    def _line(self, x: Sequence[float], y: Sequence[float], **look: Any) -> None:
        from matplotlib.lines import Line2D  # noqa: PLC0415

        self._figure.add_artist(Line2D(x, y, transform=self._pixels, **look))

    def stroke(self, x: float, y: float, dx: float, dy: float, colour: str, width: float, tip: str) -> None:
        """An arrow."""
        from matplotlib.patches import FancyArrowPatch  # noqa: PLC0415

        look: dict[str, Any] = {"arrowstyle": tip, "color": colour, "lw": width, "mutation_scale": 10}
        look |= {"shrinkA": 0, "shrinkB": 0, "transform": self._pixels}
        self._figure.add_artist(FancyArrowPatch((x, y), (x + dx, y + dy), **look))

    def triad(self, x: float, y: float, view: View) -> float:
        """World axes as the eye sees them; returns the right end."""
        names = "xy" if view.flat else "xyz"
        ends, letters = triad_of(view.axes[:2, : len(names)].T)
        reach = np.concatenate([ends, letters])
        x -= min(0.0, float(reach[:, 0].min()))
        y -= min(0.0, float(reach[:, 1].min()))
        for end, at, name in zip(ends, letters, names, strict=True):
            if end.any():
                self.stroke(x, y, end[0], end[1], INK, 1.6, "-|>")
                self.text(x + at[0], y + at[1], name, 18, INK, ha="center")
        return x + float(reach[:, 0].max()) + 5

    def length_scale(self, x: float, scale: float, width: int) -> float:
        """Bar of a round number of metres."""
        metres = round_down(0.16 * width / scale)
        pixels = metres * scale
        self._line([x, x + pixels], [46, 46], color=INK, lw=2.2, solid_capstyle="butt")
        for end in (x, x + pixels):
            self._line([end, end], [40, 52], color=INK, lw=1.4)
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
            self._line([x + 7], [y], marker="o", color=key.colour, ms=9)
            x += 14
        elif key.mark == "arrow":
            self.stroke(x, y, key.pixels, 0, key.colour, 2.6, "-|>,head_width=.3,head_length=.6")
            x += key.pixels
        elif key.mark == "band":
            from matplotlib.patches import Rectangle  # noqa: PLC0415

            look: dict[str, Any] = {"color": key.colour, "lw": 0, "transform": self._pixels}
            self._figure.add_artist(Rectangle((x, y - key.pixels / 2), BAND, key.pixels, **look))
            x += BAND
        elif key.mark != "none":
            width = 4.0 if key.mark == "bar" else 1.6
            self._line([x, x + key.pixels], [y, y], color=key.colour, lw=width, solid_capstyle="butt")
            x += key.pixels
        return self.text(x + 12, y, key.text, 18, INK)

    def bar(self, bar: ColourBar, x: float, y: float, height: int) -> None:
        """Colours with their values; by hand, as matplotlib's own takes half of a page's time."""
        from matplotlib import colormaps  # noqa: PLC0415
        from matplotlib.patches import Polygon  # noqa: PLC0415
        from matplotlib.ticker import AutoLocator  # noqa: PLC0415

        lines = 1 + bar.label.count("\n")
        lift = (32 if bar.over else 12) + 12 * lines
        room = height - lift - 14 * lines  # what the label leaves below the caption
        tall, tip = min(room - 20, 520), 20 if bar.over else 0
        low = int(y + (room - tall) / 2)
        high, tall = low + tall, tall - tip
        colours, (first, last) = colormaps[bar.colours], bar.limits
        strip = np.repeat(colours(np.linspace(0.0, 1.0, tall))[:, None], 26, axis=1)
        self._figure.figimage(strip, x, low, origin="lower")
        right, end = x + 26, low + tall
        corners = [(x, low), (right, low), (right, end), (x, end)]
        if bar.over:
            corners.insert(3, (x + 13, high))
            look: dict[str, Any] = {"color": colours(np.inf), "lw": 0, "transform": self._pixels}
            self._figure.add_artist(Polygon(corners[2:], **look))
        self._line(*zip(*corners, corners[0], strict=True), color="black", lw=0.6)
        for value in AutoLocator().tick_values(first, last):
            if first <= value <= last:
                at = low + tall * (value - first) / (last - first)
                self._line([right, right + 6], [at, at], color=INK, lw=0.8)
                self.text(right + 10, at - 1, f"{value:.6g}".replace("-", "−"), 17, INK)
        self.text(x - 4, high + lift, bar.label, 18, INK)


def triad_of(axes: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Where the arrows of the world's axes end and where their letters stand, from their common origin.

    Letters keep clear of each other and of other arrows.

    Parameters
    ----------
    axes : Unit vectors as the eye sees them, shape (n, 2).

    Returns
    -------
    Ends and letters [pixels], shapes (n, 2); both 0 for an axis that points at the eye.
    """
    ends = ARM * np.asarray(axes, float)
    ends[np.linalg.norm(ends, axis=1) < 4] = 0.0
    letters = np.zeros_like(ends)
    placed: list[int] = []
    for number in np.argsort(-np.linalg.norm(ends, axis=1), kind="stable").tolist():
        if not ends[number].any():
            continue
        unit = ends[number] / np.linalg.norm(ends[number])
        tries = []
        for turn in (0, 30, -30, 60, -60, 90, -90, 120, -120):
            c, s = np.cos(np.radians(turn)), np.sin(np.radians(turn))
            at = ends[number] + LETTER * (np.array([[c, -s], [s, c]]) @ unit)
            free = [float(np.linalg.norm(at - letters[other])) / 1.4 for other in placed]
            free += [_apart(at, ends[other]) for other in range(len(ends)) if other != number]
            tries.append((min(free, default=np.inf), at))
        clear = [at for room, at in tries if room >= LETTER - 1]
        letters[number] = clear[0] if clear else max(tries, key=lambda one: one[0])[1]
        placed.append(number)
    return ends, letters


def _apart(point: NDArray[np.float64], end: NDArray[np.float64]) -> float:
    """Distance of a point from the segment between the origin and an end."""
    along = float(np.clip(point @ end / max(float(end @ end), 1e-12), 0.0, 1.0))
    return float(np.linalg.norm(point - along * end))


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
