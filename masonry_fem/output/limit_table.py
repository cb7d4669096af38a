"""Limit table: the results of limit analysis on the console."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from masonry_fem.output.sheet import quantity
from masonry_fem.records.told import plain

if TYPE_CHECKING:
    from rich.console import Console

DIGITS = 6
NOTHING = 1e-9  # of the largest force: shown as zero

Rows = Iterator[tuple[str, str, str]]


def print_limits(record: Any, dimension: int, console: Console | None = None) -> None:
    """Print a table of the results, the verdict first.

    Parameters
    ----------
    record : Results of ``results.limit.answers``.
    dimension : Of the scene, for units.
    console : Where to write; by default standard output.
    """
    from rich.console import Console  # noqa: PLC0415
    from rich.panel import Panel  # noqa: PLC0415
    from rich.table import Table  # noqa: PLC0415
    from rich.text import Text  # noqa: PLC0415

    console, told = console or Console(), plain(record)
    style = "green" if told["admissible"] else "red"
    head = Text("admissible" if told["admissible"] else "not admissible", style=f"bold {style}")
    head.append(f"\n{told['message']}", style="default")
    console.print(Panel(head, border_style=style, title=told.get("title") or None, title_align="left"))
    table = Table(box=None, show_header=False, pad_edge=False, padding=(0, 2, 0, 0))
    table.add_column(style="bold", no_wrap=True)
    table.add_column(style="dim", no_wrap=True)
    table.add_column()
    for part in (
        _model(told),
        _loads(told),
        support_rows(told, dimension),
        _certificate(told),
        _notes(told),
    ):
        section = ""
        for heading, name, value in part:
            table.add_row("" if heading == section else heading, name, Text(value))
            section = heading
    console.print(table)


def _model(told: Mapping[str, Any]) -> Rows:
    yield "model", "", f"free blocks {told['blocks']}, contacts {told['contacts']}"


def _loads(told: Mapping[str, Any]) -> Rows:
    yield "loads", "dead", ", ".join(told["dead"]) or "none"
    yield "loads", "growing", ", ".join(told["growing"]) or "none"
    if told["unlimited"]:
        yield "loads", "collapse multiplier", "no limit"
    elif told["multiplier"] is not None:
        yield "loads", "collapse multiplier", f"{told['multiplier']:.{DIGITS}g}"
    if told["least_multiplier"]:
        yield "loads", "least multiplier", f"{told['least_multiplier']:.{DIGITS}g}"


def support_rows(told: Mapping[str, Any], dimension: int) -> Rows:
    """Smallest and largest force of each support on the blocks, by axis, and of each tie.

    Parameters
    ----------
    told : Results of ``limit.answers``.
    dimension : Of the scene, for units.
    """
    unit = "N/m" if dimension == 2 else "N"
    supports: Mapping[str, Any] = told.get("supports", {})
    inexact: Mapping[str, Any] = told.get("inexact", {})
    every = {f"support {name}": axes for name, axes in supports.items()}
    every |= {f"tie {name}": {"": pair} for name, pair in (told.get("ties") or {}).items()}
    ends = [abs(end) for axes in every.values() for pair in axes.values() for end in pair if end]
    least = NOTHING * max(ends, default=0.0)
    for title, axes in every.items():
        name = title.partition(" ")[2]
        for axis, (low, high) in axes.items():
            error = inexact.get(name, {}).get(axis or "force", 0.0)
            below, above = ("−∞", "∞") if error is not None else ("not found", "not found")
            words = f"{_end(low, below, unit, least)} to {_end(high, above, unit, least)}"
            if error:
                words += f", ± {quantity(error, unit, 2)}"
            yield title, f"force {axis}".rstrip(), words


def _end(value: float | None, unbounded: str, unit: str, least: float) -> str:
    if value is None:
        return unbounded
    return quantity(0.0 if abs(value) < least else value, unit, DIGITS)


def _certificate(told: Mapping[str, Any]) -> Rows:
    for name, value in told["certificate"].items():
        yield "certificate", name, "–" if value is None else f"{value:.1e}"


def _notes(told: Mapping[str, Any]) -> Rows:
    for note in told["notes"]:
        yield "notes", "", note
