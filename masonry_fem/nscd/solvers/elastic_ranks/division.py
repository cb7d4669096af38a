"""Division: contacts and bodies dealt to ranks, as the leader knows it."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import count as numbers
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from masonry_fem.host.ranks import Leader, Member
from masonry_fem.nscd.compliance import Kinds, Shared
from masonry_fem.nscd.linear import Library, library_for
from masonry_fem.nscd.linear_cost import LinearCost
from masonry_fem.nscd.mumps import petsc
from masonry_fem.nscd.problem import ContactProblem
from masonry_fem.nscd.solvers.body_matrix import BodyPattern
from masonry_fem.nscd.solvers.elastic_krylov import interfaces_by_size, numbered
from masonry_fem.nscd.solvers.elastic_ranks.share import Share
from masonry_fem.nscd.solvers.seams import seams

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
Mask = NDArray[np.bool_]

# Bodies from which all ranks factorise their matrix together: a part of some 400 takes two ranks 0.77 s for
# 0.91 so, one of 584 3.1 s for 3.6, one of 200 as long. Fewer give the same bits each time.
TOGETHER = 300
_NUMBERS = numbers()  # of divisions, for ranks to know them by


class Division:
    """Contacts and bodies dealt to ranks, for all problems of the same contacts.

    Parameters
    ----------
    problem : One of them, whose operator is ``Shared``.
    elastic : Contacts that have compliance, shape (c,).
    pattern : Of the bodies' matrix.
    team : The ranks.

    Attributes
    ----------
    number : By which ranks know it.
    part : Rank of each body, (b,).
    contacts : Of each rank. met : The same with the others of its seams.
    shares : What each rank is given of it.
    """

    def __init__(self, problem: ContactProblem, elastic: Mask, pattern: BodyPattern, team: Leader) -> None:
        assert isinstance(problem.operator, Shared)
        self.number, self._size = next(_NUMBERS), team.size
        self._dimension, self._width = problem.dimension, problem.rigid_mass.shape[1]
        self._sides, self._elastic = problem.bodies, elastic
        self._stones = [kind.contacts for kind in problem.operator.kinds]
        self._library = None if problem.body_count >= TOGETHER else self._library_of(pattern)
        self.part = _parted(pattern, team)
        self._bodies = np.argsort(self.part, kind="stable")  # rank after rank
        groups = interfaces_by_size(problem, elastic)
        self._owner = self._owners(groups)
        self.contacts = [np.flatnonzero(self._owner == rank) for rank in range(team.size)]
        self.met: list[IntArray] = []
        self._held: list[list[tuple[IntArray, IntArray]]] = []  # by rank and kind: stones and their contacts
        self._rooms: dict[tuple[int, int | str], FloatArray] = {}
        interface = numbered(groups, problem.count)
        self.shares = self._shares(groups, seams(problem.operator, interface), interface)

    def serves(self, problem: ContactProblem, elastic: Mask) -> bool:
        """Whether a problem has the contacts and bodies that were dealt out.

        Parameters
        ----------
        problem : Whose operator is ``Shared``. elastic : Contacts that have compliance, shape (c,).
        """
        operator = problem.operator
        assert isinstance(operator, Shared)
        stones = [kind.contacts for kind in operator.kinds]
        return (
            problem.body_count == len(self.part)
            and np.array_equal(problem.bodies, self._sides)
            and np.array_equal(elastic, self._elastic)
            and len(stones) == len(self._stones)
            and all(map(np.array_equal, stones, self._stones))
        )

    def kinds(self, operator: Shared, rank: int) -> tuple[Kinds, ...]:
        """Stones at contacts of a rank and of its seams, with its numbers of contacts.

        Parameters
        ----------
        operator : W_el of all contacts. rank : The rank.
        """
        return tuple(
            Kinds(
                contacts,
                self._taken((rank, number), kind.turns, stones),
                kind.matrices,
                kind.kind[stones],
            ).bare()
            for number, (kind, (stones, contacts)) in enumerate(
                zip(operator.kinds, self._held[rank], strict=True)
            )
            if len(contacts)
        )

    def _library_of(self, pattern: BodyPattern) -> Library:
        """By which a rank factorises the bodies' matrix."""
        cost = LinearCost.foreseen(pattern.indices, pattern.pointer, self._width)
        return library_for(pattern.count * self._width, fills=cost.fills)

    def taken(self, name: str, values: FloatArray, rank: int) -> FloatArray:
        """Values of a rank's contacts, shape (k, ...): written over when they are asked for again.

        Parameters
        ----------
        name : Of what is asked for. values : Of all contacts, shape (c, ...). rank : The rank.
        """
        own = self.contacts[rank]
        return values if len(own) == len(values) else self._taken((rank, name), values, own)

    def _taken(self, name: tuple[int, int | str], values: FloatArray, rows: IntArray) -> FloatArray:
        """Some rows of an array, where those that had the name last were: new memory is slow."""
        shape = (len(rows), *values.shape[1:])
        room = self._rooms.get(name)
        if room is None or room.shape != shape:
            room = self._rooms[name] = np.empty(shape)
        return np.take(values, rows, axis=0, out=room, mode="clip")

    def _owners(self, groups: list[IntArray]) -> IntArray:
        """Rank of each contact, (c,).

        All interfaces between two parts are of the one or of the other: few seams have contacts of both then.
        """
        ranks = np.sort(np.where(self._sides >= 0, self.part[self._sides], -1), axis=1)
        first = (ranks.sum(axis=1) % 2 == 0) & (ranks[:, 0] >= 0)
        rank = np.maximum(np.where(first, ranks[:, 0], ranks[:, 1]), 0)
        owner = rank.copy()
        for group in groups:
            owner[group] = rank[group[:, :1]]
        return owner

    def _shares(self, groups: list[IntArray], joined: list[IntArray], interface: IntArray) -> list[Share]:
        """What each rank is given. A seam is one rank's, whoever has its contacts."""
        owner = np.append(self._owner, -1)  # the last is that of no contact
        of_stones, of_seams = (
            [_most(owner[some], self._size) for some in sets] for sets in (self._stones, joined)
        )
        divided = any((owner[seam] != owner[seam[:, :1]]).any() for seam in joined)
        at = _places(np.concatenate(self.contacts), len(self._sides))  # contacts rank after rank
        body_at = _places(self._bodies, len(self.part))
        made = []
        for rank in range(self._size):
            its = [seam[of == rank] for seam, of in zip(joined, of_seams, strict=True)]
            met, local = self._contacts_of(rank, its, of_stones)
            place = _places(local, len(self._sides))
            own = [group[owner[group[:, 0]] == rank] for group in groups]
            stones = self._stones_of(rank, met, of_stones)
            bodies = self._bodies_of(rank)
            self.met.append(met)
            self._held.append(
                [(some, place[contacts[some]]) for contacts, some in zip(self._stones, stones, strict=True)]
            )
            made.append(
                Share(
                    dimension=self._dimension,
                    width=self._width,
                    count=len(self.contacts[rank]),
                    met=len(met),
                    contacts=at[local],
                    stones=tuple(
                        of[some] == rank for of, some in zip(of_stones, stones, strict=True) if len(some)
                    ),
                    groups=[place[group] for group in own if len(group)],
                    seams=[place[seam] for seam in its if len(seam)],
                    interface=interface[met],
                    divided=divided,
                    elastic=self._elastic[self.contacts[rank]],
                    bodies=_places(bodies, len(self.part))[self._sides[self.contacts[rank]]],
                    places=body_at[bodies],
                    own=int((self.part == rank).sum()),
                    everywhere=self._bodies,
                    library=self._library,
                )
            )
        return made

    def _contacts_of(
        self, rank: int, its: list[IntArray], of_stones: list[IntArray]
    ) -> tuple[IntArray, IntArray]:
        """Contacts of a rank and its seams, (m,); the same, and those that its stones touch beside, (t,)."""
        near = self._near(np.concatenate([self.contacts[rank], *(seam.ravel() for seam in its)]))
        met = np.concatenate([self.contacts[rank], np.flatnonzero(near[:-1] & (self._owner != rank))])
        touched = [contacts[of == rank].ravel() for contacts, of in zip(self._stones, of_stones, strict=True)]
        beside = np.unique(np.concatenate([np.zeros(0, dtype=np.int64), *touched]))
        return met, np.concatenate([met, beside[(beside >= 0) & ~near[beside]]])

    def _stones_of(self, rank: int, met: IntArray, of_stones: list[IntArray]) -> list[IntArray]:
        """Stones of a rank, and those at its contacts and its seams' ones, kind by kind."""
        near = self._near(met)
        return [
            np.flatnonzero((of == rank) | near[contacts].any(axis=1))
            for contacts, of in zip(self._stones, of_stones, strict=True)
        ]

    def _bodies_of(self, rank: int) -> IntArray:
        """Bodies of a rank, and others at its contacts, (b,)."""
        its, sides = np.flatnonzero(self.part == rank), self._sides[self.contacts[rank]]
        return np.concatenate([its, np.setdiff1d(sides[sides >= 0], its)])

    def _near(self, contacts: IntArray) -> Mask:
        """Which contacts are among some, (c + 1,): the last is none."""
        near = np.zeros(len(self._sides) + 1, dtype=bool)
        near[contacts] = True
        return near


