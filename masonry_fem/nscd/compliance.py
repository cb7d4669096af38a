"""Compliance: W_el as an operator, stored block by block or as what stones of one kind share.

``ContactProblem.operator`` answers what solvers ask of W_el, whichever way it is held:

    W = problem.operator
    velocity = W @ impulse            # (c d,) -> (c d,)
    W.diagonal(), W.among(groups)     # blocks of single contacts, and of sets of contacts
    W.matrix()                        # all of it, block-sparse

Stones of one shape that are touched at the same places have one matrix, in the shape's axes, however they
lie and whichever frames their contacts have. Multiplied stone by stone, out of that, a product takes a tenth
of the time that it takes entry by entry, and a wall of ten thousand stones needs a few matrices.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from masonry_fem.nscd.blocks import assemble_blocks, block_rows
from masonry_fem.nscd.transfer import add_products

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
Mask = NDArray[np.bool_]


class Operator(ABC):
    """W_el between c contacts of d components.

    Attributes
    ----------
    shape : Of the matrix, (c d, c d).
    blocksize : Of its blocks, (d, d).
    """

    shape: tuple[int, int]
    blocksize: tuple[int, int]

    @abstractmethod
    def __matmul__(self, impulse: FloatArray) -> FloatArray:
        """Velocities (c d,) from impulses (c d,)."""

    def elastic(self) -> Mask:
        """Contacts that have a row, shape (c,)."""
        found: Mask = self.terms() > 0
        return found

    @abstractmethod
    def terms(self) -> IntArray:
        """Contacts whose impulses a product sums up at each contact, shape (c,)."""

    @abstractmethod
    def diagonal(self) -> FloatArray:
        """Each contact's own block, shape (c, d, d) [1/kg]."""

    def giving(self) -> FloatArray:
        """How each contact gives way under its impulse as blocks deform: its own block, (c, d, d) [1/kg]."""
        return self.diagonal()

    def norms(self) -> FloatArray:
        """‖block‖₂ of each contact by which it gives way, shape (c,) [1/kg]."""
        from masonry_fem.nscd.contact_measures import spectral_norms  # noqa: PLC0415 - Numba is slow to import

        found: FloatArray = spectral_norms(np.ascontiguousarray(self.giving()))
        return found

    @abstractmethod
    def among(self, groups: IntArray) -> FloatArray:
        """Dense matrices between the contacts of each of n sets (n, k), shape (n, k d, k d)."""

    @abstractmethod
    def strongest(self, least: float) -> tuple[IntArray, FloatArray]:
        """Pairs of contacts of a stone that are coupled by more than ``least``, and by how much.

        Coupling is the norm of a block over the geometric mean of those of both contacts' own ones.

        Returns
        -------
        Contacts (p, 2), and their coupling (p,). A pair may come once for each stone that it has in common.
        """

    @abstractmethod
    def magnitudes(self) -> sparse.bsr_array | Shared:
        """The same with no entry below its absolute value: it bounds the rounding of products."""

    @abstractmethod
    def faulty(self) -> tuple[int, int] | None:
        """Two contacts between which a number is not finite; None: there are none."""

    @abstractmethod
    def matrix(self) -> sparse.bsr_array:
        """All of it, shape (c d, c d)."""


