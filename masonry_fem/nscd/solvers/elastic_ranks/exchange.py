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
    places : Where what it has stands among what all own: its own first, in their order, shape (t,).
    own : How many are its own. width : Numbers of each.
    """

    def __init__(self, member: Member, places: IntArray, own: int, width: int) -> None:
        library = petsc()
        self._member, self._own, beside = member, own, len(places) - own
        self._mine = library.Vec().createMPI((own * width, None), comm=member.comm)
        self._beside = library.Vec().createSeq(beside * width, comm=library.COMM_SELF)
        at = library.IS().createBlock(width, places[own:].astype(library.IntType), comm=library.COMM_SELF)
        self._scatter = library.Scatter().create(self._mine, at, self._beside, None)
        at.destroy()
        self._shape, self._bytes = (beside, width), beside * width * NUMBER

    def destroy(self) -> None:
        """Let go what PETSc holds."""
        for made in (self._scatter, self._mine, self._beside):
            made.destroy()

    def spread(self, values: FloatArray) -> FloatArray:
        """Own values (own, w) with those of others that are needed, shape (t, w)."""
        with self._member.on("exchange", self._bytes):
            self._mine.placeArray(np.ascontiguousarray(values))
            self._scatter.scatter(self._mine, self._beside)
            self._mine.resetArray()
            return np.concatenate([values, self._beside.array.reshape(self._shape)])

    def summed(self, values: FloatArray) -> FloatArray:
        """Sums over all ranks of what they have of the own ones, from (t, w), shape (own, w)."""
        library = petsc()
        with self._member.on("exchange", self._bytes):
            summed = values[: self._own].copy()
            self._beside.array[:] = values[self._own :].ravel()
            self._mine.placeArray(summed)
            self._scatter.scatter(
                self._beside, self._mine, library.InsertMode.ADD_VALUES, library.ScatterMode.REVERSE
            )
            self._mine.resetArray()
            return summed
