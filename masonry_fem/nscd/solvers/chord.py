"""Chord: Newton's method goes on with the factor of the problem before, where a problem is nearly the same.

From round to round of a step of statics blocks turn by less and less, and soon no contact opens, closes,
sticks or slips that did not before. What is left of balance then is so small that the last factor takes it
away, although its matrix is that of blocks which were turned a little less: a step costs a solution in place
of a factor. Where some contact does change, steps lead nowhere, and none is made.

A solution that is good enough is taken on in the same way, for a few steps: what its last factor takes away
at no more than a solution each, stresses need not bear.

    start = continued(problem, start, settings)
    made = taken_on(problem, made, settings)

References
----------
C. T. Kelley, "Iterative Methods for Linear and Nonlinear Equations", SIAM (1995), chapter 5 (chord method).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from masonry_fem.nscd.outcome import Solution
from masonry_fem.nscd.problem import ContactProblem
from masonry_fem.nscd.products import applied
from masonry_fem.nscd.residuals import assess
from masonry_fem.nscd.settings import SolverSettings, Start
from masonry_fem.nscd.solvers.elastic_matrix import Terms
from masonry_fem.nscd.solvers.linearisation import linearise
from masonry_fem.nscd.solvers.newton_system import NewtonFactor

FloatArray = NDArray[np.float64]

FALL = 0.1  # of the error, which a step is to leave at most: a factor that fits leaves a thousandth or less
FINE, STEPS = 1e-13, 4  # error from which on a solution is hardly known better, and steps towards it


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
    chord = _last(problem)
    if chord is None or not chord.fits(start.impulse, start.velocity):
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


def taken_on(problem: ContactProblem, made: Solution, settings: SolverSettings) -> Solution:
    """A solution after a few steps with the last factor, if these take away nine tenths of its error.

    A contact next to the edge of its cone may slip in one step and stick in the next, so that an error may
    rise before it falls.

    Parameters
    ----------
    problem : The contact problem, with the structure that keeps the factor. made : Solves it.
    settings : How well it is solved.
    """
    chord = None if made.quality.error <= FINE else _last(problem)
    if chord is None:
        return made
    best, impulse, motion = made, made.impulse, made.rigid_velocity
    for _ in range(STEPS):
        impulse, motion = chord.led(impulse, motion)
        quality = assess(problem, impulse, motion, least_impulse=settings.least_impulse)
        if quality.error < best.quality.error:
            velocity = problem.velocity(impulse, motion)
            best = replace(best, impulse=impulse, velocity=velocity, rigid_velocity=motion, quality=quality)
        if best.quality.error <= FINE:
            break
    return best if best.quality.error <= FALL * made.quality.error else made


def _last(problem: ContactProblem) -> _Chord | None:
    """The last factor, where contacts are coupled as there."""
    structure = problem.structure
    if structure is None or structure.matrix is None or not structure.matrix.couples(problem):
        return None
    factor, stiffness = structure.factor, problem.cohesion_stiffness
    if factor is None or factor.terms is None or stiffness is not None or factor.stiffness is not None:
        return None
    return _Chord(problem, factor, factor.terms)


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

    def fits(self, impulse: FloatArray, velocity: FloatArray) -> bool:
        """Whether contacts open, stick or slip as where the factor was made."""
        pressed = self.problem.contact_part(impulse, velocity)
        line = linearise(pressed, velocity, self.problem.friction, self.rho)
        alike = np.array_equal(~line.open, self.terms.closed)
        return alike and np.array_equal(line.plain, self.terms.plain)

    def led(self, impulse: FloatArray, motion: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Where a step leads, p (c, d) and U (b, m)."""
        problem, closed, rho = self.problem, self.terms.closed, self.rho
        velocity = problem.velocity(impulse, motion)
        pressed = problem.contact_part(impulse, velocity)
        residual = linearise(pressed, velocity, problem.friction, rho).residual
        step = np.where(closed[:, None], 0.0, -residual)
        shift = applied(self.terms.by_velocity, problem.elastic_velocity(step))
        balance = problem.body_impulse(impulse + step) + problem.rigid_impulse
        balance -= problem.rigid_mass * (motion - problem.rigid_velocity)
        change, moved = self.factor.solve(residual / rho[:, None] + shift, balance)
        return impulse + step + change, motion + moved
