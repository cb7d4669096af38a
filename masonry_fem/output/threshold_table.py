"""Threshold table: the threshold of a key on the console."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from masonry_fem.output.collapse_table import STYLES, mechanism_lines
from masonry_fem.records.told import plain

if TYPE_CHECKING:
    from rich.console import Console


def print_threshold(record: Any, console: Console | None = None) -> None:
    """Print both ranges side by side, the trials and the mechanism.

    Parameters
    ----------
    record : What ``threshold.json`` holds.
    console : Where to write; by default standard output.
    """
    from rich.console import Console  # noqa: PLC0415
    from rich.panel import Panel  # noqa: PLC0415
    from rich.table import Table  # noqa: PLC0415
    from rich.text import Text  # noqa: PLC0415

    console, told = console or Console(), plain(record)
    style = "green" if told["outcome"] == "bracketed" else "red"
    head = Text(str(told["outcome"]), style=f"bold {style}")
    head.append(f"\n{told['message']}", style="default")
    console.print(Panel(head, border_style=style, title=told.get("title") or None, title_align="left"))
    unit = f" [{told['unit']}]" if told["unit"] else ""
    ranges = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0), header_style="dim")
    for name in ("", f"stands{unit}", f"falls{unit}", "outcome"):
        ranges.add_column(Text(name))
    for name in ("simulation", "limit analysis"):
        one = told[name.replace(" ", "_")]
        if one is not None:
            ends = ("–" if one[end] is None else f"{one[end]:.6g}" for end in ("stands", "falls"))
            ranges.add_row(Text(name, style="bold"), *ends, one["outcome"])
    console.print(ranges)
    trials = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0), header_style="dim")
    for name in ("trial", f"value{unit}", "verdict", "steps", "CPU [s]", "outcome"):
        trials.add_column(Text(name), justify="right" if name in ("trial", "steps", "CPU [s]") else "left")
    made = [trial for trial in told["trials"] if trial["by"] == "simulation"]
    for number, trial in enumerate(made, start=1):
        trials.add_row(
            str(number),
            f"{trial['value']:.6g}",
            Text(trial["verdict"], style=STYLES[trial["verdict"]]),
            str(trial["steps"]),
            f"{trial['seconds']:.2f}",
            trial["outcome"].replace("_", " "),
        )
    console.print(trials)
    rows = Table(box=None, show_header=False, pad_edge=False, padding=(0, 2, 0, 0))
    rows.add_column(style="bold", no_wrap=True)
    rows.add_column()
    for heading, lines in (
        ("mechanism", mechanism_lines(told["simulation"]["mechanism"])),
        ("notes", told["notes"]),
    ):
        for place, line in enumerate(lines):
            rows.add_row("" if place else heading, Text(line))
    console.print(rows)
