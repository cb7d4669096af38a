"""Recommendation: the cheapest setting whose error is not expected to exceed the wanted accuracy.

The bound of a setting is its distance from the reference (or that of a finer setting, if larger) plus the
estimated error of the reference. If no bound is small enough, the recommendation says what is missing.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from masonry_fem.analyses.study.comparison import LOST, SINGLE, Comparison
from masonry_fem.analyses.study.pareto import INSTANT, Point, gather
from masonry_fem.analyses.study.target import Target
from masonry_fem.analyses.study.variation import Variation
from masonry_fem.results.study import Recommendation

TINY = 1e-8  # errors below are rounding
SAME = 0.05  # costs that differ by less are the same: the closer setting is taken


def recommend(
    target: Target,
    comparisons: Sequence[Comparison],
    vary: Sequence[Variation],
    accuracy: float,
    unseen: Sequence[str] = (),
) -> Recommendation:
    """Advice for a target.

    Parameters
    ----------
    target : Quantities.
    comparisons : One per case.
    vary : Keys and their values.
    accuracy : Wanted relative error.
    unseen : Discretisations that the study does not vary.
    """
    points = gather(comparisons, vary, target.names)
    if not points:
        return _none(target, accuracy, f"no setting was solved{_everywhere(vary)} so that it tells")
    singular = _singular(target, comparisons)
    if singular:
        return _none(target, accuracy, singular)
    good = [point for point in points if point.bound <= accuracy]
    if not good:
        return _none(target, accuracy, _what_lacks(target, points, comparisons))
    least = min(point.cpu for point in good)
    alike = [point for point in good if point.cpu <= least + max(SAME * least, INSTANT)]
    chosen = min(alike, key=lambda point: (point.bound, point.cpu))
    other = _compared_with(points)
    return Recommendation(
        target=target.label,
        accuracy=accuracy,
        settings=chosen.settings,
        error=chosen.error,
        bound=chosen.bound,
        cheaper=None if chosen is other else other.cpu / max(chosen.cpu, 1e-9),
        words=f"for {percent(accuracy)} on {target.words} use {settled(chosen.settings)}: "
        f"{_gain(chosen, other)}, {_off(chosen, unseen)}",
    )


def percent(value: float) -> str:
    """A share as people say it."""
    if not math.isfinite(value):
        return "–"
    if value < TINY:
        return f"< {100 * TINY:g} %" if value > 0 else "0 %"
    digits = 2 if value < 0.1 else 3
    return f"{100 * value:.{digits}g} %"


def settled(settings: dict[str, str]) -> str:
    """Settings in words."""
    return ", ".join(f"{key} = {value}" for key, value in settings.items()) or "the only setting"


def _everywhere(vary: Sequence[Variation]) -> str:
    return " in every case" if any(one.is_case for one in vary) else ""


def _besides(unseen: Sequence[str]) -> str:
    return f", and what {' and '.join(unseen)} may add, not varied here" if unseen else ""


def _off(point: Point, unseen: Sequence[str]) -> str:
    """How far a setting is off, as far as the study sees."""
    if point.is_reference and point.bound < TINY and unseen:
        return f"which is the reference; what {' and '.join(unseen)} leaves is not known, as it is not varied"
    return f"error {_told(point)}{_besides(unseen)}"


def _told(point: Point) -> str:
    if point.bound < TINY:
        return f"less than {100 * TINY:g} %"
    own = "" if point.is_reference else f"{percent(point.error)}, "
    return f"{own}at most {percent(point.bound)}"


def _compared_with(points: Sequence[Point]) -> Point:
    """The reference where it is a setting of the study, else the dearest."""
    own = [point for point in points if point.is_reference]
    return own[0] if own else max(points, key=lambda point: point.cpu)


def _gain(chosen: Point, other: Point) -> str:
    if chosen is other:
        return "nothing cheaper will do" if chosen.is_reference else "the dearest of all"
    times = other.cpu / max(chosen.cpu, 1e-9)
    what = "the reference" if other.is_reference else f"the dearest, {settled(other.settings)}"
    if times < 1.2:
        return f"as dear as {what} ({chosen.cpu:.2g} s of CPU)"
    with_start = (other.cpu + other.start) / max(chosen.cpu + chosen.start, 1e-9)
    whole = f"{_times(with_start)} times" if with_start >= 1.1 else "about the same"
    return (
        f"{_times(times)} times cheaper than {what} ({chosen.cpu:.2g} s against {other.cpu:.3g} s of CPU; "
        f"{whole} with the start of the program)"
    )


def _times(ratio: float) -> str:
    return f"{ratio:.0f}" if ratio >= 10 else f"{ratio:.2g}"


def _none(target: Target, accuracy: float, why: str) -> Recommendation:
    words = f"for {percent(accuracy)} on {target.words} nothing can be recommended: {why}"
    return Recommendation(
        target=target.label,
        accuracy=accuracy,
        settings=None,
        error=None,
        bound=None,
        cheaper=None,
        words=words,
    )


def _singular(target: Target, comparisons: Sequence[Comparison]) -> str:
    """Why a greatest stress is not to be relied on, or nothing."""
    if "stress.max" not in target.names or comparisons[0].reference is None:
        return ""
    for made in comparisons:
        seen = [one for one in made.orders["stress.max"].values() if one.words != "difference"]
        if not seen or not all(one.regular for one in seen):
            return (
                "the greatest stress at corners and edges grows with every finer mesh, and no limit of it is "
                "seen here; ask for stress.p95 or stress.means"
            )
    return ""


def _what_lacks(target: Target, points: Sequence[Point], comparisons: Sequence[Comparison]) -> str:
    """What keeps the best setting from being known to be good enough."""
    best = min(points, key=lambda point: (point.bound, point.error))
    if math.isfinite(best.bound):
        first = f"the best of this study, {settled(best.settings)}, is within {percent(best.bound)}"
    else:
        first = f"the error of {settled(best.settings)} is not known"
    if 1 <= best.bound < math.inf:
        first += ", which is no less than its own size"
    left = [
        (order.error / max(made.values[name].size, made.values[name].scale), key, order)
        for made in comparisons
        for name in target.names
        for key, order in made.orders[name].items()
    ]
    if not left:
        return f"{first}; add finer values"
    most, key, order = max(left, key=lambda one: one[0])
    cure = {
        SINGLE: f"of {key} one value was solved: solve another",
        LOST: f"the best value of {key} was not solved: see the message of its cell in study.csv",
        "2 levels": f"with a third value of {key} its order would be seen, and less allowed for",
        "difference": f"give a finer {key}",
        "oscillates": f"give a finer {key}: its values do not approach a limit steadily",
        "not asymptotic": f"give a finer {key}: its values do not approach a limit at a steady rate",
    }
    words = cure.get(order.words, f"give a finer {key}, whose order is {order.words}")
    if comparisons[0].reference is None or not math.isfinite(
        most
    ):  # the truth is given: what is left is no part of the bound
        return f"{first}; {words}"
    return f"{first}, of which {percent(most)} may come from {key}; {words}"
