"""The compiled loop of Rows: A + Bc W_el within sets of contacts, set after set."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from masonry_fem.host.compiled import compiled

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
Mask = NDArray[np.bool_]


@compiled
def coupled(
    chosen: IntArray, group: IntArray, set_of: IntArray, coupling: FloatArray,
    own: FloatArray, by_velocity: FloatArray, closed: Mask,
) -> FloatArray:  # fmt: skip
    """The matrices A + Bc W_el of n sets of k contacts, of open ones A alone, shape (n, k d, k d).

    Parameters
    ----------
    chosen : Numbers of the sets, shape (n,). group : Contacts of all sets, shape (s, k).
    set_of : Contacts are coupled to those that have the same number here, shape (c,).
    coupling : W_el between the contacts of all sets, shape (s, k d, k d).
    own, by_velocity : A and Bc of all contacts, shape (c, d, d). closed : Those that take part, shape (c,).
    """
    n, k, d = len(chosen), group.shape[1], own.shape[1]
    made = np.zeros((n, k * d, k * d))
    for number in range(n):
        matrix, block, contacts = coupling[chosen[number]], made[number], group[chosen[number]]
        for a in range(k):
            contact = contacts[a]
            for i in range(d):
                for j in range(d):
                    block[a * d + i, a * d + j] = own[contact, i, j]
            if not closed[contact]:
                continue
            for b in range(k):
                if not closed[contacts[b]] or set_of[contact] != set_of[contacts[b]]:
                    continue
                for i in range(d):
                    for step in range(d):
                        factor = by_velocity[contact, i, step]
                        if factor != 0.0:
                            for j in range(d):
                                block[a * d + i, b * d + j] += factor * matrix[a * d + step, b * d + j]
    return made
