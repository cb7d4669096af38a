"""Kinematics of contact points: local frames, and heights above planes.

A frame's rows are (n, t1[, t2]), right-handed, n from the antagonist to the candidate.
"""

from __future__ import annotations

import numpy as np

from masonry_fem.solid.pose import FloatArray


def local_frames(normals: FloatArray) -> FloatArray:
    """Right-handed frames (n, t1[, t2]) on unit normals (c, d), shape (c, d, d).

    In 3D t1 is the projection of the world axis that is most across n, the first of them where
    several are (compared to six digits, so that rounding does not choose).
    """
    count, d = normals.shape
    frames = np.empty((count, d, d))
    frames[:, 0] = normals
    if d == 2:
        frames[:, 1, 0], frames[:, 1, 1] = -normals[:, 1], normals[:, 0]
        return frames
    axis = np.eye(3)[np.round(np.abs(normals), 6).argmin(axis=1)]
    across = axis - np.einsum("ci,ci->c", axis, normals)[:, None] * normals
    frames[:, 1] = across / np.linalg.norm(across, axis=1)[:, None]
    frames[:, 2] = np.cross(frames[:, 0], frames[:, 1])
    return frames


def height(points: FloatArray, normals: FloatArray, on_plane: FloatArray, plane: FloatArray) -> FloatArray:
    """How far points are from planes, measured along given directions [m].

    Parameters
    ----------
    points : Shape (..., d) [m].
    normals : Unit vectors to measure along, shape (..., d).
    on_plane : A point of each plane, shape (..., d) [m].
    plane : Normal of each plane, shape (..., d).

    Returns
    -------
    Shape (...,); positive where the plane lies ahead in the direction of ``normals``.
    """
    ahead = np.einsum("...a,...a->...", on_plane - points, plane)
    result: FloatArray = ahead / np.einsum("...a,...a->...", normals, plane)
    return result
