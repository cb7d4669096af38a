"""BodyMatrix: what eliminated contacts leave between the velocities of bodies, M + Bᵀ S B.

S is a (d, d) block a contact, not symmetric in general. The pattern is that of the blocks that touch,
whatever the number of contact points, and is made once for all problems of the same contacts.

    pattern = BodyPattern(bodies, count)
    body_matrix = BodyMatrix(pattern, rigid_map, column)      # once for a problem
    A = body_matrix.assemble(slope, contacts, diagonal)       # once for a step
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


class BodyPattern:
    """Where the blocks of the matrix stand, and where each contact adds to them.

    Parameters
    ----------
    bodies : Bodies on the two sides of each contact, −1 for none, shape (c, 2).
    count : Number of bodies b.

    Attributes
    ----------
    keys : Row · b + column of each block, ascending, (k,).
    indices, pointer : Columns of the blocks, (k,), and where each row begins, (b + 1,).
    diagonal : Blocks on the diagonal, (b,).
    slots : Block between the bodies on any two sides of each contact, −1 where there is none, (c, 2, 2).
    """

    def __init__(self, bodies: IntArray, count: int) -> None:
        self.count, self.bodies = count, np.ascontiguousarray(bodies, dtype=np.int64)
        _, first, pair = np.unique(
            (self.bodies[:, 0] + 1) * (count + 1) + self.bodies[:, 1], return_index=True, return_inverse=True
        )
        joined = self.bodies[first]
        keys = joined[:, :, None] * count + joined[:, None, :]
        absent = (joined[:, :, None] < 0) | (joined[:, None, :] < 0)
        own = np.arange(count) * (count + 1)
        pattern, place = np.unique(np.concatenate([own, keys[~absent]]), return_inverse=True)
        self.keys = pattern
        self.diagonal = place[:count].copy()  # not all of them with it
        slots = np.full(keys.shape, -1, dtype=np.int64)
        slots[~absent] = place[count:]
        self.slots = slots[pair]
        rows = pattern // max(count, 1)
        self.indices = pattern - rows * count
        self.pointer = np.searchsorted(rows, np.arange(count + 1))

    def serves(self, bodies: IntArray, count: int) -> bool:
        """Whether contacts between these bodies have this pattern.

        Parameters
        ----------
        bodies, count : As they are given at first.
        """
        return count == self.count and np.array_equal(bodies, self.bodies)


class BodyMatrix:
    """The matrix of a problem.

    Parameters
    ----------
    pattern : Where its blocks stand.
    rigid_map : B by contact and side, shape (c, 2, d, m).
    column : What each column of B is divided by, shape (b, m).
    """

    def __init__(self, pattern: BodyPattern, rigid_map: FloatArray, column: FloatArray) -> None:
        self.pattern, self.size = pattern, rigid_map.shape[3]
        self._rigid_map, self.column = rigid_map, column

    @cached_property
    def maps(self) -> FloatArray:
        """B by contact and side as its columns are scaled, 0 where a side has no body, shape (c, 2, d, m)."""
        none = np.full((1, self.size), np.inf)
        maps: FloatArray = self._rigid_map.copy()
        maps /= np.append(self.column, none, axis=0)[self.pattern.bodies][:, :, None]
        return maps

    def assemble(self, slope: FloatArray, contacts: IntArray, diagonal: FloatArray) -> sparse.bsr_array:
        """Diag + Bᵀ S B over some contacts, block-sparse, shape (b m, b m).

        Parameters
        ----------
        slope : S of those contacts, shape (k, d, d).
        contacts : Their numbers, shape (k,).
        diagonal : Diagonal to start from, shape (b, m).
        """
        m, pattern = self.size, self.pattern
        blocks = np.zeros((len(pattern.indices), m, m))
        blocks[pattern.diagonal[:, None], np.arange(m), np.arange(m)] = diagonal
        if len(contacts):
            from masonry_fem.nscd.solvers.body_kernel import couple  # noqa: PLC0415 - Numba is slow to import

            sloped = np.ascontiguousarray(slope)
            couple(contacts, pattern.bodies, self.maps, sloped, pattern.slots, blocks)
        shape = (pattern.count * m, pattern.count * m)
        return sparse.bsr_array((blocks, pattern.indices, pattern.pointer), shape=shape, blocksize=(m, m))
