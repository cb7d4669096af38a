"""Determinacy on paper: ``determinacy.csv``, one line an interface, and its part of ``summary.json``."""

from __future__ import annotations

import csv
import io
from pathlib import Path
from typing import Any

import numpy as np

from masonry_fem.host.atomic import write_atomic
from masonry_fem.march.determinacy import COMPONENTS, ForceDeterminacy
from masonry_fem.march.model import Model

SHOWN = 50  # interfaces that a summary names
# Components of a support's wrench, in the axes of the scene
WORLD = {2: ("fx", "fy", "mz"), 3: ("fx", "fy", "fz", "mx", "my", "mz")}


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


def interface_name(model: Model, number: int) -> str:
    """Candidate and antagonist by name, and the joint's label."""
    interface = model.interfaces[number]
    candidate, antagonist = (model.assembly.blocks[block].name for block in interface.blocks)
    label = f" ({interface.label})" if interface.label else ""
    return f"{candidate} / {antagonist}{label}"


def _left_open(names: tuple[str, ...], known: np.ndarray) -> list[str]:
    return [name for name, is_known in zip(names, known.tolist(), strict=True) if not is_known]
