"""Coloured sweeps: colour after colour, the groups of a colour by any number of threads, same bits.

Groups of one colour share nothing (``colouring``), so it does not matter in which order they are visited,
or at once. What an error sums up it sums within groups, then over groups in their order. So results
depend on no number of threads.

    sweep = kernel("bodies_3d", parallel=True)
    made, error = sweep(groups, colours, sums, speed, relaxation, begun, count, interval, tolerance, data)

One source, compiled for each form and with threads or without: only what is ``parallel`` loads Numba's
threads. ``sweeps`` has the loops of plain NSGS, in a shuffled order.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from types import FunctionType
from typing import Any

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from masonry_fem.nscd.solvers import coloured_visits as visits
from masonry_fem.nscd.solvers.coloured_visits import judge_bodies_3d as judge  # each kernel has its own
from masonry_fem.nscd.solvers.coloured_visits import visit_bodies_3d as visit

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@njit(cache=True)
def combined_error(sums: FloatArray, speed: float) -> float:
    """``Quality.error`` without the bodies' balance, from the groups' judgements, shape (g, 5).

    ``speed`` is what it is measured by, the largest free velocity; 0: by what the impulses cause.
    """
    square = size = worst = caused = fastest = 0.0
    for g in range(len(sums)):
        square += sums[g, 0]
        size += sums[g, 1]
        worst = max(worst, sums[g, 2])
        caused = max(caused, sums[g, 3])
        fastest = max(fastest, sums[g, 4])
    caused = speed**2 if speed > 0.0 else caused
    if size == 0.0:
        return 0.0 if worst == 0.0 else math.sqrt(worst / fastest)
    if worst == 0.0:
        return 0.0
    return max(math.sqrt(square / size), math.sqrt(worst / caused) if caused > 0.0 else math.inf)


def _sweep(
    groups: IntArray, colours: IntArray, sums: FloatArray, speed: float, relaxation: float,
    begun: int, count: int, interval: int, tolerance: float, data: Any,
) -> tuple[int, float]:  # fmt: skip
    """At most ``count`` sweeps after ``begun`` earlier ones; how many, and the error they left."""
    error = math.inf
    for sweep in range(count):
        for colour in range(len(colours) - 1):
            for g in prange(colours[colour], colours[colour + 1]):
                visit(groups[g], groups[g + 1], begun + sweep, relaxation, data)
        if (sweep + 1) % interval and sweep + 1 < count:
            continue
        for g in prange(len(sums)):
            sums[g, 0], sums[g, 1], sums[g, 2], sums[g, 3], sums[g, 4] = judge(groups[g], groups[g + 1], data)
        error = combined_error(sums, speed)
        if error <= tolerance:
            return sweep + 1, error
    return count, error


@cache
def kernel(form: str, *, parallel: bool) -> Callable[..., tuple[int, float]]:
    """The compiled sweeps of a form: "bodies_2d", "bodies_3d", "plain_2d" or "plain_3d"."""
    own = {"visit": getattr(visits, f"visit_{form}"), "judge": getattr(visits, f"judge_{form}")}
    source = FunctionType(_sweep.__code__, globals() | own, _sweep.__name__)
    # Numba's cache on disk tells kernels apart by their names
    source.__qualname__ = f"{form}_{'parallel' if parallel else 'alone'}"
    source.__module__ = __name__
    compiled: Callable[..., tuple[int, float]] = njit(cache=True, parallel=parallel)(source)
    return compiled
