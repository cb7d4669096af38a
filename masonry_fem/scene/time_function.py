"""Time function: the factor by which a load or a motion is multiplied, as a callable f(t).

push = evaluator(Sine(frequency=2.0))
push(0.125)             # 1.0
push.rate(0.0)          # 12.57: df/dt [1/s], the velocity of a prescribed motion
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import cos, pi, sin
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from masonry_fem.errors import SceneError
from masonry_fem.scene.misfit import shown
from masonry_fem.scene.quantity import is_number, si_factor
from masonry_fem.scene.specs import Pulse, Record, Sine, Table, TimeFunction


class Factor(Protocol):
    """A function of time [s] with its derivative."""

    def __call__(self, time: float) -> float:
        """The factor at ``time`` [s]."""
        ...

    def rate(self, time: float) -> float:
        """Its derivative from the right [1/s]."""
        ...


@dataclass(frozen=True, slots=True)
class Constant:
    """A factor that does not vary."""

    value: float = 1.0

    def __call__(self, time: float) -> float:
        """The value, always."""
        return self.value

    def rate(self, time: float) -> float:
        """Zero."""
        return 0.0


@dataclass(frozen=True, slots=True)
class Wave:
    """amplitude · sin(2π frequency t + phase)."""

    frequency: float
    amplitude: float
    phase: float

    def __call__(self, time: float) -> float:
        """The sine at ``time`` [s]."""
        return self.amplitude * sin(2 * pi * self.frequency * time + self.phase)

    def rate(self, time: float) -> float:
        """Its derivative [1/s]."""
        turn = 2 * pi * self.frequency
        return self.amplitude * turn * cos(turn * time + self.phase)


@dataclass(frozen=True, slots=True)
class Piecewise:
    """Linear between points, constant outside them.

    Attributes
    ----------
    times : Increasing instants [s], shape (n,).
    values : Factors there, shape (n,).
    repeats : After the last point it begins anew at the first.
    """

    times: NDArray[np.float64]
    values: NDArray[np.float64]
    repeats: bool = False

    @property
    def end(self) -> float:
        """Time after which it stays as it is, or only repeats [s]."""
        if self.repeats:
            return 0.0
        changes = np.flatnonzero(np.diff(self.values))
        return float(self.times[changes[-1] + 1]) if len(changes) else 0.0

    def __call__(self, time: float) -> float:
        """The interpolated factor."""
        return float(np.interp(self._within(time), self.times, self.values))

    def _within(self, time: float) -> float:
        """The same time the first time round."""
        first, last = float(self.times[0]), float(self.times[-1])
        if self.repeats and time > last > first:
            return first + (time - first) % (last - first)
        return time

    def rate(self, time: float) -> float:
        """Slope of the segment that begins at or holds ``time`` [1/s]."""
        time = self._within(time)
        if self.repeats and time == self.times[-1] > self.times[0]:
            time = float(self.times[0])
        i = int(np.searchsorted(self.times, time, side="right"))
        if i == 0 or i == len(self.times):
            return 0.0
        rise = self.values[i] - self.values[i - 1]
        return float(rise / (self.times[i] - self.times[i - 1]))


@dataclass(frozen=True, slots=True)
class Pulses:
    """Pulses of one shape.

    Attributes
    ----------
    function : What the scene says.
    """

    function: Pulse

    @property
    def end(self) -> float:
        """Time after which there are none, or after which they only repeat [s]."""
        own = self.function
        if own.every is None:
            return own.start + own.duration
        return 0.0 if own.count is None else own.start + (own.count - 1) * own.every + own.duration

    def _since(self, time: float) -> float | None:
        """Share of its duration that the pulse has gone at a time; None where there is none."""
        own = self.function
        since = time - own.start
        if since < 0:
            return None
        if own.every is not None:
            number, since = divmod(since, own.every)
            if own.count is not None and number >= own.count:
                return None
        return since / own.duration if since < own.duration else None

    def __call__(self, time: float) -> float:
        """The factor at ``time`` [s]."""
        share = self._since(time)
        if share is None:
            return 0.0
        match self.function.shape:
            case "half_sine":
                height = sin(pi * share)
            case "full_sine":
                height = sin(2 * pi * share)
            case "triangle":
                height = 1.0 - abs(2 * share - 1.0)
            case "rectangle":
                height = 1.0
        return self.function.amplitude * height

    def rate(self, time: float) -> float:
        """Its derivative from the right [1/s]; 0 on the sides of a rectangle."""
        share = self._since(time)
        if share is None:
            return 0.0
        match self.function.shape:
            case "half_sine":
                slope = pi * cos(pi * share)
            case "full_sine":
                slope = 2 * pi * cos(2 * pi * share)
            case "triangle":
                slope = 2.0 if share < 0.5 else -2.0
            case "rectangle":
                slope = 0.0
        return self.function.amplitude * slope / self.function.duration


def evaluator(function: TimeFunction | None, base: str | Path = ".") -> Factor:
    """The callable of a time function; the constant 1 for none.

    Parameters
    ----------
    function : What the scene says.
    base : Folder of the scene file, where a record's path starts.

    Raises
    ------
    SceneError : Where a record's file cannot be read as two columns of increasing time.
    """
    match function:
        case None:
            return Constant()
        case Sine():
            return Wave(function.frequency, function.amplitude, function.phase)
        case Table():
            times, values = np.array(function.points, dtype=float).T
            return Piecewise(times, values, function.repeats)
        case Pulse():
            return Pulses(function)
        case Record():
            times, values = read_record(Path(base) / function.path, function.column)
            time_unit, unit = (
                1.0 if name is None else si_factor(name) for name in (function.time_unit, function.unit)
            )
            return Piecewise(time_unit * times, function.scale * unit * values, function.repeats)


def endless(function: TimeFunction | None) -> bool:
    """Whether a time function never comes to an end."""
    match function:
        case Sine():
            return True
        case Table() | Record():
            return function.repeats
        case Pulse():
            return function.every is not None and function.count is None
        case _:
            return False


def read_record(path: Path, column: str | None = None) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Times and values of a CSV file of two columns; ``#`` and one line of titles are skipped.

    Parameters
    ----------
    path : Of the file.
    column : Title of the column of values; the file then has a line of titles, and as many columns.

    Raises
    ------
    SceneError : A file that is no text, any other line that is not two numbers, times that do not increase,
        or no such column.
    """
    if column is None:
        pairs, unit, form = _plain(path), " s", "two columns, time [s] and value"
    else:
        pairs, unit, form = _titled(path, column), "", "a line of titles and lines of numbers"
    rows: list[tuple[float, float]] = []
    for line, row in pairs:
        if rows and row[0] <= rows[-1][0]:
            told = f"time {row[0]:g}{unit} after {rows[-1][0]:g}{unit}"
            raise SceneError(f"{line.place}: {told}, expected increasing times")
        rows.append(row)
    if not rows:
        raise SceneError(f"{path}: holds no numbers; expected {form}")
    times, values = np.array(rows).T
    return times, values


