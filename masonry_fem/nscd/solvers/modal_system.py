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
from scipy import sparse

from masonry_fem.nscd.linear import Library, Solve, factorise
from masonry_fem.nscd.mumps import Mumps, petsc
from masonry_fem.nscd.problem import ContactProblem
from masonry_fem.nscd.products import inverted, multiplied
from masonry_fem.nscd.solvers.newton_system import NewtonFactor, NewtonSystem

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
Mask = NDArray[np.bool_]


# Changes up to which the last factor is good enough for a Newton step: of a contact's slope, relative to it,
# and of an entry of B, over the largest.
SLOPE, TURN = 0.1, 1e-3


@dataclass(frozen=True, slots=True)
class Eliminated:
    """The last matrix of bodies, and what it was made of.

    Attributes
    ----------
    matrix, order : The matrix, and its factor's order of elimination. solve : With this factor.
    contacts : Those in it, shape (k,). slope : S of these, shape (k, d, d).
    diagonal : What it starts from, shape (b, m). rigid_map : B, shape (c, 2, d, m).
    """

    matrix: sparse.csr_array
    order: Mumps
    solve: Solve
    contacts: IntArray
    slope: FloatArray
    diagonal: FloatArray
    rigid_map: FloatArray

    def serves(
        self, slope: FloatArray, contacts: IntArray, diagonal: FloatArray, rigid_map: FloatArray
    ) -> bool:
        """Whether it is near enough to the matrix of these, as they are held."""
        if not np.array_equal(contacts, self.contacts) or rigid_map.shape != self.rigid_map.shape:
            return False
        turned = 0.0 if rigid_map is self.rigid_map else np.abs(rigid_map - self.rigid_map).max(initial=0.0)
        if turned > TURN * np.abs(self.rigid_map).max(initial=0.0):
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
    def iterates(self) -> bool:
        return False

    @property
    @override
    def many(self) -> bool:
        return False

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
        total = by_velocity if stiffness is None else by_velocity + multiplied(own, stiffness)
        slope_of = total[gone]
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
        last, rigid_map = self.structure.bodies, self.problem.rigid_map
        if last is not None and last.serves(slope, contacts, diagonal, rigid_map):
            return last.solve
        matrix = self.body_matrix.assemble(-slope, contacts, -diagonal).tocsr()
        order = last.order if last is not None and _alike(matrix, last.matrix) else Mumps(matrix)
        solve = factorise(matrix, "mumps", order).bare  # Newton's next step refines
        self.structure.bodies = Eliminated(matrix, order, solve, contacts, slope, diagonal, rigid_map)
        return solve


def _alike(one: sparse.csr_array, other: sparse.csr_array) -> bool:
    """Whether two matrices have one pattern."""
    return np.array_equal(one.indptr, other.indptr) and np.array_equal(one.indices, other.indices)
