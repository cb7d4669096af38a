"""Outputs: ``incremental.json``, tables of runs and of fragilities, pictures, and words for the console."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from masonry_fem.analyses.incremental.fragility import Fragility
from masonry_fem.host.atomic import write_table
from masonry_fem.output.chart import can_draw
from masonry_fem.output.folder import Folder
from masonry_fem.output.tables import columns, print_advice
from masonry_fem.records.told import write
from masonry_fem.results.incremental import IncrementalTold

if TYPE_CHECKING:
    from rich.console import Console

    from masonry_fem.analyses.incremental.sweep import Incremental


POINTS = 121  # of a fragility's curve
PICTURES = ("ida.png", "fragility.png")


def write_incremental(
    folder: Path, told: IncrementalTold, fits: Sequence[Fragility], *, demand: str, pictures: bool
) -> list[Path]:
    """Write the files of an incremental dynamic analysis, and list them.

    Parameters
    ----------
    folder : Where to. told : What was found.
    fits : Distributions, one a limit. demand : The one that is drawn.
    pictures : Whether any are drawn, where the machine can.
    """
    with Folder(folder, "incremental", title=told.title):
        paths = [_runs(folder / "incremental.csv", told), _curves(folder / "fragility.csv", told, fits)]
        if pictures and told.runs and can_draw("pictures"):
            from masonry_fem.analyses.incremental.plot import (  # noqa: PLC0415 - matplotlib
                draw_curves,
                draw_fragility,
            )

            paths.append(draw_curves(folder / PICTURES[0], told, demand))
            paths.append(draw_fragility(folder / PICTURES[1], told, fits))
        else:
            for name in PICTURES:
                (folder / name).unlink(missing_ok=True)
        return [*paths, write(folder / "incremental.json", told)]


def intensities(told: IncrementalTold) -> NDArray[np.float64]:
    """Where fragilities are told: from a tenth of the least run to 1.2 of the greatest [m/s²]."""
    ends = [one.intensity for one in told.runs]
    return np.geomspace(0.1 * min(ends), 1.2 * max(ends), POINTS)


def unit_of(demand: str) -> str:
    """Unit of a demand."""
    return "rad" if demand == "lean" else "m"


def _runs(path: Path, told: IncrementalTold) -> Path:
    """A line a run."""
    demands = list(dict.fromkeys(name for one in told.runs for name in one.demands))
    titles = [
        "record", "scale", *dict.fromkeys([f"{told.intensity} [m/s^2]", "PGA [m/s^2]"]), "verdict",
        *(f"{name} [{unit_of(name)}]" for name in demands),
        "leans", "swing", "steps", "cpu [s]", "outcome", "message",
    ]  # fmt: skip
    rows = (
        [one.record, one.scale, *([] if told.intensity == "PGA" else [one.intensity]), one.pga, one.verdict]
        + [one.demands.get(name, "") for name in demands]
        + [one.leans, one.swing, one.steps, one.cpu, one.outcome, one.message]
        for one in told.runs
    )
    return write_table(path, titles, rows)


def _curves(path: Path, told: IncrementalTold, fits: Sequence[Fragility]) -> Path:
    """A line an intensity: probability, and its range, of each limit that is fitted."""
    columns: dict[str, NDArray[np.float64]] = {}
    if told.runs:
        at = columns[f"{told.intensity} [m/s^2]"] = intensities(told)
        for one, fit in zip(told.fragilities, fits, strict=True):
            low, high = fit.band(at)
            columns |= {one.state: fit.probability(at), f"{one.state}, low": low, f"{one.state}, high": high}
    rows = np.column_stack(list(columns.values())).tolist() if columns else []
    return write_table(path, columns, rows)


def print_incremental(made: Incremental, console: Console | None = None) -> None:
    """Print where each record begins to pass each limit, and the fragilities.

    Parameters
    ----------
    made : What was found. console : Where to write; by default standard output.
    """
    from rich.console import Console  # noqa: PLC0415
    from rich.text import Text  # noqa: PLC0415

    told, console = made.told, console or Console()
    limits = told.fragilities
    if told.title:
        console.print(Text(told.title, style="bold"))
    fallen = sum(one.verdict == "falls" for one in told.runs)
    console.print(
        Text(f"{len(told.runs)} runs, in {fallen} of which a stone falls; intensity: {told.intensity} [m/s²]")
    )
    ends = [title for one in limits for title in (f"{one.state}: stands", "passes it")]
    table = columns(["record", *ends], ends)
    for of_record in zip(*(one.capacities for one in limits), strict=True):
        cells = [_number(end) for own in of_record for end in (own.stands, own.passes)]
        table.add_row(Text(of_record[0].record), *cells)
    console.print(table)
    print_advice(console, ((one.words, one.outcome == "fitted") for one in limits), told.notes)


def _number(end: float | None) -> str:
    return "–" if end is None else f"{end:.4g}"
