"""Interfaces: where blocks touch, as arrays; one by one they are objects, made as they are looked at.

interfaces = detect(assembly)
interfaces.blocks[:, 0], interfaces[7].polygon
bodies = interfaces.only(~interfaces.tie)
number, first = numbered(interfaces.blocks)     # equal rows get equal numbers
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import overload

import numpy as np

from masonry_fem.contact.contacts import FloatArray, IntArray, Interface


@dataclass(frozen=True, slots=True, eq=False)
class Interfaces(Sequence[Interface]):
    """i interfaces; what the columns mean is told at ``Interface``.

    Attributes
    ----------
    blocks, faces : Shape (i, 2). normal : Shape (i, d). area : Shape (i,). tie : Shape (i,).
    label : Number of each label in ``labels``, shape (i,).
    labels : All labels, and maybe some that none of them has.
    corners : Of all polygons, one after another, shape (k, d) [m].
    gap : At these corners, shape (k,) [m].
    first : First corner of each polygon and, last, k; shape (i + 1,).
    """

    blocks: IntArray
    faces: IntArray
    normal: FloatArray
    area: FloatArray
    tie: np.ndarray
    label: IntArray
    labels: tuple[str, ...]
    corners: FloatArray
    gap: FloatArray
    first: IntArray

    @classmethod
    def of(cls, interfaces: Iterable[Interface], dimension: int) -> Interfaces:
        """The arrays of some interfaces.

        Parameters
        ----------
        interfaces : Where blocks touch. dimension : d.
        """
        if isinstance(interfaces, Interfaces):
            return interfaces
        one_by_one = list(interfaces)
        labels = {text: number for number, text in enumerate(dict.fromkeys(one.label for one in one_by_one))}
        polygons, gaps = [one.polygon for one in one_by_one], [one.gap for one in one_by_one]
        return cls(
            blocks=np.array([one.blocks for one in one_by_one], dtype=np.int64).reshape(-1, 2),
            faces=np.array([one.faces for one in one_by_one], dtype=np.int64).reshape(-1, 2),
            normal=np.array([one.normal for one in one_by_one]).reshape(-1, dimension),
            area=np.array([one.area for one in one_by_one], dtype=float),
            tie=np.array([one.tie for one in one_by_one], dtype=bool),
            label=np.array([labels[one.label] for one in one_by_one], dtype=np.int64),
            labels=tuple(labels),
            corners=np.concatenate([*polygons, np.empty((0, dimension))]),
            gap=np.concatenate([*gaps, np.empty(0)]),
            first=np.cumsum([0, *map(len, polygons)]),
        )

    @classmethod
    def joined(cls, parts: Sequence[Interfaces]) -> Interfaces:
        """Several sets of interfaces as one.

        Parameters
        ----------
        parts : One or more, in their order.
        """
        texts = dict.fromkeys(text for one in parts for text in one.labels)
        labels = {text: number for number, text in enumerate(texts)}
        known = [np.array([labels[text] for text in one.labels], dtype=np.int64) for one in parts]
        ends = np.cumsum([0, *(len(one.corners) for one in parts)])
        firsts = [one.first[:-1] + end for one, end in zip(parts, ends, strict=False)]
        return cls(
            blocks=np.concatenate([one.blocks for one in parts]),
            faces=np.concatenate([one.faces for one in parts]),
            normal=np.concatenate([one.normal for one in parts]),
            area=np.concatenate([one.area for one in parts]),
            tie=np.concatenate([one.tie for one in parts]),
            label=np.concatenate([new[one.label] for one, new in zip(parts, known, strict=True)]),
            labels=tuple(labels),
            corners=np.concatenate([one.corners for one in parts]),
            gap=np.concatenate([one.gap for one in parts]),
            first=np.concatenate([*firsts, ends[-1:]]),
        )

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return int(self.normal.shape[1])

    @property
    def size(self) -> IntArray:
        """How many corners each polygon has, shape (i,)."""
        size: IntArray = np.diff(self.first)
        return size

    @property
    def label_of_each(self) -> list[str]:
        """The label of each."""
        each: list[str] = np.array([*self.labels, ""], dtype=object)[self.label].tolist()
        return each

    @property
    def pairs(self) -> IntArray:
        """Blocks, the lower number first, shape (i, 2)."""
        pairs: IntArray = np.sort(self.blocks, axis=1)
        return pairs

    @property
    def nearest(self) -> FloatArray:
        """Least gap of each, shape (i,) [m]."""
        least: FloatArray = np.minimum.reduceat(self.gap, self.first[:-1]) if len(self) else np.empty(0)
        return least

    def only(self, chosen: np.ndarray) -> Interfaces:
        """Some of them.

        Parameters
        ----------
        chosen : True for each that stays, shape (i,); or numbers in a new order, shape (n,).
        """
        rows = np.flatnonzero(chosen) if chosen.dtype == bool else chosen
        size = self.size[rows]
        first = np.cumsum([0, *size])
        at = np.repeat(self.first[rows] - first[:-1], size) + np.arange(first[-1])
        return replace(
            self, blocks=self.blocks[rows], faces=self.faces[rows], normal=self.normal[rows],
            area=self.area[rows], tie=self.tie[rows], label=self.label[rows],
            corners=self.corners[at], gap=self.gap[at], first=first,
        )  # fmt: skip

    def moved(self, rotation: FloatArray, translation: FloatArray) -> Interfaces:
        """Where motions of their own take them.

        Parameters
        ----------
        rotation, translation : Of each, shapes (i, d, d) and (i, d) [m].
        """
        of = np.repeat(np.arange(len(self)), self.size)
        corners = np.einsum("kij,kj->ki", rotation[of], self.corners) + translation[of]
        return replace(self, corners=corners, normal=np.einsum("kij,kj->ki", rotation, self.normal))

    def __len__(self) -> int:
        """How many there are."""
        return len(self.area)

    @overload
    def __getitem__(self, number: int) -> Interface: ...

    @overload
    def __getitem__(self, number: slice) -> Interfaces: ...

    def __getitem__(self, number: int | slice) -> Interface | Interfaces:
        """One of them, or those of a slice."""
        if isinstance(number, slice):
            return self.only(np.arange(len(self))[number])
        row = range(len(self))[number]
        corners = slice(self.first[row], self.first[row + 1])
        return Interface(
            blocks=(int(self.blocks[row, 0]), int(self.blocks[row, 1])),
            faces=(int(self.faces[row, 0]), int(self.faces[row, 1])),
            normal=self.normal[row],
            polygon=self.corners[corners],
            gap=self.gap[corners],
            area=float(self.area[row]),
            label=self.labels[self.label[row]],
            tie=bool(self.tie[row]),
        )

    def __iter__(self) -> Iterator[Interface]:
        """One after another."""
        return (self[number] for number in range(len(self)))


def among(pairs: IntArray, others: IntArray) -> np.ndarray:
    """Which pairs of blocks are among others, shape (n,).

    Parameters
    ----------
    pairs, others : The lower number first, shapes (n, 2) and (m, 2).
    """
    each = np.array([max(pairs.max(initial=0), others.max(initial=0)) + 1, 1])
    found: np.ndarray = np.isin(pairs @ each, others @ each)
    return found


def numbered(rows: np.ndarray) -> tuple[IntArray, IntArray]:
    """Numbers of rows, equal ones for equal rows, as they first come; and the first row of each number.

    Parameters
    ----------
    rows : Shape (n, k).

    Returns
    -------
    Shapes (n,) and (numbers,).
    """
    order = np.lexsort(rows.T)
    ordered = rows[order]
    starts = np.concatenate([np.ones(min(len(rows), 1), bool), (ordered[1:] != ordered[:-1]).any(axis=1)])
    first = order[starts]  # stable: the first of its kind
    rank = np.empty(len(first), dtype=np.int64)
    rank[np.argsort(first)] = np.arange(len(first))
    found = np.empty(len(rows), dtype=np.int64)
    found[order] = rank[np.cumsum(starts) - 1]
    return found, np.sort(first)
