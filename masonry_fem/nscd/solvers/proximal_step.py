"""ProximalStep: impulses and velocities under the laws of motion alone, held near a target by D.

    W_el x + q' + B U + D (x − t) = 0,    Bᵀ x + f_r − M (U − U_0) = 0

D is one number a contact. Rigid blocks leave a system of the size of their velocities. Where cohesion has
a stiffness S, it is x̃ = x + S v that D holds near t.

    step = ProximalStep(problem, scale)
    step.weigh(weight)                     # D, (c,)
    x, U = step.solve(force)               # force = D t − q', (c, d)
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from masonry_fem.nscd.linear import Library
from masonry_fem.nscd.problem import ContactProblem
from masonry_fem.nscd.solvers.newton_system import NewtonFactor, NewtonSystem

FloatArray = NDArray[np.float64]

# Mass that bodies without inertia get, relative to what their contacts give them; it is proximal: it
# holds them where the last step left them, and not where they were before the load.
PROXIMAL_MASS = 1e-7


class ProximalStep:
    """The linear half of ADMM on one problem; it factorises whenever D changes."""

    factor: NewtonFactor

    def __init__(self, problem: ContactProblem, scale: FloatArray, library: Library = "auto") -> None:
        self.problem, self.system = problem, NewtonSystem(problem, scale, library)
        self.still = problem.rigid_mass <= 0
        self.given = problem.rigid_impulse + problem.rigid_mass * problem.rigid_velocity
        self.rigid_velocity = problem.rigid_velocity.copy()
        sides = np.zeros_like(problem.rigid_mass)
        present = problem.bodies >= 0
        np.add.at(sides, problem.bodies[present], (problem.rigid_map[present] ** 2).sum(axis=1))
        self.square = np.where(sides > 0, sides, 1.0)  # squared lengths of the columns of B
        self.factorisations = 0
        self.mass = problem.rigid_mass
        free = problem.free_velocity
        # the part of −S v that x and U have nothing to do with
        self.held = -problem.contact_part(np.zeros_like(free), free) if problem.cohesive else None

    def weigh(self, weight: FloatArray) -> None:
        """Take D, shape (c,)."""
        proximal = PROXIMAL_MASS * self.square / weight.mean()
        self.mass = np.where(self.still, proximal, self.problem.rigid_mass)
        c, d = self.problem.free_velocity.shape
        identity = np.tile(np.eye(d), (c, 1, 1))
        every = np.ones(c, dtype=bool)
        with np.errstate(all="ignore"):  # a breakdown is seen in the solution
            own = weight[:, None, None] * identity
            stiffness = self.problem.cohesion_stiffness
            self.factor = self.system.factor(own, identity, every, every, self.mass, stiffness=stiffness)
        self.factorisations += 1

    def solve(self, force: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The x (c, d) and U (b, m) of ``force`` = D t − q'."""
        load = self.given + np.where(self.still, self.mass * self.rigid_velocity, 0.0)
        impulse, self.rigid_velocity = self.factor.solve(-force, load, self.held)
        return impulse, self.rigid_velocity
