"""Table: an incremental dynamic analysis on the console."""

from __future__ import annotations

from typing import TYPE_CHECKING

from masonry_fem.output.tables import columns, print_advice

if TYPE_CHECKING:
    from rich.console import Console

    from masonry_fem.analyses.incremental.sweep import Incremental


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
