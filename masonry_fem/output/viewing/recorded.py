"""Recorded: the steps of a results folder, each read when it is asked for.

    recorded = Recorded.of(Path("results/arch"))
    blocks = recorded.blocks(-1)

The blocks of a step are a pyvista grid, NaN where there is no value.
"""

from __future__ import annotations

import json
import xml.etree.ElementTree as ET
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from masonry_fem.errors import SceneError
from masonry_fem.output.folder import RUNNING
from masonry_fem.output.vtu import with_nan

KEPT = 8  # steps in memory


@dataclass(frozen=True, slots=True)
class Recorded:
    """The steps of a results folder.

    Attributes
    ----------
    directory : The folder.
    times : Of the steps, in order [s]; load factors in statics.
    files : Of the blocks, one a step.
    title : Of the scene; where its run did not come to its end it says so.
    """

    directory: Path
    times: tuple[float, ...]
    files: tuple[Path, ...]
    title: str

    @classmethod
    def of(cls, directory: str | Path) -> Recorded:
        """The steps that a run has recorded in a folder.

        Raises
        ------
        SceneError : There are none.
        """
        directory = Path(directory)
        entries = entries_of(directory / "blocks.pvd")
        return cls(directory, tuple(entries), tuple(entries.values()), title_in(directory))

    def number(self, step: int | None) -> int:
        """The place of a step, counted from 1 as people do; None: the last.

        Raises
        ------
        SceneError : There is no such step.
        """
        count = len(self.files)
        if step is None:
            return count - 1
        if not 1 <= step <= count:
            raise SceneError(
                f"step {step} of '{self.directory}', expected 1 to {count}: so many are recorded"
            )
        return step - 1

    def blocks(self, place: int) -> Any:
        """The grid of all blocks of a step, by its place from 0 on; negative ones count from the end.

        It is shared by all who ask for it, and so not to be changed.
        """
        path = self.files[place]
        written = path.stat().st_mtime_ns if path.exists() else 0
        return _kept(path, written)


@lru_cache(KEPT)
def _kept(path: Path, written: int) -> Any:
    """A field file as it was when it was written."""
    return read_grid(path)


def read_grid(path: Path) -> Any:
    """A field file as a pyvista grid, NaN where there is no value.

    Raises
    ------
    SceneError : There is no such file.
    """
    import pyvista as pv  # noqa: PLC0415

    if not path.exists():
        raise SceneError(f"{path}: no such file, though its collection names it; run the scene again")
    grid = pv.read(path)
    for arrays in (grid.point_data, grid.cell_data):
        with_nan(arrays)
    return grid


def entries_of(collection: Path) -> dict[float, Path]:
    """Files of a ``.pvd`` collection by their times, in order.

    Raises
    ------
    SceneError : There is no such collection, or it is empty.
    """
    if not collection.exists():
        raise SceneError(
            f"{collection}: no such file; expected the results folder of a run with output.fields = true"
        )
    found = {
        float(entry.get("timestep", "0")): collection.parent / str(entry.get("file"))
        for entry in ET.parse(collection).iterfind(".//DataSet")
    }
    if not found:
        raise SceneError(f"{collection}: the series is empty; run the scene again")
    return dict(sorted(found.items()))


def title_in(directory: Path) -> str:
    """Title of the scene that was run; where its run did not come to its end it says so."""
    told = told_in(directory)
    title = str(told.get("title") or "") or directory.resolve().name
    outcome = told.get("outcome")
    return f"{title} ({outcome})" if outcome in (RUNNING, "interrupted", "failed") else title


def told_in(directory: Path) -> dict[str, Any]:
    """What the summary says; {} where there is none that can be read."""
    try:
        told = json.loads((directory / "summary.json").read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return told if isinstance(told, dict) else {}
