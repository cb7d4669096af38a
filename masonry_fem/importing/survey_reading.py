"""Survey reading: the measured polygons of stones from ``.csv``, ``.obj`` and ``.dxf`` files.

CSV: a line of column names, then one line per corner; the corners of a stone are numbered in order around its
face. Columns are separated by commas, semicolons or tabs, and ``#`` begins a comment:

    stone,vertex,x,y,z
    c01s01,1,0.000,0.001,0.002

OBJ: each object ``o`` (or group ``g``) is a stone and has one face. DXF: each closed polyline (``dxf``).
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from masonry_fem.errors import GeometryError
from masonry_fem.importing.dxf import read_dxf
from masonry_fem.importing.naming import UNSPACED, Names, tell_renamed, unlike
from masonry_fem.importing.surfaces import faces_of_obj
from masonry_fem.solid.pose import FloatArray

COLUMNS = ("stone", "vertex", "x", "y", "z")


@dataclass(frozen=True, slots=True)
class Measured:
    """The visible face of a stone.

    Attributes
    ----------
    name : Of the stone.
    corners : In order around the face, shape (k, 3) [unit of the file].
    """

    name: str
    corners: FloatArray


def read_survey(path: Path, title: str, scale: float = 1.0) -> list[Measured]:
    """The stones of a survey, in the order of the file.

    Parameters
    ----------
    path : A CSV, OBJ or DXF file.
    title : Name of the file in messages.
    scale : From its unit to the metre, as the scene says; corners are returned in its unit.

    Raises
    ------
    GeometryError : Another format, lines that cannot be read, stones of fewer than 3 corners, repeated
        corners.
    """
    kind = path.suffix.lower()
    if kind == ".dxf":
        stones = [Measured(name, corners) for name, corners in read_dxf(path, title, scale)]
    else:
        stones = _csv(path, title) if kind == ".csv" else _obj(path, title)
    if not stones:
        raise GeometryError(f"{title} holds no stone, expected measured faces; export the survey again")
    for stone in stones:
        if len(stone.corners) < 3:
            raise GeometryError(
                f"{title}, stone '{stone.name}' has {len(stone.corners)} corners, expected 3 or more around "
                "its face; complete or delete it"
            )
    return stones


def _csv(path: Path, title: str) -> list[Measured]:
    try:
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise GeometryError(
            f"{title} is no text in UTF-8 ({error.reason} at byte {error.start}); save it as UTF-8"
        ) from error
    names = Names(UNSPACED)
    rows = list(_rows(text, title, names))
    tell_renamed(title, names.changed)
    stones: dict[str, dict[int, tuple[FloatArray, int]]] = {}
    for line, name, number, corner in rows:
        known = stones.setdefault(name, {})
        if number in known:
            raise GeometryError(
                f"{title}, line {line}: stone '{name}' has its corner {number} a second time (first in line "
                f"{known[number][1]}), expected each once; delete one, or give the stone a name of its own"
            )
        known[number] = (corner, line)
    return [
        Measured(name, np.array([known[number][0] for number in sorted(known)]))
        for name, known in stones.items()
    ]


def _rows(text: str, title: str, stones: Names) -> Iterator[tuple[int, str, int, FloatArray]]:
    """Line, stone, number of the corner and its place."""
    columns: _Columns | None = None
    for line, full in enumerate(text.splitlines(), start=1):
        words = full.split("#")[0].strip()
        if not words:
            continue
        if columns is None:
            columns = _Columns.of(words, f"{title}, line {line}")
            continue
        cell = columns.cells(words, f"{title}, line {line}")
        number = _number(cell["vertex"], "vertex", title, line)
        if number != round(number):
            raise GeometryError(
                f"{title}, line {line}: vertex is {number:g}, expected a whole number; number the corners"
            )
        corner = np.array([_number(cell[axis], axis, title, line) for axis in "xyz"])
        yield line, _called(cell["stone"], stones, title, line), int(number), corner


@dataclass(frozen=True, slots=True)
class _Columns:
    """What the first line of a CSV file says: what separates its columns, and their names."""

    separator: str
    names: list[str]

    @classmethod
    def of(cls, words: str, title: str) -> _Columns:
        separator = max(";\t,", key=words.count)  # of equal counts the first
        names = [name.lower() for name in _parted(words, separator)]
        lacking = [name for name in COLUMNS if name not in names]
        if lacking:
            raise GeometryError(
                f"{title}: the column '{lacking[0]}' is not among {', '.join(names[:8])}; "
                f"expected a first line with {', '.join(COLUMNS)}"
            )
        return cls(separator, names)

    def cells(self, words: str, title: str) -> dict[str, str]:
        """Cells of a further line, by column; of columns of one name the first."""
        cells, width = _parted(words, self.separator), len(self.names)
        if len(cells) != width:
            decimal = self.separator == "," and len(cells) > width
            commas = "; write decimal points for commas" if decimal else ""
            raise GeometryError(
                f"{title} has {len(cells)} columns, expected {width} as in its first line{commas}"
            )
        return dict(zip(reversed(self.names), reversed(cells), strict=True))


def _parted(words: str, separator: str) -> list[str]:
    return [word.strip().strip('"') for word in words.split(separator)]


def _number(word: str, column: str, title: str, line: int) -> float:
    try:
        value = float(word)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        cure = "write decimal points for commas" if "," in word else "correct or delete it"
        raise GeometryError(f"{title}, line {line}: {column} is '{word}', expected a number; {cure}")
    return value


def _called(word: str, names: Names, title: str, line: int) -> str:
    name = names.of(word, prefix="s" if re.match(r"[\W_]*\d", word) else "")
    if not name:
        raise GeometryError(f"{title}, line {line}: stone is '{word}', expected a name; number the stones")
    return name


def _obj(path: Path, title: str) -> list[Measured]:
    points, faces = faces_of_obj(path, title)
    names = [one.object or one.group or f"s{at}" for at, one in enumerate(faces, start=1)]
    twice = [name for name, count in Counter(names).items() if count > 1]
    if twice:
        raise GeometryError(
            f"{title}, stone '{twice[0]}' has {names.count(twice[0])} faces, expected one polygon; join its "
            "triangles, or give each stone an object of its own"
        )
    finite = np.isfinite(points).all(axis=1)
    for name, one in zip(names, faces, strict=True):
        if not finite[list(one.corners)].all():
            raise GeometryError(
                f"{title}, stone '{name}' has a corner that is no number, expected finite x y z; correct it"
            )
    return [
        Measured(f"s{name}" if re.match(r"\d", name) else name, points[list(one.corners)])
        for name, one in zip(unlike(names), faces, strict=True)
    ]
