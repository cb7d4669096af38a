"""NewtonSystem: the linear system of one Newton step in split form, with all that can go eliminated.

With A = ∂F/∂p, Bc = ∂F/∂v of the Alart–Curnier function and α w the proximal weight:

    [ A + Bc (W_el + α w)   Bc B ] [dp]     [ F                         ]
    [ Bᵀ                    −M   ] [dU] = − [ Bᵀ p + f_r − M_r (U − U_0) ]

Open contacts leave it exactly (dp = −p); the caller moves them to the right-hand side. Contacts without
compliance are eliminated one by one, and what is left of them couples the velocities of their two
bodies: rigid scenes are solved in U alone.
"""

from __future__ import annotations

import logging
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from masonry_fem.nscd.krylov import StagnationError
from masonry_fem.nscd.linear import Factorised, Library, Solve, factorise, library_for
from masonry_fem.nscd.problem import ContactProblem
from masonry_fem.nscd.products import applied, inverted, multiplied
from masonry_fem.nscd.solvers.body_matrix import BodyMatrix, BodyPattern
from masonry_fem.nscd.solvers.body_solver import BodySolver
from masonry_fem.nscd.solvers.elastic_krylov import Undivided, are_many, at_rest, iterable
from masonry_fem.nscd.solvers.elastic_matrix import ElasticMatrix, Terms
from masonry_fem.nscd.structure import Structure

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
Mask = NDArray[np.bool_]

logger = logging.getLogger(__name__)


