"""Anderson: acceleration of a fixed-point iteration z ← T(z) by its last few steps.

Of all affine combinations of the last T(z) it takes the one whose combined step T(z) − z is smallest: a
quasi-Newton method that needs nothing but the iterates (D. G. Anderson 1965, "type II").

    anderson = Anderson(memory=20, size=z.size)
    z = anderson.next(z, T(z))
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Regularisation of the least-squares problem, relative to columns of unit length.
REGULARISATION = 1e-10
# A step this much longer than the last one forgets the past.
GROWTH = 2.0


class Anderson:
    """The last steps of an iteration, and the next iterate that they suggest.

    Parameters
    ----------
    memory : Differences of steps kept; 0: no acceleration.
    size : Numbers in an iterate.
    """

    def __init__(self, memory: int, size: int) -> None:
        self.memory = memory
        self.steps = np.zeros((memory, size))  # differences of T(z) − z, one a row
        self.images = np.zeros((memory, size))  # differences of T(z)
        self.gram = np.zeros((memory, memory))
        self.forget()

    def forget(self) -> None:
        """Begin anew: the map has changed."""
        self.count = 0  # differences that are stored
        self.place = 0  # of the next one: the rows are a ring
        self.step: FloatArray | None = None
        self.image: FloatArray | None = None

    def skip(self) -> None:
        """The map has shifted: no difference is to be taken over this step."""
        self.step = None

    def next(self, state: FloatArray, image: FloatArray) -> FloatArray:
        """The iterate after z = ``state`` with T(z) = ``image``, both (size,)."""
        if not self.memory:
            return image
        step = image - state
        if self.step is not None and self.image is not None:
            if np.linalg.norm(step) > GROWTH * np.linalg.norm(self.step):
                self.forget()
            else:
                self._store(step - self.step, image - self.image)
        self.step, self.image = step, image.copy()
        if not self.count:
            return image
        kept = self.count
        length = np.sqrt(np.diagonal(self.gram)[:kept])
        length[length == 0] = 1.0
        normal = self.gram[:kept, :kept] / np.outer(length, length)
        normal[np.diag_indices(kept)] += REGULARISATION
        share = np.linalg.solve(normal, (self.steps[:kept] @ step) / length) / length
        better: FloatArray = image - share @ self.images[:kept]
        return better if np.isfinite(better).all() else image

    def _store(self, step: FloatArray, image: FloatArray) -> None:
        row = self.place
        self.steps[row], self.images[row] = step, image
        self.count = max(self.count, row + 1)
        self.place = (row + 1) % self.memory
        products = self.steps[: self.count] @ step
        self.gram[row, : self.count] = products
        self.gram[: self.count, row] = products