class Stored(Operator):
    """A block-sparse matrix.

    Parameters
    ----------
    whole : Shape (c d, c d), in blocks (d, d), its columns sorted.
    """

    def __init__(self, whole: sparse.bsr_array) -> None:
        self.whole, self.shape, self.blocksize = whole, whole.shape, whole.blocksize

    def __matmul__(self, impulse: FloatArray) -> FloatArray:
        """Velocities (c d,) from impulses (c d,)."""
        velocity: FloatArray = self.whole @ impulse
        return velocity

    def terms(self) -> IntArray:
        """Contacts whose impulses a product sums up at each contact, shape (c,)."""
        return self._count

    def diagonal(self) -> FloatArray:
        """Each contact's own block, zero where none is stored, shape (c, d, d) [1/kg]."""
        c = len(self._count)
        blocks = np.zeros((c, *self.blocksize))
        rows = np.repeat(np.arange(c), self._count)
        own = np.flatnonzero(rows == self.whole.indices)
        np.add.at(blocks, rows[own], self.whole.data[own])
        return blocks

    def among(self, groups: IntArray) -> FloatArray:
        """Dense matrices between the contacts of each of n sets (n, k), shape (n, k d, k d)."""
        from masonry_fem.nscd.scatter import take_dense  # noqa: PLC0415 - Numba is slow to import

        taken: FloatArray = take_dense(self.whole.indptr, self.whole.indices, self.whole.data, groups)
        return taken

    def strongest(self, least: float) -> tuple[IntArray, FloatArray]:
        """Pairs of contacts that are coupled by more than ``least``, and by how much."""
        rows = np.repeat(np.arange(len(self._count)), self._count)
        later = rows < self.whole.indices
        pairs = np.column_stack([rows[later], self.whole.indices[later]]).astype(np.int64)
        return _stronger(pairs, _norms(self.whole.data[later]), _norms(self.diagonal()), least)

    def magnitudes(self) -> sparse.bsr_array:
        """Absolute values."""
        sizes = self.whole.copy()
        np.abs(sizes.data, out=sizes.data)
        return sizes

    def faulty(self) -> tuple[int, int] | None:
        """Two contacts between which a number is not finite; None: there are none."""
        data = self.whole.data
        if np.isfinite(data).all():
            return None
        block = int(np.nonzero(~np.isfinite(data.reshape(len(data), -1)).all(axis=1))[0][0])
        row = int(np.searchsorted(self.whole.indptr, block, side="right")) - 1
        return row, int(self.whole.indices[block])

    def matrix(self) -> sparse.bsr_array:
        """The matrix itself."""
        return self.whole

    @property
    def _count(self) -> IntArray:
        """Blocks in each row, shape (c,)."""
        if not self.shape[0]:  # a matrix of nothing has blocks of another size
            return np.zeros(0, dtype=np.int64)
        return np.diff(self.whole.indptr).astype(np.int64)


@dataclass(frozen=True, slots=True)
class Kinds:
    """n stones with s sides each, of k kinds that give way alike; stones of a kind follow each other.

    Attributes
    ----------
    contacts : Of each stone, in one order, −1 for those that take no part, shape (n, s).
    turns : What turns velocities from the stone's axes into the contact's frame, negative on antagonists,
        shape (n, s, d, d).
    matrices : Velocities of the s points from impulses on them, in the stone's axes, (k, s d, s d) [1/kg].
    kind : Of each stone, shape (n,).
    """

    contacts: IntArray
    turns: FloatArray
    matrices: FloatArray
    kind: IntArray

    @classmethod
    def alike(cls, contacts: IntArray, turns: FloatArray, matrix: FloatArray) -> Kinds:
        """Stones of one kind.

        Parameters
        ----------
        contacts, turns : As they are held, shapes (n, s) and (n, s, d, d).
        matrix : Shape (s d, s d).
        """
        return cls(contacts, turns, matrix[None], np.zeros(len(contacts), dtype=np.int64))

    @classmethod
    def together(cls, kinds: Sequence[Kinds]) -> tuple[Kinds, ...]:
        """The same stones, those with as many sides as one.

        Parameters
        ----------
        kinds : With any number of sides.
        """
        of_sides: dict[int, list[Kinds]] = {}
        for one in kinds:
            of_sides.setdefault(one.contacts.shape[1], []).append(one)
        return tuple(cls._joined(some) if len(some) > 1 else some[0] for some in of_sides.values())

    @classmethod
    def _joined(cls, kinds: Sequence[Kinds]) -> Kinds:
        first = np.cumsum([0, *(len(one.matrices) for one in kinds)])
        return cls(
            np.concatenate([one.contacts for one in kinds]),
            np.concatenate([one.turns for one in kinds]),
            np.concatenate([one.matrices for one in kinds]),
            np.concatenate([one.kind + at for one, at in zip(kinds, first[:-1], strict=True)]),
        )

    def some(self, chosen: Mask) -> Kinds:
        """Some of the stones, shape (n,)."""
        return replace(self, contacts=self.contacts[chosen], turns=self.turns[chosen], kind=self.kind[chosen])

    def numbered(self, contacts: IntArray) -> Kinds:
        """The same with other numbers of contacts; stones without any left are left out.

        Parameters
        ----------
        contacts : Of each stone, −1 for those that take no part, shape (n, s).
        """
        return replace(self, contacts=contacts).some((contacts >= 0).any(axis=1))

    def bare(self) -> Kinds:
        """The same without matrices that no stone has."""
        used, kind = np.unique(self.kind, return_inverse=True)
        if len(used) == len(self.matrices):
            return self
        return replace(self, matrices=self.matrices[used], kind=kind)

    def blocks(self) -> FloatArray:
        """The matrices in blocks of two sides, shape (k, s, s, d, d)."""
        s, d = self.turns.shape[1:3]
        return self.matrices.reshape(-1, s, d, s, d).swapaxes(2, 3)


