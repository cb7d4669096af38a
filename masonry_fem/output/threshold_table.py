"""Threshold table: the threshold of a key on the console."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from masonry_fem.output.collapse_table import mechanism_lines, print_lines, print_trials
from masonry_fem.output.tables import columns, print_verdict
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
    from rich.text import Text  # noqa: PLC0415

    console, told = console or Console(), plain(record)
    print_verdict(console, told, told["outcome"], good=told["outcome"] == "bracketed")
    unit = f" [{told['unit']}]" if told["unit"] else ""
    ranges = columns(("", f"stands{unit}", f"falls{unit}", "outcome"))
    for name, one in (("simulation", told["simulation"]), ("limit analysis", told["limit_analysis"])):
        if one is not None:
            ends = ("–" if one[end] is None else f"{one[end]:.6g}" for end in ("stands", "falls"))
            ranges.add_row(Text(name, style="bold"), *ends, one["outcome"])
    console.print(ranges)
    made = (trial for trial in told["trials"] if trial["by"] == "simulation")
    print_trials(console, "value", told["unit"], made)
    print_lines(
        console, {"mechanism": mechanism_lines(told["simulation"]["mechanism"]), "notes": told["notes"]}
    )
