"""Portions: a problem in parts, as the leader of ranks has it."""

from __future__ import annotations

import weakref
from collections.abc import Callable
from dataclasses import replace
from itertools import count as numbers
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from masonry_fem.host.ranks import Leader, Member, team
from masonry_fem.nscd.compliance import Shared
from masonry_fem.nscd.krylov import StagnationError
from masonry_fem.nscd.linear import Library, Solve
from masonry_fem.nscd.mumps import petsc
from masonry_fem.nscd.problem import ContactProblem
from masonry_fem.nscd.solvers.body_matrix import BodyMatrix
from masonry_fem.nscd.solvers.elastic_krylov import (
    ACCURACY,
    FACTORED,
    ITERATIONS,
    Values,
    interfaces_by_size,
    most_iterations,
)
from masonry_fem.nscd.solvers.elastic_matrix import Terms
from masonry_fem.nscd.solvers.elastic_ranks.portion import solve_step, take_share, take_step
from masonry_fem.nscd.solvers.elastic_ranks.share import KEPT, Share, Step

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
Mask = NDArray[np.bool_]

# Bodies from which all ranks factorise their matrix together: factors of 1640 cost each of two ranks half as
# much then, solutions a third more. What fewer cost was not measured.
TOGETHER = 1_000
PARTS = "elastic_ranks' parts"  # name of what the leader keeps: ranks of bodies
_NUMBERS = numbers()  # of problems in parts, for ranks to know them by


def parted(
    problem: ContactProblem, elastic: Mask, scale: FloatArray, body_matrix: BodyMatrix, library: Library
) -> Portions | None:
    """A problem in parts, one for each rank; None where one rank is all, or solves it, or nothing parts it.

    Parameters
    ----------
    problem, elastic, scale, body_matrix, library : As for ``Portions``.
    """
    leader = team()
    parts = isinstance(problem.operator, Shared) and problem.body_count > 0
    if not isinstance(leader, Leader) or leader.busy or not parts:
        return None
    return Portions(problem, elastic, scale, body_matrix, library, leader)