class Shared(Operator):
    """W_el by kinds of stones, and what the contacts' own beds give way.

    Parameters
    ----------
    count, dimension : c and d.
    kinds : The stones. Each contact is one of at most two of them.
    symmetric : Whether all matrices are.
    bed : Diagonal that is added, shape (c, d) [1/kg].
    """

    def __init__(
        self,
        count: int,
        dimension: int,
        kinds: Sequence[Kinds],
        symmetric: bool = True,
        bed: FloatArray | None = None,
    ) -> None:
        self.count, self.dimension, self.kinds, self.bed = count, dimension, Kinds.together(kinds), bed
        self.shape, self.blocksize = (count * dimension,) * 2, (dimension, dimension)
        self.symmetric = symmetric
        self._matrix: sparse.bsr_array | None = None
        self._diagonal: FloatArray | None = None
        self._norms: FloatArray | None = None
        self._sound = False  # known to have no number that is not finite

    def __getstate__(self) -> dict[str, Any]:
        """What another process gets: no matrices of stones that a part has left behind."""
        return vars(self) | {"kinds": tuple(kind.bare() for kind in self.kinds)}

    @property
    def nnz(self) -> int:
        """Numbers that the stones' matrices would have if none was shared, and those of the beds."""
        beds = 0 if self.bed is None else int(np.count_nonzero(self.bed))
        numbers: int = sum(
            kind.contacts.size * kind.turns.shape[2] * kind.matrices.shape[2] for kind in self.kinds
        )
        return numbers + beds

    def __matmul__(self, impulse: FloatArray) -> FloatArray:
        """Velocities (c d,) from impulses (c d,)."""
        given = np.ascontiguousarray(impulse, dtype=np.float64).reshape(self.count, self.dimension)
        velocity = np.zeros_like(given)
        for kind in self.kinds:
            add_products(kind.contacts, kind.turns, kind.matrices, kind.kind, given, velocity)
        if self.bed is not None:
            velocity += self.bed * given
        return velocity.ravel()

    def terms(self) -> IntArray:
        """Contacts whose impulses a product sums up at each contact, shape (c,)."""
        total = np.zeros(self.count, dtype=np.int64)
        for kind in self.kinds:
            stones = np.bincount(kind.contacts.ravel() + 1, minlength=self.count + 1)[1:]
            total += kind.contacts.shape[1] * stones
        if self.bed is not None:
            total += self.bed.any(axis=1)
        return total

    def diagonal(self) -> FloatArray:
        """Each contact's own block, shape (c, d, d) [1/kg]."""
        if self._diagonal is None:
            self._diagonal = self._own_blocks()
        return self._diagonal.copy()

    def norms(self) -> FloatArray:
        """‖block‖₂ of each contact by which it gives way, shape (c,) [1/kg]."""
        if self._norms is None:
            self._norms = super().norms()
        return self._norms.copy()

    def among(self, groups: IntArray, room: FloatArray | None = None) -> FloatArray:
        """Dense matrices between the contacts of each of n sets (n, k), shape (n, k d, k d).

        Parameters
        ----------
        groups : The sets. room : What they are written to, as large; None: new room.
        """
        from masonry_fem.nscd.scatter import add_within  # noqa: PLC0415 - Numba is slow to import

        (n, k), d = groups.shape, self.dimension
        number, place = np.full((2, self.count + 1), -1)  # the last is that of contacts that take no part
        number[groups], place[groups] = np.arange(n)[:, None], np.arange(k)
        taken = np.empty((n, k * d, k * d)) if room is None else room
        taken[:] = 0.0
        for kind in self.kinds:
            at, of = number[kind.contacts], place[kind.contacts]
            add_within(taken, at, of, kind.turns, kind.matrices, kind.kind)
        if self.bed is not None:
            at = np.arange(k * d)
            taken[:, at, at] += self.bed[groups].reshape(n, -1)
        return taken

    def _own_blocks(self) -> FloatArray:
        """Each contact's own block, shape (c, d, d)."""
        from masonry_fem.nscd.scatter import add_own  # noqa: PLC0415 - Numba is slow to import

        d = self.dimension
        blocks = np.zeros((self.count, d, d))
        for kind in self.kinds:
            add_own(blocks, kind.contacts, kind.turns, kind.matrices, kind.kind)
        if self.bed is not None:
            axes = np.arange(d)
            blocks[:, axes, axes] += self.bed
        return blocks

    def strongest(self, least: float) -> tuple[IntArray, FloatArray]:
        """Pairs of contacts of a stone that are coupled by more than ``least``, and by how much."""
        pairs, norms = [np.zeros((0, 2), dtype=np.int64)], [np.zeros(0)]
        for kind in (kind.bare() for kind in self.kinds):
            norm = _norms(kind.blocks())
            # a contact gives way by at least as much as on this side alone
            own = np.sqrt(np.diagonal(norm, axis1=1, axis2=2))
            of, one, other = np.nonzero(np.triu(norm > least * own[:, :, None] * own[:, None], 1))
            stone, pair = _joins(kind.kind, of, len(kind.matrices))
            both = np.column_stack([kind.contacts[stone, one[pair]], kind.contacts[stone, other[pair]]])
            there = (both >= 0).all(axis=1)
            pairs.append(both[there])
            norms.append(norm[of, one, other][pair[there]])
        return _stronger(np.concatenate(pairs), np.concatenate(norms), _norms(self.diagonal()), least)

    def magnitudes(self) -> Shared:
        """Products of absolute values: at least those of the products."""
        kinds = [
            replace(kind, turns=np.abs(kind.turns), matrices=np.abs(kind.matrices)) for kind in self.kinds
        ]
        bed = None if self.bed is None else np.abs(self.bed)
        return Shared(self.count, self.dimension, kinds, self.symmetric, bed)

    def faulty(self) -> tuple[int, int] | None:
        """Two contacts between which a number is not finite; None: there are none."""
        if self._sound:
            return None
        for kind in self.kinds:
            wrong = ~np.isfinite(kind.matrices).all(axis=(1, 2))[kind.kind]
            if wrong.any():
                stone = int(np.argmax(wrong))
                matrix = kind.matrices[kind.kind[stone]]
                row, column = np.argwhere(~np.isfinite(matrix))[0] // self.dimension
                return int(kind.contacts[stone, row]), int(kind.contacts[stone, column])
        if self.bed is not None and not np.isfinite(self.bed).all():
            contact = int(np.argwhere(~np.isfinite(self.bed))[0, 0])
            return contact, contact
        self._sound = True
        return None

    def matrix(self) -> sparse.bsr_array:
        """All of it, shape (c d, c d)."""
        if self._matrix is None:
            parts = [part for kind in self.kinds for part in _parts(kind)]
            stones = assemble_blocks(self.count, self.dimension, parts, symmetric=self.symmetric)
            self._matrix = stones if self.bed is None else _sum(stones, self.bed)
        return self._matrix

    def only(self, contacts: IntArray) -> Shared:
        """The rows and columns of some contacts, numbered in the order given.

        Parameters
        ----------
        contacts : Shape (k,).
        """
        place = np.full(self.count + 1, -1)
        place[contacts] = np.arange(len(contacts))
        kinds = [kind.numbered(place[kind.contacts]) for kind in self.kinds]
        bed = None if self.bed is None else self.bed[contacts]
        some = Shared(len(contacts), self.dimension, kinds, self.symmetric, bed)
        some._sound = self._sound
        # a contact's own block is the same: both its stones stay
        some._diagonal = None if self._diagonal is None else self._diagonal[contacts]
        some._norms = None if self._norms is None else self._norms[contacts]
        return some

    def plus(self, bed: FloatArray) -> Shared:
        """The same with what contacts give way by themselves added.

        Parameters
        ----------
        bed : Diagonal, shape (c, d) [1/kg].
        """
        both = bed if self.bed is None else self.bed + bed
        return Shared(self.count, self.dimension, self.kinds, self.symmetric, both)


