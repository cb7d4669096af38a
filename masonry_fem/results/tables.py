"""Tables of a run as arrays, read from the CSV files that it wrote.

columns = read_table(Path("out/stones.csv"))
columns["utilisation [-]"].max()
"""

from __future__ import annotations

import csv
import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from masonry_fem.errors import OutputError
from masonry_fem.output.asked import names as asked_names
from masonry_fem.scene.misfit import nearest

Columns = dict[str, NDArray[Any]]


def read_table(path: Path) -> Columns:
    """The columns by their headings, which state units, each with a value a line.

    Columns of numbers are floats, with NaN in empty cells; others are texts.

    Parameters
    ----------
    path : The CSV file.

    Raises
    ------
    OutputError : It cannot be read.
    """
    try:
        with path.open(encoding="utf-8", newline="") as file:
            heads, *rows = list(csv.reader(file))
    except (OSError, ValueError) as error:
        raise OutputError(f"{path} cannot be read as a table ({error}); run the scene again") from error
    return {head: _column(head, [row[place] for row in rows]) for place, head in enumerate(heads)}


def table_of(files: list[Path], name: str, *, frame: bool = False) -> Any:
    """A table among the files of a run.

    Parameters
    ----------
    files : Of the run.
    name : Of the table: its file without ``.csv``.
    frame : As a pandas ``DataFrame`` rather than a dict of arrays.

    Raises
    ------
    OutputError : The run wrote no such table, or pandas is not installed.
    """
    tables = {path.stem: path for path in files if path.suffix == ".csv"}
    if name not in tables:
        there = ", ".join(f"'{one}'" for one in sorted(tables)) or "none, as nothing was written"
        asked = asked_names()
        advice = f"; ask for it with output.{name} = true and 'masonry_fem.run'" if name in asked else ""
        raise OutputError(
            f"the run has no table '{name}', expected one of those that it wrote ({there})"
            f"{advice or nearest(name, (*tables, *asked))}"
        )
    columns = read_table(tables[name])
    if not frame:
        return columns
    try:
        import pandas as pd  # type: ignore[import-untyped,import-not-found,unused-ignore]  # noqa: PLC0415
    except ImportError as error:
        raise OutputError(
            "pandas is not installed, which frame = True needs; install it ('pip install pandas'), "
            "or leave frame out for a dict of arrays"
        ) from error
    return pd.DataFrame(columns)


def _column(head: str, cells: list[str]) -> NDArray[Any]:
    try:
        numbers = [float(cell) if cell else math.nan for cell in cells]
    except ValueError:
        return np.array(cells)
    return np.array(numbers) if any(cells) or head.endswith("]") else np.array(cells)
