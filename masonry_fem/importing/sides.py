"""Sides: the edges of a wall's stones in its plane, and which of them face each other.

    sides = Sides.of(outlines)
    facing = sides.facing(reach=0.05)

Outlines run counter-clockwise, shape (k, 2) each.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from masonry_fem.contact.boxes import near_pairs
from masonry_fem.solid.mesh import IntArray
from masonry_fem.solid.pose import FloatArray

TILT = np.cos(np.radians(15))  # largest angle between sides that face each other


@dataclass(frozen=True, slots=True)
class Facing:
    """Pairs of sides that face each other (m of them).

    Attributes
    ----------
    pairs : Sides, shape (m, 2). gaps : At both ends of what they have in common, < 0 overlaps, (m, 2) [m].
    share : Length of that over the shorter side's, shape (m,).
    """

    pairs: IntArray
    gaps: FloatArray
    share: FloatArray


@dataclass(frozen=True, slots=True)
class Sides:
    """Edges of all outlines, one after another (n of them).

    Attributes
    ----------
    start, end : Corners [m], shape (n, 2). stone : Outline, shape (n,).
    first : First side of each outline and, last, n. along : Unit vectors, shape (n, 2).
    """

    start: FloatArray
    end: FloatArray
    stone: IntArray
    first: IntArray
    along: FloatArray

    @classmethod
    def of(cls, outlines: Sequence[FloatArray]) -> Sides:
        """The sides of outlines."""
        first = np.cumsum([0, *map(len, outlines)])
        start = np.concatenate(outlines)
        end = np.concatenate([np.roll(outline, -1, axis=0) for outline in outlines])
        along = (end - start) / np.linalg.norm(end - start, axis=1, keepdims=True)
        return cls(start, end, np.repeat(np.arange(len(outlines)), np.diff(first)), first, along)

    @property
    def outward(self) -> FloatArray:
        """Unit normals out of the stones, shape (n, 2)."""
        return np.column_stack([self.along[:, 1], -self.along[:, 0]])

    def facing(self, reach: float) -> Facing:
        """Pairs of sides of different stones that look at each other at most ``reach`` apart [m]."""
        one, two = self._near(reach)
        opposite = np.einsum("md,md->m", self.along[one], self.along[two]) < -TILT
        one, two = one[opposite], two[opposite]
        # in coordinates along the first side: begin and end of the second, and their common part
        origin, along, normal = self.start[one], self.along[one], self.outward[one]
        length = np.einsum("md,md->m", self.end[one] - origin, along)
        there = np.stack(
            [np.einsum("md,md->m", point[two] - origin, along) for point in (self.end, self.start)]
        )
        away = np.stack(
            [np.einsum("md,md->m", point[two] - origin, normal) for point in (self.end, self.start)]
        )
        low, high = np.maximum(there[0], 0.0), np.minimum(there[1], length)
        slope = (away[1] - away[0]) / np.maximum(there[1] - there[0], 1e-300)
        gaps = np.stack([away[0] + slope * (at - there[0]) for at in (low, high)], axis=1)
        share = (high - low) / np.maximum(np.minimum(length, there[1] - there[0]), 1e-300)
        kept = (share > 0) & (np.abs(gaps.mean(axis=1)) <= reach)
        return Facing(np.stack([one, two], axis=1)[kept], gaps[kept], share[kept])

    def _near(self, reach: float) -> tuple[IntArray, IntArray]:
        """All pairs of sides of near stones."""
        low = np.minimum.reduceat(self.start, self.first[:-1])
        high = np.maximum.reduceat(self.start, self.first[:-1])
        found = near_pairs(low, high, reach)
        count = np.diff(self.first)
        many = count[found[:, 0]] * count[found[:, 1]]
        pair = np.repeat(np.arange(len(found)), many)
        at = np.arange(len(pair)) - np.repeat(np.cumsum(many) - many, many)
        width = count[found[pair, 1]]
        return self.first[found[pair, 0]] + at // width, self.first[found[pair, 1]] + at % width
