"""Portions: a problem in parts, as the leader of ranks has it."""

from __future__ import annotations

import weakref
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from masonry_fem.host.ranks import Leader, team
from masonry_fem.nscd.compliance import Shared
from masonry_fem.nscd.krylov import StagnationError
from masonry_fem.nscd.linear import Library, Solve
from masonry_fem.nscd.problem import ContactProblem
from masonry_fem.nscd.solvers.body_matrix import BodyMatrix
from masonry_fem.nscd.solvers.elastic_krylov import FACTORED, Effort, Values
from masonry_fem.nscd.solvers.elastic_matrix import Terms
from masonry_fem.nscd.solvers.elastic_ranks.division import Division
from masonry_fem.nscd.solvers.elastic_ranks.portion import solve_step, take_problem, take_share, take_step
from masonry_fem.nscd.solvers.elastic_ranks.share import KEPT, Given, Step
from masonry_fem.nscd.structure import Structure

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
Mask = NDArray[np.bool_]


def parted(
    problem: ContactProblem,
    elastic: Mask,
    scale: FloatArray,
    body_matrix: BodyMatrix,
    library: Library,
    structure: Structure,
) -> Portions | None:
    """A problem in parts, one for each rank; None where one rank is all, or solves it, or nothing parts it.

    Parameters
    ----------
    problem : The contact problem.
    elastic : Contacts that have compliance, shape (c,).
    scale : As for ``Portions``. body_matrix : What makes the bodies' matrix.
    library : By which a rank factorises the bodies' matrix.
    structure : What is kept from one problem of these contacts to the next.
    """
    leader = team()
    parts = isinstance(problem.operator, Shared) and problem.body_count > 0
    if not isinstance(leader, Leader) or leader.busy or not parts:
        return None
    division = structure.division
    if division is None or not division.serves(problem, elastic):
        division = Division(problem, elastic, body_matrix.pattern, library, leader)
        structure.division = division
    return Portions(problem, division, scale, body_matrix.column, leader)


class Portions:
    """A problem in parts.

    Parameters
    ----------
    problem : Whose operator is ``Shared``.
    division : Its contacts and bodies dealt to ranks.
    scale : w of each contact, by which residuals are measured, shape (c,).
    column : What each column of B is divided by, shape (b, m).
    team : The ranks.
    """

    def __init__(
        self,
        problem: ContactProblem,
        division: Division,
        scale: FloatArray,
        column: FloatArray,
        team: Leader,
    ) -> None:
        self.problem, self.division, self.scale, self.team = problem, division, scale, team
        self._column = column

    def given(self) -> list[Given]:
        """What each rank is given of the problem."""
        operator, division = self.problem.operator, self.division
        assert isinstance(operator, Shared)
        bed = operator.bed
        return [
            Given(
                division.kinds(operator, rank),
                None if bed is None else bed[met],
                division.maps(self.problem.rigid_map, rank),
                self._column[bodies],
            )
            for rank, (met, bodies) in enumerate(zip(division.met, division.bodies, strict=True))
        ]

    def solver(
        self,
        terms: Terms,
        kept: IntArray,
        body_matrix: BodyMatrix,
        factorised: Callable[[sparse.bsr_array], Solve],
    ) -> Solve:
        """The solver of one step; as ``Preconditioned``, whose bodies' matrix ``factorised`` solves."""
        coupled = terms.coupled.data[self.division.coupled]
        steps = [
            (Values.at(terms, met), coupled if rank == 0 else coupled[:0])
            for rank, met in enumerate(self.division.met)
        ]
        made = _Solver(self, steps, kept)
        made.prepared()
        return made


class _Solver:
    """The solver of one step.

    Parameters
    ----------
    portions : The problem in parts.
    steps : What each rank needs of it.
    kept : Contacts that are unknowns, shape (k,).
    """

    def __init__(self, portions: Portions, steps: list[Step], kept: IntArray) -> None:
        self.whole, self.steps, self.kept = portions, steps, kept

    def prepared(self) -> None:
        """See to it that ranks have this step."""
        whole, team = self.whole, self.whole.team
        number = whole.division.number
        # problem and step that ranks have, by division: parts of a problem come between its steps
        held = team.held.setdefault(KEPT, weakref.WeakKeyDictionary())
        if whole.division not in held:
            others = frozenset(division.number for division in held)
            team.call(take_share, [(number, others, share) for share in whole.division.shares])
            held[whole.division] = _nothing, _nothing
        problem, step = (known() for known in held[whole.division])
        if step is self:
            return
        held[whole.division] = _nothing, _nothing
        if problem is not whole:
            team.call(take_problem, [(number, given) for given in whole.given()])
        team.call(take_step, [(number, step) for step in self.steps])
        held[whole.division] = weakref.ref(whole), weakref.ref(self)

    def __call__(self, rhs: FloatArray) -> FloatArray:
        """The solution of a step, ordered as ``ElasticMatrix`` orders it, with rows for ``kept``.

        Raises
        ------
        StagnationError : It has failed, and a factor fits.
        """
        self.prepared()
        portions, kept = self.whole, self.kept
        part, contacts = portions.division.part, portions.division.contacts
        problem, d = portions.problem, portions.problem.dimension
        size = len(kept) * d
        force = np.zeros_like(problem.free_velocity)
        force[kept] = rhs[:size].reshape(-1, d)
        scale = np.zeros(problem.count)
        scale[kept] = portions.scale[kept]
        balance, effort = rhs[size:].reshape(problem.body_count, -1), Effort.of(len(kept))
        shares = [
            (portions.division.number, (force[own], balance[part == rank], scale[own], effort))
            for rank, own in enumerate(contacts)
        ]
        results = portions.team.call(solve_step, shares)
        if not results[0][2] and len(kept) <= FACTORED:
            raise StagnationError(
                f"residual above {effort.accuracy:.0e} of the first after {effort.most} iterations"
            )
        x, motion = np.zeros_like(force), np.empty_like(balance)
        for rank, (own, (impulse, moved, _)) in enumerate(zip(contacts, results, strict=True)):
            x[own] = impulse
            motion[part == rank] = moved
        return np.concatenate([x[kept].ravel(), motion.ravel()])


def _nothing() -> None:
    """What is referred to where ranks have nothing."""
