"""Planes: the common planes of many patches, and their polygons there, as arrays."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from masonry_fem.contact.placement.parts.patch import Patch
from masonry_fem.host.compiled import compiled
from masonry_fem.solid.mesh import IntArray
from masonry_fem.solid.pose import FloatArray


@dataclass(frozen=True, slots=True)
class Planes:
    """The planes of k patches.

    Attributes
    ----------
    frame, origin : Of the patches, shapes (k, d, d) and (k, d) [m].
    polygon : Their corners in the planes, padded with the last, shape (k, n, d - 1) [m].
    count : How many of these are real, shape (k,).
    """

    frame: FloatArray
    origin: FloatArray
    polygon: FloatArray
    count: IntArray

    @classmethod
    def of(cls, patches: Sequence[Patch]) -> Planes:
        """Those of some patches."""
        d = len(patches[0].origin)
        count = np.array([len(patch.polygon) for patch in patches])
        corners = np.concatenate([patch.polygon for patch in patches])
        last = np.cumsum(count)[:, None]
        return cls(
            frame=np.concatenate([patch.frame for patch in patches]).reshape(-1, d, d),
            origin=np.concatenate([patch.origin for patch in patches]).reshape(-1, d),
            polygon=corners[np.minimum(last - count[:, None] + np.arange(count.max()), last - 1)],
            count=count,
        )

    def only(self, rows: IntArray) -> Planes:
        """Those of some of the patches."""
        return Planes(self.frame[rows], self.origin[rows], self.polygon[rows], self.count[rows])

    @property
    def size(self) -> FloatArray:
        """Largest extents of the polygons, shape (k,) [m]."""
        size: FloatArray = np.ptp(self.polygon, axis=1).max(axis=1)
        return size

    def flat(self, points: FloatArray, patch: IntArray) -> FloatArray:
        """Coordinates in the planes of patches, shape (m, ..., d - 1) [m].

        Parameters
        ----------
        points : World coordinates, shape (m, ..., d) [m].
        patch : In the plane of which patch, shape (m,).
        """
        stacked = points.reshape(len(patch), -1, points.shape[-1])
        found: FloatArray = _flat(stacked, patch, self.frame, self.origin)
        return found.reshape(*points.shape[:-1], -1)


@compiled
def _flat(points: FloatArray, patch: IntArray, frame: FloatArray, origin: FloatArray) -> FloatArray:
    """The compiled loop of ``Planes.flat`` over points of the shape (m, n, d)."""
    m, n, d = points.shape
    found = np.zeros((m, n, d - 1))
    for i in range(m):
        k = patch[i]
        for j in range(n):
            for p in range(d - 1):
                for axis in range(d):
                    found[i, j, p] += (points[i, j, axis] - origin[k, axis]) * frame[k, p + 1, axis]
    return found
