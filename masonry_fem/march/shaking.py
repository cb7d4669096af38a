"""Shaking: how the ground moves in an earthquake, as functions of time.

    record = GroundMotion(times, accelerations)
    ground = Shaking((Component(axis=0, record=record, moves=True),), dimension=2)
    ground.acceleration(1.25), ground.shift(1.25)

An accelerogram is linear between its samples and zero outside them; velocity and displacement are its exact
integrals, from rest. Either supports move (``moves``), or the mass feels −a(t) and displacements are relative
to the ground, which stays.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class GroundMotion:
    """Acceleration in one direction.

    Attributes
    ----------
    times : Increasing instants, shape (n,) [s]. values : Accelerations there, shape (n,) [m/s²].
    """

    times: FloatArray
    values: FloatArray

    @cached_property
    def velocities(self) -> FloatArray:
        """At the instants, shape (n,) [m/s]."""
        steps = np.diff(self.times)
        return np.append(0.0, np.cumsum(0.5 * steps * (self.values[1:] + self.values[:-1])))

    @cached_property
    def displacements(self) -> FloatArray:
        """At the instants, shape (n,) [m]."""
        steps = np.diff(self.times)
        ways = steps * self.velocities[:-1] + steps**2 * (2 * self.values[:-1] + self.values[1:]) / 6
        return np.append(0.0, np.cumsum(ways))

    @cached_property
    def slopes(self) -> FloatArray:
        """Of the acceleration after each instant, shape (n,) [m/s³]."""
        return np.append(np.diff(self.values) / np.diff(self.times), 0.0)

    def acceleration(self, time: float) -> float:
        """At an instant [m/s²]."""
        return float(np.interp(time, self.times, self.values, left=0.0, right=0.0))

    def displacement(self, time: float | FloatArray) -> FloatArray:
        """At instants of any shape [m]; after the end with the velocity of the end."""
        last = len(self.times) - 1
        place = np.clip(np.searchsorted(self.times, time, side="right") - 1, 0, last)
        since = np.maximum(time - self.times[place], 0.0)
        way = self.displacements[place] + self.velocities[place] * since
        within = since**2 * (self.values[place] / 2 + self.slopes[place] * since / 6)
        found: FloatArray = way + np.where(place < last, within, 0.0)
        return found


def corrected(record: GroundMotion, degree: int) -> GroundMotion:
    """The record less a polynomial in time with which its velocity stays nearest to zero (least squares).

    Parameters
    ----------
    record : As it was measured.
    degree : Of the polynomial that is taken from the acceleration.

    References
    ----------
    Boore, Effect of baseline corrections on displacements and response spectra, Bull. Seism. Soc. Am. 91
    (2001).
    """
    since = (record.times - record.times[0]) / (record.times[-1] - record.times[0])
    powers = since[:, None] ** np.arange(degree + 1)
    steps = np.diff(record.times)[:, None]
    grown = np.cumsum(0.5 * steps * (powers[1:] + powers[:-1]), axis=0)
    share = np.linalg.lstsq(grown, record.velocities[1:])[0]
    return GroundMotion(record.times, record.values - powers @ share)


@dataclass(frozen=True, slots=True)
class Component:
    """An accelerogram along an axis.

    Attributes
    ----------
    axis : Number of the axis. record : The accelerogram.
    moves : Whether supports move; else the mass feels it.
    """

    axis: int
    record: GroundMotion
    moves: bool


@dataclass(frozen=True, slots=True)
class Shaking:
    """All that shakes the ground.

    Attributes
    ----------
    components : Accelerograms and their axes. dimension : Of space, d.
    """

    components: tuple[Component, ...]
    dimension: int

    @property
    def moves(self) -> bool:
        """Whether supports move."""
        return any(one.moves for one in self.components)

    def acceleration(self, time: float) -> FloatArray:
        """Of the ground, shape (d,) [m/s²]."""
        total = np.zeros(self.dimension)
        for one in self.components:
            total[one.axis] += one.record.acceleration(time)
        return total

    def shift(self, time: float | FloatArray) -> FloatArray:
        """How far supports have gone at instants (...), shape (..., d) [m]."""
        return self._way(time, moves=True)

    def unseen(self, time: float | FloatArray) -> FloatArray:
        """How far the ground would have gone beyond that at instants (...), shape (..., d) [m]."""
        return self._way(time, moves=False)

    def _way(self, time: float | FloatArray, *, moves: bool) -> FloatArray:
        total = np.zeros((*np.shape(time), self.dimension))
        for one in self.components:
            if one.moves == moves:
                total[..., one.axis] += one.record.displacement(time)
        return total
