"""Limit table: the results of limit analysis on the console."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from masonry_fem.output.sheet import quantity
from masonry_fem.output.tables import print_rows, print_verdict
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

    console, told = console or Console(), plain(record)
    verdict = "admissible" if told["admissible"] else "not admissible"
    print_verdict(console, told, verdict, good=told["admissible"])
    parts = _model(told), _loads(told), support_rows(told, dimension), _certificate(told), _notes(told)
    print_rows(console, parts)


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
    every = list(_intervals(told))
    ends = [abs(end) for *_, pair in every for end in pair if end]
    least = NOTHING * max(ends, default=0.0)
    for kind, name, axis, pair in every:
        error = told.get("inexact", {}).get(name, {}).get(axis or "force", 0.0)
        signs = ("−∞", "∞") if error is not None else ("not found", "not found")
        low, high = (_end(end, sign, unit, least) for end, sign in zip(pair, signs, strict=True))
        words = f"{low} to {high}" + (f", ± {quantity(error, unit, 2)}" if error else "")
        yield f"{kind} {name}", f"force {axis}".rstrip(), words


def _intervals(told: Mapping[str, Any]) -> Iterator[tuple[str, str, str, Sequence[float | None]]]:
    """Kind, name and axis of each force that has an interval, and its ends; ties have no axis."""
    for name, axes in told.get("supports", {}).items():
        for axis, pair in axes.items():
            yield "support", name, axis, pair
    for name, pair in (told.get("ties") or {}).items():
        yield "tie", name, "", pair


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
