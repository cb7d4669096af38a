"""History: ``history.csv``, one line a step, all in SI units.

The first columns are time and step; then every number of the step's report, in its order:
scalars under their name, vectors with a suffix (``applied_fx`` ... ``applied_mz``), named ones with
the name between (``support_resultants.ground_fx``, ``probes.top_x``). Lines are flushed at once.
"""

from __future__ import annotations

import csv
import dataclasses
from collections.abc import Iterator, Mapping
from enum import Enum
from pathlib import Path
from typing import Any, TextIO

import numpy as np

from masonry_fem.dynamics.model import Model
from masonry_fem.dynamics.state import SystemState
from masonry_fem.post.recorder import StepReport

AXES = {2: ("x", "y"), 3: ("x", "y", "z")}
WRENCH = {3: ("fx", "fy", "mz"), 6: ("fx", "fy", "fz", "mx", "my", "mz")}
WRENCH_FIELDS = ("support_resultants", "applied")


class History:
    """Recorder of ``directory/history.csv``."""

    dense = True

    def __init__(self, directory: Path) -> None:
        self.path = Path(directory) / "history.csv"
        self._file: TextIO | None = None
        self._writer: Any = None

    def start(self, model: Model) -> None:
        """Open the file; what an earlier run left there is replaced."""
        self.path.parent.mkdir(parents=True, exist_ok=True)
        self._file = self.path.open("w", newline="", encoding="utf-8")
        self._writer = None

    def record(self, model: Model, state: SystemState, report: StepReport) -> None:
        """Write the line of one step; the first one also fixes the columns."""
        if self._file is None:
            return
        row = dict(columns(report))
        if self._writer is None:
            self._writer = csv.DictWriter(self._file, list(row), restval="", extrasaction="ignore")
            self._writer.writeheader()
        self._writer.writerow(row)
        self._file.flush()

    def close(self, summary: Mapping[str, Any]) -> list[Path]:
        """Close the file."""
        if self._file is not None:
            self._file.close()
            self._file = None
        return [self.path] if self.path.exists() else []


def columns(report: Any) -> Iterator[tuple[str, float | int | str]]:
    """Name and value of every number of a report (a dataclass or any object with attributes)."""
    names = [f.name for f in dataclasses.fields(report)] if dataclasses.is_dataclass(report) else vars(report)
    first = [name for name in ("time", "step") if name in names]
    for name in [*first, *(n for n in names if n not in first)]:
        yield from _flat(name, getattr(report, name), WRENCH if name in WRENCH_FIELDS else AXES)


def _flat(
    name: str, value: Any, suffixes: Mapping[int, tuple[str, ...]]
) -> Iterator[tuple[str, float | int | str]]:
    if isinstance(value, Mapping):
        for key, part in value.items():
            yield from _flat(f"{name}.{key}", part, suffixes)
    elif isinstance(value, Enum):
        yield name, value.name.lower()
    elif isinstance(value, (bool, np.bool_, int, np.integer)):
        yield name, int(value)
    elif isinstance(value, (float, np.floating)):
        yield name, float(value)
    elif isinstance(value, (str, type(None))):
        yield name, value or ""
    elif dataclasses.is_dataclass(value):
        for part, number in columns(value):
            yield f"{name}.{part}", number
    else:
        flat = np.ravel(value)
        parts = suffixes.get(flat.size) or tuple(str(i) for i in range(flat.size))
        for part, number in zip(parts, flat, strict=True):
            yield f"{name}_{part}", number.item()
