"""Plots: histories as SVG, drawn of ``history.csv``.

for plot in plots(history): plot.title, plot.lines, plot.ticks
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from masonry_fem.output.sheet import prefix_of

FloatArray = NDArray[np.float64]
COLOURS = ("#1f5fa8", "#c8352b", "#1b7f5c", "#e07b1a", "#7a4fa3", "#6b7280")
LEFT, TOP, WIDTH, HEIGHT = 70.0, 14.0, 560.0, 190.0  # of the frame within the drawing
POINTS = 600  # of a line at most
TITLES = {
    "energies": ("Energy", "J", ("kinetic_energy", "strain_energy")),
    "speed": ("Speed (root mean square over the mass)", "m/s", ("speed",)),
}
LARGEST = 8  # plots of supports and probes


@dataclass(frozen=True, slots=True)
class Line:
    """A curve.

    Attributes
    ----------
    name, colour : In the legend. points : As SVG has them, ``x,y x,y``.
    """

    name: str
    colour: str
    points: str


@dataclass(frozen=True, slots=True)
class Plot:
    """A drawing.

    Attributes
    ----------
    title, unit : What is drawn. lines : The curves.
    across, up : Ticks of both axes: place in the drawing and label.
    """

    title: str
    unit: str
    lines: tuple[Line, ...]
    across: tuple[tuple[float, str], ...]
    up: tuple[tuple[float, str], ...]


def plots(history: Mapping[str, FloatArray], dimension: int) -> list[Plot]:
    """What a history shows, where it has more than one step.

    Parameters
    ----------
    history : Columns of ``history.csv``, shape (steps,) each.
    dimension : 2 or 3.
    """
    time = history.get("time")
    if time is None or len(time) < 2:
        return []
    wanted = [
        *_vectors(history, "Displacement", "m", "probes", "_"),
        *_vectors(history, "Force", "N/m" if dimension == 2 else "N", "support_resultants", "_f"),
        *(
            (title, unit, {key.replace("_", " "): key for key in keys})
            for title, unit, keys in TITLES.values()
        ),
    ]
    made = [_plot(title, unit, time, {a: history[k] for a, k in parts.items() if k in history})
            for title, unit, parts in wanted]  # fmt: skip
    return [plot for plot in made if plot is not None]


def _vectors(
    history: Mapping[str, FloatArray], what: str, unit: str, kind: str, mark: str
) -> Iterator[tuple[str, str, dict[str, str]]]:
    """Title, unit and columns by axis of the first vectors of a kind, whose axes stand after a mark."""
    start, end = len(kind) + 1, -len(mark) - 1
    names = sorted({column[start:end] for column in history if column.startswith(f"{kind}.")})
    for name in names[:LARGEST]:
        yield f"{what} of {name}", unit, {axis: f"{kind}.{name}{mark}{axis}" for axis in "xyz"}


def _plot(title: str, unit: str, time: FloatArray, curves: Mapping[str, FloatArray]) -> Plot | None:
    values = [curve[np.isfinite(curve)] for curve in curves.values()]
    if not any(len(part) and np.ptp(part) > 0 for part in values):
        return None
    everything = np.concatenate(values)
    factor, prefix = prefix_of(float(np.abs(everything).max()))
    low, high = min(float(everything.min()), 0.0) / factor, max(float(everything.max()), 0.0) / factor
    start, end = float(time.min()), float(time.max())
    chosen = np.unique(np.linspace(0, len(time) - 1, min(len(time), POINTS)).astype(int))

    def across(t: FloatArray) -> FloatArray:
        return LEFT + WIDTH * (t - start) / ((end - start) or 1.0)

    def up(v: FloatArray) -> FloatArray:
        return TOP + HEIGHT * (high - v) / ((high - low) or 1.0)

    lines = []
    for colour, (name, curve) in zip(COLOURS, curves.items(), strict=False):
        known = chosen[np.isfinite(curve[chosen])]
        if len(known) and np.abs(curve[known]).max() > 1e-9 * np.abs(everything).max():
            pairs = zip(across(time[known]), up(curve[known] / factor), strict=True)
            lines.append(Line(name, colour, " ".join(f"{x:.1f},{y:.1f}" for x, y in pairs)))
    return Plot(
        title,
        f"{prefix}{unit}",
        tuple(lines),
        tuple((float(across(np.array(t))), f"{t:.4g}") for t in _ticks(start, end)),
        tuple((float(up(np.array(v))), f"{v:.4g}") for v in _ticks(low, high)),
    )


def _ticks(low: float, high: float) -> Sequence[float]:
    """Round numbers between two values, three to seven of them."""
    span = high - low
    if not span > 0:
        return [low]
    power = 10.0 ** np.floor(np.log10(span / 3))
    step = next(step * power for step in (5, 2, 1) if span / (step * power) >= 3)
    first = np.ceil(low / step - 1e-9)
    count = int(np.floor(high / step + 1e-9) - first) + 1
    ticks: list[float] = ((first + np.arange(count)) * step).tolist()
    return ticks
