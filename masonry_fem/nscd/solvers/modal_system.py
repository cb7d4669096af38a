"""ModalSystem: the linear system of a Newton step whose contacts give way by themselves only.

D is the bed of a contact, W_el = D: each contact is eliminated within its own rows as rigid ones are, with
the derivative A + Bc (D + α w) by its impulse, and what is left is a matrix of the bodies' velocities, modes
of deformation among them.
"""

from __future__ import annotations

from typing import override

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from masonry_fem.nscd.linear import Library, Solve, factorise
from masonry_fem.nscd.mumps import Mumps, petsc
from masonry_fem.nscd.problem import ContactProblem
from masonry_fem.nscd.products import multiplied
from masonry_fem.nscd.solvers.newton_system import NewtonFactor, NewtonSystem

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
Mask = NDArray[np.bool_]


class ModalSystem(NewtonSystem):
    """What does not change between the Newton steps of one problem.

    Parameters
    ----------
    problem, scale, library : As for ``NewtonSystem``; W_el has blocks on its diagonal only.
    """

    def __init__(self, problem: ContactProblem, scale: FloatArray, library: Library = "auto") -> None:
        super().__init__(problem, scale, library)
        self._bed = problem.operator.diagonal()

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
        inverse = np.linalg.inv(own[gone] + multiplied(slope_of, self._bed[gone]))
        diagonal = self.unit * mass / self.column**2
        slope = self.unit * multiplied(inverse, slope_of)
        return NewtonFactor(
            self, gone[:0], gone, (inverse,), slope_of, own, self._solver(slope, gone, diagonal)
        )

    def _solver(self, slope: FloatArray, contacts: IntArray, diagonal: FloatArray) -> Solve:
        """Solves with the bodies' matrix: its pattern stays from step to step, and so does MUMPS's plan."""
        if self.library != "auto" or petsc() is None:
            return self.body_solver.solver(slope, contacts, diagonal, self._bodies_factorised)
        matrix = -self.body_matrix.assemble(slope, contacts, diagonal).tocsr()
        last = self.structure.bodies
        if last is None or not _alike(matrix, last[0]):
            last = matrix, Mumps(matrix)
        self.structure.bodies = last
        return factorise(matrix, "mumps", last[1])


def _alike(one: sparse.csr_array, other: sparse.csr_array) -> bool:
    """Whether two matrices have one pattern."""
    return np.array_equal(one.indptr, other.indptr) and np.array_equal(one.indices, other.indices)
