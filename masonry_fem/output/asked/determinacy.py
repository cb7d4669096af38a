"""Which forces are facts: ``determinacy.csv``, one line an interface, and its part of ``summary.json``."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from masonry_fem.host.atomic import write_table
from masonry_fem.march.determinacy import COMPONENTS, ForceDeterminacy
from masonry_fem.march.march import March
from masonry_fem.march.model import Model
from masonry_fem.march.state import SystemState
from masonry_fem.output.recorder import Request, StepReport


def recorder(request: Request) -> DeterminacyTable:
    """The table of the last step."""
    return DeterminacyTable(request.folder / "determinacy.csv")


class DeterminacyTable:
    """Recorder of ``determinacy.csv``."""

    dense = False

    def __init__(self, path: Path) -> None:
        self._path = path
        self._end: tuple[Model, ForceDeterminacy] | None = None

    def start(self, model: Model) -> None:
        """Nothing is written before the end."""

    def record(self, model: Model, state: SystemState, report: StepReport) -> None:
        """Nor of a step."""

    def end(self, made: March, determinacy: ForceDeterminacy | None) -> None:
        """Keep what is determined."""
        self._end = None if determinacy is None else (made.model, determinacy)

    def close(self, summary: Any) -> list[Path]:
        """Write the table."""
        return [] if self._end is None else [write_determinacy(self._path, *self._end)]


def write_determinacy(path: Path, model: Model, told: ForceDeterminacy) -> Path:
    """Write resultants of the least-norm reactions, each component with 1 where it is determined."""
    names = COMPONENTS[model.assembly.dimension]
    points = np.bincount(model.contacts.interface, minlength=len(model.interfaces))
    titles = ["interface", "candidate", "antagonist", "label", "points"]
    titles += [*names, *(f"{name}_determined" for name in names)]
    rows = []
    for k, (pair, label) in enumerate(
        zip(model.interfaces.blocks.tolist(), model.interfaces.label_of_each, strict=True)
    ):
        blocks = [model.assembly.blocks.names[block] for block in pair]
        known = told.determined[k].astype(int).tolist()
        rows.append([k, *blocks, label, points[k], *told.resultant[k].tolist(), *known])
    return write_table(path, titles, rows)