class Portions:
    """A problem in parts.

    Parameters
    ----------
    problem : Whose operator is ``Shared``.
    elastic : Contacts that have compliance, shape (c,).
    scale : w of each contact, by which residuals are measured, shape (c,).
    body_matrix : Pattern of the bodies' matrix, and B by contact and side.
    library : By which a rank factorises it.
    team : The ranks.
    """

    def __init__(
        self,
        problem: ContactProblem,
        elastic: Mask,
        scale: FloatArray,
        body_matrix: BodyMatrix,
        library: Library,
        team: Leader,
    ) -> None:
        self.number = next(_NUMBERS)
        self.problem, self.scale, self.team = problem, scale, team
        self.library = None if problem.body_count >= TOGETHER else library
        self.part, self.body_order = self._bodies_parted(body_matrix)
        groups = interfaces_by_size(problem, elastic)
        self.owner = self._owners(groups)
        self.contacts = [np.flatnonzero(self.owner == rank) for rank in range(team.size)]
        # blocks of the bodies' matrix that the leader adds: their mass, and what rigid joints leave
        slots = body_matrix.slots[~elastic]
        self.coupled = np.union1d(body_matrix.diagonal, slots[slots >= 0])
        self.shares = self._shares(groups, body_matrix)

    def solver(
        self,
        terms: Terms,
        kept: IntArray,
        body_matrix: BodyMatrix,
        factorised: Callable[[sparse.bsr_array], Solve],
    ) -> Solve:
        """The solver of one step; as ``Preconditioned``, whose bodies' matrix ``factorised`` solves."""
        coupled = terms.coupled.data[self.coupled]
        steps = [
            (Values.at(terms, own), coupled if rank == 0 else coupled[:0])
            for rank, own in enumerate(self.contacts)
        ]
        made = _Solver(self, steps, kept)
        made.prepared()
        return made

    def _bodies_parted(self, body_matrix: BodyMatrix) -> tuple[IntArray, IntArray]:
        """Rank of each body, (b,), and bodies rank after rank, (b,)."""
        count = body_matrix.count
        rows = np.repeat(np.arange(count), np.diff(body_matrix.pointer))
        joined = rows != body_matrix.indices
        edges = np.stack([rows[joined], body_matrix.indices[joined]])
        first = np.linspace(0, count, self.team.size + 1).astype(np.int64)
        bounds = np.searchsorted(edges[0], first)
        shares = [
            (first[rank : rank + 2] - first[rank], count, edges[:, low:high])
            for rank, (low, high) in enumerate(pairwise(bounds))
        ]
        joins, part = self.team.held.get(PARTS, (edges[:, :0], edges[0]))
        if not np.array_equal(edges, joins) or len(part) != count:
            part = np.concatenate(self.team.call(_partition, shares))
            self.team.held[PARTS] = edges, part
        return part, np.argsort(part, kind="stable")

    def _owners(self, groups: list[IntArray]) -> IntArray:
        """Rank of each elastic contact, −1 for others, (c,): whole interfaces are of one body's rank."""
        pair = np.sort(self.problem.bodies, axis=1)
        # one or the other, so that parts have as many
        chosen = np.where((pair.sum(axis=1) % 2 == 0) & (pair[:, 0] >= 0), pair[:, 0], pair[:, 1])
        rank = np.where(chosen >= 0, self.part[chosen], 0)
        owner = np.full(self.problem.count, -1)
        for group in groups:
            owner[group] = rank[group[:, :1]]
        return owner

    def _shares(self, groups: list[IntArray], body_matrix: BodyMatrix) -> list[Share]:
        """What each rank is given."""
        problem, operator, ranks = self.problem, self.problem.operator, range(self.team.size)
        assert isinstance(operator, Shared)
        at = np.full(problem.count + 1, -1)  # contacts rank after rank; the last is nobody's
        at[np.concatenate(self.contacts)] = np.arange(sum(map(len, self.contacts)))
        body_at = np.empty(len(self.part), dtype=np.int64)
        body_at[self.body_order] = np.arange(len(self.part))
        owner = np.append(self.owner, -1)
        stones = [_ranks_of_stones(owner[kind.contacts], self.team.size) for kind in operator.kinds]
        rows = np.repeat(np.arange(body_matrix.count), np.diff(body_matrix.pointer))
        coupled = np.stack([body_at[rows], body_at[body_matrix.indices]])[:, self.coupled]
        made = []
        for rank in ranks:
            own = self.contacts[rank]
            touched = [
                kind.contacts[of == rank].ravel() for kind, of in zip(operator.kinds, stones, strict=True)
            ]
            beside = np.unique(np.concatenate([np.zeros(0, dtype=np.int64), *touched]))
            beside = beside[(beside >= 0) & (owner[beside] != rank)]
            local = np.concatenate([own, beside])
            place = np.full(problem.count + 1, -1)
            place[local] = np.arange(len(local))
            kinds = []
            for kind, of in zip(operator.kinds, stones, strict=True):
                some = (of == rank) | (owner[kind.contacts] == rank).any(axis=1)
                if some.any():
                    part = replace(kind, contacts=place[kind.contacts]).some(some).bare()
                    kinds.append((part, of[some] == rank))
            parts = [place[group[owner[group[:, 0]] == rank]] for group in groups]
            sides = problem.bodies[own]
            its = np.flatnonzero(self.part == rank)
            others = np.setdiff1d(sides[sides >= 0], its)
            bodies = np.concatenate([its, others])
            number = np.full(len(self.part) + 1, -1)
            number[bodies] = np.arange(len(bodies))
            made.append(
                Share(
                    dimension=problem.dimension,
                    count=len(own),
                    contacts=at[local],
                    kinds=tuple(kinds),
                    bed=None if operator.bed is None else operator.bed[own],
                    groups=[part for part in parts if len(part)],
                    bodies=number[sides],
                    places=body_at[bodies],
                    own=len(its),
                    maps=body_matrix.maps[own],
                    coupled=coupled if rank == 0 else coupled[:, :0],
                    library=self.library,
                )
            )
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
        # steps that ranks have, by problems: parts of one come between its steps
        steps = team.held.setdefault(KEPT, weakref.WeakKeyDictionary())
        if whole not in steps:
            others = frozenset(portions.number for portions in steps)
            team.call(take_share, [(whole.number, others, share) for share in whole.shares])
            steps[whole] = _nothing
        if steps[whole]() is not self:
            steps[whole] = _nothing
            team.call(take_step, [(whole.number, step) for step in self.steps])
            steps[whole] = weakref.ref(self)

    def __call__(self, rhs: FloatArray) -> FloatArray:
        """The solution of a step, ordered as ``ElasticMatrix`` orders it, with rows for ``kept``.

        Raises
        ------
        StagnationError : It has failed, and a factor fits.
        """
        self.prepared()
        portions, kept = self.whole, self.kept
        problem, d = portions.problem, portions.problem.dimension
        size = len(kept) * d
        force = np.zeros_like(problem.free_velocity)
        force[kept] = rhs[:size].reshape(-1, d)
        scale = np.zeros(problem.count)
        scale[kept] = portions.scale[kept]
        balance, most = rhs[size:].reshape(problem.body_count, -1), most_iterations(len(kept))
        shares = [
            (portions.number, (force[own], balance[portions.part == rank], scale[own], most))
            for rank, own in enumerate(portions.contacts)
        ]
        results = portions.team.call(solve_step, shares)
        if not results[0][2] and len(kept) <= FACTORED:
            raise StagnationError(f"residual above {ACCURACY:.0e} of the first after {ITERATIONS} iterations")
        x, motion = np.zeros_like(force), np.empty_like(balance)
        for rank, (own, (impulse, moved, _)) in enumerate(zip(portions.contacts, results, strict=True)):
            x[own] = impulse
            motion[portions.part == rank] = moved
        return np.concatenate([x[kept].ravel(), motion.ravel()])


def _nothing() -> None:
    """What is referred to where ranks have nothing."""


def _ranks_of_stones(owners: IntArray, size: int) -> IntArray:
    """Ranks that own most contacts of each stone, (n,), from their owners, −1 for none, (n, s)."""
    n = len(owners)
    key = np.where(owners >= 0, np.arange(n)[:, None] * size + owners, n * size)
    counted = np.bincount(key.ravel(), minlength=n * size + 1)[:-1].reshape(n, size)
    return counted.argmax(axis=1)


def _partition(member: Member, share: tuple[IntArray, int, IntArray]) -> IntArray:
    """Ranks of some bodies, (n,), by PT-Scotch, from where they begin and end, and their edges (2, k)."""
    library = petsc()
    bounds, count, edges = share
    own = int(bounds[1])
    graph = library.Mat().createAIJ(((own, count), (own, count)), comm=member.comm)
    places = edges.astype(library.IntType)
    graph.setPreallocationCOO(places[0], places[1])
    graph.setValuesCOO(np.ones(places.shape[1]))
    parter = library.MatPartitioning().create(member.comm)
    parter.setAdjacency(graph)
    parter.setType(library.MatPartitioning.Type.PARTITIONINGPTSCOTCH)
    found = library.IS()
    parter.apply(found)
    part: IntArray = found.getIndices().astype(np.int64)
    for made in (found, parter, graph):
        made.destroy()
    return part
