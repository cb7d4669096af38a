"""Plot: error against CPU time of all settings, one panel per quantity.

Settings that no other surpasses are filled, connected and labelled, the others pale; a thin line goes up to
the bound of each of the former. The reference is a star at its own possible error; settings that are nearer
to
the reference than this error are hollow.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from masonry_fem.analyses.study.pareto import Point
from masonry_fem.analyses.study.target import Target
from masonry_fem.analyses.study.variation import Variation
from masonry_fem.output.chart import COLOURS, blank, frame, head, save
from masonry_fem.output.sheet import INK, PALE

if TYPE_CHECKING:
    from masonry_fem.analyses.study.sweep import Study

MARKS = ("o", "s", "^", "D", "v", "P")
FLOOR = 1e-8  # errors below are rounding
NEAR = 0.1  # of what the reference may be off: distances from it below that tell nothing
PANEL = (6.4, 4.3)  # [inch]
PLACES = (
    (-7, -13, "right"),
    (8, 8, "left"),
    (8, -13, "left"),
    (-8, 8, "right"),
    (8, 22, "left"),
    (8, -27, "left"),
)


def draw(study: Study, path: Path) -> Path:
    """Draw the panels of the quantities that differ between settings.

    Parameters
    ----------
    study : The study.
    path : The picture.
    """
    telling = _telling(study)
    columns = min(2, len(telling))
    lines = math.ceil(len(telling) / columns)
    figure = blank(PANEL[0] * columns, PANEL[1] * lines + 1.1)
    axes = figure.subplots(lines, columns, squeeze=False).ravel()
    marks = _Marks.of(study.vary)
    for axis, (target, points) in zip(axes, telling, strict=False):
        _panel(axis, target, points, marks, study.accuracy)
    for axis in axes[len(telling) :]:
        axis.axis("off")
    top = 1 - 0.85 / figure.get_figheight()
    figure.tight_layout(rect=(0, 0, 1, top), h_pad=2.2, w_pad=2.0)
    _head(figure, study, marks)
    figure.canvas.draw()
    for axis, (_, points) in zip(axes, telling, strict=False):
        _label(axis, points, marks)
    return save(figure, path)


def _telling(study: Study) -> list[tuple[Target, list[Point]]]:
    """Targets that differ between settings, or else the first, with their points."""
    panels = [
        (target, [p for p in study.points(target) if math.isfinite(p.bound)]) for target in study.targets
    ]
    panels = [(target, points) for target, points in panels if points]
    return [one for one in panels if any(point.error > FLOOR for point in one[1])] or panels[:1]


class _Marks:
    """Colour and mark of a setting, by two of the varied keys, and its label, by the others."""

    def __init__(self, vary: Sequence[Variation], shown: Sequence[Variation]) -> None:
        self.vary = vary
        self.colour = shown[0] if shown else None
        self.mark = shown[1] if len(shown) > 1 else None
        self.rest = [one for one in vary if not one.is_case and one not in shown and len(one.values) > 1]

    @classmethod
    def of(cls, vary: Sequence[Variation]) -> _Marks:
        """Keys without widths first, for colours tell kinds better than sizes."""
        usable = [one for one in vary if not one.is_case and 1 < len(one.values) <= len(COLOURS)]
        kinds = [one for one in usable if not one.is_graded]
        return cls(vary, kinds[:2] or usable[1:2])

    def look(self, point: Point) -> tuple[str, str]:
        """Colour and mark."""
        return (
            COLOURS[self._place(self.colour, point)],
            MARKS[self._place(self.mark, point)],
        )

    def text(self, point: Point) -> str:
        """What colour and mark do not say."""
        return " · ".join(point.settings[one.key].replace(" ", "") for one in self.rest)

    def legend(self) -> list[tuple[str, str, str]]:
        """Colour, mark, words."""
        found = []
        if self.colour is not None:
            found += [
                (COLOURS[i], "o", f"{tail(self.colour.key)} {self.colour.text(i)}")
                for i in self._all(self.colour)
            ]
        if self.mark is not None:
            found += [
                (PALE, MARKS[i], f"{tail(self.mark.key)} {self.mark.text(i)}") for i in self._all(self.mark)
            ]
        return found

    def _place(self, one: Variation | None, point: Point) -> int:
        return 0 if one is None else point.places[self.vary.index(one)]

    @staticmethod
    def _all(one: Variation) -> range:
        return range(len(one.values))


def tail(key: str) -> str:
    """The last word of a key."""
    return key.rpartition(".")[2]


def _panel(axis: Any, target: Target, points: Sequence[Point], marks: _Marks, accuracy: float) -> None:
    axis.set_xscale("log")
    axis.set_yscale("log")
    frame(axis)
    axis.yaxis.set_major_formatter(lambda value, _: f"{100 * value:g} %")
    axis.yaxis.set_minor_formatter(lambda value, _: _minor(100 * value, axis.get_ylim(), " %"))
    axis.xaxis.set_major_formatter(lambda value, _: f"{value:g}")
    axis.xaxis.set_minor_formatter(lambda value, _: _minor(value, axis.get_xlim(), ""))
    best = sorted((p for p in points if p.best and not _beside(p)), key=lambda point: point.cpu)
    axis.plot([p.cpu for p in best], [_height(p) for p in best], color=INK, lw=1.1, alpha=0.55, zorder=2)
    for point in points:
        _spot(axis, point, *marks.look(point))
    low, high = axis.get_ylim()
    if low < accuracy < high:
        axis.axhline(accuracy, color=COLOURS[1], lw=0.9, ls=(0, (5, 4)), zorder=1)
        axis.annotate(
            "asked", (1.0, accuracy), xycoords=("axes fraction", "data"),
            xytext=(4, 0), textcoords="offset points", va="center", fontsize=8, color=COLOURS[1],
        )  # fmt: skip
    axis.set_title(target.words.removeprefix("the "), fontsize=11.5, color=INK, loc="left", weight="bold")
    axis.set_xlabel("CPU time [s]", fontsize=9.5, color=PALE)
    axis.set_ylabel("relative error", fontsize=9.5, color=PALE)
    axis.margins(x=0.12, y=0.14)


def _spot(axis: Any, point: Point, colour: str, mark: str) -> None:
    """One setting, with its bound if it is one of the best."""
    height = _height(point)
    if point.is_reference:
        axis.plot(point.cpu, height, "*", ms=15, mfc="white", mec=colour, mew=1.5, zorder=4)
    elif _beside(point):
        axis.plot(point.cpu, height, mark, ms=6.5, mfc="white", mec=colour, mew=1.2, zorder=3)
    elif point.best:
        axis.plot(point.cpu, height, mark, ms=7.5, color=colour, mec="white", mew=0.8, zorder=4)
        top = max(min(point.bound, 10.0), height)
        axis.plot([point.cpu] * 2, [height, top], color=colour, lw=1.0, alpha=0.7, zorder=3)
        axis.plot(point.cpu, top, "_", ms=6, color=colour, alpha=0.7, zorder=3)
    else:
        axis.plot(point.cpu, height, mark, ms=5.5, color=colour, alpha=0.28, mec="none", zorder=1)


def _minor(value: float, limits: tuple[float, float], unit: str) -> str:
    """Label of a tick between powers of ten, where there are few of these: 0.2, 0.5; all of a short scale."""
    span = limits[1] / limits[0]
    told = span < 2 or (span <= 200 and f"{value:.3e}"[0] in "25")
    return f"{value:.6g}{unit}" if told else ""


def _height(point: Point) -> float:
    """Where a point stands: its error; of the reference what it may be off itself."""
    return max(point.rest if _beside(point) else point.error, FLOOR)


def _beside(point: Point) -> bool:
    """Whether a point is the reference, or so near to it that its error is the reference's."""
    return point.is_reference or point.error < NEAR * point.rest


