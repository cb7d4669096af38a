"""Row: the result of a cell."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from masonry_fem.analyses.cells.cell import Cell
from masonry_fem.analyses.cells.kept import SOLVED
from masonry_fem.analyses.study.peak import Peak, asked_for
from masonry_fem.analyses.study.quantity import Quantities, Quantity


@dataclass(frozen=True, slots=True)
class Row:
    """A cell and its results.

    Attributes
    ----------
    cell : What was asked.
    outcome : As of a run, or ``bad_scene``, ``refused``, ``failed``, ``out_of_memory``, ``time_limit``,
        ``missing``.
    message : The same as a sentence.
    cpu, start : CPU time of the cell and of loading what it needs [s].
    seconds : The former by phase. memory : Peak [MB]. size : Counts.
    certificate : Error measures of the run.
    quantities : What is compared; empty where the cell was not solved.
    peaks : Those that were asked for, up to where the cell came.
    yielded : Which stones have yielded or cracked, and how far, in words.
    warnings : What the run warned of.
    """

    cell: Cell
    outcome: str
    message: str
    cpu: float
    start: float
    seconds: Mapping[str, float]
    memory: float
    size: Mapping[str, int]
    certificate: Mapping[str, float]
    quantities: Quantities
    warnings: tuple[str, ...]
    peaks: tuple[Peak, ...] = ()
    yielded: str = ""

    @property
    def solved(self) -> bool:
        """Whether there is a state to compare."""
        return self.outcome in SOLVED

    @classmethod
    def of(cls, cell: Cell, told: Mapping[str, Any], peaks: Sequence[str] = ()) -> Row:
        """From what a worker left.

        Parameters
        ----------
        cell : What was asked. told : The cell's file. peaks : Names of those that are asked for.

        Raises
        ------
        MasonryError : The cell's history has no such number.
        """
        solved = told["outcome"] in SOLVED
        quantities = told.get("quantities", {}) if solved else {}
        reached = asked_for(told.get("peaks", ()), peaks)
        return cls(
            cell=cell,
            outcome=told["outcome"],
            message=told["message"],
            cpu=float(told.get("cpu", 0.0)),
            start=float(told.get("start", 0.0)),
            seconds=told.get("seconds", {}),
            memory=float(told.get("peak_memory_mb", 0.0)),
            size=told.get("size", {}),
            certificate=told.get("certificate", {}),
            quantities={name: Quantity.of(one) for name, one in quantities.items()}
            | {one.name: one.quantity for one in reached if solved},
            warnings=tuple(told.get("warnings", ())),
            peaks=reached,
            yielded=", ".join(
                f"{one['block']} ({one['measure']} {one['greatest']:.3g})" for one in told.get("yielded", ())
            ),
        )

    @classmethod
    def unsolved(cls, cell: Cell, outcome: str, message: str) -> Row:
        """Of a cell that was not computed."""
        return cls.of(cell, {"outcome": outcome, "message": message})
