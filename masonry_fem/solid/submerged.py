"""Submerged: a factor that grows linearly with depth below a level, and where faces lie below it. NumPy only.

factor = Submerged(level=3.0, even=0.0, slope=9810.0)
factor(points)                                  # even + slope · depth, 0 above the level
below(depth)                                    # the parts of lines or triangles with depth ≥ 0
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Submerged:
    """What a load on a face is multiplied by at each point, by its depth below a level.

    Attributes
    ----------
    level : Along the last axis [m].
    even : The factor at the level. slope : By metre of depth [1/m].
    """

    level: float
    even: float
    slope: float

    def depth(self, points: FloatArray) -> FloatArray:
        """How far points (..., d) [m] lie below the level, negative above it, shape (...)."""
        found: FloatArray = self.level - points[..., -1]
        return found

    def __call__(self, points: FloatArray) -> FloatArray:
        """The factor at points (..., d) [m] that lie below the level, shape (...)."""
        return self.even + self.slope * self.depth(points)


def below(depth: FloatArray) -> FloatArray:
    """The parts of lines or triangles where a linear function is positive, as lines or triangles.

    Parameters
    ----------
    depth : The function at the corners of each, shape (t, 2) or (t, 3).

    Returns
    -------
    Corners of the parts as weights of those of the whole, shape (t, 1, 2, 2) or (t, 2, 3, 3). Parts without
    extent stand for what there is not.
    """
    order = np.argsort(depth, axis=1)
    own = np.take_along_axis(depth, order, axis=1)
    whole = np.eye(depth.shape[1])[order]  # corners from the highest to the lowest, (t, k, k)

    def crossed(high: int, low: int) -> FloatArray:
        rise = own[:, low] - own[:, high]
        share = np.clip(np.divide(-own[:, high], rise, out=np.zeros(len(own)), where=rise > 0), 0.0, 1.0)
        share = np.where(own[:, low] <= 0, 1.0, share)[:, None]
        point: FloatArray = (1 - share) * whole[:, high] + share * whole[:, low]
        return point

    if depth.shape[1] == 2:
        return np.stack([crossed(0, 1), whole[:, 1]], axis=1)[:, None]
    outer, wet = crossed(0, 2), (own[:, 1] > 0)[:, None]
    inner = np.where(wet, crossed(0, 1), crossed(1, 2))
    middle = np.where(wet, whole[:, 1], inner)
    low = whole[:, 2]
    return np.stack(
        [np.stack([outer, inner, middle], axis=1), np.stack([outer, middle, low], axis=1)], axis=1
    )