def _joins(kind: IntArray, of: IntArray, count: int) -> tuple[IntArray, IntArray]:
    """Every stone with every item of its kind: numbers of both.

    Parameters
    ----------
    kind : Of each stone, shape (n,). of : Kind of each item, ascending, shape (p,). count : Kinds.
    """
    first, times = np.searchsorted(of, np.arange(count)), np.bincount(of, minlength=count)
    stone = np.repeat(np.arange(len(kind)), times[kind])
    begun = np.cumsum(times[kind]) - times[kind]  # where each stone's joins begin
    return stone, np.arange(len(stone)) - begun[stone] + first[kind][stone]


def _norms(blocks: FloatArray) -> FloatArray:
    """Frobenius norms of blocks (..., d, d), shape (...)."""
    norms: FloatArray = np.sqrt(np.einsum("...ij,...ij->...", blocks, blocks))
    return norms


def _stronger(
    pairs: IntArray, norms: FloatArray, own: FloatArray, least: float
) -> tuple[IntArray, FloatArray]:
    """Those of some pairs that are coupled by more than ``least``, and their coupling.

    Parameters
    ----------
    pairs : Shape (p, 2). norms : Of the blocks between them, shape (p,).
    own : Of contacts' own blocks, shape (c,).
    """
    scale = np.sqrt(own[pairs].prod(axis=1))
    strong = norms > least * scale
    return pairs[strong], norms[strong] / scale[strong]


