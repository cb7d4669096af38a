"""Search table: the search for a collapse multiplier or a threshold on the console, and what it found."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, Self

from masonry_fem.output.tables import columns, print_rows, print_verdict
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
    from rich.text import Text  # noqa: PLC0415

    console, told = console or Console(), plain(record)
    print_verdict(console, told, told["outcome"], good=told["outcome"] in ("bracketed", "unlimited"))
    console.print(Text().append("grows  ", style="bold").append(told["action"]))
    print_trials(console, "multiplier", told["unit"], told["trials"])
    limit = told["limit_multiplier"]
    print_lines(
        console,
        {
            "mechanism": mechanism_lines(told["mechanism"]),
            "limit analysis": [] if limit is None else [f"at most {limit:.6g}"],
            "notes": told["notes"],
        },
    )


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


def print_trials(console: Console, name: str, unit: str, trials: Iterable[Mapping[str, Any]]) -> None:
    """A row for each simulation of a search.

    Parameters
    ----------
    console : Where to write.
    name, unit : Of what is searched for; the unit may be empty.
    trials : In their order.
    """
    from rich.text import Text  # noqa: PLC0415

    titles = ("trial", name + (f" [{unit}]" if unit else ""), "verdict", "steps", "CPU [s]", "outcome")
    table = columns(titles, ("trial", "steps", "CPU [s]"))
    for number, trial in enumerate(trials, start=1):
        table.add_row(
            str(number),
            f"{trial[name]:.6g}",
            Text(trial["verdict"], style=STYLES[trial["verdict"]]),
            str(trial["steps"]),
            f"{trial['seconds']:.2f}",
            trial["outcome"].replace("_", " "),
        )
    console.print(table)


def print_lines(console: Console, lines: Mapping[str, Iterable[str]]) -> None:
    """Lines under their headings.

    Parameters
    ----------
    console : Where to write.
    lines : By heading.
    """
    print_rows(console, ([(key, "", line) for line in told] for key, told in lines.items()), named=False)


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


def _number(value: float | None) -> str:
    return "–" if value is None else f"{value:.6g}"
