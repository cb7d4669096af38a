"""Escape: evidence that a static problem has no equilibrium.

Each round of the proximal Newton method holds U to its centre by a proximal mass ε. Where an
equilibrium exists the impulse ε (U − U_k) falls from round to round, ten times faster when ε is ten
times smaller. Where none exists it stays what it is, the unbalanced part of the loads, and U
travels along the mechanism.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

UNBALANCED = 1e-9  # impulse relative to the loads below which no part is said to move


@dataclass(slots=True)
class Escape:
    """Evidence that no equilibrium exists.

    Attributes
    ----------
    rounds : Rounds in a row whose unbalanced impulse did not fall.
    softer : Times that ε was reduced and it still did not.
    mechanism : Direction in which U runs off, of unit length, shape (b, m).
    """

    rounds: int = 0
    softer: int = 0
    last: float = np.inf
    mechanism: FloatArray = field(default_factory=lambda: np.zeros((0, 0)))

    @property
    def sure(self) -> bool:
        """True where softer proximal masses changed nothing, twice."""
        return self.softer >= 2

    def watch(self, unbalanced: float, travelled: FloatArray) -> bool:
        """Take note of a round; True when ε is to be reduced for the counter-check."""
        stays = unbalanced > UNBALANCED and unbalanced > 0.9 * self.last
        self.last = unbalanced
        if not stays:
            self.rounds = self.softer = 0
            return False
        self.rounds += 1
        length = float(np.linalg.norm(travelled))
        self.mechanism = travelled / length
        if self.rounds < 3:
            return False
        self.rounds = 1
        self.softer += 1
        return True
