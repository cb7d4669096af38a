"""Polygon moments: area, first and second moments of plane polygons, whole or cut by a line. NumPy only.

    area, first, second = polygon_moments(corners)                    # (i, k, 2), padded
    area, first, second = polygon_moments(corners, values)            # the part where values >= 0

``values`` are those of a linear function at the corners; its zero line does the cutting.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def polygon_moments(
    corners: FloatArray, values: FloatArray | None = None
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """∫ 1, ∫ y, ∫ y yᵀ over convex polygons, or over their parts where a linear function is positive.

    Parameters
    ----------
    corners : Counter-clockwise, padded by repeating one, shape (i, k, 2).
    values : Of the function at them, shape (i, k); None: the whole polygon.

    Returns
    -------
    area, first, second : Shapes (i,), (i, 2), (i, 2, 2).
    """
    start, end = corners, np.roll(corners, -1, axis=1)
    hub = corners[:, 0]
    if values is not None:
        start, end, cut, crossing = _clipped(start, end, values)
        # seen from a point of the cutting line the side that lies on it adds nothing
        any_cut = crossing.any(axis=1)
        first_cut = cut[np.arange(len(cut)), crossing.argmax(axis=1)]
        hub = np.where(any_cut[:, None], first_cut, hub)
    a, b = start - hub[:, None], end - hub[:, None]
    twice = a[:, :, 0] * b[:, :, 1] - a[:, :, 1] * b[:, :, 0]
    if values is not None:
        inside = (values >= 0) | (np.roll(values, -1, axis=1) >= 0)
        twice = np.where(inside, twice, 0.0)
    total = a + b
    area = 0.5 * twice.sum(axis=1)
    first = np.einsum("ik,ika->ia", twice, total) / 6
    second = np.einsum("ik,ika,ikb->iab", twice, a, a) + np.einsum("ik,ika,ikb->iab", twice, b, b)
    second = (second + np.einsum("ik,ika,ikb->iab", twice, total, total)) / 24
    # back from the hub to the origin
    shift = first[:, :, None] * hub[:, None, :]
    second += shift + shift.transpose(0, 2, 1) + area[:, None, None] * hub[:, :, None] * hub[:, None, :]
    return area, first + area[:, None] * hub, second


def _clipped(
    start: FloatArray, end: FloatArray, values: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, NDArray[np.bool_]]:
    """Edges shortened to where the function is positive; where they are cut, and which."""
    there = np.roll(values, -1, axis=1)
    crossing = (values >= 0) != (there >= 0)
    drop = np.where(crossing, values - there, 1.0)
    cut = start + np.where(crossing, values / drop, 0.0)[:, :, None] * (end - start)
    new_start = np.where((crossing & (values < 0))[:, :, None], cut, start)
    new_end = np.where((crossing & (there < 0))[:, :, None], cut, end)
    return new_start, new_end, cut, crossing
