"""Response spectra: the greatest way of linear oscillators on a ground that moves, by period.

    spectrum = of_accelerations(times, values, periods(), damping=0.05)
    spectrum.displacements, spectrum.accelerations        # [m], [m/s²], greatest, by period

Accelerations are linear between samples, or displacements are, as between the steps of a march, in which
impacts make velocities jump. Oscillators follow either exactly, by a recurrence between samples, from rest.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm
from scipy.signal import lfilter

FloatArray = NDArray[np.float64]

FINE = 40  # samples in a period at least; the peak between them is that of a cubic
COARSE = 10  # steps of a motion in a period at least: of what is faster it tells nothing
MOST = 1_000_000  # samples of a motion whose steps differ, at equal steps


@dataclass(frozen=True, slots=True)
class Spectrum:
    """Greatest response by period.

    Attributes
    ----------
    periods : Of the oscillators without damping, shape (n,) [s]. damping : Their damping ratio.
    displacements : Greatest relative to the ground, shape (n,) [m]; NaN where the motion does not tell.
    """

    periods: FloatArray
    damping: float
    displacements: FloatArray

    @property
    def accelerations(self) -> FloatArray:
        """Greatest pseudo-accelerations, ω² times the displacements, shape (n,) [m/s²]."""
        return (2 * np.pi / self.periods) ** 2 * self.displacements


def periods() -> FloatArray:
    """From 0.02 to 10 s, 36 in each factor of ten, shape (98,) [s]."""
    return np.geomspace(0.02, 10.0, 98)


def of_accelerations(times: FloatArray, values: FloatArray, periods: FloatArray, damping: float) -> Spectrum:
    """The spectrum of a ground's acceleration, which is zero after its end, where oscillators go on.

    Parameters
    ----------
    times, values : Instants, shape (n,) [s], and accelerations there, shape (n,) [m/s²].
    periods : Of the oscillators, shape (m,) [s]. damping : Their damping ratio.

    References
    ----------
    Nigam and Jennings, Calculation of response spectra from strong-motion earthquake records, Bull. Seism.
    Soc. Am. 59 (1969).
    """
    times, values = _evenly(times, values)
    step = times[1] - times[0]
    found = np.empty(len(periods))
    for k, period in enumerate(periods):
        parts = int(np.ceil(FINE * step / period))
        h, turn = step / parts, 2 * np.pi / period
        fine = np.interp(np.arange((len(values) - 1) * parts + 1) / parts, np.arange(len(values)), values)
        moves = np.zeros((4, 4))  # of way, velocity, acceleration of the ground and its rate
        moves[0, 1] = moves[2, 3] = 1.0
        moves[1, :3] = -(turn**2), -2 * damping * turn, -1.0
        over = expm(moves * h)
        rate = np.diff(fine) / h
        forced = np.outer(over[:2, 2], fine[:-1]) + np.outer(over[:2, 3], rate)
        state = _states(over[:2, :2], forced)
        # the ground stays at rest, or goes on evenly: a period later all later peaks are smaller
        free = _states(over[:2, :2], np.zeros((2, int(np.ceil(period / h)))), state[:, -1])
        found[k] = max(_greatest(state, state, h), _greatest(free, free, h))
    return Spectrum(periods, damping, found)


def of_displacements(times: FloatArray, ways: FloatArray, periods: FloatArray, damping: float) -> Spectrum:
    """The spectrum of a motion as long as it is known, which has velocities that jump from step to step.

    Parameters
    ----------
    times, ways : Instants, shape (n,) [s], and displacements in space there, shape (n,) [m].
    periods : Of the oscillators, shape (m,) [s]. damping : Their damping ratio.
    """
    found = np.full(len(periods), np.nan)
    if len(times) < 2:
        return Spectrum(periods, damping, found)
    times, ways = _evenly(times, ways)
    step = times[1] - times[0]
    for k in np.flatnonzero(periods >= COARSE * step * (1 - 1e-9)):
        period = periods[k]
        parts = int(np.ceil(FINE * step / period))
        h, turn = step / parts, 2 * np.pi / period
        jumps = np.zeros((len(times) - 1) * parts)
        jumps[::parts] = -np.diff(np.diff(ways) / step, prepend=0.0)
        over = expm(h * np.array([[0.0, 1.0], [-(turn**2), -2 * damping * turn]]))
        state = _states(over, np.outer(over[:, 1], jumps))
        after = state.copy()
        after[1, :-1] += jumps
        found[k] = _greatest(after, state, h)
    return Spectrum(periods, damping, found)


def _evenly(times: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """At equal steps: as they are, or where they differ, by the least of them."""
    steps, span = np.diff(times), times[-1] - times[0]
    number = len(steps)
    if np.ptp(steps) > 1e-6 * steps.mean():
        number = int(min(np.ceil(span / steps.min() - 1e-6), MOST))
    even = times[0] + span * np.arange(number + 1) / number
    return even, values if number == len(steps) else np.interp(even, times, values)


def _states(over: FloatArray, forced: FloatArray, first: FloatArray | None = None) -> FloatArray:
    """Ways and velocities s with s(k+1) = A s(k) + f(k), shape (2, n + 1).

    By the theorem of Cayley and Hamilton s(k+2) = tr A s(k+1) − det A s(k) + f(k+1) + (A − tr A I) f(k), a
    filter of each component.

    Parameters
    ----------
    over : A, shape (2, 2). forced : f, shape (2, n). first : s(0), shape (2,); None: at rest.
    """
    trace = float(np.trace(over))
    forced = forced.copy()
    if first is not None:
        forced[:, 0] += over @ first
    fed = forced.copy()
    fed[:, 1:] += (over - trace * np.eye(2)) @ forced[:, :-1]
    found = lfilter([1.0], [1.0, -trace, float(np.linalg.det(over))], fed)
    return np.column_stack([np.zeros(2) if first is None else first, found])


def _greatest(after: FloatArray, before: FloatArray, step: float) -> float:
    """Greatest way, also between samples: there the cubic of ways and velocities at both ends.

    Parameters
    ----------
    after, before : Ways and velocities just after and before each sample, shape (2, n).
    step : Between samples [s].
    """
    turns = np.flatnonzero(after[1, :-1] * before[1, 1:] < 0)
    way, end = after[0, turns], before[0, turns + 1]
    leaves, arrives = step * after[1, turns], step * before[1, turns + 1]
    square, cube = 3 * (end - way) - 2 * leaves - arrives, 2 * (way - end) + leaves + arrives
    # the one root of its derivative between both, without cancellation
    half = -(square + np.copysign(np.sqrt(np.maximum(square**2 - 3 * cube * leaves, 0)), square))
    with np.errstate(divide="ignore", invalid="ignore"):
        roots = np.stack([half / (3 * cube), leaves / half])
    place = np.where((roots >= 0) & (roots <= 1), roots, 0.0)
    between = way + place * (leaves + place * (square + place * cube))
    return float(max(np.abs(before[0]).max(), np.abs(between).max(initial=0.0)))
