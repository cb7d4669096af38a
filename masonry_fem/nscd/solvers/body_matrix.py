"""BodyMatrix: what eliminated contacts leave between the velocities of bodies, M + Bᵀ S B.

S is a (d, d) block a contact, not symmetric in general. The pattern is that of the blocks that touch,
whatever the number of contact points, and is made once for a problem.

    body_matrix = BodyMatrix(bodies, maps, count)
    A = body_matrix.assemble(slope, contacts, diagonal)
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


class BodyMatrix:
    """Pattern of the matrix, and where each contact adds to it.

    Parameters
    ----------
    bodies : Bodies on the two sides of each contact, −1 for none, shape (c, 2).
    maps : B by contact and side, shape (c, 2, d, m).
    count : Number of bodies b.
    """

    def __init__(self, bodies: IntArray, maps: FloatArray, count: int) -> None:
        self.count, self.size = count, maps.shape[3]
        self.bodies = np.ascontiguousarray(bodies, dtype=np.int64)
        self.maps = np.ascontiguousarray(maps)
        keys = bodies[:, :, None] * count + bodies[:, None, :]  # of the block (body of one side, of another)
        absent = (bodies[:, :, None] < 0) | (bodies[:, None, :] < 0)
        own = np.arange(count) * (count + 1)
        pattern, place = np.unique(np.concatenate([own, keys[~absent]]), return_inverse=True)
        self.keys = pattern  # row · b + column of each block, ascending
        self.diagonal = place[:count]
        self.slots = np.full(keys.shape, -1, dtype=np.int64)
        self.slots[~absent] = place[count:]
        rows = pattern // max(count, 1)
        self.indices = pattern - rows * count
        self.pointer = np.searchsorted(rows, np.arange(count + 1))

    def assemble(self, slope: FloatArray, contacts: IntArray, diagonal: FloatArray) -> sparse.bsr_array:
        """Diag + Bᵀ S B over some contacts, block-sparse, shape (b m, b m).

        Parameters
        ----------
        slope : S of those contacts, shape (k, d, d).
        contacts : Their numbers, shape (k,).
        diagonal : Diagonal to start from, shape (b, m).
        """
        m = self.size
        blocks = np.zeros((len(self.indices), m, m))
        blocks[self.diagonal[:, None], np.arange(m), np.arange(m)] = diagonal
        if len(contacts):
            from masonry_fem.nscd.solvers.body_kernel import couple  # noqa: PLC0415 - Numba is slow to import

            couple(contacts, self.bodies, self.maps, np.ascontiguousarray(slope), self.slots, blocks)
        shape = (self.count * m, self.count * m)
        return sparse.bsr_array((blocks, self.indices, self.pointer), shape=shape, blocksize=(m, m))
