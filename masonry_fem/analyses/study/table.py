"""Table: a study on the console."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

from masonry_fem.analyses.cells.kept import SOLVED
from masonry_fem.analyses.study.outputs import orders
from masonry_fem.analyses.study.pareto import setting_places
from masonry_fem.analyses.study.recommendation import percent
from masonry_fem.analyses.study.values import shown, words
from masonry_fem.output.tables import columns, print_advice
from masonry_fem.records.remark import first_few

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

    from masonry_fem.analyses.study.pareto import Point
    from masonry_fem.analyses.study.peak import Peak
    from masonry_fem.analyses.study.row import Row
    from masonry_fem.analyses.study.sweep import Study

WIDE, NARROW = 160, 130  # characters: of a file or a pipe; where some columns are left out
SHOWN = 60  # cells; of more the best are shown
SAID = 3  # cells that a message names
FEW = 2  # quantities with a column where it is narrow
type Errors = dict[tuple[int, str], tuple[float, Point | None]]  # by row and target
SHORT = {"stress.means": "means", "stress.p95": "p95", "stress.max": "max"}


def print_study(study: Study, console: Console | None = None) -> None:
    """Print cells, orders and advice.

    Parameters
    ----------
    study : The study.
    console : Where to write; by default standard output.
    """
    from rich.console import Console  # noqa: PLC0415
    from rich.text import Text  # noqa: PLC0415

    console = console or Console()
    if not console.is_terminal:
        console = Console(file=console.file, width=WIDE, force_jupyter=False)
    if study.title:
        console.print(Text(study.title, style="bold"))
    console.print(_cells(study, narrow=console.width < NARROW))
    left = len(study.rows) - len(_shown(study))
    if left:
        console.print(
            Text(
                f"{left} more cells, that are beaten or pose one of these problems, in study.csv", style="dim"
            )
        )
    peaks = _peaks(study)
    if peaks.row_count:
        console.print()
        console.print(peaks)
    for line in _failures(study):
        console.print(Text(line, style="red"))
    seen = _orders(study)
    if seen.row_count:
        console.print()
        console.print(seen)
    if study.recommendations:
        console.print()
        console.print(Text(f"Advice, for {percent(study.accuracy)}", style="bold"))
    advice = ((one.words, one.settings is not None) for one in study.recommendations)
    print_advice(console, advice, study.notes)


def _cells(study: Study, narrow: bool) -> Table:
    """One line a cell that is not another's twin: settings, costs, errors in per cent."""
    from rich.text import Text  # noqa: PLC0415

    table, told = columns((), gap=1 if narrow else 2), list(_columns(study, narrow))
    for title, aside, _ in told:
        table.add_column(Text(title), justify="right" if aside else "left", no_wrap=not aside)
    for row in _shown(study):
        table.add_row(*(cell(row) for *_, cell in told))
    return table


def _columns(study: Study, narrow: bool) -> Iterator[tuple[str, bool, Callable[[Row], Any]]]:
    """Title of each column, whether it is set to the right, and what it says of a cell."""
    varied, aims = [one.key for one in study.vary], study.targets
    for title, key in zip(_titles(study, varied), varied, strict=True):
        yield title, False, partial(_setting, key=key)
    costs = ["CPU [s]", "MB"] if narrow or study.explores else ["CPU [s]", "mostly", "MB", "unknowns"]
    failed = any(row.outcome not in SOLVED for row in study.rows)
    for title in ["outcome", *costs] if failed else costs:
        yield title, title != "outcome", partial(_told, title=title)
    if study.explores:
        for name in shown(aims)[: FEW if narrow else None]:
            yield name.replace(".", "\n", 1), True, partial(words, name=name)
        return
    errors = _errors(study)
    for aim in aims:
        yield f"{SHORT.get(aim.label, aim.label)} %", True, partial(_error, errors=errors, label=aim.label)


def _peaks(study: Study) -> Table:
    """One line a peak of a cell: how great, when, where the probes were, and what has yielded at the end."""
    from rich.text import Text  # noqa: PLC0415

    varied, rows = [one.key for one in study.vary], _shown(study)
    probes = list(dict.fromkeys(probe for row in rows for one in row.peaks for probe in one.probes))
    yielded = ["yielded"] if any(row.yielded for row in rows) else []
    table = columns(
        [*_titles(study, varied), "peak of", "is", "at time", *(f"{probe} [m]" for probe in probes), *yielded]
    )
    for row in rows:
        settings = [row.cell.settings[key] for key in varied]
        for one in row.peaks:
            words = [*settings, *_peak_words(one, probes), row.yielded]
            table.add_row(*map(Text, words[: len(table.columns)]))
    return table


