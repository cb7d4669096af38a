"""Peers: what a contact problem asks of the ranks that have its other contacts.

Each of several ranks has some contacts of a problem, and all its bodies. What is told of all contacts is
then a sum, or a least value, over ranks, and the same on each of them: so they all take the same turns.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


class Peers(Protocol):
    """The ranks that have the other contacts of a problem."""

    @property
    def count(self) -> int:
        """Contacts of all ranks."""
        ...

    def summed(self, values: FloatArray) -> FloatArray:
        """Sums over all ranks of what each has, number by number."""
        ...

    def least(self, values: FloatArray) -> FloatArray:
        """The least values that any rank has, number by number; nan where one is."""
        ...
