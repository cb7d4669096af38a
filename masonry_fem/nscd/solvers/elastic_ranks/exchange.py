"""Exchange: values that ranks own, and those that they need beside them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from masonry_fem.host.ranks import Member
from masonry_fem.nscd.mumps import petsc

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

NUMBER = 8  # bytes


class Exchange:
    """Values that ranks own, and those that they need beside them.

    Parameters
    ----------
    member : The rank.
    places : Where what it has stands among what all own, its own first, shape (t,).
    own : How many are its own. width : Numbers of each.
    """

    def __init__(self, member: Member, places: IntArray, own: int, width: int) -> None:
        library = petsc()
        self._member, self._own, self._width, self._all = member, own, width, len(places)
        self._mine = library.Vec().createMPI((own * width, None), comm=member.comm)
        self._local = library.Vec().createSeq(len(places) * width, comm=library.COMM_SELF)
        at = library.IS().createBlock(width, places.astype(library.IntType), comm=library.COMM_SELF)
        self._scatter = library.Scatter().create(self._mine, at, self._local, None)
        at.destroy()
        self._bytes = (self._all - own) * width * NUMBER

    def destroy(self) -> None:
        """Let go what PETSc holds."""
        for made in (self._scatter, self._mine, self._local):
            made.destroy()

    def spread(self, values: FloatArray) -> FloatArray:
        """Own values (own, w) with those of others that are needed, shape (t, w)."""
        with self._member.on("exchange", self._bytes):
            self._mine.array[:] = values.ravel()
            self._scatter.scatter(self._mine, self._local)
            local: FloatArray = self._local.array.reshape(self._all, self._width).copy()
            return local

    def summed(self, values: FloatArray) -> FloatArray:
        """Sums over all ranks of what they have of the own ones, from (t, w), shape (own, w)."""
        library = petsc()
        with self._member.on("exchange", self._bytes):
            self._local.array[:] = values.ravel()
            self._mine.set(0.0)
            self._scatter.scatter(
                self._local, self._mine, library.InsertMode.ADD_VALUES, library.ScatterMode.REVERSE
            )
            summed: FloatArray = self._mine.array.reshape(self._own, self._width).copy()
            return summed
