"""Search table: the search for a collapse multiplier or a threshold on the console, and what it found."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from math import ceil, log2
from typing import TYPE_CHECKING, Any

from masonry_fem.host.phases import phase
from masonry_fem.output.tables import columns, print_rows, print_verdict
from masonry_fem.records.told import plain

if TYPE_CHECKING:
    from rich.console import Console

STYLES = {"stands": "green", "falls": "red", "undecided": "yellow"}


@contextmanager
def watched(tolerance: float) -> Iterator[Callable[[float, str, float | None, float | None], None]]:
    """Tell of the trials of a collapse or a threshold as of a phase, with the bracket found so far.

        with watched(tolerance=0.01) as say:
            threshold(scene, key, between, tolerance=0.01, tell=say)

    Parameters
    ----------
    tolerance : Relative width of the bracket at which the search ends: tells how many trials are left.

    Yields
    ------
    What is told each value that was tried, its verdict, and the bracket.
    """
    count = 0

    def say(value: float, verdict: str, stands: float | None, falls: float | None) -> None:
        nonlocal count
        count += 1
        words = f"{count}: {value:.6g} {verdict}; stands at {_number(stands)}, falls at {_number(falls)}"
        at(count, words, count + halvings(stands, falls, tolerance))

    with phase("trials") as at:
        at(0, "build and first trial")
        yield say


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
