"""Table: a study on the console, while it runs and when it has ended."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Self

from masonry_fem.study.files import orders
from masonry_fem.study.recommendation import percent
from masonry_fem.study.row import SOLVED

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

    from masonry_fem.study.pareto import Point
    from masonry_fem.study.study import Study

WIDE = 160  # of a file or a pipe
SHOWN = 60  # cells; of more the best are shown
SAID = 3  # cells that a message names
SHORT = {"stress.means": "means", "stress.p95": "p95", "stress.max": "max"}


class Watch:
    """A bar on standard error with the cells done; nothing where that is no terminal, or with ``quiet``.

    with Watch() as watch:
        study(scene, vary, tell=watch.tell)
    """

    def __init__(self, *, quiet: bool = False, console: Console | None = None) -> None:
        self._quiet, self._console = quiet, console
        self._bar: Any = None
        self._task: Any = None

    def __enter__(self) -> Self:
        """Show an empty bar."""
        from rich.console import Console  # noqa: PLC0415 - not on the path of --help
        from rich.progress import (  # noqa: PLC0415  # noqa: PLC0415
            BarColumn,
            MofNCompleteColumn,
            Progress,
            TextColumn,
            TimeElapsedColumn,
            TimeRemainingColumn,
        )

        console = self._console or Console(stderr=True)
        if not self._quiet and console.is_terminal:
            columns = (
                TextColumn("cells"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(),
                TextColumn("left"), TimeRemainingColumn(), TextColumn("{task.fields[last]}"),
            )  # fmt: skip
            self._bar = Progress(*columns, console=console, transient=True)
            self._task = self._bar.add_task("", total=None, last="")
            self._bar.start()
        return self

    def __exit__(self, *_: object) -> None:
        """Take the bar away."""
        if self._bar is not None:
            self._bar.stop()

    def tell(self, done: int, total: int, last: str) -> None:
        """A cell has ended."""
        if self._bar is not None:
            self._bar.update(self._task, completed=done, total=total, last=last)


def print_study(study: Study, console: Console | None = None) -> None:
    """Cells, orders and advice."""
    from rich.console import Console  # noqa: PLC0415
    from rich.text import Text  # noqa: PLC0415

    console = console or Console()
    if not console.is_terminal:
        console = Console(file=console.file, width=WIDE)
    if study.title:
        console.print(Text(study.title, style="bold"))
    console.print(_cells(study))
    for line in _failures(study):
        console.print(Text(line, style="red"))
    seen = _orders(study)
    if seen.row_count:
        console.print()
        console.print(seen)
    if study.recommendations:
        console.print()
        console.print(Text(f"Advice, for {percent(study.accuracy)}", style="bold"))
    for advice in study.recommendations:
        text = Text("• ", style="green" if advice.settings is not None else "yellow")
        console.print(text.append(advice.words, style="default"))
    for note in study.notes:
        console.print(Text(f"note: {note}", style="dim"))


def _cells(study: Study) -> Table:
    from rich.table import Table  # noqa: PLC0415
    from rich.text import Text  # noqa: PLC0415

    varied = [one.key for one in study.vary]
    aims = study.targets
    failed = any(row.outcome not in SOLVED for row in study.rows)
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0), header_style="dim")
    for key in heads(varied):
        table.add_column(Text(key), no_wrap=True)
    if failed:
        table.add_column("outcome", no_wrap=True)
    for name in ("CPU [s]", "mostly", "MB", "unknowns", *(SHORT.get(aim.label, aim.label) for aim in aims)):
        table.add_column(Text(name), justify="right", no_wrap=True)
    points = {aim.label: {point.places: point for point in study.points(aim)} for aim in aims}
    of = {id(row): (made, number) for made in study.comparisons for number, row in enumerate(made.rows)}
    worst = {
        (id(made), aim.label): made.worst(aim.names, made.error)
        for made in study.comparisons
        for aim in aims
        if all(name in made.error for name in aim.names)
    }
    hidden = 0
    for row in study.rows:
        places = tuple(-1 if one.is_case else p for one, p in zip(study.vary, row.cell.places, strict=True))
        own = {aim.label: points[aim.label].get(places) for aim in aims}
        if len(study.rows) > SHOWN and not any(point is not None and point.best for point in own.values()):
            hidden += 1
            continue
        made, number = of[id(row)]
        errors = []
        for aim in aims:
            values = worst.get((id(made), aim.label))
            errors.append(_error(None if values is None else float(values[number]), own[aim.label]))
        good = row.outcome in SOLVED
        table.add_row(
            *(Text(row.cell.settings[key]) for key in varied),
            *([Text(row.outcome.replace("_", " "), style="green" if good else "red")] if failed else []),
            f"{row.cpu:.2f}" if row.cpu else "",
            _mostly(row.seconds),
            f"{row.memory:.0f}" if row.memory else "",
            str(row.size.get("unknowns", "")),
            *errors,
        )
    if hidden:
        table.caption = f"{hidden} more cells, which others beat in everything, are in study.csv"
    return table


def heads(keys: Sequence[str]) -> list[str]:
    """Keys by their last word where no two have the same."""
    tails = [key.rpartition(".")[2] for key in keys]
    return [tail if tails.count(tail) == 1 else key for key, tail in zip(keys, tails, strict=True)]


def _mostly(seconds: Mapping[str, float]) -> str:
    """The phase that took most of the time."""
    return max(seconds, key=seconds.__getitem__) if any(seconds.values()) else ""


def _failures(study: Study) -> list[str]:
    """How cells failed, alike ones together."""
    found: dict[str, list[str]] = {}
    for row in study.rows:
        if row.outcome not in SOLVED and row.outcome != "missing":
            found.setdefault(row.message, []).append(" · ".join(row.cell.settings.values()))
    return [
        f"{', '.join(cells[:SAID])}{f' and {len(cells) - SAID} more' if len(cells) > SAID else ''}: {message}"
        for message, cells in found.items()
    ]


def _error(value: float | None, point: Point | None) -> Any:
    """An error in per cent; bold where nothing cheaper is as close."""
    from rich.text import Text  # noqa: PLC0415

    if value is None or not math.isfinite(value):
        return Text("–", style="dim")
    if point is not None and point.is_reference:
        return Text("reference", style="cyan")
    return Text(percent(value), style="bold green" if point is not None and point.best else "")


def _orders(study: Study) -> Table:
    from rich.table import Table  # noqa: PLC0415
    from rich.text import Text  # noqa: PLC0415

    found = list(orders(study))
    keys: Sequence[str] = list(dict.fromkeys(key for _, _, key, *_ in found))
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0), header_style="dim")
    table.add_column("observed order of, and left at the finest")
    for key in keys:
        table.add_column(Text(key))
    rows: dict[tuple[str, str], dict[str, str]] = {}
    for case, name, key, _, words, left in found:
        label = ", ".join(f"{key} = {value}" for key, value in case.items())
        rows.setdefault((label, name), {})[key] = f"{words}, ≤ {percent(left).removeprefix('< ')}"
    for (case_label, name), by_key in rows.items():
        table.add_row(
            Text(f"{name} ({case_label})" if case_label else name),
            *(Text(by_key.get(key, "")) for key in keys),
        )
    return table
