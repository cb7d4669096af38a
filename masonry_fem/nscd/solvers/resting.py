"""Resting: whether steps leave an error as it is because it is rounding."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from masonry_fem.nscd.problem import ContactProblem
from masonry_fem.nscd.residuals import Quality, rounding
from masonry_fem.nscd.settings import ACCEPTABLE

FloatArray = NDArray[np.float64]

STEPS = 2  # that leave the error as it is
SAME, RISEN = 0.5, 10.0  # times the least error: what is as it was


class Resting:
    """The errors of a problem's steps.

    Parameters
    ----------
    problem : The contact problem.
    """

    def __init__(self, problem: ContactProblem) -> None:
        self._problem = problem
        self._least, self._steps = np.inf, 0  # least error, and how many steps stayed at it

    def at(self, quality: Quality, tolerance: float, impulse: FloatArray, rigid_velocity: FloatArray) -> bool:
        """Whether steps stay where they are, by no more than rounding from the solution.

        Parameters
        ----------
        quality : Of the last state. tolerance : What is near enough.
        impulse, rigid_velocity : The state, shapes (c, d) and (b, m).
        """
        rests = SAME * self._least <= quality.error <= RISEN * self._least
        self._steps = self._steps + 1 if rests else 0
        self._least = min(self._least, quality.error)
        if self._steps < STEPS or self._least > ACCEPTABLE:
            return False
        return quality.bounded_by(rounding(self._problem, impulse, rigid_velocity), tolerance)
