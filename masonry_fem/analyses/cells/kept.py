"""Kept: rows of cells in a folder, where a second search, or one after a kill, finds them.

kept = Kept(folder, fresh=False)
rows, interrupted = kept.computed(cells, crew, base, tell)       # those that are known are not computed
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from masonry_fem.analyses.cells.cell import Cell
from masonry_fem.analyses.cells.crew import Crew
from masonry_fem.host.atomic import PART
from masonry_fem.output.folder import make_folder
from masonry_fem.records.told import known, write

SOLVED = ("equilibrium", "finished")
KNOWN = (*SOLVED, "no_equilibrium", "no_convergence", "toppled", "refused")  # another attempt would end alike

Tell = Callable[[int, int, str], None]


class Kept:
    """Rows of cells, one file each.

    Parameters
    ----------
    folder : Of the search; rows stand in ``cells/KEY.json`` of it. fresh : Take no row for known.
    """

    def __init__(self, folder: Path, *, fresh: bool) -> None:
        self.folder, self._fresh = folder / "cells", fresh
        make_folder(self.folder)
        for left in self.folder.glob(f"*{PART}"):  # by a kill, beside a row that was whole
            left.unlink(missing_ok=True)

    def row[T](self, key: str, kind: type[T]) -> T | None:
        """What is kept of a cell; None where it is to be computed.

        Parameters
        ----------
        key : Of the cell. kind : Of its row.
        """
        return None if self._fresh else known(self._path(key), kind)

    def keep(self, key: str, row: Any) -> None:
        """Keep the row of a cell.

        Parameters
        ----------
        key : Of the cell. row : What came of it.
        """
        write(self._path(key), row)

    def computed(
        self, cells: Sequence[Cell], crew: Crew, base: Path, tell: Tell | None
    ) -> tuple[dict[str, dict[str, Any]], bool]:
        """Rows of all cells by key, and whether Ctrl-C came.

        Parameters
        ----------
        cells : What is wanted. crew : Who computes what is not known.
        base : Folder that paths in scenes are relative to.
        tell : Called with the number of finished cells, the number of all, and what was finished last.
        """
        unique = {cell.key: cell for cell in cells if cell.scene is not None}
        found = {key: self.row(key, dict[str, Any]) for key in unique}
        rows = {key: row for key, row in found.items() if row and _lasts(row, crew.limit)}
        waiting = [cell for key, cell in unique.items() if key not in rows]
        say = tell or (lambda done, total, last: None)
        say(len(rows), len(unique), "")
        try:
            with crew:
                for cell, row in crew.compute(waiting, base=base, folder=self.folder):
                    rows[cell.key] = row
                    say(len(rows), len(unique), f"{', '.join(cell.settings.values())}: {row['outcome']}")
        except KeyboardInterrupt:
            return rows, True
        return rows, False

    def _path(self, key: str) -> Path:
        return self.folder / f"{key}.json"


def outlook(done: int, total: int, words: str, folder: Path) -> str:
    """How far an interrupted search is, and how to go on.

    Parameters
    ----------
    done, total : Numbers of cells. words : What they are, and that they are done. folder : Of the search.
    """
    left = total - done
    return f"{done} of {total} {words} and kept in {folder}; the same command goes on with the {left} left"


def _lasts(row: dict[str, Any], limit: float | None) -> bool:
    """Whether a kept row need not be computed again, with a ``limit`` of CPU time [s]; None: no limit."""
    if row.get("outcome") == "time_limit":
        return limit is not None and limit <= row.get("limit", 0.0)
    return row.get("outcome") in KNOWN
