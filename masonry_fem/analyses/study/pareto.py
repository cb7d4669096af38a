"""Pareto: cost and error bound of each setting, and the settings that no other surpasses in both.

points = gather(comparisons, vary, names)
[point for point in points if point.best]
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from masonry_fem.analyses.study.comparison import Comparison
from masonry_fem.analyses.study.row import Row
from masonry_fem.analyses.study.variation import Variation

SAME = 0.02  # costs and bounds that differ by less are the same, relative ...
INSTANT = 0.01  # ... and costs absolute [s]


@dataclass(frozen=True, slots=True)
class Point:
    """A setting in all cases.

    Attributes
    ----------
    places : Place of the value of each variation; −1 for keys that make cases.
    settings : Values as written.
    cpu, start : CPU time of its cells and of loading what they need, all cases together [s].
    error, bound : Greatest over the cases. rest : What the reference may be off itself.
    is_reference : Whether it is what the others are compared with.
    best : Whether no other is cheaper and has as low a bound, or as cheap and has a lower one.
    """

    places: tuple[int, ...]
    settings: dict[str, str]
    cpu: float
    start: float
    error: float
    bound: float
    rest: float
    is_reference: bool
    best: bool = False


def gather(comparisons: Sequence[Comparison], vary: Sequence[Variation], names: Sequence[str]) -> list[Point]:
    """One point per setting that was solved in every case and has all of the quantities.

    Parameters
    ----------
    comparisons : One per case.
    vary : Keys and their values.
    names : Quantities.
    """
    found: dict[tuple[int, ...], list[tuple[Comparison, int]]] = {}
    for made in comparisons:
        for number, row in enumerate(made.rows):
            found.setdefault(setting_places(vary, row), []).append((made, number))
    points: dict[tuple[str, ...], Point] = {}  # settings that make no difference are one point
    for places, members in found.items():
        rows = [made.rows[number] for made, number in members]
        point = _point(places, members, vary, names)
        if math.isfinite(point.error) and all(row.solved for row in rows):
            points.setdefault(tuple(row.cell.key for row in rows), point)
    best = _best(list(points.values()))
    return [replace(point, best=bool(one)) for point, one in zip(points.values(), best, strict=True)]


def _point(
    places: tuple[int, ...],
    members: Sequence[tuple[Comparison, int]],
    vary: Sequence[Variation],
    names: Sequence[str],
) -> Point:
    """A setting's cells, one a case, as one point; its error is NaN where a quantity lacks."""
    rows = [made.rows[number] for made, number in members]
    return Point(
        places=places,
        settings={one.key: rows[0].cell.settings[one.key] for one in vary if not one.is_case},
        cpu=sum(row.cpu for row in rows),
        start=sum(row.start for row in rows),
        error=_worst([(made.error, number) for made, number in members], names),
        bound=_worst([(made.bound, number) for made, number in members], names),
        rest=max((made.rest.get(name, math.nan) for made, _ in members for name in names), default=0.0),
        is_reference=all(made.reference is made.rows[number] for made, number in members),
    )


def setting_places(vary: Sequence[Variation], row: Row) -> tuple[int, ...]:
    """Place of the row's value of each varied key; −1 for keys that make cases.

    Parameters
    ----------
    vary : Keys and their values.
    row : A cell with its results.
    """
    return tuple(-1 if one.is_case else place for one, place in zip(vary, row.cell.places, strict=True))


def _worst(members: list[tuple[dict[str, NDArray[np.float64]], int]], names: Sequence[str]) -> float:
    """Greatest of some quantities over the cases; NaN where one lacks."""
    return float(
        np.max([of[name][number] if name in of else math.nan for of, number in members for name in names])
    )


def _best(points: Sequence[Point]) -> NDArray[np.bool_]:
    """Whether no other point is as good in cost and bound and better in one.

    Of equal ones the reference is taken, or the first.
    """
    cpu, bound = (np.array([getattr(point, name) for point in points]) for name in ("cpu", "bound"))
    spare = np.maximum(SAME * cpu, INSTANT)
    # at [i, j]: whether i is cheaper than j, or has a lower bound, by more than means nothing
    cheaper = cpu[:, None] < cpu - spare
    closer = bound[:, None] < bound * (1 - SAME)
    worse = (cpu[:, None] > cpu + spare) | (bound[:, None] > bound * (1 + SAME))
    turn = np.array([-1 if point.is_reference else i for i, point in enumerate(points)])
    first = turn[:, None] < turn
    beats = ~worse & (cheaper | closer | first)
    np.fill_diagonal(beats, val=False)
    best: NDArray[np.bool_] = ~beats.any(axis=0)
    return best
