"""ProximalStep: impulses and velocities under the laws of motion alone, held near a target by D.

    W_el x + q' + B U + D (x − t) = 0,    Bᵀ x + f_r − M (U − U_0) = 0

D is one number a contact. Rigid blocks leave a system of the size of their velocities. Where cohesion has
a stiffness S, it is x̃ = x + S v that D holds near t.

    step = factorised(problem, scale)      # or iterated(problem, scale): products only
    step.weigh(weight)                     # D, (c,)
    x, U = step.solve(force)               # force = D t − q', (c, d)
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from masonry_fem.nscd.linear import Library
from masonry_fem.nscd.problem import ContactProblem
from masonry_fem.nscd.scaling import diagonal_blocks
from masonry_fem.nscd.solvers.conjugate import conjugate
from masonry_fem.nscd.solvers.newton_system import NewtonFactor, NewtonSystem

FloatArray = NDArray[np.float64]

# Mass that bodies without inertia get, relative to what their contacts give them; it is proximal: it
# holds them where the last step left them, and not where they were before the load.
PROXIMAL_MASS = 1e-7
# What the inner iterations leave: the outer ones take them for exact.
INNER = 1e-12


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
    plain = _all_rigid(problem) and problem.cohesion_stiffness is None
    return _RigidFactor(problem, system) if plain else _MixedFactor(problem, system)


def iterated(problem: ContactProblem, accuracy: float) -> ProximalStep:
    """A step by conjugate gradients, with nothing but products: what can be distributed.

    ``accuracy`` is the share of its residual that each solution leaves of the last one's.
    """
    return _Products(problem, accuracy)


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
        free = problem.free_velocity
        # the part of −S v that x and U have nothing to do with
        self.held = -problem.contact_part(np.zeros_like(free), free) if problem.cohesive else None

    def weigh(self, weight: FloatArray) -> None:
        super().weigh(weight)
        c, d = self.problem.free_velocity.shape
        identity = np.tile(np.eye(d), (c, 1, 1))
        every = np.ones(c, dtype=bool)
        with np.errstate(all="ignore"):  # a breakdown is seen in the solution
            own = weight[:, None, None] * identity
            stiffness = self.problem.cohesion_stiffness
            self.factor = self.system.factor(own, identity, every, every, self.mass, stiffness=stiffness)
        self.factorisations += 1

    def solve(self, force: FloatArray) -> tuple[FloatArray, FloatArray]:
        impulse, self.rigid_velocity = self.factor.solve(-force, self.load(), self.held)
        return impulse, self.rigid_velocity


class _Maps:
    """B and Bᵀ as sparse matrices: their products cost a third of those by contact and side."""

    def __init__(self, problem: ContactProblem) -> None:
        rows, columns = problem.free_velocity.size, problem.rigid_mass.size
        self.matrix = (
            problem.rigid_matrix().tocsr() if columns else sparse.csr_array((rows, columns), dtype=float)
        )
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


class _Products(_Balance):
    """Products only: with A = W_el + D, (M + Bᵀ A⁻¹ B) U = f + Bᵀ A⁻¹ force by conjugate gradients.

    W is never condensed: its rigid part would drown the elastic one. Where blocks are elastic, A⁻¹ is
    an iteration within the iteration, a short one, because D keeps A well-conditioned.
    """

    def __init__(self, problem: ContactProblem, accuracy: float) -> None:
        super().__init__(problem)
        self.accuracy, self.maps = accuracy, _Maps(problem)
        self.own = diagonal_blocks(problem.compliance, problem.count, problem.dimension)
        self.impulse = np.zeros_like(problem.free_velocity)

    def weigh(self, weight: FloatArray) -> None:
        super().weigh(weight)
        problem = self.problem
        self.near = np.linalg.inv(self.own + weight[:, None, None] * np.eye(problem.dimension))
        maps = problem.rigid_map
        own = maps.swapaxes(2, 3) @ (self.near[:, None] @ maps)
        b, m = self.mass.shape
        blocks = np.zeros((b, m, m))
        present = problem.bodies >= 0
        np.add.at(blocks, problem.bodies[present], own[present])
        blocks[:, np.arange(m), np.arange(m)] += np.where(self.mass > 0, self.mass, 1.0)
        self.inverse = np.linalg.inv(blocks)

    def solve(self, force: FloatArray) -> tuple[FloatArray, FloatArray]:
        if not self.problem.body_count:
            self.impulse = self._spread(force, self.impulse, self.accuracy)
            return self.impulse, self.rigid_velocity
        pull = self.load().ravel() + self.maps.impulse(self._spread(force))
        answer, _ = conjugate(
            self._product, self._precondition, pull, self.rigid_velocity.ravel(), self.accuracy
        )
        self.rigid_velocity = answer.reshape(self.mass.shape)
        moved = self.maps.velocity(answer).reshape(force.shape)
        return self._spread(force - moved), self.rigid_velocity

    def _product(self, motion: FloatArray) -> FloatArray:
        """(M + Bᵀ A⁻¹ B) U."""
        moved = self.maps.velocity(motion).reshape(self.impulse.shape)
        total: FloatArray = self.mass.ravel() * motion + self.maps.impulse(self._spread(moved))
        return total

    def _precondition(self, residual: FloatArray) -> FloatArray:
        """By the blocks of the bodies."""
        blocks = self.inverse @ residual.reshape(self.mass.shape)[:, :, None]
        return blocks.ravel()

    def _spread(
        self, velocity: FloatArray, guess: FloatArray | None = None, accuracy: float = INNER
    ) -> FloatArray:
        """The impulses A⁻¹ v, (c, d)."""
        if self.problem.rigid:
            return velocity / self.weight[:, None]
        first = np.zeros_like(velocity) if guess is None else guess
        answer, _ = conjugate(
            self._resistance, self._precondition_own, velocity.ravel(), first.ravel(), accuracy
        )
        return answer.reshape(velocity.shape)

    def _resistance(self, flat: FloatArray) -> FloatArray:
        """A p."""
        impulse = flat.reshape(self.impulse.shape)
        velocity = self.problem.elastic_velocity(impulse) + self.weight[:, None] * impulse
        return velocity.ravel()

    def _precondition_own(self, residual: FloatArray) -> FloatArray:
        """By the contacts' own blocks."""
        blocks = self.near @ residual.reshape(self.impulse.shape)[:, :, None]
        return blocks.ravel()
