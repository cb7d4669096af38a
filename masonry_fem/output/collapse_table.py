"""Collapse table: the search for a collapse multiplier on the console, while it runs and at its end."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import AbstractContextManager
from math import ceil, log2
from typing import TYPE_CHECKING, Any, Self

from masonry_fem.host.phases import At, phase
from masonry_fem.records.told import plain

if TYPE_CHECKING:
    from rich.console import Console

STYLES = {"stands": "green", "falls": "red", "undecided": "yellow"}


class Watch:
    """Tells of the trials of a collapse or a threshold as of a phase, with the bracket found so far.

        with Watch(tolerance=0.01) as watch:
            collapse(scene, tolerance=0.01, tell=watch.tell)

    Parameters
    ----------
    tolerance : Relative width of the bracket at which the search ends: tells how many trials are left.
    """

    def __init__(self, tolerance: float) -> None:
        self._tolerance, self._count = tolerance, 0
        self._phase: AbstractContextManager[At] = phase("trials")

    def __enter__(self) -> Self:
        """The search begins."""
        self._at = self._phase.__enter__()
        self._at(0, "build and first trial")
        return self

    def __exit__(self, *_: object) -> None:
        """It has ended."""
        self._phase.__exit__(None, None, None)

    def tell(self, trial: Any, stands: float | None, falls: float | None) -> None:
        """A trial has ended: ``multiplier``, ``verdict``, and the bracket."""
        self.say(trial.multiplier, trial.verdict, stands, falls)

    def say(self, value: float, verdict: str, stands: float | None, falls: float | None) -> None:
        """The same of any value that is tried."""
        self._count += 1
        words = (
            f"{self._count}: {value:.6g} {verdict}; stands at {_number(stands)}, falls at {_number(falls)}"
        )
        self._at(self._count, words, self._count + halvings(stands, falls, self._tolerance))


def halvings(stands: float | None, falls: float | None, tolerance: float) -> int:
    """How many trials narrow a bracket to its tolerance, if each of them halves it; 1 where it has no end.

    Parameters
    ----------
    stands, falls : Its ends; None: not known. tolerance : Relative to the larger one.
    """
    if stands is None or falls is None:
        return 1
    narrow = tolerance * max(abs(stands), abs(falls))
    return max(ceil(log2(abs(falls - stands) / narrow)), 0) if narrow > 0 and falls != stands else 0


def print_collapse(record: Any, console: Console | None = None) -> None:
    """Print the verdict, the trials and the mechanism.

    Parameters
    ----------
    record : What ``collapse.json`` holds.
    console : Where to write; by default standard output.
    """
    from rich.console import Console  # noqa: PLC0415
    from rich.panel import Panel  # noqa: PLC0415
    from rich.table import Table  # noqa: PLC0415
    from rich.text import Text  # noqa: PLC0415

    console, told = console or Console(), plain(record)
    style = "green" if told["outcome"] in ("bracketed", "unlimited") else "red"
    head = Text(str(told["outcome"]), style=f"bold {style}")
    head.append(f"\n{told['message']}", style="default")
    console.print(Panel(head, border_style=style, title=told.get("title") or None, title_align="left"))
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0), header_style="dim")
    for name in ("trial", f"multiplier [{told['unit']}]", "verdict", "steps", "CPU [s]", "outcome"):
        table.add_column(Text(name), justify="right" if name in ("trial", "steps", "CPU [s]") else "left")
    for number, trial in enumerate(told["trials"], start=1):
        table.add_row(
            str(number),
            f"{trial['multiplier']:.6g}",
            Text(trial["verdict"], style=STYLES[trial["verdict"]]),
            str(trial["steps"]),
            f"{trial['seconds']:.2f}",
            trial["outcome"].replace("_", " "),
        )
    console.print(Text().append("grows  ", style="bold").append(told["action"]))
    console.print(table)
    rows = Table(box=None, show_header=False, pad_edge=False, padding=(0, 2, 0, 0))
    rows.add_column(style="bold", no_wrap=True)
    rows.add_column()
    for heading, lines in _told(told):
        for place, line in enumerate(lines):
            rows.add_row("" if place else heading, Text(line))
    console.print(rows)


def mechanism_lines(mechanism: Mapping[str, Any] | None, most: int = 16) -> list[str]:
    """A mechanism part by part and joint by joint, in words.

    Parameters
    ----------
    mechanism : As in ``collapse.json``; None for none.
    most : Number of lines after which the rest is left out.
    """
    words = list(mechanism["words"]) if mechanism else []
    more = len(words) - most
    return words if more <= 1 else [*words[:most], f"and {more} more, in the file"]


def _told(told: Mapping[str, Any]) -> list[tuple[str, list[str]]]:
    limit = told["limit_multiplier"]
    return [
        ("mechanism", mechanism_lines(told["mechanism"])),
        ("limit analysis", [] if limit is None else [f"at most {limit:.6g}"]),
        ("notes", list(told["notes"])),
    ]


def _number(value: float | None) -> str:
    return "–" if value is None else f"{value:.6g}"
