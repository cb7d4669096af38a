"""Files: what a study leaves in its folder: ``study.csv``, ``study.json``, a picture."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from masonry_fem.analyses.study.comparison import Comparison
from masonry_fem.analyses.study.pareto import Point
from masonry_fem.analyses.study.row import Row
from masonry_fem.analyses.study.values import draw_values, drawable
from masonry_fem.host.atomic import write_records
from masonry_fem.host.phases import phase
from masonry_fem.output.chart import can_draw
from masonry_fem.output.folder import Folder
from masonry_fem.records.told import write
from masonry_fem.results.study import Choice, OrderTold, StudyTold

if TYPE_CHECKING:
    from masonry_fem.analyses.study.sweep import Study


def write_study(study: Study, folder: Path, *, pictures: bool) -> list[Path]:
    """Write the files of a study, and list them.

    Parameters
    ----------
    study : What was computed.
    folder : Where to.
    pictures : Whether to draw ``pareto.png``, where at least two settings can be compared, and
        ``values.png``, where each cell is a problem of its own; those of before are removed otherwise.
    """
    with Folder(folder, "study", title=study.title):
        table = write_records(folder / "study.csv", lines(study), end="\r\n")
        paths = [table, write(folder / "study.json", told(study))]
        picture = folder / "pareto.png"
        compared = any(_comparable(study.points(target)) for target in study.targets)
        if pictures and compared and can_draw(picture.name):
            from masonry_fem.analyses.study.plot import draw  # noqa: PLC0415 - matplotlib

            with phase(picture.name):
                paths.append(draw(study, picture))
        else:
            picture.unlink(missing_ok=True)
        curves = folder / "values.png"
        if pictures and drawable(study) and can_draw(curves.name):
            with phase(curves.name):
                paths.append(draw_values(study, curves))
        else:
            curves.unlink(missing_ok=True)
    return paths


def _comparable(points: Sequence[Point]) -> bool:
    """Whether there is a choice, and something is known of how far it is off."""
    return len(points) > 1 and any(math.isfinite(point.bound) for point in points)


def told(study: Study) -> StudyTold:
    """What ``study.json`` holds."""
    return StudyTold(
        title=study.title,
        outcome="interrupted" if study.interrupted else "finished",
        varied={one.key: [one.text(i) for i in range(len(one.values))] for one in study.vary},
        reference=study.reference.words,
        accuracy=study.accuracy,
        recommendations=tuple(study.recommendations),
        orders=tuple(orders(study)),
        pareto={target.label: _best(study.points(target)) for target in study.targets},
        notes=tuple(study.notes),
        cells=tuple(lines(study)),
    )


def _best(points: Sequence[Point]) -> tuple[Choice, ...]:
    """The settings that no others surpass, the cheapest first."""
    best = sorted((point for point in points if point.best), key=lambda point: point.cpu)
    return tuple(
        Choice(settings=point.settings, cpu=point.cpu, error=point.error, bound=point.bound) for point in best
    )


def orders(study: Study) -> Iterator[OrderTold]:
    """Observed orders of convergence of all cases."""
    for made in study.comparisons:
        case = case_of(study, made)
        for name, by_key in made.orders.items():
            size = max(made.values[name].size, made.values[name].scale)
            for key, order in by_key.items():
                left = order.error / size if size > 0 else 0.0
                yield OrderTold(
                    case=case, quantity=name, key=key, order=order.order, verdict=order.words, left=left
                )


def case_of(study: Study, made: Comparison) -> dict[str, str]:
    """Values of the keys that make a case."""
    keys = [one.key for one in study.vary if one.is_case]
    return {key: made.rows[0].cell.settings[key] for key in keys}


def lines(study: Study) -> Iterator[dict[str, Any]]:
    """One record a cell: settings, how it ended, costs, sizes, values and errors."""
    of = {id(row): (made, number) for made in study.comparisons for number, row in enumerate(made.rows)}
    for row in study.rows:
        made, number = of[id(row)]
        yield {
            **row.cell.settings,
            "outcome": row.outcome,
            "message": row.message,
            "warnings": "; ".join(row.warnings),
            "cpu": row.cpu,
            "start": row.start,
            **{f"seconds.{phase}": value for phase, value in row.seconds.items()},
            "peak_memory_mb": row.memory,
            **row.size,
            **{f"certificate.{name}": value for name, value in row.certificate.items()},
            **({"yielded": row.yielded} if row.yielded else {}),
            **dict(_values(row)),
            **{name: value for one in row.peaks for name, value in one.columns()},
            **{f"error.{name}": _number(value[number]) for name, value in made.error.items()},
            **{f"bound.{name}": _number(value[number]) for name, value in made.bound.items()},
        }


def _values(row: Row) -> Iterator[tuple[str, float]]:
    """Components of vectors, numbers, of long lists the norm."""
    for name, value in row.quantities.items():
        if len(value.values) == 1 and not value.axes:
            yield name, value.values[0]
        elif len(value.values) == len(value.axes):
            for axis, number in zip(value.axes, value.values, strict=True):
                yield f"{name}.{axis}", number
        else:
            yield name, value.size


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
