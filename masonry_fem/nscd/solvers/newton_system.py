"""NewtonSystem: the linear system of one Newton step in split form, with all that can go eliminated.

With A = ∂F/∂p, Bc = ∂F/∂v of the Alart–Curnier function and α w the proximal weight:

    [ A + Bc (W_el + α w)   Bc B ] [dp]     [ F                         ]
    [ Bᵀ                    −M   ] [dU] = − [ Bᵀ p + f_r − M_r (U − U_0) ]

Open contacts leave it exactly (dp = −p); the caller moves them to the right-hand side. Contacts without
compliance are eliminated one by one, and what is left of them couples the velocities of their two
bodies: rigid scenes are solved in U alone.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from masonry_fem.nscd.linear import Factorised, Library, Solve, factorise, library_for
from masonry_fem.nscd.problem import ContactProblem
from masonry_fem.nscd.solvers.body_matrix import BodyMatrix
from masonry_fem.nscd.solvers.body_solver import BodySolver
from masonry_fem.nscd.solvers.matrix_entries import MatrixEntries, MatrixPattern

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
Mask = NDArray[np.bool_]


class NewtonSystem:
    """What does not change between the Newton steps of one problem.

    Parameters
    ----------
    problem : The contact problem.
    scale : w of each contact, shape (c,).
    library : Linear factor, see ``linear``.
    """

    def __init__(self, problem: ContactProblem, scale: FloatArray, library: Library = "auto") -> None:
        self.problem = problem
        self.scale = scale
        self.library = library
        self.unit = float(scale.mean()) if len(scale) else 1.0  # impulses are solved for as unit · p
        compliance = problem.compliance
        self.rows = block_rows(compliance)
        self.elastic = np.zeros(problem.count, dtype=bool)
        self.elastic[self.rows] = True
        self.contact, self.side = np.nonzero(problem.bodies >= 0)
        self.body = problem.bodies[self.contact, self.side]
        self.map = problem.rigid_map[self.contact, self.side]
        total = np.zeros_like(problem.rigid_mass)
        np.add.at(total, self.body, (self.map**2).sum(axis=1))
        self.column = np.sqrt(np.where(total > 0, total, 1.0))  # lengths of the columns of B, (b, m)
        self.scaled_map = self.map / self.column[self.body][:, None, :]
        self._pattern: MatrixPattern | None = None  # of the last matrix with elastic contacts

    @cached_property
    def body_matrix(self) -> BodyMatrix:
        """Pattern of the bodies' rows and columns."""
        problem = self.problem
        scaled = np.zeros_like(problem.rigid_map)
        scaled[self.contact, self.side] = self.scaled_map
        return BodyMatrix(problem.bodies, scaled, problem.body_count)

    @cached_property
    def body_solver(self) -> BodySolver:
        """What solves the bodies' matrix where no contact is left beside it."""
        return BodySolver(self.body_matrix, self.library)

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
        """The factor of one Newton step; it may be used for several right-hand sides.

        Parameters
        ----------
        own : D, derivative of the contact function by the contact's own impulse, in velocities,
            shape (c, d, d).
        by_velocity : Its derivative by the velocity, shape (c, d, d).
        closed : Contacts that take part; the others keep their impulses, shape (c,).
        plain : Contacts whose ``by_velocity`` is the identity, shape (c,).
        mass : M with the proximal mass, shape (b, m).
        own_inverse : D⁻¹ of contacts without compliance, where the caller has it more exactly.
        root : R with D⁻¹ = R Rᵀ, likewise, and better: products in two steps keep what is small in D⁻¹.
        stiffness : S of cohesion where D is the derivative by p̃ = p + S v and ``by_velocity`` that at fixed
            p̃, shape (c, d, d).
        """
        kept = np.flatnonzero(closed & self.elastic)
        gone = np.flatnonzero(closed & ~self.elastic)
        inverse, factors = _inverse(own[gone], own_inverse, root, gone)
        slope = inverse @ by_velocity[gone]
        springs = None if stiffness is None else stiffness[gone]
        if springs is not None:
            slope = slope + springs
        diagonal = self.unit * mass / self.column**2
        if not len(kept):
            solve = self.body_solver.solver(self.unit * slope, gone, diagonal, self._bodies_factorised)
            return NewtonFactor(self, kept, gone, factors, by_velocity[gone], own, solve, springs)
        coupled = self.body_matrix.assemble(-self.unit * slope, gone, -diagonal)
        total, same = by_velocity, plain
        if stiffness is not None:
            total, same = by_velocity + own @ stiffness, plain & ~stiffness.any(axis=(1, 2))
        entries = self._entries(own, total, same, kept, coupled)
        if self._pattern is None or not self._pattern.fits(kept, coupled):
            self._pattern = MatrixPattern(kept, coupled, entries)
        solve = self._pattern.factorise(entries, self.library)
        return NewtonFactor(self, kept, gone, factors, by_velocity[gone], own, solve, springs)

    def _bodies_factorised(self, blocks: sparse.bsr_array) -> Solve:
        """The factor's solver of a matrix of the bodies alone."""
        library = library_for(blocks.shape[0], self.library, fills=self.body_solver.cost.fills)
        return factorise(blocks.tocsr(), library)

    def _entries(
        self,
        own: FloatArray,
        by_velocity: FloatArray,
        plain: Mask,
        kept: IntArray,
        coupled: sparse.bsr_array,
    ) -> MatrixEntries:
        """Rows of elastic contacts, and below them those of the bodies."""
        d, m = self.problem.dimension, coupled.blocksize[0]
        first = len(kept) * d
        entries = MatrixEntries(first + coupled.shape[0])
        place = np.full(self.problem.count, -1)
        place[kept] = np.arange(len(kept))
        compliance = self.problem.compliance
        inside = (place[self.rows] >= 0) & (place[compliance.indices] >= 0)
        rows, columns = self.rows[inside], compliance.indices[inside]
        blocks = compliance.data[inside] / self.unit
        turned = np.flatnonzero(~plain[rows])
        blocks[turned] = by_velocity[rows[turned]] @ blocks[turned]
        diagonal = np.flatnonzero(rows == columns)
        blocks[diagonal] += own[rows[diagonal]] / self.unit
        entries.add(d * place[rows], d * place[columns], blocks)
        alone = np.setdiff1d(kept, rows[diagonal], assume_unique=True)  # coupled to others only
        entries.add(d * place[alone], d * place[alone], own[alone] / self.unit)
        sides = np.flatnonzero(place[self.contact] >= 0)
        at, body, map_ = place[self.contact[sides]], self.body[sides], self.scaled_map[sides]
        entries.add(d * at, first + m * body, by_velocity[self.contact[sides]] @ map_)
        entries.add(first + m * body, d * at, map_.transpose(0, 2, 1))
        entries.add(
            first + m * block_rows(coupled), first + m * coupled.indices.astype(np.int64), coupled.data
        )
        return entries


