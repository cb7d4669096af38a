"""Motion: how each block of a step has moved as a whole: the rigid motion nearest to its displacements."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from masonry_fem.output import fields

FloatArray = NDArray[np.float64]

LINE = 1e-9  # of a block's size: points this near to a line have no turn about it


@dataclass(frozen=True, slots=True)
class Motion:
    """Rigid motions of n blocks.

    Attributes
    ----------
    centre : Mean of the nodes before, shape (n, 3) [m]. shift : Displacement of the mean, shape (n, 3) [m].
    turn : Rotation about it, shape (n, 3, 3).
    """

    centre: FloatArray
    shift: FloatArray
    turn: FloatArray

    @property
    def matrix(self) -> FloatArray:
        """Homogeneous matrices of the motions, shape (n, 4, 4)."""
        made = np.zeros((len(self.centre), 4, 4))
        made[:, :3, :3] = self.turn
        made[:, :3, 3] = self.centre + self.shift - np.einsum("nij,nj->ni", self.turn, self.centre)
        made[:, 3, 3] = 1.0
        return made

    @property
    def angle(self) -> FloatArray:
        """How far each turns, shape (n,) [rad]."""
        skew = 0.5 * (self.turn - self.turn.transpose(0, 2, 1))
        sine = np.sqrt(0.5) * np.linalg.norm(skew, axis=(1, 2))
        cosine = 0.5 * (np.trace(self.turn, axis1=1, axis2=2) - 1.0)
        return np.asarray(np.arctan2(sine, cosine), float)


def motion_of(blocks: Any, count: int) -> Motion:
    """The rigid motions that fit the displacements of the nodes best, by least squares.

    Parameters
    ----------
    blocks : Grid of a step. count : Number of blocks.

    References
    ----------
    Kabsch, A solution for the best rotation to relate two sets of vectors, Acta Cryst. A32, 1976.
    """
    own = np.asarray(blocks.point_data[fields.BLOCK])
    points = np.asarray(blocks.points, float)
    moved = np.asarray(blocks.point_data[fields.DISPLACEMENT], float)
    many = np.maximum(np.bincount(own, minlength=count), 1)[:, None]

    def mean(values: FloatArray) -> FloatArray:
        return np.stack([np.bincount(own, v, minlength=count) for v in values.T], axis=1) / many

    centre, shift = mean(points), mean(moved)
    before = points - centre[own]
    after = before + moved - shift[own]
    products = (after[:, :, None] * before[:, None, :]).reshape(-1, 9)
    covariance = (mean(products)).reshape(-1, 3, 3)
    u, size, vt = np.linalg.svd(covariance)
    sign = np.sign(np.linalg.det(u @ vt))
    u[:, :, 2] *= np.where(sign == 0, 1.0, sign)[:, None]
    turn = u @ vt
    turn[size[:, 1] <= LINE**2 * np.maximum(size[:, 0], 1e-300)] = np.eye(3)
    return Motion(centre, shift, turn)
