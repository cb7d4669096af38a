"""Fragility: the probability that a limit is passed, by intensity, as a lognormal distribution.

    fit = fragility(stands, passes)          # of each record: greatest intensity below, least above
    fit.outcome, fit.median, fit.dispersion, fit.median_range
    fit.probability(intensities), fit.band(intensities)

Of a record only an interval is known in which it begins to pass the limit. The likelihood of all intervals
is greatest for the fit. With s = 1/β and m = ln θ/β its logarithm is concave: the parameters that it leaves
likely are a convex region, along whose rim all ranges are found.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize
from scipy.special import log_ndtr, ndtr
from scipy.stats import chi2

FloatArray = NDArray[np.float64]
Outcome = Literal["fitted", "step", "never passed", "not determined"]

CONFIDENCE = 0.95
RAYS = 720  # directions in which the rim of the region is looked for
HALVINGS = 60
STEEPEST, FLATTEST = 1e7, 1e-3  # slopes s: beyond them there is no maximum
FAR = 1e8  # in standard deviations: the region has no rim there


@dataclass(frozen=True)
class Fragility:
    """A lognormal distribution of the intensity at which a limit is passed.

    Attributes
    ----------
    outcome : ``fitted``; ``step`` where one intensity parts all records that stand from all that pass the
        limit, so that no spread is seen; ``never passed``; ``not determined`` where likelihood has no
        maximum.
    records : How many there are. passed : How many of them pass the limit somewhere.
    median, dispersion : θ, in the unit of the intensities, and standard deviation β of its logarithm; of a
        step the geometric middle of its range and zero; None: not known.
    median_range, dispersion_range : Those that the likelihood ratio does not reject; of a step the
        intensities between which it lies. Ends may be infinite. None: not known.
    rim : Pairs (s, m) on the rim of the region of likely parameters, shape (k, 2).
    """

    outcome: Outcome
    records: int
    passed: int
    median: float | None = None
    dispersion: float | None = None
    median_range: tuple[float, float] | None = None
    dispersion_range: tuple[float, float] | None = None
    rim: FloatArray | None = None

    def probability(self, intensities: FloatArray) -> FloatArray:
        """Probability that the limit is passed at intensities > 0, shape (n,); NaN where none is fitted."""
        if self.median is None or self.dispersion is None:
            return np.full(len(intensities), np.nan)
        if self.outcome == "step":
            return np.where(intensities >= self.median, 1.0, 0.0)
        found: FloatArray = ndtr(np.log(intensities / self.median) / self.dispersion)
        return found

    def band(self, intensities: FloatArray) -> FloatArray:
        """Least and greatest likely probabilities there, shape (2, n); NaN where nothing is fitted."""
        if self.rim is None:
            return np.full((2, len(intensities)), np.nan)
        all_of_them = np.outer(self.rim[:, 0], np.log(intensities)) - self.rim[:, 1:]
        return np.array([ndtr(all_of_them.min(axis=0)), ndtr(all_of_them.max(axis=0))])


def fragility(stands: FloatArray, passes: FloatArray) -> Fragility:
    """Fit the distribution by maximum likelihood.

    Parameters
    ----------
    stands : Of each record the greatest intensity below that at which it passes the limit, shape (n,); 0:
        it does at the least that was tried.
    passes : The least one at which it does, shape (n,); infinite: at none.

    References
    ----------
    Baker, Efficient analytical fragility function fitting using dynamic structural analysis, Earthquake
    Spectra 31 (2015); intervals in place of levels as in Turnbull, J. R. Stat. Soc. B 38 (1976).
    """
    with np.errstate(divide="ignore"):
        low, high = np.log(stands), np.log(passes)
    records, passed = len(low), int(np.isfinite(high).sum())
    if not passed:
        return Fragility("never passed", records, 0)
    if low.max() <= high.min():
        between = (float(stands.max()), float(passes.min()))
        middle = math.sqrt(math.prod(between)) or None  # of what falls at the least intensity none is known
        return Fragility("step", records, passed, middle, 0.0, between)
    # zero in the middle and of unit spread, so that start and limits have a meaning
    ends = np.concatenate([low[np.isfinite(low)], high[np.isfinite(high)]])
    middle, width = float(ends.mean()), float(ends.std())
    low, high = (low - middle) / width, (high - middle) / width

    def unlikely(at: FloatArray) -> float:
        return -float(_likelihood(at[None], low, high)[0])

    found = minimize(unlikely, [1.0, 0.0], method="Nelder-Mead", options={"xatol": 1e-10, "fatol": 1e-12})
    best = found.x
    if not FLATTEST < best[0] < STEEPEST:
        return Fragility("not determined", records, passed)
    rim = _rim(best, -float(found.fun), low, high)
    slopes = rim[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        logs, spreads = rim[:, 1] / slopes, width / slopes
    if slopes.min() > 0:
        medians = (_exp(middle + width * logs.min()), _exp(middle + width * logs.max()))
        dispersions = (float(spreads.min()), float(spreads.max()))
    else:  # no spread is too large, and so no median
        medians, dispersions = (0.0, math.inf), (float(width / slopes.max()), math.inf)
    return Fragility(
        "fitted", records, passed, _exp(middle + width * best[1] / best[0]), float(width / best[0]),
        medians, dispersions, np.column_stack([slopes / width, rim[:, 1] + slopes * middle / width]),
    )  # fmt: skip


def _likelihood(at: FloatArray, low: FloatArray, high: FloatArray) -> FloatArray:
    """Logarithm of the likelihood of each pair (s, m), shape (k,); −∞ where s ≤ 0.

    Parameters
    ----------
    at : Pairs, shape (k, 2). low, high : Logarithms of the intervals' ends, shape (n,).
    """
    slope, shift = at[:, :1], at[:, 1:]
    valid = slope[:, 0] > 0
    slope = np.where(slope > 0, slope, 1.0)
    lower, upper = slope * low - shift, slope * high - shift
    with np.errstate(invalid="ignore"):
        turned = lower + upper > 0  # in the other tail, where small numbers stay apart
    lower, upper = np.where(turned, -upper, lower), np.where(turned, -lower, upper)
    with np.errstate(invalid="ignore", divide="ignore"):
        most, least = log_ndtr(upper), log_ndtr(lower)
        share = np.where(np.isneginf(least), 0.0, np.exp(least - most))
        total: FloatArray = (most + np.log1p(-share)).sum(axis=1)
    return np.where(valid, total, -np.inf)


def _rim(best: FloatArray, most: float, low: FloatArray, high: FloatArray) -> FloatArray:
    """Where the likelihood has fallen by half of χ², along rays from the best pair, shape (RAYS, 2).

    Parameters
    ----------
    best : The pair (s, m) of the greatest likelihood. most : Its logarithm.
    low, high : Logarithms of the intervals' ends, shape (n,).
    """
    step = 1e-4 * np.array([best[0], max(1.0, abs(best[1]))])
    grid = np.array([[1, 0], [-1, 0], [0, 1], [0, -1], [1, 1], [-1, -1]]) * step
    east, west, north, south, both, none = _likelihood(best + grid, low, high) - most
    mixed = (both + none - east - west - north - south) / 2
    curves = -np.array([[east + west, mixed], [mixed, north + south]]) / np.outer(step, step)
    sizes, ways = np.linalg.eigh(curves)
    scale = ways / np.sqrt(np.maximum(sizes, 1e-12 * sizes.max()))
    turn = np.linspace(0.0, 2 * np.pi, RAYS, endpoint=False)
    rays = np.column_stack([np.cos(turn), np.sin(turn)]) @ scale.T
    bar = most - 0.5 * float(chi2.ppf(CONFIDENCE, 1))
    inside, outside = np.zeros(RAYS), np.ones(RAYS)
    while True:
        within = _likelihood(best + outside[:, None] * rays, low, high) >= bar
        if not (within & (outside < FAR)).any():
            break
        inside = np.where(within, outside, inside)
        outside = np.where(within & (outside < FAR), 2 * outside, outside)
    for _ in range(HALVINGS):
        half = (inside + outside) / 2
        within = _likelihood(best + half[:, None] * rays, low, high) >= bar
        inside, outside = np.where(within, half, inside), np.where(within, outside, half)
    return best + outside[:, None] * rays


def _exp(value: float) -> float:
    return math.exp(value) if value < 700 else math.inf
