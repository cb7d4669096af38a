"""The compiled loop of BodyMatrix: Bᵀ S B, contact after contact."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from masonry_fem.host.compiled import compiled

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@compiled
def couple(
    contacts: IntArray, bodies: IntArray, maps: FloatArray, slope: FloatArray, slots: IntArray,
    blocks: FloatArray,
) -> None:  # fmt: skip
    """Add map_oneᵀ S map_other to ``blocks[slots[contact, one, other]]`` for all sides that have a body.

    Parameters
    ----------
    contacts : Contacts to add, shape (k,).
    bodies : Bodies at the two sides of all contacts, −1 for none, shape (c, 2).
    maps : Rigid map B by contact and side, shape (c, 2, d, m).
    slope : S of the contacts to add, shape (k, d, d).
    slots : Where a pair of sides goes, shape (c, 2, 2).
    blocks : What is added to, shape (n, m, m).
    """
    d, m = maps.shape[2], maps.shape[3]
    moved = np.zeros((3, m))  # S map_other; its last row stays 0 in 2D
    for number in range(len(contacts)):
        contact = contacts[number]
        for other in range(2):
            if bodies[contact, other] < 0:
                continue
            _product(slope[number], maps[contact, other], moved)
            for one in range(2):
                if bodies[contact, one] < 0:
                    continue
                block, left = blocks[slots[contact, one, other]], maps[contact, one]
                for a in range(m):  # three rows at once: what is added to is read once
                    x, y, z = left[0, a], left[1, a], left[d - 1, a]
                    for b in range(m):
                        block[a, b] += x * moved[0, b] + y * moved[1, b] + z * moved[2, b]


@compiled(inline="always")
def _product(one: FloatArray, other: FloatArray, found: FloatArray) -> None:
    """Put the product of two matrices into the first rows of ``found``."""
    for i in range(one.shape[0]):
        first = one[i, 0]
        for b in range(found.shape[1]):
            found[i, b] = first * other[0, b]
        for j in range(1, one.shape[1]):
            factor = one[i, j]
            for b in range(found.shape[1]):
                found[i, b] += factor * other[j, b]
