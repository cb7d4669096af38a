"""ElasticMatrix: the matrix of a Newton step with elastic contacts: their rows, and below them the bodies'.

Its pattern is that of some contacts, and is kept with the factor's order of elimination while these are
enough: from step to step of Newton's method, and from problem to problem of one ``Structure``. Contacts
that are open have a row of their own then, with 1 on the diagonal and nothing beside it. Of stones with many
contacts that are all coupled there is no pattern: their matrix is dense, and only its factor is held.

    matrix = ElasticMatrix(problem, contacts, coupled)
    solve = matrix.factorise(values, "auto")
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from masonry_fem.nscd.blocks import block_rows
from masonry_fem.nscd.compliance import Shared
from masonry_fem.nscd.linear import Library, Solve, factorise, factorise_dense, library_for
from masonry_fem.nscd.mumps import Mumps
from masonry_fem.nscd.problem import ContactProblem
from masonry_fem.nscd.products import applied, multiplied
from masonry_fem.nscd.solvers.block_pattern import BlockPattern, Family
from masonry_fem.nscd.solvers.body_matrix import BodyMatrix

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
Mask = NDArray[np.bool_]

# Contacts of a matrix, over those that are closed, up to which it serves. Factors cost as the cube of the
# contacts of a block; a new pattern costs a third of a factor with some thousand rows, less of larger ones.
SPARE = 1.05
# Share of entries from which a matrix is a dense one, of a single block's contacts: MUMPS
# takes 240 MB for 2900 rows, the dense matrix is 67 MB.
FULL = 0.5
AT_ONCE = 200  # contacts whose rows are turned together


@dataclass(frozen=True, slots=True)
class Terms:
    """What a step has at each contact, and between bodies.

    Attributes
    ----------
    own : D, derivative by the contact's own impulse, shape (c, d, d).
    by_velocity : Derivative by its velocity, shape (c, d, d).
    plain : Contacts whose ``by_velocity`` is the identity, shape (c,).
    closed : Contacts that take part, shape (c,).
    body_matrix : What has B by contact and side.
    coupled : Matrix of the bodies.
    unit : Impulses are solved for as unit · p.
    """

    own: FloatArray
    by_velocity: FloatArray
    plain: Mask
    closed: Mask
    body_matrix: BodyMatrix
    coupled: sparse.bsr_array
    unit: float


class ElasticMatrix:
    """Where the entries of a matrix go, and the factor's order.

    Parameters
    ----------
    problem : Whose contacts are coupled.
    contacts : Those that have rows, ascending.
    coupled : Matrix of its bodies, of which the pattern counts.
    """

    def __init__(self, problem: ContactProblem, contacts: IntArray, coupled: sparse.bsr_array) -> None:
        d, m = problem.dimension, coupled.blocksize[0]
        self.contacts = contacts
        self.mumps: Mumps | None = None
        self._dense, self._seen = _dense(problem), _seen(problem)
        place = np.full(problem.count, -1)
        place[contacts] = np.arange(len(contacts))
        rows, columns = np.zeros((2, 0), dtype=np.int64)
        if not self._dense:
            compliance = problem.operator.matrix()
            rows, columns = block_rows(compliance), compliance.indices.astype(np.int64)
        self._inside = np.flatnonzero((place[rows] >= 0) & (place[columns] >= 0))
        self._rows, self._columns = rows[self._inside], columns[self._inside]
        self._diagonal = np.flatnonzero(self._rows == self._columns)
        # coupled to others only
        self._alone = np.setdiff1d(contacts, self._rows[self._diagonal], assume_unique=True)
        contact, side = np.nonzero(problem.bodies >= 0)
        chosen = place[contact] >= 0
        self._contact, self._side = contact[chosen], side[chosen]
        at, body = d * place[self._contact], problem.bodies[self._contact, self._side]
        first = len(contacts) * d
        self._pattern = BlockPattern(
            first + coupled.shape[0],
            [
                Family(d * place[self._rows], d * place[self._columns], d, d),
                Family(d * place[self._alone], d * place[self._alone], d, d),
                Family(at, first + m * body, d, m),
                Family(first + m * body, at, m, d),
                Family(first + m * block_rows(coupled), first + m * coupled.indices.astype(np.int64), m, m),
            ],
        )

    def serves(self, problem: ContactProblem, closed: IntArray) -> bool:
        """Whether it has rows for these contacts of a problem, and not many more.

        Parameters
        ----------
        problem : The contact problem. closed : Its elastic contacts that take part.
        """
        enough = np.isin(closed, self.contacts, assume_unique=True).all()
        return bool(enough and len(self.contacts) <= SPARE * len(closed)) and self.couples(problem)

    def couples(self, problem: ContactProblem) -> bool:
        """Whether the contacts of a problem are coupled as those that the pattern was made for."""
        return all(map(np.array_equal, self._seen, _seen(problem)))

    def widened(self, problem: ContactProblem, closed: IntArray, coupled: sparse.bsr_array) -> Self:
        """One that serves, with the contacts of this one, too, where these are not many more.

        Parameters
        ----------
        problem, closed : As for ``serves``. coupled : Matrix of the bodies.
        """
        both = np.union1d(closed, self.contacts) if self.couples(problem) else closed
        return type(self)(problem, both if len(both) <= SPARE * len(closed) else closed, coupled)

    def factorise(self, problem: ContactProblem, terms: Terms, library: Library) -> Solve:
        """The factor's solver of the matrix of a step."""
        if self._dense:
            return self._densely(problem, terms)
        matrix = self._pattern.filled(self._blocks(problem, terms))
        if library == "auto" and matrix.nnz > FULL * matrix.shape[0] ** 2:
            library = "dense"
        library = library_for(matrix.shape[0], library, fills=True)
        if library == "mumps" and self.mumps is None:
            self.mumps = Mumps(matrix)
        return factorise(matrix, library, self.mumps)

    def _densely(self, problem: ContactProblem, terms: Terms) -> Solve:
        """The same by a dense factor, without the matrix itself."""
        contacts, d = self.contacts, problem.dimension
        count, size = len(contacts), len(contacts) * d
        rest = self._pattern.filled(self._blocks(problem, terms))
        coupling = problem.operator.among(contacts[None])[0]
        coupling /= terms.unit
        rows = coupling.reshape(count, d, size)
        for first in range(0, count, AT_ONCE):
            some = slice(first, first + AT_ONCE)
            rows[some] = terms.by_velocity[contacts[some]] @ rows[some]
        shut = np.repeat(~terms.closed[contacts], d)
        coupling[shut], coupling[:, shut] = 0.0, 0.0
        matrix = rest.toarray(order="F")
        matrix[:size, :size] += coupling
        return factorise_dense(matrix, _Product(problem, terms, contacts, rest))

    def _blocks(self, problem: ContactProblem, terms: Terms) -> list[FloatArray]:
        """Values, family by family."""
        rows, diagonal, contact, closed = self._rows, self._diagonal, self._contact, terms.closed
        identity = np.eye(problem.dimension)
        own = np.where(closed[:, None, None], terms.own / terms.unit, identity)
        coupling = np.zeros((0, *identity.shape))
        if len(rows):
            coupling = problem.operator.matrix().data[self._inside]
            coupling /= terms.unit
            turned = np.flatnonzero(~terms.plain[rows])
            coupling[turned] = multiplied(terms.by_velocity[rows[turned]], coupling[turned])
            coupling[~(closed[rows] & closed[self._columns])] = 0.0
            coupling[diagonal] += own[rows[diagonal]]
        maps = np.where(closed[contact][:, None, None], terms.body_matrix.maps[contact, self._side], 0.0)
        return [
            coupling,
            own[self._alone],
            multiplied(terms.by_velocity[contact], maps),
            maps.transpose(0, 2, 1),
            terms.coupled.data,
        ]


