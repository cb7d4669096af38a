"""Comparison: the errors of one case's cells against its reference, and bounds of these errors.

The finest cell has an error of its own. Along each key an order of convergence is observed at this cell,
and the error that follows from it (``order``) is added to every cell's distance from the reference. A cell
may also
be accurate by chance, if its error changes sign between two levels: so its bound covers the distances of
all
finer cells.
"""

from __future__ import annotations

import fnmatch
import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from masonry_fem.analyses.study.order import Order, observe
from masonry_fem.analyses.study.quantity import Quantities, Quantity, group_of, pick
from masonry_fem.analyses.study.reference import Reference, finest_of
from masonry_fem.analyses.study.row import Row
from masonry_fem.analyses.study.variation import Variation

SINGLE, LOST = "1 value", "the best not solved"  # what keeps an order from being seen


@dataclass(frozen=True, slots=True)
class Comparison:
    """Errors of the n rows of a case, relative, by quantity.

    Attributes
    ----------
    rows : The case's rows, solved or not.
    reference : The row compared with; None: numbers from outside, or none.
    values : What is compared with, by name.
    error : Distance from the reference, NaN where there is none, shape (n,) each.
    bound : What the true error is not expected to exceed, shape (n,) each.
    orders : By name and key, along the keys through the reference, or the finest row.
    rest : Estimated error of the reference itself, by name.
    left_out : Quantities that are too small to be compared.
    """

    rows: tuple[Row, ...]
    reference: Row | None
    values: Quantities
    error: dict[str, NDArray[np.float64]] = field(default_factory=dict)
    bound: dict[str, NDArray[np.float64]] = field(default_factory=dict)
    orders: dict[str, dict[str, Order]] = field(default_factory=dict)
    rest: dict[str, float] = field(default_factory=dict)
    left_out: tuple[str, ...] = ()

    def worst(self, names: Sequence[str], of: dict[str, NDArray[np.float64]]) -> NDArray[np.float64]:
        """Greatest value over some quantities, NaN where one lacks, shape (n,)."""
        worst = np.stack([of[name] for name in names]).max(axis=0)
        return np.asarray(worst, dtype=np.float64)


def compare(
    rows: Sequence[Row], vary: Sequence[Variation], reference: Reference, asked: Sequence[str] = ()
) -> Comparison:
    """Compare the rows of a case.

    Parameters
    ----------
    rows : The cells of the case with their results.
    vary : Keys and their values.
    reference : What to compare with.
    asked : Names, groups or patterns of quantities; empty for all.
    """
    anchor = reference.among(rows, vary)
    given = reference.given if anchor is None else anchor.quantities
    if not given:
        return Comparison(tuple(rows), anchor, {})
    # numbers from outside do not know how small the rest is: the cells do
    values, left_out = _compared(given, rows if anchor is None else (), asked)
    made = Comparison(tuple(rows), anchor, values, left_out=left_out)
    finer, finest = _finer(rows, vary), anchor or finest_of(rows, vary)
    for name, value in values.items():
        error = np.array([distance(pick(row.quantities, name), value) for row in rows])
        made.error[name] = error
        made.orders[name] = {} if finest is None else dict(_orders(name, finest, rows, vary))
        size = _size(value)
        left = 0.0 if anchor is None else sum(one.error for one in made.orders[name].values())
        rest = left / size if size > 0 else 0.0
        made.rest[name] = rest
        made.bound[name] = _bounds(error, finer) + rest
    return made


def distance(found: Quantity | None, value: Quantity) -> float:
    """Relative distance of a quantity from its reference; NaN if they cannot be compared.

    Parameters
    ----------
    found : The quantity of a cell; None if it has none.
    value : The same quantity of the reference.
    """
    size = _size(value)
    if found is None or len(found.values) != len(value.values) or size <= 0:
        return math.nan
    if found.axes and value.axes and found.axes != value.axes:
        return math.nan
    return math.dist(found.values, value.values) / size


def _size(value: Quantity) -> float:
    return max(value.size, value.scale)


def _compared(
    given: Quantities, rows: Sequence[Row], asked: Sequence[str]
) -> tuple[Quantities, tuple[str, ...]]:
    """What is compared of a reference, and what of it is too small."""
    chosen = dict(given)
    if asked:
        chosen = {}
        for pattern in asked:
            matching = {name: value for name, value in given.items() if matches(name, pattern)}
            chosen |= matching or _components(given, pattern)
    large = {
        name: value
        for name, value in chosen.items()
        if value.size > max(value.least, _least(rows, name)) or value.scale > 0.0
    }
    return large, tuple(name for name in chosen if name not in large)


def _components(given: Quantities, pattern: str) -> Quantities:
    """Components of vectors that a pattern means, as ``probes.*.z``."""
    found = {}
    for name, value in given.items():
        for axis in value.axes:
            one = value.component(axis)
            if one is not None and fnmatch.fnmatchcase(f"{name}.{axis}", pattern):
                found[f"{name}.{axis}"] = one
    return found


def _least(rows: Sequence[Row], name: str) -> float:
    """What half of the cells take for too small."""
    found = [one.least for row in rows if (one := pick(row.quantities, name)) is not None]
    return float(np.median(found)) if found else 0.0


def matches(name: str, pattern: str) -> bool:
    """Whether a pattern selects a quantity.

    Parameters
    ----------
    name : Of the quantity.
    pattern : Its name, its group, the first word of its name, or a shell-style pattern.
    """
    groups = (name, group_of(name), name.partition(".")[0])
    return pattern in groups or fnmatch.fnmatchcase(name, pattern)


