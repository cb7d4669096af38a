"""Which forces are facts: ``determinacy.csv``, one line an interface, and its part of ``summary.json``."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from masonry_fem.host.atomic import write_atomic
from masonry_fem.march.determinacy import COMPONENTS, ForceDeterminacy
from masonry_fem.march.march import March
from masonry_fem.march.model import Model
from masonry_fem.march.state import SystemState
from masonry_fem.output.interface_fields import interface_name
from masonry_fem.output.recorder import Request, StepReport

SHOWN = 50  # interfaces that a summary names
# Components of a support's wrench, in the axes of the scene
WORLD = {2: ("fx", "fy", "mz"), 3: ("fx", "fy", "fz", "mx", "my", "mz")}


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

    def close(self, summary: Mapping[str, Any]) -> list[Path]:
        """Write the table."""
        return [] if self._end is None else [write_determinacy(self._path, *self._end)]


def determinacy_summary(model: Model, told: ForceDeterminacy) -> dict[str, Any]:
    """How much of the forces is a fact; the interfaces and supports of which something is not, by name."""
    names = COMPONENTS[model.assembly.dimension]
    whole = told.determined.all(axis=1)
    open_ones = np.flatnonzero(~whole)
    return {
        "reactions": "least norm" if told.least_norm else "as solved",
        "error": told.error,
        "interfaces_determined": int(whole.sum()),
        "interfaces_not_determined": len(open_ones),
        "not_determined": [
            {"interface": interface_name(model, k), "components": _left_open(names, told.determined[k])}
            for k in open_ones[:SHOWN].tolist()
        ],
        "supports_not_determined": {
            name: _left_open(WORLD[model.assembly.dimension], known)
            for name, known in told.supports_determined.items()
            if not known.all()
        },
        "contacts_unique": int(told.unique.sum()),
        "contacts_not_unique": int((~told.unique).sum()),
    }


def write_determinacy(path: Path, model: Model, told: ForceDeterminacy) -> Path:
    """Write resultants of the least-norm reactions, each component with 1 where it is determined."""
    names = COMPONENTS[model.assembly.dimension]
    points = np.bincount(model.contacts.interface, minlength=len(model.interfaces))
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(
        [
            "interface",
            "candidate",
            "antagonist",
            "label",
            "points",
            *names,
            *(f"{n}_determined" for n in names),
        ]
    )
    for k, interface in enumerate(model.interfaces):
        blocks = [model.assembly.blocks[block].name for block in interface.blocks]
        known = told.determined[k].astype(int).tolist()
        table.writerow([k, *blocks, interface.label, points[k], *told.resultant[k].tolist(), *known])
    write_atomic(path, text.getvalue().encode())
    return path


def _left_open(names: tuple[str, ...], known: np.ndarray) -> list[str]:
    return [name for name, is_known in zip(names, known.tolist(), strict=True) if not is_known]
