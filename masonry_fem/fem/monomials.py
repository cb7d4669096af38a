"""Monomials: products of powers of coordinates, and their slopes."""

from __future__ import annotations

from itertools import combinations_with_replacement

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


def exponents(dimension: int, degree: int, lowest: int = 1) -> IntArray:
    """Powers of the coordinates in each monomial, from the lowest degree on, shape (t, d).

    Parameters
    ----------
    dimension : Coordinates d. degree : Highest degree. lowest : Lowest degree.
    """
    return np.array(
        [
            np.bincount(np.array(axes, dtype=int), minlength=dimension)
            for total in range(lowest, degree + 1)
            for axes in combinations_with_replacement(range(dimension), total)
        ]
    )


def monomials(places: FloatArray, degree: int) -> FloatArray:
    """Monomials of degree 1 to ``degree`` at p places, shape (t, p).

    Parameters
    ----------
    places : Coordinates, best between -1 and 1, shape (p, d).
    degree : Highest degree, >= 1.
    """
    values: FloatArray = np.prod(places ** exponents(places.shape[1], degree)[:, None], axis=2)
    return values


def monomial_slopes(places: FloatArray, degree: int) -> FloatArray:
    """Their slopes along the coordinates, shape (t, p, d).

    Parameters
    ----------
    places : Coordinates, best between -1 and 1, shape (p, d).
    degree : Highest degree, >= 1.
    """
    d = places.shape[1]
    powers = exponents(d, degree)
    lower = np.maximum(powers[:, None] - np.eye(d, dtype=int), 0)  # t, axis, d
    slopes: FloatArray = powers[:, None] * np.prod(places[:, None] ** lower[:, None], axis=3)
    return slopes
