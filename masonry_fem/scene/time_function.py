"""Time function: the factor by which a load or a motion is multiplied, as a callable f(t).

push = evaluator(Sine(frequency=2.0))
push(0.125)             # 1.0
push.rate(0.0)          # 12.57: df/dt [1/s], the velocity of a prescribed motion
"""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, pi, sin
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from masonry_fem.errors import SceneError
from masonry_fem.scene.misfit import shown
from masonry_fem.scene.specs import Record, Sine, Table, TimeFunction


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
    """

    times: NDArray[np.float64]
    values: NDArray[np.float64]

    @property
    def end(self) -> float:
        """Time after which it stays as it is [s]."""
        changes = np.flatnonzero(np.diff(self.values))
        return float(self.times[changes[-1] + 1]) if len(changes) else 0.0

    def __call__(self, time: float) -> float:
        """The interpolated factor."""
        return float(np.interp(time, self.times, self.values))

    def rate(self, time: float) -> float:
        """Slope of the segment that begins at or holds ``time`` [1/s]."""
        i = int(np.searchsorted(self.times, time, side="right"))
        if i == 0 or i == len(self.times):
            return 0.0
        rise = self.values[i] - self.values[i - 1]
        return float(rise / (self.times[i] - self.times[i - 1]))


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
            return Piecewise(times, values)
        case Record():
            times, values = read_record(Path(base) / function.path)
            return Piecewise(times, function.scale * values)


def read_record(path: Path) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Times [s] and values of a CSV file of two columns; ``#`` and one line of titles are skipped.

    Raises
    ------
    SceneError : A file that is no text, any other line that is not two numbers, times that do not increase.
    """
    rows: list[tuple[float, float]] = []
    titled = False
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise SceneError(f"{path}: cannot be read; expected a CSV file of time and value") from error
    for number, line in enumerate(text.splitlines(), start=1):
        cells = line.partition("#")[0].replace(",", " ").replace(";", " ").split()
        if not cells:
            continue
        row = _row(cells)
        if row is None:
            if rows or titled or _is_number(cells[0]):
                expected = "two finite numbers: time [s] and value"
                raise SceneError(f"{path}, line {number}: {shown(line)}, expected {expected}; correct it")
            titled = True
        elif rows and row[0] <= rows[-1][0]:
            raise SceneError(f"{path}, line {number}: time {row[0]:g} s after {rows[-1][0]:g} s, "
                             "expected increasing times")  # fmt: skip
        else:
            rows.append(row)
    if not rows:
        raise SceneError(f"{path}: holds no numbers; expected two columns, time [s] and value")
    times, values = np.array(rows).T
    return times, values


def _is_number(word: str) -> bool:
    """Whether a word is meant as a number, 'nan' among them: then its line is no line of titles."""
    try:
        float(word)
    except ValueError:
        return False
    return True


def _row(cells: list[str]) -> tuple[float, float] | None:
    """Two finite numbers, or None."""
    if len(cells) != 2:
        return None
    try:
        time, value = float(cells[0]), float(cells[1])
    except ValueError:
        return None
    return (time, value) if np.isfinite([time, value]).all() else None
