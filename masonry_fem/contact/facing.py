"""Facing: faces of near blocks that look at each other, and which of the two carries the other."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit

from masonry_fem.contact.posed import Posed, clearances
from masonry_fem.contact.surface import PosedFaces
from masonry_fem.solid.mesh import IntArray
from masonry_fem.solid.pose import FloatArray

TILTED = 1e-5  # radians between faces above which one of them carries the other
ALIKE = 0.5  # of the deeper: how far two tilted faces reach into the blocks must differ for one to carry


@dataclass(frozen=True, slots=True)
class FacePairs:
    """Pairs of face pieces that may touch: candidate and antagonist rows of PosedFaces, (m,).

    ``carried`` where the antagonist carries a tilted candidate, and gives the normal alone.
    """

    candidate: IntArray
    antagonist: IntArray
    carried: np.ndarray

    def __len__(self) -> int:
        return len(self.candidate)


def facing(faces: PosedFaces, pairs: IntArray, far: float, angle: float) -> tuple[IntArray, IntArray]:
    """Pieces of near blocks that look at each other and have near boxes: rows (m,), (m,)."""
    low, high = faces.points.min(axis=1), faces.points.max(axis=1)
    rows: IntArray = facing_rows(
        faces.normal, low, high, faces.first, pairs, -math.cos(math.radians(angle)), far
    )
    return rows[:, 0], rows[:, 1]


@njit(cache=True)
def facing_rows(
    normal: FloatArray,
    low: FloatArray,
    high: FloatArray,
    first: IntArray,
    pairs: IntArray,
    cosine: float,
    far: float,
) -> IntArray:
    """The pairs of rows of ``facing``, shape (m, 2); of thick masonry all pairs of faces fill memories."""
    found = np.empty((max(16, 2 * len(pairs)), 2), dtype=np.int64)
    total = 0
    for pair in pairs:
        for i in range(first[pair[0]], first[pair[0] + 1]):
            for j in range(first[pair[1]], first[pair[1] + 1]):
                across, near = 0.0, True
                for c in range(normal.shape[1]):
                    across += normal[i, c] * normal[j, c]
                    near = near and low[i, c] <= high[j, c] + far and low[j, c] <= high[i, c] + far
                if across > cosine or not near:
                    continue
                if total == len(found):
                    more = np.empty((2 * total, 2), dtype=np.int64)
                    more[:total] = found
                    found = more
                found[total, 0], found[total, 1] = i, j
                total += 1
    return found[:total].copy()


def orient(rows: tuple[IntArray, IntArray], posed: Posed, faces: PosedFaces) -> FacePairs:
    """Choose candidate and antagonist of each pair of faces."""
    antagonist, candidate = rows[0].copy(), rows[1].copy()  # the later block is the candidate
    cosine = -np.einsum("md,md->m", faces.normal[candidate], faces.normal[antagonist])
    tilted = cosine < math.cos(TILTED)
    swap = posed.support[faces.block[candidate]] & ~posed.support[faces.block[antagonist]]
    # of tilted ones the face in front of which all of the other block lies carries it; of two curved
    # ones neither does, and the normal lies between
    pair = np.flatnonzero(tilted)
    carries = [
        clearances(
            posed.vertices, posed.count, faces.block[other[pair]], faces.points[own[pair], 0],
            faces.normal[own[pair]],
        )
        for own, other in ((candidate, antagonist), (antagonist, candidate))
    ]  # fmt: skip
    rounding = 1e-9 * np.sqrt(faces.area[candidate[pair]] + faces.area[antagonist[pair]])
    clear = np.abs(carries[0] - carries[1]) > np.maximum(rounding, ALIKE * np.abs(carries).max(axis=0))
    swap[pair] = np.where(clear, carries[0] > carries[1], swap[pair])
    carried = np.zeros(len(tilted), dtype=bool)
    carried[pair] = clear
    candidate[swap], antagonist[swap] = antagonist[swap], candidate[swap]
    return FacePairs(candidate, antagonist, carried)
