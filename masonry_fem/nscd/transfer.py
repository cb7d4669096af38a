"""Transfer: the compiled products with the rigid map B, contact after contact.

A solver makes several of each every step, and B's blocks are too small for BLAS.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from masonry_fem.host.compiled import compiled

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@compiled
def to_contacts(bodies: IntArray, maps: FloatArray, motion: FloatArray) -> FloatArray:
    """B U of body velocities, shape (c, d).

    Parameters
    ----------
    bodies : Bodies at the two sides, −1 for none, shape (c, 2).
    maps : Rigid map B by contact and side, shape (c, 2, d, m).
    motion : U, shape (b, m).
    """
    c, _, d, m = maps.shape
    velocity = np.zeros((c, d))
    for contact in range(c):
        for side in range(2):
            body = bodies[contact, side]
            if body < 0:
                continue
            for i in range(d):
                total = 0.0
                for a in range(m):
                    total += maps[contact, side, i, a] * motion[body, a]
                velocity[contact, i] += total
    return velocity


@compiled
def to_bodies(bodies: IntArray, maps: FloatArray, impulse: FloatArray, count: int) -> FloatArray:
    """Bᵀ p of contact impulses, shape (b, m).

    Parameters
    ----------
    bodies : Bodies at the two sides, −1 for none, shape (c, 2).
    maps : Rigid map B by contact and side, shape (c, 2, d, m).
    impulse : p, shape (c, d).
    count : Number b of bodies.
    """
    c, _, d, m = maps.shape
    total = np.zeros((count, m))
    for contact in range(c):
        for side in range(2):
            body = bodies[contact, side]
            if body < 0:
                continue
            for a in range(m):
                given = 0.0
                for i in range(d):
                    given += maps[contact, side, i, a] * impulse[contact, i]
                total[body, a] += given
    return total
