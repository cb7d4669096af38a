"""ModalSystem: the linear system of a Newton step whose contacts give way by themselves only.

D is the bed of a contact, W_el = D: each contact is eliminated within its own rows as rigid ones are, with
the derivative A + Bc (D + α w) by its impulse, and what is left is a matrix of the bodies' velocities, modes
of deformation among them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import override

import numpy as np
from numpy.typing import NDArray

from masonry_fem.nscd.linear import Library, Solve, factorise
from masonry_fem.nscd.mumps import Mumps, petsc
from masonry_fem.nscd.problem import ContactProblem
from masonry_fem.nscd.products import inverted, multiplied
from masonry_fem.nscd.solvers.body_matrix import BodyMatrix, BodyPattern
from masonry_fem.nscd.solvers.elastic_krylov import are_many, at_rest
from masonry_fem.nscd.solvers.newton_system import NewtonFactor, NewtonSystem

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
Mask = NDArray[np.bool_]


# Changes up to which the last factor is good enough for a Newton step: of a contact's slope, relative to it,
# and of an entry of B, whose columns are scaled to length one.
SLOPE, TURN = 0.1, 1e-3


@dataclass(frozen=True, slots=True)
class Eliminated:
    """The last matrix of bodies, and what it was made of.

    Attributes
    ----------
    pattern : Where its blocks stand. order : Its factor's order of elimination. solve : With this factor.
    contacts : Those in it, shape (k,). slope : S of these, shape (k, d, d).
    diagonal : What it starts from, shape (b, m). maps : B as its columns are scaled, shape (c, 2, d, m).
    """

    pattern: BodyPattern
    order: Mumps
    solve: Solve
    contacts: IntArray
    slope: FloatArray
    diagonal: FloatArray
    maps: FloatArray

    def serves(self, matrix: BodyMatrix, slope: FloatArray, contacts: IntArray, diagonal: FloatArray) -> bool:
        """Whether it is near enough to the matrix of these, as they are held."""
        if matrix.pattern is not self.pattern or not np.array_equal(contacts, self.contacts):
            return False
        if np.abs(matrix.maps - self.maps).max(initial=0.0) > TURN:
            return False
        changed, size = (np.einsum("kij,kij->k", one, one) for one in (slope - self.slope, self.slope))
        same = (changed <= SLOPE**2 * size).all()
        return bool(same and (np.abs(diagonal - self.diagonal) <= SLOPE * self.diagonal).all())


class ModalSystem(NewtonSystem):
    """What does not change between the Newton steps of one problem.

    Parameters
    ----------
    problem, scale, library : As for ``NewtonSystem``; W_el has blocks on its diagonal only.
    """

    def __init__(self, problem: ContactProblem, scale: FloatArray, library: Library = "auto") -> None:
        super().__init__(problem, scale, library)
        self._bed = problem.operator.diagonal()

    @property
    @override
    def many(self) -> bool:
        return at_rest(self.problem) and are_many(self.problem, self.library)

    @override
    def factor(
        self,
        own: FloatArray,
        by_velocity: FloatArray,
        closed: Mask,
        plain: Mask,
        mass: FloatArray,
        own_inverse: FloatArray | None = None,
        root: FloatArray | None = None,
        stiffness: FloatArray | None = None,
    ) -> NewtonFactor:
        gone = np.flatnonzero(closed)
        slope_of = by_velocity[gone]
        inverse = inverted(own[gone] + multiplied(slope_of, self._bed[gone]))
        diagonal = self.unit * mass / self.column**2
        slope = self.unit * multiplied(inverse, slope_of)
        return NewtonFactor(
            self, gone[:0], gone, (inverse,), slope_of, own, self._solver(slope, gone, diagonal)
        )

    def _solver(self, slope: FloatArray, contacts: IntArray, diagonal: FloatArray) -> Solve:
        """Solves with the bodies' matrix: its pattern stays from step to step, and so does MUMPS's plan."""
        if self.library != "auto" or petsc() is None:
            return self.body_solver.solver(slope, contacts, diagonal, self._bodies_factorised)
        last, bodies = self.structure.bodies, self.body_matrix
        if last is not None and last.serves(bodies, slope, contacts, diagonal):
            return last.solve
        matrix = bodies.assemble(-slope, contacts, -diagonal).tocsr()
        order = last.order if last is not None and last.pattern is bodies.pattern else Mumps(matrix)
        solve = factorise(matrix, "mumps", order).bare  # Newton's next step refines
        made = Eliminated(bodies.pattern, order, solve, contacts, slope, diagonal, bodies.maps)
        self.structure.bodies = made
        return solve
