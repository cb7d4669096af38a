"""Bodies: the matrix of the bodies' velocities, factorised by each rank or by all together."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from masonry_fem.host.ranks import Member
from masonry_fem.nscd.linear import Factorised, Library, factorise
from masonry_fem.nscd.mumps import petsc
from masonry_fem.nscd.solvers.elastic_krylov import bodies_of
from masonry_fem.nscd.solvers.elastic_ranks.exchange import NUMBER, Exchange
from masonry_fem.nscd.solvers.elastic_ranks.share import Share

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

SCALING = 8  # ICNTL of MUMPS: columns are scaled already, and to do it again costs a seventh of a factor


def blocks_at(share: Share, coupled: IntArray) -> tuple[IntArray, IntArray]:
    """Block rows and columns of what a rank adds to the bodies' matrix, −1 where there is no body, (k,)."""
    place = np.append(share.places, -1)
    rows, columns = [coupled[0]], [coupled[1]]
    for group in share.groups:
        bodies = place[bodies_of(share.bodies, group)[0]]
        rows.append(np.repeat(bodies, bodies.shape[1], axis=1).ravel())
        columns.append(np.tile(bodies, bodies.shape[1]).ravel())
    row, column = np.concatenate(rows), np.concatenate(columns)
    absent = (row < 0) | (column < 0)
    return np.where(absent, -1, row), np.where(absent, -1, column)


class BodiesOfEach:
    """The bodies' matrix, all of it on each rank.

    Parameters
    ----------
    member : The rank.
    share : Its part of the contacts.
    coupled : Block rows and columns of what it adds beside its interfaces' ones, shape (2, k).
    """

    def __init__(self, member: Member, share: Share, coupled: IntArray) -> None:
        assert share.library is not None
        self._member, self._places, self._own = member, share.places, share.own
        self._library: Library = share.library
        self._width = share.width
        everywhere = member.comm.allgather(blocks_at(share, coupled))
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


class BodiesTogether:
    """The bodies' matrix, of each rank the rows of its own.

    Parameters
    ----------
    member : The rank.
    share : Its part of the contacts.
    coupled : Block rows and columns of what it adds beside its interfaces' ones, shape (2, k).
    """

    def __init__(self, member: Member, share: Share, coupled: IntArray) -> None:
        library, m = petsc(), share.width
        self._member, self._own = member, share.own
        self._exchange = Exchange(member, share.places, share.own, m)
        self._matrix = library.Mat().createAIJ(((share.own * m, None),) * 2, comm=member.comm)
        first, last = self._matrix.getOwnershipRange()
        row, column = blocks_at(share, coupled)
        away = (row >= 0) & ((row < first // m) | (row >= last // m))
        self._bytes = NUMBER * m**2 * int(away.sum())  # that leave it: of all ranks as many as arrive
        at = np.arange(m)
        rows = np.where(row[:, None, None] < 0, -1, row[:, None, None] * m + at[:, None])
        columns = np.where(column[:, None, None] < 0, -1, column[:, None, None] * m + at)
        places = [part.ravel().astype(library.IntType) for part in np.broadcast_arrays(rows, columns)]
        self._matrix.setPreallocationCOO(*places)
        self._matrix.setValuesCOO(np.zeros(places[0].size))  # PETSc asks for values before a factor
        self._factor = library.KSP().create(member.comm)
        self._factor.setType("preonly")
        self._factor.setOperators(self._matrix)
        steps = self._factor.getPC()
        steps.setType("lu")
        steps.setFactorSolverType("mumps")
        steps.setFactorSetUpSolverType()
        steps.getFactorMatrix().setMumpsIcntl(SCALING, 0)
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
        """As ``BodiesOfEach.moved``; MUMPS refines nothing."""
        left = balance - self._exchange.summed(given)
        with self._member.on("bodies' solution"):
            moved = np.full_like(left, np.nan)
            if self._regular:
                self._given.array[:] = left.ravel()
                self._factor.solve(self._given, self._found)
                moved[:] = self._found.array.reshape(left.shape)
        return self._exchange.spread(moved)