class NewtonSystem:
    """What does not change between the Newton steps of one problem.

    Parameters
    ----------
    problem : The contact problem.
    scale : w of each contact, shape (c,).
    library : Linear factor, see ``linear``.
    """

    def __init__(self, problem: ContactProblem, scale: FloatArray, library: Library = "auto") -> None:
        from masonry_fem.nscd.transfer import column_squares  # noqa: PLC0415 - Numba is slow to import

        self.problem = problem
        self.scale = scale
        self.library = library
        count = problem.whole_count  # impulses are solved for as unit · p
        self.unit = float(problem.summed(scale.sum(keepdims=True))[0] / count) if count else 1.0
        self.elastic = problem.operator.elastic()
        total = problem.summed(column_squares(problem.bodies, problem.rigid_map, problem.body_count))
        self.column = np.sqrt(np.where(total > 0, total, 1.0))  # lengths of the columns of B, (b, m)
        self.structure = Structure() if problem.structure is None else problem.structure

    @cached_property
    def body_matrix(self) -> BodyMatrix:
        """The bodies' rows and columns."""
        problem, pattern = self.problem, self.structure.pattern
        if pattern is None or not pattern.serves(problem.bodies, problem.body_count):
            pattern = self.structure.pattern = BodyPattern(problem.bodies, problem.body_count)
        return BodyMatrix(pattern, problem.rigid_map, self.column)

    @property
    def iterates(self) -> bool:
        """True where steps with elastic contacts are solved by iteration in place of a factor."""
        return self._iterable and not self.structure.factored

    @property
    def many(self) -> bool:
        """True for many elastic contacts in statics, which Newton's method goes about in other ways."""
        return self._iterable and at_rest(self.problem) and are_many(self.problem, self.library)

    @cached_property
    def _iterable(self) -> bool:
        """True for as many elastic contacts as iterations are worth a try for."""
        return iterable(self.problem, self.library)

    @cached_property
    def interfaces(self) -> Undivided:
        """Elastic contacts as the iteration's preconditioner sorts them."""
        return Undivided(self.problem, self.elastic, self.scale)

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
        slope = multiplied(inverse, by_velocity[gone])
        springs = None if stiffness is None else stiffness[gone]
        if springs is not None:
            slope = slope + springs
        diagonal = self.unit * mass / self.column**2
        if not self._coupled(kept):
            solve = self.body_solver.solver(self.unit * slope, gone, diagonal, self._bodies_factorised)
            return NewtonFactor(self, kept, gone, factors, by_velocity[gone], own, solve, springs)
        coupled = self.body_matrix.assemble(-self.unit * slope, gone, -diagonal)
        total, same = by_velocity, plain
        if stiffness is not None:
            total, same = by_velocity + multiplied(own, stiffness), plain & ~stiffness.any(axis=(1, 2))
        self.structure.factor = None  # two at a time would take twice the memory
        terms = Terms(own, total, same, closed, self.body_matrix, coupled, self.unit)
        parts = (self, kept, gone, factors, by_velocity[gone], own)
        if self.iterates:
            return NewtonFactor(*parts, self._iteration(kept, terms), springs, kept, terms)
        matrix = self._matrix(kept, coupled)
        solve = matrix.factorise(self.problem, terms, self.library)
        made = NewtonFactor(*parts, solve, springs, matrix.contacts, terms)
        self.structure.factor = made
        return made

    def _coupled(self, kept: IntArray) -> bool:
        """Whether contacts that are unknowns are left."""
        return bool(len(kept))

    def _iteration(self, kept: IntArray, terms: Terms) -> Solve:
        """Solves by iteration, and by a factor from where that fails."""
        quick = self.interfaces.solver(terms, kept, self.body_matrix, self._bodies_factorised)
        factor: Solve | None = None

        def solve(rhs: FloatArray) -> FloatArray:
            nonlocal factor
            if factor is None:
                try:
                    return quick(rhs)
                except StagnationError as failure:
                    logger.info("iteration of a Newton step failed (%s); factors follow", failure)
                    self.structure.factored = True
                    matrix = ElasticMatrix(self.problem, kept, terms.coupled)
                    factor = matrix.factorise(self.problem, terms, "direct")
            return factor(rhs)

        return solve

    def _matrix(self, kept: IntArray, coupled: sparse.bsr_array) -> ElasticMatrix:
        """One with rows for these contacts."""
        last = self.structure.matrix
        if last is None:
            made = ElasticMatrix(self.problem, kept, coupled)
        elif last.serves(self.problem, kept):
            return last
        else:
            made = last.widened(self.problem, kept, coupled)
        self.structure.matrix = made
        return made

    def _bodies_factorised(self, blocks: sparse.bsr_array) -> Factorised:
        """The factor of a matrix of the bodies alone."""
        return factorise(blocks.tocsr(), self._library_of_bodies(blocks.shape[0]))

    def _library_of_bodies(self, size: int) -> Library:
        """The factor of a matrix of the bodies alone."""
        return library_for(size, self.library, fills=self.body_solver.cost.fills)


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
    rows : Contacts that have rows in the matrix, those that are kept among them; None: no others.
    terms : What the matrix was made of; None where no contact is kept.
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
        rows: IntArray | None = None,
        terms: Terms | None = None,
    ) -> None:
        self.rows, self.terms = kept if rows is None else rows, terms
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
        problem, rows = system.problem, self.rows
        missing = force[gone]
        step = np.zeros_like(force)
        step[gone] = -self._inverted(missing)
        if given is not None:
            step[gone] += given[gone]
            force = force - applied(self.own, given)
        if problem.any(gone >= 0):
            balance = balance + problem.body_impulse(step)
        asked = np.zeros_like(force)
        asked[kept] = -force[kept]
        rhs = np.concatenate([asked[rows].ravel(), (-system.unit * balance / system.column).ravel()])
        answer = self.answer(rhs)
        contacts, bodies = np.split(answer, [rows.size * force.shape[1]])
        contacts = contacts.reshape(-1, force.shape[1]) / system.unit
        step[kept] = contacts if rows is kept else contacts[np.searchsorted(rows, kept)]
        motion = bodies.reshape(balance.shape) / system.column
        if not len(gone):
            return step, motion
        moved = problem.contact_velocity(motion)[gone]
        # what D⁻¹ is applied to is small where D⁻¹ is large: first the sum, then the product
        missing = missing + applied(self.by_velocity, moved)
        step[gone] = -self._inverted(missing)
        if self.stiffness is not None:
            step[gone] -= applied(self.stiffness, moved)
        if given is not None:
            step[gone] += given[gone]
        return step, motion

    def sign(self) -> int:
        """Sign of the determinant up to one that all factors of a problem share; 0 where unknown."""
        return self.answer.sign() if isinstance(self.answer, Factorised) else 0

    def _inverted(self, force: FloatArray) -> FloatArray:
        """D⁻¹ force at contacts without compliance."""
        for part in self.inverse:
            force = applied(part, force)
        return force


def _inverse(
    own: FloatArray, own_inverse: FloatArray | None, root: FloatArray | None, gone: IntArray
) -> tuple[FloatArray, tuple[FloatArray, ...]]:
    """D⁻¹ of some contacts, and the factors to apply it by, first to last."""
    if root is not None:
        first, last = root[gone].transpose(0, 2, 1), root[gone]
        return multiplied(last, first), (first, last)
    inverse = inverted(own) if own_inverse is None else own_inverse[gone]
    return inverse, (inverse,)
