"""ProximalStep: impulses and velocities under the laws of motion alone, held near a target by D.

    W_el x + q' + B U + D (x − t) = 0,    Bᵀ x + f_r − M (U − U_0) = 0

D is one number a contact. Rigid blocks leave a system of the size of their velocities.

    step = factorised(problem, scale)      # or iterated(problem, scale): products only
    step.weigh(weight)                     # D, (c,)
    x, U = step.solve(force)               # force = D t − q', (c, d)
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from masonry_fem.errors import ProblemError
from masonry_fem.nscd.linear import Library
from masonry_fem.nscd.problem import ContactProblem
from masonry_fem.nscd.scaling import diagonal_blocks, rigid_diagonal
from masonry_fem.nscd.solvers.conjugate import conjugate
from masonry_fem.nscd.solvers.newton_system import NewtonFactor, NewtonSystem

FloatArray = NDArray[np.float64]

# Mass that bodies without inertia get, relative to what their contacts give them; it is proximal: it
# holds them where the last step left them, and not where they were before the load.
PROXIMAL_MASS = 1e-7


class ProximalStep(Protocol):
    """The linear half of ADMM on one problem."""

    factorisations: int
    rigid_velocity: FloatArray

    def weigh(self, weight: FloatArray) -> None:
        """Take D, shape (c,)."""
        ...

    def solve(self, force: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The x (c, d) and U (b, m) of ``force`` = D t − q'."""
        ...


def factorised(problem: ContactProblem, scale: FloatArray, library: Library = "auto") -> ProximalStep:
    """A step that factorises whenever D changes."""
    system = NewtonSystem(problem, scale, library)
    return _RigidFactor(problem, system) if _all_rigid(problem) else _MixedFactor(problem, system)


def iterated(problem: ContactProblem, accuracy: float) -> ProximalStep:
    """A step by conjugate gradients, with nothing but products: what can be distributed.

    ``accuracy`` is the share of its residual that each solution leaves of the last one's.
    """
    if _all_rigid(problem):
        return _RigidProducts(problem, accuracy)
    if (problem.rigid_mass <= 0).any():
        body = int(np.argwhere(problem.rigid_mass <= 0)[0][0])
        raise ProblemError(
            f"body {body} has no rigid mass (statics) beside elastic contacts, which ADMM cannot solve by "
            "products alone; leave it its factorisation, or use a dynamic step"
        )
    return _PlainProducts(problem, accuracy)


def _all_rigid(problem: ContactProblem) -> bool:
    return problem.rigid and problem.body_count > 0


class _Balance:
    """Loads, masses and proximal masses of the bodies."""

    def __init__(self, problem: ContactProblem) -> None:
        self.problem = problem
        self.still = problem.rigid_mass <= 0
        self.given = problem.rigid_impulse + problem.rigid_mass * problem.rigid_velocity
        self.rigid_velocity = problem.rigid_velocity.copy()
        sides = np.zeros_like(problem.rigid_mass)
        present = problem.bodies >= 0
        np.add.at(sides, problem.bodies[present], (problem.rigid_map[present] ** 2).sum(axis=1))
        self.square = np.where(sides > 0, sides, 1.0)  # squared lengths of the columns of B
        self.factorisations = 0
        self.weight = np.ones(problem.count)
        self.mass = problem.rigid_mass

    def weigh(self, weight: FloatArray) -> None:
        self.weight = weight
        proximal = PROXIMAL_MASS * self.square / weight.mean()
        self.mass = np.where(self.still, proximal, self.problem.rigid_mass)

    def load(self) -> FloatArray:
        """Right-hand side of the balance, (b, m)."""
        return self.given + np.where(self.still, self.mass * self.rigid_velocity, 0.0)


class _MixedFactor(_Balance):
    """Elastic blocks, or both kinds: by the factor of a Newton step."""

    factor: NewtonFactor

    def __init__(self, problem: ContactProblem, system: NewtonSystem) -> None:
        super().__init__(problem)
        self.system = system

    def weigh(self, weight: FloatArray) -> None:
        super().weigh(weight)
        c, d = self.problem.free_velocity.shape
        identity = np.tile(np.eye(d), (c, 1, 1))
        every = np.ones(c, dtype=bool)
        with np.errstate(all="ignore"):  # a breakdown is seen in the solution
            own = weight[:, None, None] * identity
            self.factor = self.system.factor(own, identity, every, every, self.mass)
        self.factorisations += 1

    def solve(self, force: FloatArray) -> tuple[FloatArray, FloatArray]:
        impulse, self.rigid_velocity = self.factor.solve(-force, self.load())
        return impulse, self.rigid_velocity


