"""Pose: where a block stands, as a rigid motion of its shape."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
# rotations (b, d, d) and translations (b, d) [m] of b poses
Poses = tuple[FloatArray, FloatArray]


@dataclass(frozen=True, slots=True)
class Pose:
    """Rigid motion from a shape's own frame to the world: ``x = rotation @ X + translation``.

    Attributes
    ----------
    rotation : Proper orthogonal matrix, shape (d, d).
    translation : Position of the shape's origin [m], shape (d,).
    """

    rotation: FloatArray
    translation: FloatArray

    @classmethod
    def identity(cls, dimension: int) -> Pose:
        """The pose that leaves a shape where it was described."""
        return cls(np.eye(dimension), np.zeros(dimension))

    @classmethod
    def at(cls, *position: float) -> Pose:
        """A pure translation to ``position`` [m]."""
        return cls(np.eye(len(position)), np.array(position, dtype=float))

    def to_world(self, points: FloatArray) -> FloatArray:
        """World coordinates of shape points, shape (..., d) [m]."""
        return points @ self.rotation.T + self.translation

    def to_shape(self, points: FloatArray) -> FloatArray:
        """Shape coordinates of world points, shape (..., d) [m]."""
        return (points - self.translation) @ self.rotation
