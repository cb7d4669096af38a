"""Ring: stones side by side around a vertical axis, with curved faces divided into flat pieces."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from masonry_fem.solid.assembly import Shape
from masonry_fem.solid.polytope import Polytope
from masonry_fem.solid.pose import FloatArray

MARGIN = 0.25  # of the thickness: how far supports extend beyond the stones


def about_axis(longitude: ArrayLike) -> FloatArray:
    """Rotations about the vertical axis by angles of any shape [rad], shape (..., 3, 3)."""
    turn = np.zeros((*np.shape(longitude), 3, 3))
    turn[..., 0, 0] = turn[..., 1, 1] = np.cos(longitude)
    turn[..., 1, 0] = np.sin(longitude)
    turn[..., 0, 1] = -turn[..., 1, 0]
    turn[..., 2, 2] = 1.0
    return turn


def ring_stone(
    name: str, points: FloatArray, pieces: int, names: tuple[str, ...], labels: tuple[str, ...]
) -> Shape:
    """Shape between two parallels and two radii.

    Parameters
    ----------
    name : Of the shape.
    points : Corners along four arcs, ``pieces`` + 1 each: inner side below and above, outer side below and
        above, shape (4 (pieces + 1), 3) [m].
    pieces : Flat pieces of each curved face.
    names, labels : Face names and joint labels of inner, outer, lower, upper, left and right faces.
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
