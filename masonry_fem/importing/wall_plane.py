"""Wall plane: the plane in which the measured faces of a wall's stones lie.

    plane = WallPlane.fit(points, outward)
    flat = plane.flat(points)               # along the wall and up it, shape (n, 2)

Fitted to all corners by least squares whose weights fall with the distance, so that projecting stones and
mistakes do not tilt it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from masonry_fem.solid.pose import FloatArray, Pose

ROUNDS = 50
SETTLED = 1e-12  # change of the normal below which the iteration ends
SPREAD = 1.4826  # ratio of the standard deviation to the median absolute deviation, for Gaussian noise
SHARPEST = 1e-9  # of the wall's size: smallest noise that is assumed


@dataclass(frozen=True, slots=True)
class WallPlane:
    """A plane with axes: along the wall, up it, and out of it.

    Attributes
    ----------
    origin : Where the world's origin falls on the plane [m], shape (3,).
    along, up, outward : Unit vectors, right-handed, shape (3,); ``up`` is as near to z as can be.
    """

    origin: FloatArray
    along: FloatArray
    up: FloatArray
    outward: FloatArray

    @classmethod
    def fit(cls, points: FloatArray, outward: FloatArray) -> WallPlane:
        """The plane nearest to the points, its normal on the side of ``outward`` (any length)."""
        size = float(np.ptp(points, axis=0).max())
        weight = np.ones(len(points))
        normal = np.zeros(3)
        for _ in range(ROUNDS):
            centre = np.average(points, axis=0, weights=weight)
            arms = points - centre
            new = np.linalg.eigh((weight[:, None] * arms).T @ arms)[1][:, 0]
            new = new if new @ outward >= 0 else -new
            distance = arms @ new
            spread = max(SPREAD * float(np.median(np.abs(distance))), SHARPEST * size)
            weight = 1 / (1 + (distance / (2 * spread)) ** 2)
            settled = np.abs(new - normal).max() < SETTLED
            normal = new
            if settled:
                break
        upright = np.array([0.0, 0.0, 1.0]) if abs(normal[2]) < 0.9 else np.array([0.0, 1.0, 0.0])
        up = upright - (upright @ normal) * normal
        up /= np.linalg.norm(up)
        return cls((centre @ normal) * normal, np.cross(up, normal), up, normal)

    @property
    def pose(self) -> Pose:
        """From axes along the wall, into it and up it to the world."""
        return Pose(np.stack([self.along, -self.outward, self.up], axis=1), self.origin)

    def flat(self, points: FloatArray) -> FloatArray:
        """Places along the wall and up it [m], shape (n, 2)."""
        return np.asarray(points @ np.stack([self.along, self.up], axis=1))

    def height(self, points: FloatArray) -> FloatArray:
        """Distances from the plane, positive outside [m], shape (n,)."""
        return np.asarray((points - self.origin) @ self.outward)
