"""Capacity: the intensities between which each record begins to pass a limit, and what they tell."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from masonry_fem.analyses.incremental.fragility import CONFIDENCE, Fragility, fragility
from masonry_fem.records.remark import counted, first_few
from masonry_fem.results.incremental import Capacity, FragilityTold, ShakenTold

FALLS = "falls"  # the limit that is always asked for
SWINGS = 0.1  # of the greatest way of a probe: where more is left at the end, nothing is said of what stays
FEW = 10  # records: of fewer the distribution's form is not seen


def capacities(runs: Sequence[ShakenTold], state: str, limit: float) -> list[Capacity]:
    """Of each record, those of which a run is decided.

    Parameters
    ----------
    runs : What came out. state : Name of the demand, or ``falls``. limit : Greatest demand.
    """
    tried: dict[str, list[tuple[float, bool]]] = {}
    for one in runs:
        if one.verdict != "undecided":
            passes = one.verdict == "falls" or (state != FALLS and one.demands[state] > limit)
            tried.setdefault(one.record, []).append((one.intensity, passes))
    return [_capacity(name, own) for name, own in tried.items()]


def _capacity(record: str, tried: Sequence[tuple[float, bool]]) -> Capacity:
    """Of intensities, and whether the limit is passed there."""
    first = min((at for at, passed in tried if passed), default=math.inf)
    below = [at for at, passed in tried if not passed and at < first]
    return Capacity(
        record=record,
        stands=max(below, default=0.0),
        passes=None if math.isinf(first) else first,
        again=sum(not passed for at, passed in tried if at > first),
    )


def fitted(found: Sequence[Capacity]) -> Fragility:
    """The distribution that follows."""
    passes = [math.inf if one.passes is None else one.passes for one in found]
    return fragility(np.array([one.stands for one in found]), np.array(passes))


def fragility_told(fit: Fragility, found: Sequence[Capacity], state: str, intensity: str) -> FragilityTold:
    """What the summary says of a limit.

    Parameters
    ----------
    fit : The distribution. found : What it is fitted to.
    state : The limit in words. intensity : How records are measured.
    """
    sample = f"{counted(fit.records, 'record')}, of which {fit.passed} pass it"
    said = f"{state}: not determined by {sample}"
    if fit.outcome == "never passed":
        said = f"{state}: never, under {counted(fit.records, 'record')}"
    elif fit.outcome == "step" and fit.median_range is not None:
        low, high = fit.median_range
        said = f"{state}: at {intensity} between {low:.4g} and {high:.4g} m/s² for all of {sample}"
    elif fit.median_range is not None and fit.dispersion_range is not None:
        said = (
            f"{state}: median {intensity} {fit.median:.4g} m/s² ({_between(fit.median_range)}), dispersion "
            f"{fit.dispersion:.3g} ({_between(fit.dispersion_range)}), {100 * CONFIDENCE:g} % ranges, of "
            f"{sample}"
        )
    return FragilityTold(
        state=state,
        outcome=fit.outcome,
        records=fit.records,
        passed=fit.passed,
        median=fit.median,
        dispersion=fit.dispersion,
        median_range=fit.median_range,
        dispersion_range=fit.dispersion_range,
        confidence=CONFIDENCE,
        capacities=tuple(found),
        words=f"{said}.",
    )


def _between(ends: tuple[float, float]) -> str:
    return f"{ends[0]:.3g} to " + ("any" if math.isinf(ends[1]) else f"{ends[1]:.3g}")


def notes(runs: Sequence[ShakenTold], told: Sequence[FragilityTold]) -> Iterator[str]:
    """What a reader should know.

    Parameters
    ----------
    runs : What came out. told : The fragilities that follow.
    """
    doubtful = [one for one in runs if one.verdict == "undecided"]
    if doubtful:
        named = first_few([f"{one.record} at {one.scale:.4g}" for one in doubtful], 3)
        yield (
            f"{counted(len(doubtful), 'run')} ended undecided and were left out ({named}); the last said: "
            f"{doubtful[-1].message}"
        )
    for one in told:
        yield from _not_once(one)
    if any(one.outcome == "fitted" and one.records < FEW for one in told):
        yield (
            f"ranges are those of large samples; of fewer than {FEW} records they are somewhat too narrow, "
            "and whether the distribution is lognormal cannot be seen"
        )
    moving = sum(one.verdict == "stands" and one.swing > SWINGS for one in runs)
    if moving:
        yield (
            f"in {counted(moving, 'run')} probes still move at the end by more than {100 * SWINGS:g} % of "
            "their peak: residuals are not final, and what moves may still fall; expected a longer "
            "analysis.duration"
        )


def _not_once(told: FragilityTold) -> Iterator[str]:
    """Records that pass a limit, and at a greater intensity do not."""
    back = [own for own in told.capacities if own.again]
    if back:
        named = first_few([own.record for own in back], 3)
        yield (
            f"{told.state}: {counted(sum(own.again for own in back), 'run')} of {named} stay below it at a "
            "greater intensity than the first that passes it; the first counts"
        )
