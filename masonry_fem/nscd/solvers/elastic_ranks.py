"""ElasticRanks: Newton steps with elastic contacts by iteration, each rank for its stones.

What ``elastic_krylov`` does, with the wall in parts: PT-Scotch divides the graph of stones and interfaces, a
rank has the rows of W_el of its stones, and the interfaces between two parts are one's or the other's. A
product with W_el takes impulses of such interfaces from one part to the other, and velocities back. The
bodies' matrix is factorised by each rank, or, where there are very many, by MUMPS on all together. GMRES is
PETSc's.

    portions = Portions(problem, elastic, body_matrix, team)       # once for a problem
    solve = portions.solver(terms, kept, body_matrix, factorised)  # once for a step
"""

from __future__ import annotations

import weakref
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from masonry_fem.host.ranks import Leader, Member, team
from masonry_fem.nscd.compliance import Alike, Shared
from masonry_fem.nscd.krylov import StagnationError
from masonry_fem.nscd.linear import Factorised, Library, factorise
from masonry_fem.nscd.mumps import petsc
from masonry_fem.nscd.problem import ContactProblem
from masonry_fem.nscd.solvers.body_matrix import BodyMatrix
from masonry_fem.nscd.solvers.elastic_krylov import (
    ACCURACY,
    FACTORED,
    ITERATIONS,
    Rows,
    Values,
    interfaces_by_size,
)
from masonry_fem.nscd.solvers.elastic_matrix import Terms

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
Mask = NDArray[np.bool_]
Solve = Callable[[FloatArray], FloatArray]

# Bodies from which all ranks factorise their matrix together. Below, its factor is cheap, and what MUMPS on
# several ranks would save is less than what it waits: several messages for each level of the factor.
TOGETHER = 20_000
KEPT, PARTS = "elastic_ranks", "elastic_ranks' parts"  # names of what is kept: portions, ranks of bodies
NUMBER = 8  # bytes


@dataclass(frozen=True, slots=True)
class Share:
    """What a rank has of a problem.

    Attributes
    ----------
    dimension : d. count : Contacts that are its own; those that its stones touch beside them follow these.
    contacts : Where its contacts stand among those of all ranks, shape (t,).
    kinds : Stones of which some contact is its own, and which of them are its own, (n,).
    bed : Of its own contacts, shape (c, d); None: none.
    groups : Its interfaces, by their own contacts.
    bodies : Of its own contacts, numbered as in ``places``, shape (c, 2).
    places : Where its bodies stand among those of all ranks, shape (b,); the first ``own`` are its own.
    maps : B of its own contacts, shape (c, 2, d, m).
    coupled : Block rows and columns that it adds to the bodies' matrix beside its interfaces' ones, (2, k).
    library : By which it factorises the bodies' matrix; None: all ranks do so together.
    """

    dimension: int
    count: int
    contacts: IntArray
    kinds: tuple[tuple[Alike, Mask], ...]
    bed: FloatArray | None
    groups: list[IntArray]
    bodies: IntArray
    places: IntArray
    own: int
    maps: FloatArray
    coupled: IntArray
    library: Library | None


Step = tuple[Values, FloatArray]  # at a rank's own contacts, and blocks that it adds to the bodies' matrix


def parted(
    problem: ContactProblem, elastic: Mask, body_matrix: BodyMatrix, library: Library
) -> Portions | None:
    """A problem in parts, one for each rank; None where there is one rank, or nothing to part it by.

    Parameters
    ----------
    problem, elastic, body_matrix, library : As for ``Portions``.
    """
    leader = team()
    parts = isinstance(problem.operator, Shared) and problem.body_count > 0
    if not isinstance(leader, Leader) or not parts:
        return None
    return Portions(problem, elastic, body_matrix, library, leader)


