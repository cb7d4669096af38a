"""Table: an incremental dynamic analysis on the console."""

from __future__ import annotations

from typing import TYPE_CHECKING

from masonry_fem.results.incremental import IncrementalTold

if TYPE_CHECKING:
    from rich.console import Console


def print_incremental(told: IncrementalTold, console: Console | None = None) -> None:
    """Print where each record begins to pass each limit, and the fragilities.

    Parameters
    ----------
    told : What was found. console : Where to write; by default standard output.
    """
    from rich.console import Console  # noqa: PLC0415
    from rich.table import Table  # noqa: PLC0415
    from rich.text import Text  # noqa: PLC0415

    console = console or Console()
    if told.title:
        console.print(Text(told.title, style="bold"))
    fallen = sum(one.verdict == "falls" for one in told.runs)
    console.print(
        Text(f"{len(told.runs)} runs, in {fallen} of which a stone falls; intensity: {told.intensity} [m/s²]")
    )
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0), header_style="dim")
    table.add_column("record")
    for one in told.fragilities:
        table.add_column(Text(f"{one.state}: stands"), justify="right")
        table.add_column(Text("passes it"), justify="right")
    rows: dict[str, list[str]] = {own.record: [] for own in told.fragilities[0].capacities}
    for one in told.fragilities:
        for own in one.capacities:
            passes = "–" if own.passes is None else f"{own.passes:.4g}"
            rows[own.record] += [f"{own.stands:.4g}", passes]
    for name, words in rows.items():
        table.add_row(Text(name), *words)
    console.print(table)
    for one in told.fragilities:
        text = Text("• ", style="green" if one.outcome == "fitted" else "yellow")
        console.print(text.append(one.words, style="default"))
    for note in told.notes:
        console.print(Text(f"note: {note}", style="dim"))