def _parts(kinds: Kinds) -> Iterator[tuple[IntArray, FloatArray]]:
    """Contacts of each stone that take part, and the matrix between them in their frames."""
    s, d = kinds.turns.shape[1:3]
    for contacts, turns, kind in zip(kinds.contacts, kinds.turns, kinds.kind, strict=True):
        rows = (turns @ kinds.matrices[kind].reshape(s, d, s * d)).reshape(s * d, s, d).swapaxes(0, 1)
        turned = (rows @ turns.swapaxes(1, 2)).swapaxes(0, 1).reshape(s, d, s, d)
        there = np.flatnonzero(contacts >= 0)
        if len(there) < s:
            turned = turned[there][:, :, there]
        yield contacts[there], turned.reshape(len(there) * d, -1)


def operator(compliance: sparse.bsr_array | Shared) -> Operator:
    """W_el as an operator.

    Parameters
    ----------
    compliance : As a contact problem has it.
    """
    return compliance if isinstance(compliance, Shared) else Stored(compliance)


def only(compliance: sparse.bsr_array | Shared, contacts: IntArray) -> sparse.bsr_array | Shared:
    """Rows and columns of some contacts.

    Parameters
    ----------
    compliance : Of c contacts. contacts : Ascending, shape (k,).
    """
    return compliance.only(contacts) if isinstance(compliance, Shared) else _part(compliance, contacts)


def plus(compliance: sparse.bsr_array | Shared, bed: FloatArray) -> sparse.bsr_array | Shared:
    """The compliance and what contacts give way by themselves.

    Parameters
    ----------
    compliance : Of c contacts. bed : Diagonal, shape (c, d) [1/kg].
    """
    return compliance.plus(bed) if isinstance(compliance, Shared) else _sum(compliance, bed)


def _part(matrix: sparse.bsr_array, contacts: IntArray) -> sparse.bsr_array:
    d, count = matrix.blocksize[0], len(contacts)
    if not count:
        return sparse.bsr_array((0, 0), blocksize=(1, 1))
    place = np.full(matrix.shape[0] // d, -1, dtype=matrix.indices.dtype)
    place[contacts] = np.arange(count)
    row, column = place[block_rows(matrix)], place[matrix.indices]
    inside = np.flatnonzero((row >= 0) & (column >= 0))
    row, column = row[inside], column[inside]
    first = np.zeros(count + 1, dtype=column.dtype)
    np.cumsum(np.bincount(row, minlength=count), out=first[1:])
    return sparse.bsr_array((matrix.data[inside], column, first), shape=(count * d, count * d))


def _sum(matrix: sparse.bsr_array, bed: FloatArray) -> sparse.bsr_array:
    own = sparse.diags_array(bed.ravel()).tobsr(matrix.blocksize)
    return sparse.bsr_array(matrix + own, blocksize=matrix.blocksize)
