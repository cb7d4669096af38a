"""Records: what shakes a scene, at which scales, and how intense that is.

records = read_records(["a.AT2", "pairs.txt"], axes=("x", "y"))
scales = parsed_scales("0.2:1:0.2,1.5,2")            # (0.2, 0.4, 0.6, 0.8, 1.0, 1.5, 2.0)
Intensity(period=0.5, damping=0.05).of(ground, level=(0,))
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from masonry_fem.errors import MasonryError
from masonry_fem.march.shaking import Shaking
from masonry_fem.records.remark import first_few

LIST = ".txt"  # of files that list records


@dataclass(frozen=True, slots=True)
class Record:
    """A record.

    Attributes
    ----------
    name : Of its first file, without the ending. files : By axis, relative to the current folder.
    """

    name: str
    files: dict[str, Path]


def read_records(given: Sequence[str | Path], axes: Sequence[str]) -> list[Record]:
    """Records of files: a file serves all axes, a ``.txt`` lists records, a line with a file for each axis.

    Parameters
    ----------
    given : Accelerograms, and lists of such. axes : Those along which the scene is shaken.

    Raises
    ------
    MasonryError : A list cannot be read, a line has another number of files, a file is not there, or two
        records have one name.
    """
    found: list[Record] = []
    for one in map(Path, given):
        found += _listed(one, axes) if one.suffix.lower() == LIST else [_record([one], axes, str(one))]
    if not found:
        raise MasonryError("no records, expected .AT2 or .csv files, or a .txt file that lists some")
    lacking = [str(path) for record in found for path in record.files.values() if not path.is_file()]
    if lacking:
        raise MasonryError(
            f"no such record: {first_few(list(dict.fromkeys(lacking)), 3)}; give paths from where you are, "
            "those in a list from where the list is"
        )
    names = [record.name for record in found]
    for name in names:
        if names.count(name) > 1:
            raise MasonryError(f"two records are named '{name}'; rename the file of one of them")
    return found


def _listed(path: Path, axes: Sequence[str]) -> list[Record]:
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise MasonryError(f"{path}: cannot be read ({error}); expected a list of records") from error
    found = []
    for number, line in enumerate(lines, start=1):
        words = [word.strip() for word in line.partition("#")[0].split(",")]
        if words != [""]:
            found.append(_record([path.parent / word for word in words], axes, f"{path}, line {number}"))
    return found


def _record(files: Sequence[Path], axes: Sequence[str], where: str) -> Record:
    if len(files) not in (1, len(axes)):
        raise MasonryError(
            f"{where}: {len(files)} files, expected one, or {len(axes)} with commas between them, for "
            f"{' and '.join(axes)}, the axes of the scene's loads.accelerograms"
        )
    every = list(files) * (len(axes) // len(files))
    return Record(files[0].stem, dict(zip(axes, every, strict=True)))


def parsed_scales(given: str | Sequence[float], name: str) -> tuple[float, ...]:
    """Increasing numbers, from a text of numbers and ranges ``first:last:step`` between commas.

    Parameters
    ----------
    given : Text or numbers. name : What messages call them.

    Raises
    ------
    MasonryError : One is no positive number.
    """
    parts = given.split(",") if isinstance(given, str) else given
    return tuple(sorted({number for part in parts for number in _numbers(part, name)}))


def _numbers(part: str | float, name: str) -> Sequence[float]:
    """Numbers that a number or a range stands for."""
    try:
        ends = [float(word) for word in (part.split(":") if isinstance(part, str) else [part])]
    except (TypeError, ValueError):
        ends = []
    if all(0 < end < math.inf for end in ends):
        if len(ends) == 1:
            return ends
        if len(ends) == 3 and ends[0] <= ends[1]:
            return _range(f"{name}: {part}", *ends)
    raise MasonryError(
        f"{name}: '{part}', expected positive numbers, or ranges first:last:step, as 0.2:2:0.2"
    )


def _range(words: str, first: float, last: float, step: float) -> list[float]:
    """Numbers from the first to the last, both included."""
    count = math.floor((last - first) / step * (1 + 1e-9) + 1e-9) + 1
    if count > 1e5:
        raise MasonryError(f"{words} are {count} numbers; expected a larger step")
    return [float(f"{first + k * step:.12g}") for k in range(count)]


@dataclass(frozen=True, slots=True)
class Intensity:
    """How strong a record is.

    Attributes
    ----------
    period : Of an oscillator whose pseudo-acceleration tells [s]; None: the greatest acceleration of the
        ground. damping : Ratio of the oscillator.
    """

    period: float | None
    damping: float

    def __post_init__(self) -> None:
        """Refuse what is no period."""
        if self.period is not None and not 0 < self.period < math.inf:
            raise MasonryError(f"period is {self.period:g} s, expected a positive time")

    @property
    def words(self) -> str:
        """The same in words."""
        return "PGA" if self.period is None else f"Sa({self.period:g} s, {100 * self.damping:g} %)"

    def of(self, ground: Shaking, level: Sequence[int]) -> float:
        """Intensity [m/s²]: along the level axes, of two the geometric mean; else of the greatest component.

        Parameters
        ----------
        ground : What shakes. level : Numbers of the axes across gravity.
        """
        by_axis = {one.axis: self._along(one.record.times, one.record.values) for one in ground.components}
        across = [by_axis[axis] for axis in level if axis in by_axis]
        return math.prod(across) ** (1 / len(across)) if across else max(by_axis.values())

    def _along(self, times: np.ndarray, values: np.ndarray) -> float:
        if self.period is None:
            return float(np.abs(values).max())
        from masonry_fem.output.spectrum import of_accelerations  # noqa: PLC0415 - scipy.signal

        return float(of_accelerations(times, values, np.array([self.period]), self.damping).accelerations[0])
