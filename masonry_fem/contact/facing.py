"""Facing: faces of near blocks that look at each other, and which of the two carries the other."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from masonry_fem.contact.posed import Posed, clearances
from masonry_fem.contact.surface import PosedFaces
from masonry_fem.host.compiled import compiled, put
from masonry_fem.solid.mesh import IntArray
from masonry_fem.solid.pose import FloatArray

TILTED = 1e-5  # angle between faces [rad] above which one of them carries the other
# of two inclined faces one carries the other only if the depths to which they reach into the blocks differ
# by more than this share of the larger depth
ALIKE = 0.5
AT_ONCE = 1 << 20  # pairs of blocks that are looked at in one compiled call, which Ctrl-C waits for


@dataclass(frozen=True, slots=True)
class FacePairs:
    """Pairs of face pieces that may touch, m of them.

    Attributes
    ----------
    candidate, antagonist : Rows of ``PosedFaces``, each of shape (m,).
    carried : True if the two are inclined to each other and all of the candidate's block lies in front of the
        antagonist; then the antagonist alone gives the normal. Shape (m,).
    """

    candidate: IntArray
    antagonist: IntArray
    carried: np.ndarray

    def __len__(self) -> int:
        return len(self.candidate)

    def only(self, rows: slice) -> FacePairs:
        """Some of the pairs."""
        return FacePairs(self.candidate[rows], self.antagonist[rows], self.carried[rows])


def facing(faces: PosedFaces, pairs: IntArray, far: float, angle: float) -> tuple[IntArray, IntArray]:
    """Pieces of faces that look at each other and whose bounding boxes are near.

    Parameters
    ----------
    faces : The faces of all blocks.
    pairs : Pairs of near blocks, shape (p, 2).
    far : Largest gap between bounding boxes [m].
    angle : Largest angle between one normal and the opposite of the other [degrees].

    Returns
    -------
    Rows of ``faces``, one array for each block of the pairs, each of shape (m,).
    """
    low, high = faces.points.min(axis=1), faces.points.max(axis=1)
    cosine = -math.cos(math.radians(angle))
    lots = [pairs[start : start + AT_ONCE] for start in range(0, len(pairs), AT_ONCE)] or [pairs]
    rows = np.concatenate(
        [facing_rows(faces.normal, low, high, faces.first, lot, cosine, far) for lot in lots]
    )
    return rows[:, 0], rows[:, 1]


@compiled
def facing_rows(
    normal: FloatArray,
    low: FloatArray,
    high: FloatArray,
    first: IntArray,
    pairs: IntArray,
    cosine: float,
    far: float,
) -> IntArray:
    """The compiled loop of ``facing``; arrays of all pairs of faces of thick masonry would fill the memory.

    Parameters
    ----------
    normal : Outward unit normals of the pieces, shape (f, d).
    low, high : Opposite corners of their bounding boxes, shape (f, d) [m].
    first : First piece of each block, shape (b + 1,).
    pairs : Pairs of near blocks, shape (p, 2).
    cosine : Largest scalar product of the two normals.
    far : Largest gap between bounding boxes [m].

    Returns
    -------
    Pairs of pieces, shape (m, 2).
    """
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
                    put(more, found)
                    found = more
                found[total, 0], found[total, 1] = i, j
                total += 1
    return found[:total].copy()


def orient(rows: tuple[IntArray, IntArray], posed: Posed, faces: PosedFaces) -> FacePairs:
    """Choose candidate and antagonist of each pair of faces.

    The later block is the candidate, unless it is a support. If the faces are inclined to each other, the
    face with all of the other block in front of it becomes the antagonist.

    Parameters
    ----------
    rows : Rows of ``faces``, one array for each side, each of shape (m,).
    posed : Corners of all blocks.
    faces : The faces of all blocks.
    """
    antagonist, candidate = rows[0].copy(), rows[1].copy()  # the later block is the candidate
    cosine = -np.einsum("md,md->m", faces.normal[candidate], faces.normal[antagonist])
    tilted = cosine < math.cos(TILTED)
    swap = posed.support[faces.block[candidate]] & ~posed.support[faces.block[antagonist]]
    # of two inclined faces the one with all of the other block in front of it carries that block; between
    # two curved surfaces neither does, and the normal lies between theirs
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
