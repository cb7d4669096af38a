"""Common lines: sides that nearly touch, gathered on straight lines through several stones.

    lines = CommonLines.of(sides, facing, tolerance=0.01)

Pairs are joined from the best fitting on, as long as all ends of what is joined stay within the tolerance
of its line (at last, half as much again, so that a bed joint is not broken for the noise of one stone).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from masonry_fem.importing.sides import Facing, Sides
from masonry_fem.solid.mesh import IntArray
from masonry_fem.solid.pose import FloatArray

LAST = 1.5  # tolerances: largest distance of an end from the line in the second round


@dataclass(frozen=True, slots=True)
class CommonLines:
    """The line of each side.

    Attributes
    ----------
    line : Number of the line of each side, shape (n,).
    point, along : A point and the direction of each line, shape (l, 2). members : Its sides, shape (l,).
    """

    line: IntArray
    point: FloatArray
    along: FloatArray
    members: IntArray

    @classmethod
    def of(cls, sides: Sides, facing: Facing, tolerance: float) -> CommonLines:
        """Lines through sides whose mean gaps are within ``tolerance`` [m]; the others have their own."""
        near = np.flatnonzero(
            (np.abs(facing.gaps.mean(axis=1)) <= tolerance)
            & (np.abs(facing.gaps).max(axis=1) <= 2 * tolerance)
        )
        order = near[np.argsort(np.abs(facing.gaps[near]).max(axis=1), kind="stable")]
        owner = np.arange(len(sides.start))
        groups = {side: [side] for side in range(len(sides.start))}
        for limit in (tolerance, LAST * tolerance):
            _join(sides, facing.pairs[order], limit, owner, groups)
        fits = [_fit(sides, members) for members in groups.values()]
        number = {group: at for at, group in enumerate(groups)}
        return cls(
            np.array([number[int(group)] for group in owner]),
            np.array([point for point, _ in fits]),
            np.array([along for _, along in fits]),
            np.array([len(members) for members in groups.values()]),
        )

    def to_line(self, points: FloatArray, lines: IntArray) -> FloatArray:
        """The nearest points on the lines, shape (n, 2)."""
        along = self.along[lines]
        return np.asarray(
            self.point[lines] + np.einsum("nd,nd->n", points - self.point[lines], along)[:, None] * along
        )


def _join(sides: Sides, pairs: IntArray, limit: float, owner: IntArray, groups: dict[int, list[int]]) -> None:
    """Join the groups of pairs of sides where all ends stay within ``limit`` of their line; in place."""
    for one, two in pairs.tolist():
        first, second = int(owner[one]), int(owner[two])
        if first == second:
            continue
        joined = groups[first] + groups[second]
        if _deviation(sides, joined) <= limit:
            keep, give = (first, second) if len(groups[first]) >= len(groups[second]) else (second, first)
            owner[groups.pop(give)] = keep
            groups[keep] = joined


def _fit(sides: Sides, members: list[int]) -> tuple[FloatArray, FloatArray]:
    """Line nearest to the ends of sides, weighted by their lengths: a point and its direction."""
    if len(members) == 1:
        return sides.start[members[0]], sides.along[members[0]]
    points = np.concatenate([sides.start[members], sides.end[members]])
    weight = np.tile(np.linalg.norm(sides.end[members] - sides.start[members], axis=1), 2)
    centre = np.average(points, axis=0, weights=weight)
    arms = points - centre
    return centre, np.linalg.eigh((weight[:, None] * arms).T @ arms)[1][:, 1]


def _deviation(sides: Sides, members: list[int]) -> float:
    """Greatest distance of an end of the sides from their line [m]."""
    point, along = _fit(sides, members)
    arms = np.concatenate([sides.start[members], sides.end[members]]) - point
    return float(np.abs(arms[:, 0] * along[1] - arms[:, 1] * along[0]).max())