def _plain(path: Path) -> Iterator[tuple[_Line, tuple[float, float]]]:
    """Lines of two numbers, after at most one of titles."""
    begun = False
    for line in _lines(path, "a CSV file of time and value"):
        cells = line.words.replace(",", " ").replace(";", " ").split()
        row = _row(cells)
        if row is not None:
            yield line, row
        elif cells and (begun or is_number(cells[0])):
            raise line.fault("two finite numbers: time [s] and value")
        begun = begun or bool(cells)


def _titled(path: Path, column: str) -> Iterator[tuple[_Line, tuple[float, float]]]:
    """The first column and the one with a title, line by line."""
    titles: list[str] = []
    for line in _lines(path, "a CSV file with a line of titles"):
        cells = line.cells()
        if not titles:
            titles = cells
            _refuse_unknown(column, titles, line)
            continue
        row = _row([cells[0], cells[titles.index(column)]]) if len(cells) == len(titles) else None
        if row is None:
            raise line.fault(f"{len(titles)} cells, with finite numbers for the time and for '{column}'")
        yield line, row


@dataclass(frozen=True, slots=True)
class _Line:
    """A line of a table: where it is, as it stands there, and without its comment."""

    place: str
    text: str
    words: str

    def cells(self) -> list[str]:
        """Between semicolons, or commas where there is none."""
        return [cell.strip().strip('"') for cell in self.words.split(";" if ";" in self.words else ",")]

    def fault(self, expected: str) -> SceneError:
        """The error to raise."""
        return SceneError(f"{self.place}: {shown(self.text)}, expected {expected}; correct it")


def _lines(path: Path, expected: str) -> Iterator[_Line]:
    """Lines of a file that are not empty."""
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise SceneError(f"{path}: cannot be read; expected {expected}") from error
    for number, line in enumerate(text.splitlines(), start=1):
        words = line.partition("#")[0].strip()
        if words:
            yield _Line(f"{path}, line {number}", line, words)


def _refuse_unknown(column: str, titles: list[str], line: _Line) -> None:
    if column not in titles[1:]:
        known = ", ".join(f"'{title}'" for title in titles[1:]) or "several"
        raise SceneError(
            f"{line.place}: no column '{column}', expected one of {known} after that of the time; correct "
            "the key 'column'"
        )


def _row(cells: list[str]) -> tuple[float, float] | None:
    """Two finite numbers, or None."""
    if len(cells) != 2:
        return None
    try:
        time, value = float(cells[0]), float(cells[1])
    except ValueError:
        return None
    return (time, value) if np.isfinite([time, value]).all() else None
