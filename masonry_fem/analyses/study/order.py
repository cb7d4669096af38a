"""Order: how fast a quantity converges along one key, and what error its finest value still has.

    seen = observe([0.2, 0.1, 0.05], [1.3, 1.1, 1.05])     # widths, values; the finest last
    seen.order, seen.error                                # 2.0 (error ~ width²), bound of |1.05 - limit|

With three levels that approach a limit the rest is Richardson's, times 1.5; with two, or where they do not,
three times what an order of one would leave: allowances as those of grid convergence studies (Roache's grid
convergence index). No order above one is counted on. At the edge of a joint stresses are singular as r^-½ or
nearly so, and what is left of energies and displacements falls as the width in the end, even if coarse meshes
seem to converge faster; so do impacts in the time step.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

SAFETY, ALLOWANCE = 1.5, 3.0
LEAST, MOST = 0.5, 2.5  # orders that elements of degree one and steps in time show where they converge
TRUSTED = 1.0  # no more is counted on
ROUNDING = 1e-9  # of a quantity: changes below say nothing of orders


@dataclass(frozen=True, slots=True)
class Order:
    """What a line of levels shows.

    Attributes
    ----------
    order : Exponent of the width that the last three levels show; None where they show none.
    regular : Whether it is one that can be relied on.
    error : Bound of the error of the finest level, in the unit of the values.
    words : The same for a table.
    """

    order: float | None
    regular: bool
    error: float
    words: str


def observe(
    widths: Sequence[float], values: Sequence[ArrayLike], *, degree: int = 1, scale: float | None = None
) -> Order:
    """Order and rest of a line.

    Parameters
    ----------
    widths : Of the levels, the finest last. values : Numbers or vectors of the levels.
    degree : Of the elements: orders up to twice of it are believed.
    scale : Size of the quantity; None: that of the last value.
    """
    levels = [np.atleast_1d(np.asarray(value, dtype=float)) for value in values]
    size = float(np.linalg.norm(levels[-1])) if scale is None else scale
    if len(levels) < 2:
        return Order(None, False, 0.0, "1 level")
    last = _step(levels[-2], levels[-1])
    ratio = widths[-2] / widths[-1]
    if len(levels) == 2:
        return Order(None, False, _allowance(last, ratio), "2 levels")
    before = _step(levels[-3], levels[-2])
    if max(last, before) <= ROUNDING * size:
        return Order(None, True, ALLOWANCE * max(last, before), "no change")
    order = _order(widths[-3:], before, last)
    towards = float(np.dot(levels[-2] - levels[-3], levels[-1] - levels[-2])) > 0
    ratios = (widths[-3] / widths[-2], ratio)
    if not towards or order is None or not LEAST <= order <= MOST * degree:
        # what the coarser difference would leave if it shrank with the width, should the last be an accident
        left = max(_allowance(last, ratio), _allowance(before / ratios[0], ratio))
        why = "oscillates" if not towards else "not asymptotic"
        return Order(order if towards else None, False, left, why)
    trusted = min(order, TRUSTED)
    shrunk = before / _gain(ratios[0], ratio, trusted)
    left = SAFETY * max(last, shrunk) / (ratio**trusted - 1)
    return Order(order, True, left, f"{order:.2f}")


def _allowance(change: float, ratio: float) -> float:
    return ALLOWANCE * change / min(ratio - 1.0, 1.0)


def _gain(coarse: float, fine: float, order: float) -> float:
    """Difference of the coarser two levels over that of the finer two, for an order."""
    return float((coarse**order - 1.0) / (1.0 - fine**-order))


def _order(widths: Sequence[float], before: float, last: float) -> float | None:
    """Order at which the differences of three levels are those; None: none up to 12."""
    coarse, fine = widths[0] / widths[1], widths[1] / widths[2]
    if last <= 0:
        return None

    def excess(order: float) -> float:
        return _gain(coarse, fine, order) - before / last

    low, high = 1e-3, 12.0
    if excess(low) > 0 or excess(high) < 0:
        return None
    while high - low > 1e-9:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if excess(middle) < 0 else (low, middle)
    return 0.5 * (low + high)


def _step(one: NDArray[np.float64], other: NDArray[np.float64]) -> float:
    found = float(np.linalg.norm(other - one))
    return found if math.isfinite(found) else math.inf