class _Maps:
    """B and Bᵀ as sparse matrices: their products cost a third of those by contact and side."""

    def __init__(self, problem: ContactProblem) -> None:
        self.matrix = problem.rigid_matrix().tocsr()
        self.transposed = self.matrix.T.tocsr()

    def velocity(self, rigid_velocity: FloatArray) -> FloatArray:
        moved: FloatArray = self.matrix @ rigid_velocity.ravel()
        return moved

    def impulse(self, impulse: FloatArray) -> FloatArray:
        given: FloatArray = self.transposed @ impulse.ravel()
        return given


class _RigidFactor(_MixedFactor):
    """Rigid blocks only: (M + Bᵀ D⁻¹ B) U = f + Bᵀ D⁻¹ force, x = D⁻¹ (force − B U)."""

    def __init__(self, problem: ContactProblem, system: NewtonSystem) -> None:
        super().__init__(problem, system)
        self.maps = _Maps(problem)

    def solve(self, force: FloatArray) -> tuple[FloatArray, FloatArray]:
        system, load = self.system, self.load()
        target = force / self.weight[:, None]
        pull = load + self.maps.impulse(target).reshape(load.shape)
        answer = self.factor.answer((-system.unit * pull / system.column).ravel())
        self.rigid_velocity = answer.reshape(load.shape) / system.column
        moved = self.maps.velocity(self.rigid_velocity).reshape(force.shape)
        return target - moved / self.weight[:, None], self.rigid_velocity


class _RigidProducts(_Balance):
    """The same by conjugate gradients, preconditioned by the blocks of the bodies."""

    def __init__(self, problem: ContactProblem, accuracy: float) -> None:
        super().__init__(problem)
        self.accuracy, self.maps = accuracy, _Maps(problem)

    def weigh(self, weight: FloatArray) -> None:
        super().weigh(weight)
        sides = self.problem.rigid_map
        own = (sides / weight[:, None, None, None]).swapaxes(2, 3) @ sides
        b, m = self.mass.shape
        blocks = np.zeros((b, m, m))
        present = self.problem.bodies >= 0
        np.add.at(blocks, self.problem.bodies[present], own[present])
        blocks[:, np.arange(m), np.arange(m)] += np.where(self.mass > 0, self.mass, 1.0)
        self.inverse = np.linalg.inv(blocks)
        self.thrice = np.repeat(1.0 / weight, self.problem.dimension)

    def solve(self, force: FloatArray) -> tuple[FloatArray, FloatArray]:
        load = self.load()
        target = force / self.weight[:, None]
        pull = load.ravel() + self.maps.impulse(target)
        answer, _ = conjugate(
            self._product, self._precondition, pull, self.rigid_velocity.ravel(), self.accuracy
        )
        self.rigid_velocity = answer.reshape(load.shape)
        moved = self.maps.velocity(self.rigid_velocity).reshape(force.shape)
        return target - moved / self.weight[:, None], self.rigid_velocity

    def _product(self, motion: FloatArray) -> FloatArray:
        given = self.maps.impulse(self.thrice * self.maps.velocity(motion))
        total: FloatArray = self.mass.ravel() * motion + given
        return total

    def _precondition(self, residual: FloatArray) -> FloatArray:
        blocks = self.inverse @ residual.reshape(self.mass.shape)[:, :, None]
        return blocks.ravel()


class _PlainProducts(_Balance):
    """Any problem with inertia: (W + D) x = force − B U_free, by conjugate gradients."""

    def __init__(self, problem: ContactProblem, accuracy: float) -> None:
        super().__init__(problem)
        self.accuracy = accuracy
        self.own = diagonal_blocks(problem.compliance, problem.count, problem.dimension)
        if problem.body_count:
            self.own += rigid_diagonal(problem)
        self.impulse = np.zeros_like(problem.free_velocity)
        self.offset = problem.contact_velocity(problem.free_rigid_velocity())

    def weigh(self, weight: FloatArray) -> None:
        super().weigh(weight)
        self.inverse = np.linalg.inv(self.own + weight[:, None, None] * np.eye(self.problem.dimension))

    def solve(self, force: FloatArray) -> tuple[FloatArray, FloatArray]:
        answer, _ = conjugate(
            self._product, self._precondition, (force - self.offset).ravel(), self.impulse.ravel(),
            self.accuracy,
        )  # fmt: skip
        self.impulse = answer.reshape(force.shape)
        self.rigid_velocity = self.problem.balanced_velocity(self.impulse)
        return self.impulse, self.rigid_velocity

    def _product(self, flat: FloatArray) -> FloatArray:
        problem = self.problem
        impulse = flat.reshape(self.impulse.shape)
        velocity = problem.elastic_velocity(impulse) + self.weight[:, None] * impulse
        if problem.body_count:
            velocity += problem.contact_velocity(problem.body_impulse(impulse) / problem.rigid_mass)
        return velocity.ravel()

    def _precondition(self, residual: FloatArray) -> FloatArray:
        blocks = self.inverse @ residual.reshape(self.impulse.shape)[:, :, None]
        return blocks.ravel()