@dataclass(frozen=True, slots=True)
class _Product:
    """Multiplies by a matrix that is held as W_el and a sparse rest.

    Attributes
    ----------
    problem, terms : What it is made of. contacts : Those that have rows, ascending. rest : All but W_el.
    """

    problem: ContactProblem
    terms: Terms
    contacts: IntArray
    rest: sparse.csr_array

    def __matmul__(self, x: FloatArray) -> FloatArray:
        terms, contacts, d = self.terms, self.contacts, self.problem.dimension
        closed, size = terms.closed[contacts, None], len(contacts) * d
        impulse = np.zeros_like(self.problem.free_velocity)
        impulse[contacts] = np.where(closed, x[:size].reshape(-1, d), 0.0)
        velocity = self.problem.elastic_velocity(impulse)[contacts] / terms.unit
        turned = applied(terms.by_velocity[contacts], velocity)
        product: FloatArray = self.rest @ x
        product[:size] += np.where(closed, turned, 0.0).ravel()
        return product


def _dense(problem: ContactProblem) -> bool:
    """Whether contacts are many, and most of them coupled to each other."""
    shared = problem.operator
    return isinstance(shared, Shared) and shared.nnz > FULL * shared.shape[0] ** 2


def _seen(problem: ContactProblem) -> tuple[NDArray[np.integer], ...]:
    """What decides which contacts and bodies are coupled."""
    bodies = problem.bodies, np.array(problem.body_count)
    if _dense(problem):
        return *bodies, np.zeros(0, dtype=np.int64)
    matrix = problem.operator.matrix()
    return *bodies, matrix.indptr, matrix.indices
