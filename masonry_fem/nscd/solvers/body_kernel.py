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
    moved = np.empty((d, m))
    for number in range(len(contacts)):
        contact = contacts[number]
        for other in range(2):
            if bodies[contact, other] < 0:
                continue
            _product(slope[number], maps[contact, other], moved)
            for one in range(2):
                if bodies[contact, one] < 0:
                    continue
                slot = slots[contact, one, other]
                for a in range(m):
                    for i in range(d):
                        left = maps[contact, one, i, a]
                        if left != 0.0:
                            for b in range(m):
                                blocks[slot, a, b] += left * moved[i, b]


@compiled(inline="always")
def _product(one: FloatArray, other: FloatArray, found: FloatArray) -> None:
    """Put the product of two matrices into ``found``."""
    for i in range(found.shape[0]):
        for b in range(found.shape[1]):
            total = 0.0
            for j in range(one.shape[1]):
                total += one[i, j] * other[j, b]
            found[i, b] = total