class Portions:
    """A problem in parts.

    Parameters
    ----------
    problem : Whose operator is ``Shared``.
    elastic : Contacts that have compliance, shape (c,).
    body_matrix : Pattern of the bodies' matrix, and B by contact and side.
    library : By which a rank factorises it.
    team : The ranks.
    """

    def __init__(
        self,
        problem: ContactProblem,
        elastic: Mask,
        body_matrix: BodyMatrix,
        library: Library,
        team: Leader,
    ) -> None:
        self.problem, self.team = problem, team
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
                    part = Alike(place[kind.contacts[some]], kind.turns[some], kind.matrix)
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
        portions, team = self.whole, self.whole.team
        problem, step = (known() for known in team.held.get(KEPT, (_nothing, _nothing)))
        if step is self:
            return
        team.held.pop(KEPT, None)
        if problem is not portions:
            team.call(take_share, portions.shares)
            team.held[KEPT] = weakref.ref(portions), _nothing
        team.call(take_step, self.steps)
        team.held[KEPT] = weakref.ref(portions), weakref.ref(self)

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
        unknown = np.zeros(problem.count, dtype=bool)
        unknown[kept] = True
        balance = rhs[size:].reshape(problem.body_count, -1)
        shares = [
            (force[own], balance[portions.part == rank], unknown[own])
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


# what ranks do


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


def take_share(member: Member, share: Share) -> None:
    """Make a rank's portion of a problem."""
    before = member.kept.pop(KEPT, None)
    if before is not None:
        before.close()
    member.kept[KEPT] = Portion(member, share)


def take_step(member: Member, step: Step) -> None:
    """Prepare a step."""
    member.kept[KEPT].take(*step)


def solve_step(
    member: Member, share: tuple[FloatArray, FloatArray, Mask]
) -> tuple[FloatArray, FloatArray, bool]:
    """Impulses and motions of a rank's own contacts and bodies, and whether iterations have ended."""
    solved: tuple[FloatArray, FloatArray, bool] = member.kept[KEPT].solve(*share)
    return solved


class Portion:
    """What a rank has of a problem, and of a step.

    Parameters
    ----------
    member : The rank.
    share : Its part of the problem.
    """

    def __init__(self, member: Member, share: Share) -> None:
        self.member, self.share = member, share
        self.operator: Shared | None = None
        self.coupling = member.together(self._coupled)
        self.contacts = _Exchange(member, share.contacts, share.count, share.dimension)
        self.bodies = (_BodiesTogether if share.library is None else _BodiesOfEach)(member, share)

    def close(self) -> None:
        """Let go what PETSc holds."""
        self.contacts.destroy()
        self.bodies.destroy()

    def _coupled(self) -> list[FloatArray]:
        """Blocks of W_el within interfaces; and the operator of the rank's own stones."""
        share = self.share
        t, d = len(share.contacts), share.dimension
        bed = None if share.bed is None else np.concatenate([share.bed, np.zeros((t - share.count, d))])
        whole = Shared(t, d, [kind for kind, _ in share.kinds], bed=bed)
        own = [
            Alike(kind.contacts[some], kind.turns[some], kind.matrix)
            for kind, some in share.kinds
            if some.any()
        ]
        self.operator = Shared(t, d, own, bed=bed) if own else None
        with self.member.on("interfaces"):
            return [whole.among(group) for group in share.groups]

    def take(self, values: Values, coupled: FloatArray) -> None:
        """Prepare a step."""
        member = self.member
        with member.on("interfaces"):
            self.rows, blocks = member.together(lambda: self._prepared(values))
        self.bodies.factorise(
            np.concatenate([coupled, *(-given.reshape(-1, *coupled.shape[1:]) for given in blocks)])
        )

    def _prepared(self, values: Values) -> tuple[Rows, list[FloatArray]]:
        share = self.share
        rows = Rows(values, share.bodies, share.maps, share.groups, self.coupling)
        return rows, [given for _, given in rows.eliminated()]

    def solve(
        self, force: FloatArray, balance: FloatArray, unknown: Mask
    ) -> tuple[FloatArray, FloatArray, bool]:
        """As ``solve_step``."""
        library, shape = petsc(), force.shape
        nothing = np.zeros_like(balance)
        x, motion = self._precondition(force, balance)
        left = np.where(unknown[:, None], force - self._product(x, motion), 0.0)
        moved = motion[: len(balance)].copy()

        def apply(y: FloatArray) -> FloatArray:
            product = self._product(*self._precondition(y.reshape(shape), nothing, refined=False))
            return np.where(unknown[:, None], product, 0.0).ravel()

        size = ((force.size, None),) * 2
        shell = library.Mat().createPython(size, _Shell(apply), comm=self.member.comm)
        shell.setUp()
        method = library.KSP().create(self.member.comm)
        method.setType("gmres")
        method.getPC().setType("none")
        method.setGMRESRestart(ITERATIONS)
        method.setTolerances(rtol=ACCURACY, atol=0.0, max_it=ITERATIONS)
        method.setOperators(shell)
        given, found = shell.createVecs()
        given.array[:] = left.ravel()
        method.solve(given, found)
        ended = int(method.getConvergedReason()) > 0
        y = found.array.reshape(shape).copy()
        for made in (method, shell, given, found):
            made.destroy()
        more, motion = self._precondition(y, nothing)
        return x + more, moved + motion[: len(balance)], ended

    def _precondition(
        self, force: FloatArray, balance: FloatArray, *, refined: bool = True
    ) -> tuple[FloatArray, FloatArray]:
        """Impulses, and U of the rank's bodies, of given rows, with W_el within interfaces only.

        Bodies balance to rounding where they are ``refined``: iterations need less.
        """
        rows, member = self.rows, self.member
        with member.on("preconditioner"):
            given = rows.to_bodies(rows.inside(force), len(self.share.places))
        motion = self.bodies.moved(balance, given, refined=refined)
        with member.on("preconditioner"):
            return rows.inside(force - rows.turned(rows.moved(motion))), motion

    def _product(self, x: FloatArray, motion: FloatArray) -> FloatArray:
        """The rows of the rank's own contacts times x and U, shape (c, d)."""
        rows, member = self.rows, self.member
        impulse = self.contacts.spread(np.where(rows.values.closed[:, None], x, 0.0))
        with member.on("products"):
            velocity = np.zeros_like(impulse)
            if self.operator is not None:
                velocity[:] = (self.operator @ impulse.ravel()).reshape(impulse.shape)
        given = self.contacts.summed(velocity)
        with member.on("products"):
            product: FloatArray = rows.product(x, given, motion)
            return product


def _blocks_at(share: Share) -> tuple[IntArray, IntArray]:
    """Block rows and columns of what a rank adds to the bodies' matrix, −1 where there is no body, (k,)."""
    place = np.append(share.places, -1)
    rows, columns = [share.coupled[0]], [share.coupled[1]]
    for group in share.groups:
        pair = place[share.bodies[group[:, 0]]]
        rows.append(np.repeat(pair, 2, axis=1).ravel())
        columns.append(np.tile(pair, 2).ravel())
    row, column = np.concatenate(rows), np.concatenate(columns)
    absent = (row < 0) | (column < 0)
    return np.where(absent, -1, row), np.where(absent, -1, column)


class _BodiesOfEach:
    """The bodies' matrix, all of it on each rank.

    Parameters
    ----------
    member : The rank.
    share : Its part of the problem.
    """

    def __init__(self, member: Member, share: Share) -> None:
        assert share.library is not None
        self._member, self._places, self._own = member, share.places, share.own
        self._library: Library = share.library
        self._width = share.maps.shape[3]
        everywhere = member.comm.allgather(_blocks_at(share))
        rows, columns = (np.concatenate(parts) for parts in zip(*everywhere, strict=True))
        self._counts = [self._width**2 * len(part) for part, _ in everywhere]  # numbers of each rank
        self._bytes = NUMBER * (sum(self._counts) - self._counts[member.rank])
        self._count = sum(member.comm.allgather(share.own))
        self._summed = NUMBER * self._count * self._width if member.size > 1 else 0
        there = np.flatnonzero(rows >= 0)
        pattern, slots = np.unique(rows[there] * self._count + columns[there], return_inverse=True)
        order = np.argsort(slots, kind="stable")
        self._order = there[order]  # blocks by where they are added
        self._first = np.searchsorted(slots[order], np.arange(len(pattern)))
        row = pattern // max(self._count, 1)
        self._indices = pattern - row * self._count
        self._pointer = np.searchsorted(row, np.arange(self._count + 1))

    def destroy(self) -> None:
        """There is nothing of PETSc's."""

    def factorise(self, blocks: FloatArray) -> None:
        """Factorise what the blocks of all ranks make, (k, m, m)."""
        comm, m = self._member.comm, self._width
        self._member.meet()
        with self._member.on("bodies' factor", self._bytes):
            everywhere = np.empty((sum(self._counts) // m**2, m, m))
            given = np.ascontiguousarray(blocks)
            self._member.wait(comm.Iallgatherv(given, [everywhere, self._counts]))
            data = np.add.reduceat(everywhere[self._order], self._first, axis=0)
            size = self._count * m
            matrix = sparse.bsr_array(
                (data, self._indices, self._pointer), shape=(size, size), blocksize=(m, m)
            )
            self._factor: Factorised = self._member.together(lambda: factorise(matrix.tocsr(), self._library))

    def moved(self, balance: FloatArray, given: FloatArray, *, refined: bool) -> FloatArray:
        """U of the rank's bodies, (b, m).

        Parameters
        ----------
        balance : What is asked of its own, shape (own, m). given : What its contacts take off, shape (b, m).
        refined : The factor's solution is corrected by its residual.
        """
        with self._member.on("exchange", self._summed):
            left = np.zeros((self._count, self._width))
            left[self._places] = -given
            left[self._places[: self._own]] += balance
            summed = np.empty_like(left)
            self._member.wait(self._member.comm.Iallreduce(left, summed))
        with self._member.on("bodies' solution"):
            solve = self._factor if refined else self._factor.bare
            motion: FloatArray = solve(summed.ravel()).reshape(summed.shape)[self._places]
            return motion


class _BodiesTogether:
    """The bodies' matrix, of each rank the rows of its own.

    Parameters
    ----------
    member : The rank.
    share : Its part of the problem.
    """

    def __init__(self, member: Member, share: Share) -> None:
        library, m = petsc(), share.maps.shape[3]
        self._member, self._own = member, share.own
        self._exchange = _Exchange(member, share.places, share.own, m)
        self._matrix = library.Mat().createAIJ(((share.own * m, None),) * 2, comm=member.comm)
        first, last = self._matrix.getOwnershipRange()
        row, column = _blocks_at(share)
        away = (row >= 0) & ((row < first // m) | (row >= last // m))
        self._bytes = NUMBER * m**2 * int(away.sum())  # that leave it: of all ranks as many as arrive
        at = np.arange(m)
        rows = np.where(row[:, None, None] < 0, -1, row[:, None, None] * m + at[:, None])
        columns = np.where(column[:, None, None] < 0, -1, column[:, None, None] * m + at)
        places = [part.ravel().astype(library.IntType) for part in np.broadcast_arrays(rows, columns)]
        self._matrix.setPreallocationCOO(*places)
        self._factor = library.KSP().create(member.comm)
        self._factor.setType("preonly")
        steps = self._factor.getPC()
        steps.setType("lu")
        steps.setFactorSolverType("mumps")
        self._given, self._found = self._matrix.createVecs()
        self._regular = True

    def destroy(self) -> None:
        """Let go what PETSc holds."""
        for made in (self._factor, self._given, self._found, self._matrix, self._exchange):
            made.destroy()

    def factorise(self, blocks: FloatArray) -> None:
        """Factorise what the blocks of all ranks make, (k, m, m)."""
        with self._member.on("bodies' factor", self._bytes):
            self._matrix.setValuesCOO(blocks.ravel())
            self._factor.setOperators(self._matrix)
            self._factor.setUp()
            self._regular = self._factor.getPC().getFailedReason() == 0

    def moved(self, balance: FloatArray, given: FloatArray, *, refined: bool) -> FloatArray:
        """As ``_BodiesOfEach.moved``; MUMPS refines nothing."""
        left = balance - self._exchange.summed(given)
        with self._member.on("bodies' solution"):
            moved = np.full_like(left, np.nan)
            if self._regular:
                self._given.array[:] = left.ravel()
                self._factor.solve(self._given, self._found)
                moved[:] = self._found.array.reshape(left.shape)
        return self._exchange.spread(moved)


class _Shell:
    """What PETSc multiplies by."""

    def __init__(self, apply: Callable[[FloatArray], FloatArray]) -> None:
        self._apply = apply

    def mult(self, _: Any, x: Any, y: Any) -> None:
        """Y = A x."""
        y.array[:] = self._apply(x.array_r)


class _Exchange:
    """Values that ranks own, and those that they need beside them.

    Parameters
    ----------
    member : The rank.
    places : Where what it has stands among what all own, its own first, shape (t,).
    own : How many are its own. width : Numbers of each.
    """

    def __init__(self, member: Member, places: IntArray, own: int, width: int) -> None:
        library = petsc()
        self._member, self._own, self._width, self._all = member, own, width, len(places)
        self._mine = library.Vec().createMPI((own * width, None), comm=member.comm)
        self._local = library.Vec().createSeq(len(places) * width, comm=library.COMM_SELF)
        at = library.IS().createBlock(width, places.astype(library.IntType), comm=library.COMM_SELF)
        self._scatter = library.Scatter().create(self._mine, at, self._local, None)
        at.destroy()
        self._bytes = (self._all - own) * width * NUMBER

    def destroy(self) -> None:
        """Let go what PETSc holds."""
        for made in (self._scatter, self._mine, self._local):
            made.destroy()

    def spread(self, values: FloatArray) -> FloatArray:
        """Own values (own, w) with those of others that are needed, shape (t, w)."""
        with self._member.on("exchange", self._bytes):
            self._mine.array[:] = values.ravel()
            self._scatter.scatter(self._mine, self._local)
            local: FloatArray = self._local.array.reshape(self._all, self._width).copy()
            return local

    def summed(self, values: FloatArray) -> FloatArray:
        """Sums over all ranks of what they have of the own ones, from (t, w), shape (own, w)."""
        library = petsc()
        with self._member.on("exchange", self._bytes):
            self._local.array[:] = values.ravel()
            self._mine.set(0.0)
            self._scatter.scatter(
                self._local, self._mine, library.InsertMode.ADD_VALUES, library.ScatterMode.REVERSE
            )
            summed: FloatArray = self._mine.array.reshape(self._own, self._width).copy()
            return summed
