"""Tie table: ``ties.csv``, one line for each straight part of a tie at the end of a run."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from masonry_fem.host.atomic import write_table
from masonry_fem.march.model import Model
from masonry_fem.march.ties import TieForces, tie_forces
from masonry_fem.output.history import AXES
from masonry_fem.output.recorder import LastState


class TieTable(LastState):
    """Recorder of ``directory/ties.csv``; of structures without ties it writes nothing."""

    def __init__(self, directory: Path) -> None:
        self.path = Path(directory) / "ties.csv"

    def close(self, summary: Any) -> list[Path]:
        """Write the table."""
        last = self.taken()
        told = None if last is None else tie_forces(*last)
        if last is None or told is None:
            return []
        columns = tie_columns(last[0], told)
        return [write_table(self.path, columns, zip(*columns.values(), strict=True))]


def tie_columns(model: Model, told: TieForces) -> dict[str, list[Any]]:
    """The columns of the table by their headings, each with a value a part.

    Parameters
    ----------
    model : The structure. told : What its ties bear.
    """
    flat = model.assembly.dimension == 2
    blocks = model.contacts.blocks[told.contacts].tolist()
    names = [[model.assembly.blocks.names[block] for block in pair] for pair in blocks]
    columns: dict[str, list[Any]] = {
        "tie": list(told.names),
        "from": [pair[0] for pair in names],
        "to": [pair[1] for pair in names],
        f"force [{'N/m' if flat else 'N'}]": told.force.tolist(),
        "stress [Pa]": told.stress.tolist(),
        "elongation [m]": told.elongation.tolist(),
        "strain [-]": told.strain.tolist(),
        "plastic_strain [-]": told.plastic.tolist(),
        "utilisation [-]": [
            value if yields else ""
            for value, yields in zip(told.utilisation.tolist(), told.yields, strict=True)
        ],
        "snapped": told.snapped.astype(int).tolist(),
    }
    for side, end in enumerate(("from", "to")):
        for axis, letter in enumerate(AXES[model.assembly.dimension]):
            columns[f"{end}_{letter} [m]"] = told.ends[:, side, axis].tolist()
    return columns
