"""Accelerogram files: PEER's ``.AT2`` and CSV, read as times and accelerations in SI units.

times, values = read_accelerogram(Path("RSN6_180.AT2"), "x", None)         # [s], [m/s²]
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from masonry_fem.errors import SceneError
from masonry_fem.scene.actions import is_at2
from masonry_fem.scene.misfit import shown
from masonry_fem.scene.quantity import is_number

FloatArray = NDArray[np.float64]

UNITS = {"m/s^2": 1.0, "cm/s^2": 0.01, "g": 9.80665}  # in m/s²; cm/s² is the gal
NUMBER = r"([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)"
COUNT = re.compile(r"NPTS\s*=\s*(\d+)", re.IGNORECASE)
STEP = re.compile(rf"DT\s*=\s*{NUMBER}", re.IGNORECASE)
OLD = re.compile(rf"\s*(\d+)\s+{NUMBER}\s+NPTS\s*,\s*DT", re.IGNORECASE)
BRACKETS = re.compile(r"[\[(]([^\])]*)[\])]")
STATED = {"ms": "ms", "m/s^2": "m/s^2", "m/s/s": "m/s^2", "cm/s^2": "cm/s^2", "gal": "cm/s^2", "g": "g"}
HEADER = 4  # lines of an .AT2 file before its values


def read_accelerogram(path: Path, axis: str, unit: str | None) -> tuple[FloatArray, FloatArray]:
    """Times [s] and accelerations [m/s²] of a file.

    Parameters
    ----------
    path : An ``.AT2`` file, or a CSV file of time and acceleration, or of time and columns titled x, y, z.
    axis : The column to take of the latter.
    unit : Of the accelerations in a CSV file; None: m/s².

    Raises
    ------
    SceneError : The file cannot be read, and what line of it is wrong.
    """
    try:
        lines = path.read_text(encoding="utf-8-sig", errors="strict").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise SceneError(f"{path}: cannot be read as text ({error}); expected an accelerogram") from error
    if is_at2(path.name):
        return _at2(path, lines)
    times, values = _csv(path, lines, axis, unit or "m/s^2")
    return times, UNITS[unit or "m/s^2"] * values


def _at2(path: Path, lines: list[str]) -> tuple[FloatArray, FloatArray]:
    """PEER's format: title, event, "... IN UNITS OF G", "NPTS= n, DT= s SEC", values in lines."""
    head = "\n".join(lines[:HEADER])
    old, count, step = OLD.search(head), COUNT.search(head), STEP.search(head)
    if old is not None:
        number, dt = int(old[1]), float(old[2])
    elif count is not None and step is not None:
        number, dt = int(count[1]), float(step[1])
    else:
        raise SceneError(
            f"{path}, line {HEADER}: {shown(lines[HEADER - 1] if len(lines) >= HEADER else '')}, expected "
            "'NPTS= 4000, DT= .0100 SEC' as PEER writes it; take the file as it was downloaded, or a CSV file"
        )
    if not (number >= 2 and dt > 0):
        raise SceneError(
            f"{path}, line {HEADER}: NPTS = {number}, DT = {dt:g} s, expected two values or more, and DT > 0"
        )
    units = re.search(r"UNITS OF (\S+)", head, re.IGNORECASE)
    if units is not None and units[1].strip(".,").upper() != "G":
        raise SceneError(
            f"{path}: holds {shown(units[0])}, expected an acceleration in units of g; take its .AT2 file"
        )
    values: list[float] = []
    for place, line in enumerate(lines[HEADER:], start=HEADER + 1):
        values += _numbers(path, place, line.split())
    if len(values) != number:
        raise SceneError(
            f"{path}: holds {len(values)} values, expected NPTS = {number}; the file is not whole, or has "
            "more than one record: download it again"
        )
    return dt * np.arange(float(number)), UNITS["g"] * np.array(values)


def _csv(path: Path, lines: list[str], axis: str, unit: str) -> tuple[FloatArray, FloatArray]:
    """Time and one of the other columns."""
    told = [(place, _words(line)) for place, line in enumerate(lines, start=1) if _words(line)]
    titles: list[str] = []
    if told and not is_number(told[0][1][0]):
        line = lines[told.pop(0)[0] - 1]
        _check_units(path, line, unit)
        titles = [word.strip("\"'").lower() for word in _words(BRACKETS.sub("", line))]
    if len(told) < 2:
        raise SceneError(f"{path}: holds {len(told)} lines of numbers, expected time [s] and acceleration")
    rows = [_numbers(path, place, words) for place, words in told]
    width = max(len(rows[0]), 2)
    for (place, _), row, before in zip(told, rows, [None, *rows], strict=False):
        if len(row) != width:
            raise SceneError(f"{path}, line {place}: {len(row)} numbers, expected {width}; correct it")
        if before is not None and row[0] <= before[0]:
            raise SceneError(
                f"{path}, line {place}: time {row[0]:g} s after {before[0]:g} s, expected increasing times"
            )
    table = np.array(rows)
    return table[:, 0], table[:, _column(path, titles, width, axis)]


def _check_units(path: Path, titles: str, unit: str) -> None:
    """Refuse units in brackets of a line of titles that are others than those the columns are read in."""
    for told in BRACKETS.findall(titles):
        named = STATED.get(told.strip().lower().replace("²", "^2").replace("s2", "s^2"))
        if named not in (None, unit):
            raise SceneError(
                f"{path}: its titles say '{told}', and it is read in s and {unit}; expected the same: "
                "set 'unit', or write times in s"
            )


def _words(line: str) -> list[str]:
    """What stands in a line before a comment."""
    return line.partition("#")[0].replace(",", " ").replace(";", " ").split()


def _column(path: Path, titles: list[str], width: int, axis: str) -> int:
    """Which column has the acceleration along an axis: of two the second."""
    if width == 2:
        return 1
    found = titles.count(axis)
    if found != 1 or len(titles) != width:
        raise SceneError(
            f"{path}: has {width} columns and {found or 'none'} titled '{axis}', expected a first line as "
            "'time, x, y, z', or two columns"
        )
    return titles.index(axis)


def _numbers(path: Path, place: int, words: list[str]) -> list[float]:
    """Finite numbers of a line."""
    try:
        values = [float(word) for word in words]
    except ValueError:
        values = [np.nan]
    if not np.isfinite(values).all():
        told = shown(" ".join(words))
        raise SceneError(f"{path}, line {place}: {told}, expected finite numbers; correct it")
    return values
