"""Collapse table: the search for a collapse multiplier on the console, while it runs and at its end."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Self

from masonry_fem.records.told import plain

if TYPE_CHECKING:
    from rich.console import Console

STYLES = {"stands": "green", "falls": "red", "undecided": "yellow"}


class Watch:
    """A line on standard error with the bracket found so far, of a collapse or a threshold.

        with Watch() as watch:
            collapse(scene, tell=watch.tell)

    Parameters
    ----------
    quiet : Show nothing; so it is, too, if standard error is no terminal.
    console : Where to write; by default standard error.
    """

    def __init__(self, *, quiet: bool = False, console: Console | None = None) -> None:
        self._quiet, self._console, self._count = quiet, console, 0
        self._status: Any = None

    def __enter__(self) -> Self:
        """Show that the search begins."""
        from rich.console import Console  # noqa: PLC0415  not on the path of --help

        console = self._console or Console(stderr=True)
        if not self._quiet and console.is_terminal:
            self._status = console.status("build and first trial")
            self._status.start()
        return self

    def __exit__(self, *_: object) -> None:
        """Take the line away."""
        if self._status is not None:
            self._status.stop()

    def tell(self, trial: Any, stands: float | None, falls: float | None) -> None:
        """A trial has ended: ``multiplier``, ``verdict``, and the bracket."""
        self.say(trial.multiplier, trial.verdict, stands, falls)

    def say(self, value: float, verdict: str, stands: float | None, falls: float | None) -> None:
        """The same of any value that is tried."""
        self._count += 1
        if self._status is not None:
            self._status.update(
                f"trial {self._count}: {value:.6g} {verdict}; "
                f"stands at {_number(stands)}, falls at {_number(falls)}"
            )


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