def _label(axis: Any, points: Sequence[Point], marks: _Marks) -> None:
    """Label the best settings where there is room beside them."""
    renderer = axis.figure.canvas.get_renderer()
    frame = axis.get_window_extent(renderer)
    spots = axis.transData.transform([(point.cpu, _height(point)) for point in points])
    taken: list[Any] = []
    for point in sorted((point for point in points if point.best), key=lambda point: point.cpu):
        words = marks.text(point) or " · ".join(point.settings.values())
        for dx, dy, side in PLACES:
            text = axis.annotate(
                words, (point.cpu, _height(point)), xytext=(dx, dy), textcoords="offset points",
                fontsize=8, color=INK, ha=side,
            )  # fmt: skip
            box = text.get_window_extent(renderer)
            if _has_room(box, frame, taken, spots):
                taken.append(box)
                break
            text.remove()


def _has_room(box: Any, frame: Any, taken: Sequence[Any], spots: Any) -> bool:
    """Whether a label is within the frame, beside the other labels and on no point."""
    inside = box.x0 >= frame.x0 and box.x1 <= frame.x1 + 12 and box.y0 >= frame.y0
    free = not any(box.overlaps(other) for other in taken)
    clear = not any(box.x0 < x < box.x1 and box.y0 < y < box.y1 for x, y in spots)
    return inside and free and clear


def _head(figure: Any, study: Study, marks: _Marks) -> None:
    """Title, what labels say, and the legend of colours."""
    from matplotlib.lines import Line2D  # noqa: PLC0415

    parts = [" · ".join(tail(one.key) for one in marks.rest)] if marks.rest else []
    words = [f"labels: {parts[0]}"] if parts else []
    words += [
        "line up: bound of the true error",
        "star: the reference, at what it may be off; hollow: the same",
    ]
    head(figure, study.title or "study", ";  ".join(words))
    handles = [
        Line2D([], [], marker=mark, ls="none", color=colour, ms=7, label=text)
        for colour, mark, text in marks.legend()
    ]
    if handles:
        figure.legend(
            handles=handles, loc="upper right", bbox_to_anchor=(0.995, 1 - 0.1 / figure.get_figheight()),
            ncols=len(handles),
            frameon=False, fontsize=9.5, handletextpad=0.2, columnspacing=1.2, labelcolor=INK,
        )  # fmt: skip