def _peak_words(peak: Peak, probes: Sequence[str]) -> Iterator[str]:
    """What it is of, how great, when, and where probes were."""
    yield from (peak.of, f"{peak.value:.4g} {peak.unit}", f"{peak.time:.4g}")
    for probe in probes:
        yield ", ".join(f"{part:.3g}" for part in peak.probes[probe])


def _setting(row: Row, key: str) -> Any:
    """The value of a key in a cell."""
    from rich.text import Text  # noqa: PLC0415

    return Text(row.cell.settings[key])


def _told(row: Row, title: str) -> Any:
    """What came of a cell, or what it took: by the title of a column."""
    from rich.text import Text  # noqa: PLC0415

    match title:
        case "outcome":
            return Text(row.outcome.replace("_", " "), style="green" if row.outcome in SOLVED else "red")
        case "CPU [s]":
            return f"{row.cpu:.2f}" if row.cpu else ""
        case "mostly":
            return max(row.seconds, key=row.seconds.__getitem__, default="")
        case "MB":
            return f"{row.memory:.0f}" if row.memory else ""
    return str(row.size.get(title, ""))


def _shown(study: Study) -> list[Row]:
    """Rows to print: one of those that pose one problem; of many the best, and those that failed."""
    unique: dict[str | int, Row] = {}
    for row in study.rows:
        unique.setdefault(row.cell.key or id(row), row)
    rows = list(unique.values())
    if len(rows) <= SHOWN or study.explores:
        return rows
    best = {point.places for aim in study.targets for point in study.points(aim) if point.best}
    return [row for row in rows if setting_places(study.vary, row) in best]


def _errors(study: Study) -> Errors:
    """Error of each row for each target, and its point."""
    found: Errors = {}
    for aim in study.targets:
        points = {point.places: point for point in study.points(aim)}
        for made in study.comparisons:
            known = all(name in made.error for name in aim.names)
            values = made.worst(aim.names, made.error) if known else [math.nan] * len(made.rows)
            for row, value in zip(made.rows, values, strict=True):
                found[id(row), aim.label] = float(value), points.get(setting_places(study.vary, row))
    return found


def heads(keys: Sequence[str]) -> list[str]:
    """Keys by their last word where no two have the same."""
    tails = [key.rpartition(".")[2] for key in keys]
    return [tail if tails.count(tail) == 1 else key for key, tail in zip(keys, tails, strict=True)]


def _titles(study: Study, keys: Sequence[str]) -> list[str]:
    """Headings of columns of keys, with the unit of plain numbers."""
    units = {one.key: f" [{one.unit}]" for one in study.vary if one.unit}
    return [f"{head}{units.get(key, '')}" for head, key in zip(heads(keys), keys, strict=True)]


def _failures(study: Study) -> list[str]:
    """How cells failed, alike ones together."""
    found: dict[str, list[str]] = {}
    for row in study.rows:
        if row.outcome not in SOLVED and row.outcome != "missing":
            found.setdefault(row.message, []).append(" · ".join(row.cell.settings.values()))
    return [f"{first_few(cells, SAID)}: {message}" for message, cells in found.items()]


def _error(row: Row, errors: Errors, label: str) -> Any:
    """An error in per cent; bold where nothing cheaper is as close. Empty where nothing was compared."""
    from rich.text import Text  # noqa: PLC0415

    if not errors:
        return ""
    value, point = errors[id(row), label]
    if not math.isfinite(value):
        return Text("–", style="dim")
    if point is not None and point.is_reference:
        return Text("ref", style="cyan")
    words = percent(value).removesuffix(" %").replace("< ", "<")
    return Text(words, style="bold green" if point is not None and point.best else "")


def _left(words: str, left: float) -> str:
    """What is seen of an order, and what is left at the finest value."""
    if not math.isfinite(left):
        return f"{words}, not known"
    return f"{words}, ≤ {percent(left).removeprefix('< ')}"


def _orders(study: Study) -> Table:
    from rich.text import Text  # noqa: PLC0415

    found = list(orders(study))
    keys: Sequence[str] = list(dict.fromkeys(one.key for one in found))
    table = columns(["observed order of, and left at the finest", *keys])
    rows: dict[tuple[str, str], dict[str, str]] = {}
    for one in found:
        label = ", ".join(f"{key} = {value}" for key, value in one.case.items())
        rows.setdefault((label, one.quantity), {})[one.key] = _left(one.verdict, one.left)
    for (case_label, name), by_key in rows.items():
        table.add_row(
            Text(f"{name} ({case_label})" if case_label else name),
            *(Text(by_key.get(key, "")) for key in keys),
        )
    return table
