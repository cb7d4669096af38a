"""Ring: stones side by side around a vertical axis, their curved faces in flat pieces."""

from __future__ import annotations

import numpy as np

from masonry_fem.solid.assembly import Shape
from masonry_fem.solid.polytope import Polytope
from masonry_fem.solid.pose import FloatArray

MARGIN = 0.25  # of the thickness: how far supports stand out beside the stones


def about_axis(longitude: float) -> FloatArray:
    """Rotation about the vertical axis, shape (3, 3)."""
    c, s = np.cos(longitude), np.sin(longitude)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def ring_stone(
    name: str, points: FloatArray, pieces: int, names: tuple[str, ...], labels: tuple[str, ...]
) -> Shape:
    """Shape between two parallels and two radii, its curved faces in flat ``pieces``.

    ``points`` are the corners along the parallel, ``pieces`` + 1 each: below and above on the inner side,
    below and above on the outer. ``names`` and ``labels``: inner, outer, lower, upper, left, right.
    """
    n = pieces + 1
    low_in, high_in, low_out, high_out = (range(k * n, (k + 1) * n) for k in range(4))
    loops, which = [], []
    for i, j in zip(range(pieces), range(1, n), strict=True):
        loops += [
            (low_in[i], high_in[i], high_in[j], low_in[j]),
            (low_out[i], low_out[j], high_out[j], high_out[i]),
            (low_in[i], low_in[j], low_out[j], low_out[i]),
            (high_in[i], high_out[i], high_out[j], high_in[j]),
        ]
        which += [0, 1, 2, 3]
    loops += [
        (low_in[0], low_out[0], high_out[0], high_in[0]),
        (low_in[-1], high_in[-1], high_out[-1], low_out[-1]),
    ]
    which += [4, 5]
    solid = Polytope(points, tuple(loops), tuple(names[k] for k in which), tuple(labels[k] for k in which))
    if pieces == 1:
        return Shape(name, solid)
    rails = tuple(tuple(chain) for chain in (low_in, low_out, high_in, high_out))
    return Shape(name, solid, rails=rails, parts=pieces)
