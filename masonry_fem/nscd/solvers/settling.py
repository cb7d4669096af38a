"""Settling: bodies that are far from where they rest come to rest by themselves, and the whole goes on then.

Where stones lie loosely, as in the uppermost courses of a wall, all contacts of a stone may slide, and a
Newton step moves it much too far. Shortened until no stone goes too far, steps bring a wall of ten thousand
on by a thousandth. So such bodies and those around them are solved for as a problem of their own (``part``)
while all others stay; then the next step of the whole is a full one. That is nonlinear elimination of what
is most nonlinear.

    settling = Settling(problem, held)
    settled = settling.settle(residual, impulse, rigid_velocity, error, wanted)
    if settled is not None:
        impulse, rigid_velocity = settled

References
----------
X.-C. Cai and X. Li, "Inexact Newton methods with restricted additive Schwarz based nonlinear elimination for
problems with high local nonlinearity", SIAM Journal on Scientific Computing 33 (2011).
"""

from __future__ import annotations

from dataclasses import replace
from time import monotonic
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from masonry_fem.nscd.iterate import iterate
from masonry_fem.nscd.methods.interior_point import InteriorPoint
from masonry_fem.nscd.outcome import Outcome, Solution
from masonry_fem.nscd.part import Part, touched, unsettled
from masonry_fem.nscd.problem import ContactProblem
from masonry_fem.nscd.settings import ACCEPTABLE, SolverSettings, Start

if TYPE_CHECKING:
    from masonry_fem.nscd.methods.newton import ProximalNewton

FloatArray = NDArray[np.float64]

# A part is made of the bodies without which this share of the residual is left: the first share that makes
# a part of no more than so many of all contacts.
LEFT = (0.1, 0.3, 0.6)
MOST = 0.5
# Error that is wanted of a part relative to that of the whole, the least and greatest; what is good enough,
# and steps from there on. Steps of the whole are dear: a wall of 100×100 takes 10, but 24 with parts no
# finer than 1e-6.
SHARE, FINEST, COARSEST = 1e-2, 1e-7, 1e-5
ENOUGH, FURTHER = 0.1, 20
# Least errors that are wanted, and good enough, over that at which the whole ends, where that is less.
FINER, LEAST = 10.0, 100.0
# Contacts up to which the interior point has a go at it: docs/solvers.md says what that is worth.
FEW = 1_500
_NO_TIME = 1e-9  # a limit that is over [s]


class Settling:
    """What it takes to bring parts of a problem to rest.

    Parameters
    ----------
    problem : The whole.
    held : The method that solves parts: one that holds slip back from the start.
    """

    def __init__(self, problem: ContactProblem, held: ProximalNewton) -> None:
        self.problem, self.held = problem, held
        self.linear_solves = 0  # of all parts so far

    def settle(
        self,
        residual: FloatArray,
        impulse: FloatArray,
        rigid_velocity: FloatArray,
        error: float,
        wanted: float,
        until: float | None = None,
    ) -> tuple[FloatArray, FloatArray] | None:
        """Impulses (c, d) and U (b, m) with what was far from settled at rest; None where that fails.

        Parameters
        ----------
        residual : At each contact, as an impulse, shape (c, d).
        impulse, rigid_velocity : The state, shapes (c, d) and (b, m).
        error : Norm of the residual over that of the impulses. wanted : Error at which the whole ends.
        until : Monotonic clock after which parts stay as far as they have come [s]; None: no limit.
        """
        size = float(np.linalg.norm(residual))
        for left in LEFT:
            chosen = unsettled(self.problem, residual, left * size)
            if touched(self.problem, chosen).mean() <= MOST:
                break
        else:
            return None
        part = Part.of(self.problem, chosen, impulse, rigid_velocity)
        tolerance = float(np.clip(SHARE * error, min(FINEST, FINER * wanted), COARSEST))
        enough = float(np.clip(ENOUGH * error, min(ACCEPTABLE, LEAST * wanted), ENOUGH))
        impulse, rigid_velocity, settled = impulse.copy(), rigid_velocity.copy(), False
        for cluster in part.clusters():
            time_left = None if until is None else max(until - monotonic(), _NO_TIME)
            found = self._rest(cluster, SolverSettings(tolerance=tolerance, time_limit=time_left), enough)
            if found.quality.error <= enough:
                impulse[cluster.contacts], settled = found.impulse, True
                rigid_velocity[cluster.bodies] = found.rigid_velocity
        return (impulse, rigid_velocity) if settled else None

    def _rest(self, part: Part, settings: SolverSettings, enough: float) -> Solution:
        """A part's best state: first one that is good enough, then a few steps towards what is wanted.

        Parameters
        ----------
        part : With the state that it is in. settings : What is wanted. enough : Error that is good enough.
        """
        found = self._enough(part, replace(settings, tolerance=enough))
        if found.quality.error <= settings.tolerance or not found.converged:
            return found
        held = replace(self.held, iterations=FURTHER)
        return _better(found, self._counted(iterate(part.problem, held, settings, _ahead(found))))

    def _enough(self, part: Part, settings: SolverSettings) -> Solution:
        """A part's best state: with slip held; else, of a small one, from inside the cones."""
        found = self._counted(iterate(part.problem, self.held, settings, part.start))
        if found.converged or found.outcome is Outcome.TIME_LIMIT or part.problem.count > FEW:
            return found
        return _better(found, self._from_inside(part, settings))

    def _from_inside(self, part: Part, settings: SolverSettings) -> Solution:
        """A part's state by the interior point, and polished."""
        method = InteriorPoint(align=0.0, library=self.held.library)
        inside = self._counted(iterate(part.problem, method, replace(settings, tolerance=COARSEST)))
        if inside.quality.error <= settings.tolerance:
            return inside
        return _better(inside, self._counted(iterate(part.problem, self.held, settings, _ahead(inside))))

    def _counted(self, solution: Solution) -> Solution:
        self.linear_solves += solution.linear_solves
        return solution


def _ahead(solution: Solution) -> Start:
    """What goes on from a solution."""
    return Start(solution.impulse, solution.rigid_velocity, solution.velocity)


def _better(one: Solution, other: Solution) -> Solution:
    """The one with the smaller error."""
    return min(one, other, key=lambda solution: solution.quality.error)