def _finer(rows: Sequence[Row], vary: Sequence[Variation]) -> NDArray[np.bool_]:
    """Whether row j is row i or finer than it in graded keys alone, shape (n, n) at [i, j]."""
    places = np.array([row.cell.places for row in rows]).reshape(len(rows), len(vary))
    found: NDArray[np.bool_] = np.ones((len(rows), len(rows)), dtype=bool)
    for column, one in enumerate(vary):
        rank = np.array(one.ranks)[places[:, column]]
        found &= rank[None, :] >= rank[:, None] if one.is_graded else rank[None, :] == rank[:, None]
    return found


def _bounds(error: NDArray[np.float64], finer: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Greatest error of a row and those finer than it; NaN where it has none, shape (n,)."""
    known = np.where(np.isnan(error), -np.inf, error)
    bound = np.where(finer, known[None, :], -np.inf).max(axis=1, initial=-np.inf)
    return np.where(np.isnan(error), np.nan, bound)


def _orders(
    name: str, anchor: Row, rows: Sequence[Row], vary: Sequence[Variation]
) -> list[tuple[str, Order]]:
    """What is observed along each key through the reference."""
    made = []
    for column, one in enumerate(vary):
        if _lost(anchor, rows, vary, column):
            made.append((one.key, Order(None, False, math.inf, LOST)))
            continue
        if not (one.is_graded or _speaks(one, vary)):
            continue
        line = _line(name, anchor, rows, vary, column)
        told = _single(one, anchor, rows, column) if len(line) < 2 else _along(one, anchor, line)
        if told is not None:
            made.append((one.key, _beyond(told, anchor, name, rows, vary, column)))
    return made


def _along(one: Variation, anchor: Row, line: Sequence[tuple[int, Quantity]]) -> Order | None:
    """What two or more values of a key show, given by their places; None where widths are not known."""
    values = [np.array(value.values) for _, value in line]
    if one.setting.role != "width":
        # what the finer of two tolerances leaves is less than what the coarser one changes
        return Order(None, False, float(np.linalg.norm(values[-1] - values[-2])), "difference")
    widths = [width for place, _ in line if (width := one.widths[place]) is not None]
    if len(widths) < len(line):
        return None
    return observe(widths, values, degree=_degree(anchor), scale=_size(line[-1][1]))


def _single(one: Variation, anchor: Row, rows: Sequence[Row], column: int) -> Order | None:
    """What a single value shows: nothing, unless finer cells tell of a chosen reference."""
    if one.setting.role == "tolerance" or len(one.values) == 1:
        return None
    others = any(row is not anchor and _apart(row, anchor, column) for row in rows)
    return Order(None, False, 0.0 if others else math.inf, SINGLE)


def _lost(anchor: Row, rows: Sequence[Row], vary: Sequence[Variation], column: int) -> bool:
    """Whether better values of an ordered key (elastic beside rigid) were asked for and none was solved."""
    one = vary[column]
    if one.setting.role != "ordered" or one.is_case or (one.setting.of and not _speaks(one, vary)):
        return False
    best = one.ranks[anchor.cell.places[column]]
    better = [row for row in rows if one.ranks[row.cell.places[column]] > best]
    return bool(better) and not any(row.solved for row in better)


def _speaks(one: Variation, vary: Sequence[Variation]) -> bool:
    """Whether an ordered key has to tell of a discretisation, for no key with widths does."""
    of = one.setting.of
    return (
        one.setting.role == "ordered"
        and bool(of)
        and not any(other.setting.of == of and other.setting.role == "width" for other in vary)
    )


def _line(
    name: str, anchor: Row, rows: Sequence[Row], vary: Sequence[Variation], column: int
) -> list[tuple[int, Quantity]]:
    """Places and quantities of the rows that differ from the reference in one key, up to it, finest last."""
    one, found = vary[column], []
    for row in rows:
        value = pick(row.quantities, name)
        if (
            value is not None
            and _apart(row, anchor, column)
            and len(value.values) == len((pick(anchor.quantities, name) or value).values)
        ):
            found.append((row.cell.places[column], value))
    last = one.ranks[anchor.cell.places[column]]
    return sorted((pair for pair in found if one.ranks[pair[0]] <= last), key=lambda pair: one.ranks[pair[0]])


def _beyond(
    told: Order, anchor: Row, name: str, rows: Sequence[Row], vary: Sequence[Variation], column: int
) -> Order:
    """The same, where cells finer than a chosen reference show that more is left."""
    one, own = vary[column], pick(anchor.quantities, name)
    last, left = one.ranks[anchor.cell.places[column]], 0.0
    for row in rows:
        value = pick(row.quantities, name)
        if value is None or own is None or not _apart(row, anchor, column):
            continue
        if one.ranks[row.cell.places[column]] > last and len(value.values) == len(own.values):
            left = max(left, math.dist(value.values, own.values))
    return told if left <= told.error else Order(told.order, told.regular, left, told.words)


def _apart(row: Row, anchor: Row, column: int) -> bool:
    """Whether two rows differ in one key at most."""
    pairs = zip(row.cell.places, anchor.cell.places, strict=True)
    return row.solved and all(own == other or i == column for i, (own, other) in enumerate(pairs))


def _degree(row: Row) -> int:
    """Degree of the elements of a cell."""
    return 2 if '"Q2"' in (row.cell.scene or "") or '"P2"' in (row.cell.scene or "") else 1
