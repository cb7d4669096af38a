"""Flips: contacts that swing between open and sticking, step after step, past the slip in between.

At the trial point x = p − ρ v a contact slips only where 0 ≤ x_N < ‖x_T‖/μ: in a rough joint a strip
so narrow that Newton's steps jump over it. Stuck, the contact is pulled on, and opens; open, it is
pushed through, and sticks again. What is left is to slip, with hardly any normal impulse.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from masonry_fem.nscd.solvers.linearisation import Linearisation

FloatArray = NDArray[np.float64]
Mask = NDArray[np.bool_]

# μ above which the slipping states are the narrow ones
ROUGH = 1.0
_OPEN, _SLIPS, _STICKS = 0, 1, 2


class Flips:
    """The contacts' states of the last steps.

    Parameters
    ----------
    friction : Coefficients μ, shape (c,).
    anywhere : Tells whether some contact of any rank is in a mask; None: all contacts are here.
    """

    def __init__(self, friction: FloatArray, anywhere: Callable[[Mask], bool] | None = None) -> None:
        self.rough, self._anywhere = friction > ROUGH, anywhere
        self.states: list[NDArray[np.int8]] = []

    def forget(self) -> None:
        """Begin anew."""
        self.states.clear()

    def swinging(self, line: Linearisation, *, settled: bool) -> Mask:
        """Contacts that went there and back in the last two steps; none before a round has ``settled``.

        Those found start anew: they are made to slip for one step only.
        """
        state = np.where(line.open, _OPEN, np.where(line.plain, _STICKS, _SLIPS)).astype(np.int8)
        self.states = [*self.states[-2:], state]
        if not settled or len(self.states) < 3:
            return np.zeros_like(self.rough)
        first, second, last = self.states
        found: Mask = self.rough & (first == last) & (np.abs(second - last) == _STICKS - _OPEN)
        if found.any() if self._anywhere is None else self._anywhere(found):
            self.forget()
        return found