class NewtonFactor:
    """A factorised Newton step.

    solve(force, balance) gives (dp, dU) with

        D (dp + S dv − given) + Bc dv = −force,    dv = W_el dp + B dU,    Bᵀ dp − M dU = −balance

    Parameters
    ----------
    system : The problem's matrices.
    kept, gone : Contacts that are unknowns, and those that were solved for within their own rows.
    inverse : Matrices whose product is D⁻¹ of those that are gone.
    by_velocity : Bc of the g that are gone, derivative of the contact function by velocities, (g, d, d).
    own : D, the derivative by impulses, shape (c, d, d).
    answer : Solves with the factor.
    stiffness : S of the contacts that are gone; None where no joint coheres.
    """

    def __init__(
        self,
        system: NewtonSystem,
        kept: IntArray,
        gone: IntArray,
        inverse: tuple[FloatArray, ...],
        by_velocity: FloatArray,
        own: FloatArray,
        answer: Solve,
        stiffness: FloatArray | None = None,
    ) -> None:
        self.stiffness = stiffness  # of the contacts that are gone
        self.system, self.kept, self.gone = system, kept, gone
        self.inverse, self.by_velocity, self.own, self.answer = inverse, by_velocity, own, answer

    def solve(
        self, force: FloatArray, balance: FloatArray, given: FloatArray | None = None
    ) -> tuple[FloatArray, FloatArray]:
        """(dp, dU), shapes (c, d) and (b, m); dp = 0 where contacts take no part.

        Parameters
        ----------
        force : Contact function in velocities, shape (c, d).
        balance : Bᵀ p + f_r − M (U − centre), shape (b, m).
        given : Part of dp known beforehand, kept apart from ``force`` because D may be nearly singular,
            shape (c, d).
        """
        system, kept, gone = self.system, self.kept, self.gone
        problem, count, d = system.problem, len(self.kept), force.shape[1]
        missing = force[gone]
        step = np.zeros_like(force)
        step[gone] = -self._inverted(missing)
        if given is not None:
            step[gone] += given[gone]
            force = force - (self.own @ given[:, :, None])[:, :, 0]
        balance = balance + problem.body_impulse(step)
        rhs = np.concatenate([-force[kept].ravel(), (-system.unit * balance / system.column).ravel()])
        answer = self.answer(rhs)
        step[kept] = answer[: count * d].reshape(count, d) / system.unit
        motion = answer[count * d :].reshape(balance.shape) / system.column
        moved = problem.contact_velocity(motion)[gone]
        # what D⁻¹ is applied to is small where D⁻¹ is large: first the sum, then the product
        missing = missing + (self.by_velocity @ moved[:, :, None])[:, :, 0]
        step[gone] = -self._inverted(missing)
        if self.stiffness is not None:
            step[gone] -= (self.stiffness @ moved[:, :, None])[:, :, 0]
        if given is not None:
            step[gone] += given[gone]
        return step, motion

    def sign(self) -> int:
        """Sign of the determinant up to one that all factors of a problem share; 0 where unknown."""
        return self.answer.sign() if isinstance(self.answer, Factorised) else 0

    def _inverted(self, force: FloatArray) -> FloatArray:
        """D⁻¹ force at contacts without compliance."""
        for part in self.inverse:
            force = (part @ force[:, :, None])[:, :, 0]
        return force


def _inverse(
    own: FloatArray, own_inverse: FloatArray | None, root: FloatArray | None, gone: IntArray
) -> tuple[FloatArray, tuple[FloatArray, ...]]:
    """D⁻¹ of some contacts, and the factors to apply it by, first to last."""
    if root is not None:
        first, last = root[gone].transpose(0, 2, 1), root[gone]
        return last @ first, (first, last)
    inverse = np.linalg.inv(own) if own_inverse is None else own_inverse[gone]
    return inverse, (inverse,)


def block_rows(matrix: sparse.bsr_array) -> IntArray:
    """Block row of each stored block, shape (stored,)."""
    rows: IntArray = np.repeat(np.arange(len(matrix.indptr) - 1, dtype=np.int64), np.diff(matrix.indptr))
    return rows
