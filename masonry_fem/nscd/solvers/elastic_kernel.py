"""The compiled loops of Rows, set of contacts after set: A + Bc W_el, and what iterations multiply by."""

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


@compiled
def add_solutions(group: IntArray, inverse: FloatArray, force: FloatArray, impulse: FloatArray) -> None:
    """Add what n sets of k contacts give for forces on them.

    Parameters
    ----------
    group : The sets, shape (n, k). inverse : Impulses from forces, shape (n, k d, k d).
    force : Of all contacts, shape (c, d). impulse : The same; it is added to.
    """
    k, d = group.shape[1], force.shape[1]
    given = np.empty(k * d)
    for number in range(len(group)):
        for a in range(k):
            for i in range(d):
                given[a * d + i] = force[group[number, a], i]
        for a in range(k):
            for i in range(d):
                total = 0.0
                for j in range(k * d):
                    total += inverse[number, a * d + i, j] * given[j]
                impulse[group[number, a], i] += total


@compiled
def take_followed(
    group: IntArray, followed: FloatArray, bodies: IntArray, motion: FloatArray, impulse: FloatArray
) -> None:
    """Take off what n sets of k contacts give for the motions of their b bodies.

    Parameters
    ----------
    group : The sets, shape (n, k). followed : Impulses from motions, shape (n, k d, b m).
    bodies : Of each set, −1 for none, shape (n, b). motion : Of all bodies, shape (g, m).
    impulse : Of all contacts, shape (c, d); it is taken off from.
    """
    k, d, b, m = group.shape[1], impulse.shape[1], bodies.shape[1], motion.shape[1]
    given = np.empty(b * m)
    for number in range(len(group)):
        for place in range(b):
            body = bodies[number, place]
            for i in range(m):
                given[place * m + i] = motion[body, i] if body >= 0 else 0.0
        for a in range(k):
            for i in range(d):
                total = 0.0
                for j in range(b * m):
                    total += followed[number, a * d + i, j] * given[j]
                impulse[group[number, a], i] -= total


@compiled
def rows_product(
    by_velocity: FloatArray, own: FloatArray, unit: float,
    velocity: FloatArray, moved: FloatArray, x: FloatArray,
) -> FloatArray:  # fmt: skip
    """Bc (v / unit + B U) + A x, shape (c, d).

    Parameters
    ----------
    by_velocity, own : Bc and A, shape (c, d, d). unit : Of impulses.
    velocity, moved, x : v, B U and x, shape (c, d).
    """
    c, d, _ = own.shape
    product = np.empty((c, d))
    for contact in range(c):
        for i in range(d):
            total = 0.0
            for j in range(d):
                total += by_velocity[contact, i, j] * (velocity[contact, j] / unit + moved[contact, j])
                total += own[contact, i, j] * x[contact, j]
            product[contact, i] = total
    return product
