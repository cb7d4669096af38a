"""InterfaceArrays: interfaces as arrays, for what is done with all of them at once.

    arrays = InterfaceArrays.of(interfaces, dimension)
    number, first = numbered(arrays.blocks)     # equal rows get equal numbers

The objects stay what users and messages deal with.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from masonry_fem.contact.contacts import FloatArray, IntArray, Interface


@dataclass(frozen=True, slots=True)
class InterfaceArrays:
    """i interfaces; what the columns mean is told at ``Interface``.

    Attributes
    ----------
    blocks, faces : Shape (i, 2). normal : Shape (i, d). area : Shape (i,). tie : Shape (i,).
    label : Number of each label in ``labels``, shape (i,).
    labels : The labels, as they first come.
    corners : Of all polygons, one after another, shape (k, d) [m].
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
    first: IntArray

    @classmethod
    def of(cls, interfaces: Sequence[Interface], dimension: int) -> InterfaceArrays:
        """The arrays of some interfaces.

        Parameters
        ----------
        interfaces : Where blocks touch. dimension : d.
        """
        labels = {text: number for number, text in enumerate(dict.fromkeys(one.label for one in interfaces))}
        polygons = [one.polygon for one in interfaces]
        return cls(
            blocks=np.array([one.blocks for one in interfaces], dtype=np.int64).reshape(-1, 2),
            faces=np.array([one.faces for one in interfaces], dtype=np.int64).reshape(-1, 2),
            normal=np.array([one.normal for one in interfaces]).reshape(-1, dimension),
            area=np.array([one.area for one in interfaces], dtype=float),
            tie=np.array([one.tie for one in interfaces], dtype=bool),
            label=np.array([labels[one.label] for one in interfaces], dtype=np.int64),
            labels=tuple(labels),
            corners=np.concatenate([*polygons, np.empty((0, dimension))]),
            first=np.cumsum([0, *map(len, polygons)]),
        )


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
