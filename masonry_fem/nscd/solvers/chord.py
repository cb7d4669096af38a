"""Chord: Newton's method goes on with the factor of the problem before, where a problem is nearly the same.

From round to round of a step of statics blocks turn by less and less, and soon no contact opens, closes,
sticks or slips that did not before. What is left of balance then is so small that the last factor takes it
away, although its matrix is that of blocks which were turned a little less: a step costs a solution in place
of a factor. Where some contact does change, steps lead nowhere, and none is made.

    start = continued(problem, start, settings)

References
----------
C. T. Kelley, "Iterative Methods for Linear and Nonlinear Equations", SIAM (1995), chapter 5 (chord method).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from masonry_fem.nscd import graphs
from masonry_fem.nscd.problem import ContactProblem
from masonry_fem.nscd.residuals import assess
from masonry_fem.nscd.settings import SolverSettings, Start
from masonry_fem.nscd.solvers.elastic_matrix import Terms
from masonry_fem.nscd.solvers.linearisation import linearise
from masonry_fem.nscd.solvers.newton_system import NewtonFactor

FloatArray = NDArray[np.float64]

FALL = 0.1  # of the error, which a step is to leave at most: a factor that fits leaves a thousandth or less


def continued(problem: ContactProblem, start: Start | None, settings: SolverSettings) -> Start | None:
    """A first guess that is a solution, where the last factor leads to one; else the guess that was given.

    Parameters
    ----------
    problem : The contact problem, with the structure that keeps the factor.
    start : First guess; None: there is none.
    settings : How well the problem is to be solved.
    """
    if start is None or start.impulse is None or start.velocity is None or start.rigid_velocity is None:
        return start
    chord = _chord(problem, start.impulse, start.velocity)
    if chord is None:
        return start
    impulse, motion, error = start.impulse, start.rigid_velocity, np.inf
    while True:
        left = assess(problem, impulse, motion, least_impulse=settings.least_impulse).error
        if left <= settings.tolerance:
            return Start(impulse, motion, problem.velocity(impulse, motion))
        if not left <= FALL * error:
            return start
        error = left
        impulse, motion = chord.led(impulse, motion)


def _chord(problem: ContactProblem, impulse: FloatArray, velocity: FloatArray) -> _Chord | None:
    """Steps with the last factor, where contacts are coupled as there, and open, stick or slip as there."""
    structure = problem.structure
    if structure is None or structure.matrix is None or not structure.matrix.couples(problem):
        return None
    factor, stiffness = structure.factor, problem.cohesion_stiffness
    if factor is None or factor.terms is None or stiffness is not None or factor.stiffness is not None:
        return None
    chord = _Chord(problem, factor, factor.terms)
    line = linearise(problem.contact_part(impulse, velocity), velocity, problem.friction, chord.rho)
    alike = np.array_equal(~line.open, chord.terms.closed) and np.array_equal(line.plain, chord.terms.plain)
    return chord if alike else None


@dataclass(frozen=True, slots=True)
class _Chord:
    """A problem, and the factor of another one, with what that was made of."""

    problem: ContactProblem
    factor: NewtonFactor
    terms: Terms

    @property
    def rho(self) -> FloatArray:
        """ρ of the contact function, shape (c,) [kg]."""
        rho: FloatArray = 1.0 / self.factor.system.scale
        return rho

    def led(self, impulse: FloatArray, motion: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Where a step leads, p (c, d) and U (b, m)."""
        problem, closed, rho = self.problem, self.terms.closed, self.rho
        velocity = problem.velocity(impulse, motion)
        pressed = problem.contact_part(impulse, velocity)
        residual = graphs.alart_curnier(pressed, velocity, problem.friction, rho)[0]
        step = np.where(closed[:, None], 0.0, -residual)
        shift = (self.terms.by_velocity @ problem.elastic_velocity(step)[:, :, None])[:, :, 0]
        balance = problem.body_impulse(impulse + step) + problem.rigid_impulse
        balance -= problem.rigid_mass * (motion - problem.rigid_velocity)
        change, moved = self.factor.solve(residual / rho[:, None] + shift, balance)
        return impulse + step + change, motion + moved
