"""NormalMap: a plane contact problem, held near a centre, as one piecewise linear equation.

With x = p − ρ v each contact's impulse is a function of its own x: none where x_N ≤ 0; x itself where
‖x_T‖ ≤ μ x_N; else x_N, with friction at its limit on the side of x_T. What is left to solve is

    R(x) = v(p(x)) + α w (p(x) − p_k) − (p(x) − x)/ρ = 0,    v(p) = W p + q + B U(p)

(Robinson's normal map of the proximal problem about p_k). In the plane it is linear in each *piece*: for
each choice of which contacts are open, stick, or slide which way.

    equation = NormalMap(problem)
    equation.hold(centre, alpha)
    piece = equation.at(x)
    x + piece.change(missing)             # R(x + change) = R(x) − missing, as long as the piece lasts
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from masonry_fem.nscd.problem import ContactProblem
from masonry_fem.nscd.products import applied
from masonry_fem.nscd.scaling import contact_scale
from masonry_fem.nscd.solvers.linearisation import linearise
from masonry_fem.nscd.solvers.newton_system import NewtonFactor, NewtonSystem

FloatArray = NDArray[np.float64]


class NormalMap:
    """The equation of a dry problem in 2D whose bodies all have inertia.

    Parameters
    ----------
    problem : The contact problem.

    References
    ----------
    S. M. Robinson, "Normal maps induced by linear transformations", Mathematics of Operations Research 17
    (1992).
    """

    def __init__(self, problem: ContactProblem) -> None:
        self.problem = problem
        self.scale = contact_scale(problem)
        self.system = NewtonSystem(problem, self.scale, "direct")
        self.factors = 0  # made since it was last set to zero
        self.hold(np.zeros_like(problem.free_velocity), 1.0)

    def hold(self, centre: FloatArray, alpha: float) -> None:
        """Set the centre p_k, shape (c, 2), and the weight α."""
        self.centre, self.alpha = centre, alpha
        self.rho = 1.0 / (self.scale * (1.0 + alpha))
        self.pull = alpha * self.scale

    def start(self, impulse: FloatArray) -> FloatArray:
        """The x of given impulses and the velocities they make, shape (c, 2)."""
        velocity = self.problem.velocity(impulse, self.problem.balanced_velocity(impulse))
        return impulse - self.rho[:, None] * velocity

    def at(self, x: FloatArray) -> Piece:
        """The piece that x (c, 2) lies in."""
        return Piece(self, x)

    def relative(self, residual: FloatArray, impulse: FloatArray) -> float:
        """‖ρ R‖ / ‖p‖ of an R, shape (c, 2)."""
        size = float(np.linalg.norm(impulse))
        error = float(np.linalg.norm(self.rho[:, None] * residual))
        return error / size if size > 0 else np.inf if error > 0 else 0.0


class Piece:
    """The equation about one x.

    Attributes
    ----------
    x : The place, shape (c, 2).
    impulse : p(x), shape (c, 2).
    residual : R(x), shape (c, 2) [m/s].
    """

    def __init__(self, equation: NormalMap, x: FloatArray) -> None:
        self.equation, self.x = equation, x
        problem, rho = equation.problem, equation.rho
        self._line = linearise(x, np.zeros_like(x), problem.friction, rho)
        self.impulse = x - self._line.residual
        velocity = problem.velocity(self.impulse, problem.balanced_velocity(self.impulse))
        velocity += equation.pull[:, None] * (self.impulse - equation.centre)
        self.residual = velocity - (self.impulse - x) / rho[:, None]

    @cached_property
    def factor(self) -> NewtonFactor:
        """The factor of the piece's derivative."""
        equation, line = self.equation, self._line
        own = line.by_impulse / equation.rho[:, None, None]
        own = own + equation.pull[:, None, None] * line.by_velocity
        mass = equation.problem.rigid_mass
        equation.factors += 1
        return equation.system.factor(own, line.by_velocity, ~line.open, line.plain, mass)

    @cached_property
    def sign(self) -> int:
        """Sign of the derivative's determinant, up to one that all pieces share."""
        return self.factor.sign()

    def change(self, missing: FloatArray) -> FloatArray:
        """The dx of dR = −missing, shape (c, 2)."""
        equation = self.equation
        force = applied(self._line.by_velocity, missing)
        impulse, motion = self.factor.solve(force, np.zeros_like(equation.problem.rigid_mass))
        return impulse - equation.rho[:, None] * (missing + self._moved(impulse, motion))

    def response(self, contact: int, push: FloatArray) -> FloatArray:
        """The dx where a contact's p is a ``push`` (2,) beside its function of x, R the same, (c, 2)."""
        equation, problem = self.equation, self.equation.problem
        step, force = np.zeros_like(self.x), np.zeros_like(self.x)
        if self._line.open[contact]:
            step[contact] = push
            force = applied(self._line.by_velocity, problem.elastic_velocity(step))
        else:
            force[contact] = -push / equation.rho[contact]
        impulse, motion = self.factor.solve(force, problem.body_impulse(step))
        impulse = impulse + step
        return impulse - equation.rho[:, None] * self._moved(impulse, motion)

    def _moved(self, impulse: FloatArray, motion: FloatArray) -> FloatArray:
        problem = self.equation.problem
        velocity = problem.elastic_velocity(impulse) + problem.contact_velocity(motion)
        return velocity + self.equation.pull[:, None] * impulse
