"""History: ``history.csv``, one line a step, all in SI units.

The first columns are time and step; then every number of the step's report, in its order:
scalars under their name, vectors with a suffix (``applied_fx`` ... ``applied_mz``), named ones with
the name between (``support_resultants.ground_fx``, ``probes.top_x``).
Each line is written at once and whole: what does not end in a line break is no line.
"""

from __future__ import annotations

import csv
import dataclasses
import io
from collections.abc import Iterable, Iterator, Mapping
from enum import Enum
from io import FileIO
from pathlib import Path
from typing import Any

import numpy as np

from masonry_fem.errors import OutputError
from masonry_fem.host.atomic import announce, settle, unwritten
from masonry_fem.march.model import Model
from masonry_fem.march.state import SystemState
from masonry_fem.output.recorder import StepReport

AXES = {2: ("x", "y"), 3: ("x", "y", "z")}
WRENCH = {3: ("fx", "fy", "mz"), 6: ("fx", "fy", "fz", "mx", "my", "mz")}
WRENCH_FIELDS = ("support_resultants", "applied")


class History:
    """Recorder of ``directory/history.csv``."""

    dense = True

    def __init__(self, directory: Path) -> None:
        self.path = Path(directory) / "history.csv"
        self._file: FileIO | None = None
        self._columns: list[str] = []

    def start(self, model: Model) -> None:
        """Open the file; what an earlier run left there is replaced."""
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            announce(self.path)
            self._file = FileIO(self.path, "w")
        except OSError as error:
            raise unwritten(self.path, error) from error
        self._columns = []

    def saved(self) -> dict[str, Any]:
        """How much of the file is written, and on the disk by then, and its columns."""
        if self._file is not None:
            settle(self.path)
        return {"size": 0 if self._file is None else self._file.tell(), "columns": list(self._columns)}

    def go_on(self, model: Model, saved: dict[str, Any]) -> None:
        """Open the file with the lines that it had; those that were written later go."""
        size = saved["size"]
        try:
            announce(self.path)
            self._file = FileIO(self.path, "r+" if self.path.exists() else "w")
            there = self.path.stat().st_size
            if there >= size:
                self._file.truncate(size)
                self._file.seek(size)
        except OSError as error:
            raise unwritten(self.path, error) from error
        if there < size:
            raise OutputError(
                f"{self.path} has {there} bytes, expected at least the {size} of its checkpoint: it was "
                "changed since; run the scene again"
            )
        self._columns = list(saved["columns"])

    def record(self, model: Model, state: SystemState, report: StepReport) -> None:
        """Write the line of one step; the first one also fixes the columns."""
        row = dict(columns(report))
        if self._columns:
            self._write([row.get(name, "") for name in self._columns])
        else:
            self._columns = list(row)
            self._write(self._columns, row.values())

    def close(self, summary: Any) -> list[Path]:
        """Close the file."""
        if self._file is not None:
            self._file.close()
            self._file = None
        return [self.path] if self.path.exists() else []

    def _write(self, *rows: Iterable[Any]) -> None:
        """Write whole lines at once; a line that found no room is taken back."""
        if self._file is None:
            return
        text = io.StringIO()
        csv.writer(text).writerows(rows)
        content, before = text.getvalue().encode(), self._file.tell()
        try:
            while content:
                content = content[self._file.write(content) :]
        except OSError as error:
            self._file.truncate(before)
            raise unwritten(self.path, error) from error


def columns(report: Any) -> Iterator[tuple[str, float | int | str]]:
    """Name and value of every number of a report (a dataclass or any object with attributes)."""
    names = [f.name for f in dataclasses.fields(report)] if dataclasses.is_dataclass(report) else vars(report)
    first = [name for name in ("time", "step") if name in names]
    for name in [*first, *(n for n in names if n not in first)]:
        yield from _flat(name, getattr(report, name), WRENCH if name in WRENCH_FIELDS else AXES)


def _flat(
    name: str, value: Any, suffixes: Mapping[int, tuple[str, ...]]
) -> Iterator[tuple[str, float | int | str]]:
    if isinstance(value, (float, np.floating)):  # first, as most are
        yield name, float(value)
    elif isinstance(value, Enum):
        yield name, value.name.lower()
    elif isinstance(value, (bool, np.bool_, int, np.integer)):
        yield name, int(value)
    elif isinstance(value, (str, type(None))):
        yield name, value or ""
    elif isinstance(value, Mapping):
        for key, part in value.items():
            yield from _flat(f"{name}.{key}", part, suffixes)
    elif dataclasses.is_dataclass(value):
        for part, number in columns(value):
            yield f"{name}.{part}", number
    else:
        flat = np.ravel(value)
        parts = suffixes.get(flat.size) or tuple(map(str, range(flat.size)))
        for part, number in zip(parts, flat, strict=True):
            yield f"{name}_{part}", number.item()
