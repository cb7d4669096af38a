"""ProximalStep: impulses and velocities under the laws of motion alone, held near a target by D.

    W_el x + q' + B U + D (x − t) = 0,    Bᵀ x + f_r − M (U − U_0) = 0

D is one number a contact. Rigid blocks leave a system of the size of their velocities.

    step = ProximalStep(problem, scale)
    step.weigh(rho)                        # factorises
    x, U = step.solve(force)               # force = D t − q', (c, d)
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from masonry_fem.nscd.linear import Library
from masonry_fem.nscd.problem import ContactProblem
from masonry_fem.nscd.solvers.newton_system import NewtonFactor, NewtonSystem

FloatArray = NDArray[np.float64]

# Mass that bodies without inertia get, relative to what their contacts give them; it is proximal: it
# holds them where the last step left them, and not where they were before the load.
PROXIMAL_MASS = 1e-7


class ProximalStep:
    """The linear half of ADMM on one problem.

    Parameters
    ----------
    problem : The contact problem.
    scale : w of each contact, shape (c,).
    library : Linear factor, see ``linear``.
    """

    def __init__(self, problem: ContactProblem, scale: FloatArray, library: Library = "auto") -> None:
        self.problem, self.scale = problem, scale
        self.system = NewtonSystem(problem, scale, library)
        self.map = problem.rigid_matrix().tocsr() if problem.body_count else sparse.csr_array((0, 0))
        self.transposed = self.map.T.tocsr()
        self.still = problem.rigid_mass <= 0
        self.given = problem.rigid_impulse + problem.rigid_mass * problem.rigid_velocity
        self.rigid_velocity = problem.rigid_velocity.copy()
        self.factor: NewtonFactor

    def weigh(self, rho: float) -> FloatArray:
        """Take D = ρ w and factorise; D, shape (c,)."""
        c, d = self.problem.free_velocity.shape
        self.weight = rho * self.scale
        own = self.weight[:, None, None] * np.eye(d)
        every = np.ones(c, dtype=bool)
        self.mass = np.where(
            self.still, PROXIMAL_MASS * self.system.column**2 / self.weight.mean(), self.problem.rigid_mass
        )
        with np.errstate(all="ignore"):  # a breakdown is seen in the solution
            identity = np.tile(np.eye(d), (c, 1, 1))
            self.factor = self.system.factor(own, identity, every, every, self.mass)
        return self.weight

    def solve(self, force: FloatArray) -> tuple[FloatArray, FloatArray]:
        """X (c, d) and U (b, m) for ``force`` = D t − q'."""
        balance = self.given + np.where(self.still, self.mass * self.rigid_velocity, 0.0)
        if not self.problem.rigid or not self.problem.body_count:
            impulse, self.rigid_velocity = self.factor.solve(-force, balance)
            return impulse, self.rigid_velocity
        system = self.system
        target = force / self.weight[:, None]
        pull = balance + (self.transposed @ target.ravel()).reshape(balance.shape)
        answer = self.factor.answer((-system.unit * pull / system.column).ravel())
        self.rigid_velocity = answer.reshape(balance.shape) / system.column
        moved = (self.map @ self.rigid_velocity.ravel()).reshape(force.shape)
        return target - moved / self.weight[:, None], self.rigid_velocity
