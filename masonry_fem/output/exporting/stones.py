"""Stones: a table of one line a block for spreadsheets: how it has moved, and the ends of its stresses.

All in SI units; a cell is empty where a block has no such value. It can be made of any recorded step; the
table ``stones.csv`` of a run's end tells more (``output.stones``).
"""

from __future__ import annotations

import csv
import io
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from masonry_fem.host.atomic import write_atomic
from masonry_fem.output import fields
from masonry_fem.output.exporting.motion import motion_of
from masonry_fem.output.viewing.recorded import Recorded

ENDS = {  # columns: array, its column, whether the greatest
    "greatest_von_mises": (fields.VON_MISES, 0, True),
    "greatest_principal": (fields.PRINCIPAL, 0, True),
    "least_principal": (fields.PRINCIPAL, 2, False),
    "greatest_utilisation": (fields.UTILISATION, 0, True),
}


def write(recorded: Recorded, place: int, path: Path) -> list[Path]:
    """Write the table of a step.

    Parameters
    ----------
    recorded : The steps. place : Which, from 0 on. path : The file.
    """
    columns = stone_columns(recorded.blocks(place))
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(columns)
    table.writerows(zip(*columns.values(), strict=True))
    write_atomic(path, text.getvalue().encode())
    return [path]


def stone_columns(blocks: Any) -> dict[str, list[Any]]:
    """Columns by name, one value a block."""
    names = bytes(np.asarray(blocks.field_data["block_names"])).decode().splitlines()
    count = len(names)
    motion = motion_of(blocks, count)
    columns: dict[str, list[Any]] = {"block": names}
    for word, values in (("centre", motion.centre), ("displacement", motion.shift)):
        columns |= {f"{word}_{axis}": values[:, i].tolist() for i, axis in enumerate("xyz")}
    columns["turn"] = motion.angle.tolist()
    own = np.asarray(blocks.point_data[fields.BLOCK])
    for name, (array, column, most) in ENDS.items():
        if array in blocks.point_data:
            values = np.asarray(blocks.point_data[array], float).reshape(len(own), -1)[:, column]
            columns[name] = [
                value if np.isfinite(value) else "" for value in _ends(values, own, count, most).tolist()
            ]
    return columns


def _ends(values: NDArray[np.float64], own: NDArray[np.int64], count: int, most: bool) -> NDArray[np.float64]:
    """Greatest or least value of each block, infinite where it has none."""
    found = np.full(count, -np.inf if most else np.inf)
    known = np.isfinite(values)
    (np.maximum if most else np.minimum).at(found, own[known], values[known])
    return found