def some(values: FloatArray, contacts: IntArray) -> FloatArray:
    """Values of some contacts, shape (k, ...); the same array where they are all.

    Parameters
    ----------
    values : Of all contacts, shape (c, ...). contacts : Numbers of some, ascending, shape (k,).
    """
    return values if len(contacts) == len(values) else values[contacts]


def whole(contacts: list[IntArray], parts: Sequence[FloatArray]) -> FloatArray:
    """Values of all contacts, shape (c, ...).

    Parameters
    ----------
    contacts : Those of each rank, ascending. parts : What it has of its own, shape (k, ...).
    """
    if len(parts) == 1:
        return parts[0]
    found = np.empty((sum(map(len, contacts)), *parts[0].shape[1:]), dtype=parts[0].dtype)
    for own, part in zip(contacts, parts, strict=True):
        found[own] = part
    return found


def _places(values: IntArray, count: int) -> IntArray:
    """Where each of ``count`` numbers, and at the end none, stands among some; −1: nowhere, (count + 1,)."""
    places = np.full(count + 1, -1)
    places[values] = np.arange(len(values))
    return places


def _parted(pattern: BodyPattern, team: Leader) -> IntArray:
    """Rank of each body, (b,)."""
    count = pattern.count
    rows = np.repeat(np.arange(count), np.diff(pattern.pointer))
    joined = rows != pattern.indices
    edges = np.stack([rows[joined], pattern.indices[joined]])
    first = np.linspace(0, count, team.size + 1).astype(np.int64)
    bounds = np.searchsorted(edges[0], first)
    shares = [
        (first[rank : rank + 2] - first[rank], count, edges[:, low:high])
        for rank, (low, high) in enumerate(pairwise(bounds))
    ]
    return np.concatenate(team.call(_partition, shares))


def _most(owners: IntArray, size: int) -> IntArray:
    """Ranks that own most of each n contacts, (n,), from their owners, −1 for none, (n, s)."""
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
