"""Write ``stones.csv``: the stress of each stone and how much of its strength it uses.

One line a stone at the end of a run. A cell is empty where a stone has no such value: of rigid stones only
the mean stress is known, and of stones without a strength no utilisation.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from masonry_fem.host.atomic import write_table
from masonry_fem.march.model import Model
from masonry_fem.march.state import SystemState
from masonry_fem.march.ties import without_ties
from masonry_fem.output.interfaces import interface_forces
from masonry_fem.output.recorder import LastState, Request
from masonry_fem.output.strength import Strengths
from masonry_fem.output.utilisation import governed, stone_utilisation
from masonry_fem.solid.assembly import taken

Columns = dict[str, list[Any]]


def recorder(request: Request) -> StoneTable:
    """The table of the last step."""
    return StoneTable(request.folder / "stones.csv", request.materials, request.strengths)


class StoneTable(LastState):
    """Recorder of ``stones.csv``."""

    def __init__(self, path: Path, materials: Any, strengths: Strengths | None) -> None:
        self._path, self._materials, self._strengths = path, materials, strengths

    def close(self, summary: Any) -> list[Path]:
        """Write the table."""
        last = self.taken()
        if last is None:
            return []
        columns = stone_columns(*last, self._materials, self._strengths)
        return [write_table(self._path, columns, zip(*columns.values(), strict=True))]


def stone_columns(model: Model, state: SystemState, materials: Any, strengths: Strengths | None) -> Columns:
    """The columns of the table by their headings, each with a value a stone; supports are left out.

    Parameters
    ----------
    model, state : Of which instant.
    materials : Names of the blocks' materials, by their numbers.
    strengths : Of the blocks; None where no stone has one.
    """
    count = len(model.assembly.blocks)
    known = strengths or Strengths(np.full(count, np.nan), np.full(count, np.nan))
    told = stone_utilisation(model, state, known)
    kinds = np.full(count, "", dtype=object)
    for group in model.groups:
        kinds[group.blocks] = group.kind
    measure = "m2" if model.assembly.dimension == 2 else "m3"
    columns: Columns = {
        "block": list(model.assembly.blocks.names),
        "material": list(materials),
        "fidelity": kinds.tolist(),
        f"volume [{measure}]": told.volume.tolist(),
        "utilisation [-]": told.local.tolist(),
        "utilisation_error [-]": told.error.tolist(),
        "utilisation_p95 [-]": told.p95.tolist(),
        "utilisation_greatest [-]": told.greatest.tolist(),
        "utilisation_of_mean [-]": told.of_mean.tolist(),
        "governs": governed(told),
        "contact_pressure [Pa]": _pressures(model, state).tolist(),
        "compressive_strength [Pa]": known.compression_design.tolist(),
        "tensile_strength [Pa]": known.tension_design.tolist(),
        "greatest_sigma_1 [Pa]": told.at_greatest[:, 0].tolist(),
        "greatest_sigma_3 [Pa]": told.at_greatest[:, 2].tolist(),
    }
    for number in range(3):
        columns[f"mean_sigma_{number + 1} [Pa]"] = told.principal[:, number].tolist()
    for number, name in enumerate(("xx", "yy", "zz", "xy", "yz", "xz")):
        columns[f"mean_{name} [Pa]"] = told.stress[:, number].tolist()
    free = np.flatnonzero(~np.isnan(told.volume))
    return {name: list(taken(values, free)) for name, values in columns.items()}


def _pressures(model: Model, state: SystemState) -> np.ndarray:
    """Greatest of N/A of the joints of each block, 0 where none presses, shape (b,) [Pa]."""
    most = np.zeros(len(model.assembly.blocks))
    model, state = without_ties(model, state)
    if model.interfaces:
        told = interface_forces(model, state)
        area = told.faces.area
        pressure = np.divide(told.normal, area, out=np.zeros_like(area), where=area > 0)
        for side in (0, 1):
            blocks = model.interfaces.blocks[told.faces.first, side]
            np.maximum.at(most, blocks, pressure)
    return most
