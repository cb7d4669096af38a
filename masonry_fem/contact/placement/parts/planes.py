"""Planes: the common planes of many patches, and their polygons there, as arrays."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from masonry_fem.contact.placement.parts.patch import Patch
from masonry_fem.host.compiled import compiled
from masonry_fem.solid.mesh import IntArray
from masonry_fem.solid.pose import FloatArray

ROUNDING = 1e-12  # of its size: patches that differ by less are congruent


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


def shapes(patches: Sequence[Patch]) -> list[tuple[object, ...]]:
    """What congruent patches have in common, to rounding: faces, and how they lie on each other."""
    if not patches:
        return []
    planes = Planes.of(patches)
    across, size = planes.frame[:, 1:], planes.size
    size = np.where(size > 0, size, 1.0)[:, None]
    numbers = [planes.polygon.reshape(len(patches), -1) / size]
    for side in (0, 1):
        poses = [patch.sides[side].pose for patch in patches]
        rotation = np.array([pose.rotation for pose in poses])
        away = np.array([pose.translation for pose in poses]) - planes.origin
        numbers.append((across @ rotation).reshape(len(patches), -1))
        numbers.append(np.einsum("kpd,kd->kp", across, away) / size)
    digits = np.rint(np.concatenate(numbers, axis=1) / ROUNDING) + 0.0  # no −0
    return [
        (
            *((id(side.surface), side.face) for side in patch.sides),
            patch.interface.label,
            patch.interface.area == 0,
            corners,
            row.tobytes(),
        )
        for patch, corners, row in zip(patches, planes.count.tolist(), digits, strict=True)
    ]
