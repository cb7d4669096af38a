"""Voussoir: a stone between an intrados and an extrados, cut off by two straight joints.

    low, high = (Run(Offset(line, by), p, q) for by in (-t / 2, t / 2))
    stone = Voussoir((low,), (high,))

Stones stand in the arch's plane (x right, y up).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from masonry_fem.solid.pose import FloatArray
from masonry_fem.structures.parts.curve import Line, Offset, crossing, equal_parts, swept

Ends = Sequence[float] | FloatArray  # of a joint: parameters on intrados and extrados

FACETS = 16  # flat facets for each smooth part of a curved face


@dataclass(frozen=True, slots=True)
class Run:
    """A smooth part of a face.

    Attributes
    ----------
    curve : Intrados or extrados.
    start, end : Parameters of the curve at the ends.
    """

    curve: Offset
    start: float
    end: float

    def points(self, facets: int) -> FloatArray:
        """Ends of its facets, shape (facets + 1, 2).

        The inner ones lie a little off the curve, so that the polygon sweeps the curve's area: stones
        have their exact mass.
        """
        p = np.linspace(self.start, self.end, facets + 1)
        points = self.curve.at(p)
        if facets == 1:
            return points
        out = self.curve.normal(p)
        out[[0, -1]] = 0.0
        # the area that the polygon sweeps is a quadratic of how far its inner points are moved
        lacking = _polyline(points, points) - swept(self.curve, self.start, self.end, facets)
        first = _polyline(points, out) + _polyline(out, points)
        second = _polyline(out, out)
        root = np.sqrt(max(first * first - 4 * second * lacking, 0.0))
        move = -2 * lacking / (first + np.copysign(root, first)) if first else 0.0
        return np.asarray(points + move * out)


def _polyline(one: FloatArray, two: FloatArray) -> float:
    """Half the sum of the cross products of each point of ``one`` with the next of ``two``."""
    a, b = one[:-1], two[1:]
    return float((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum() / 2)


@dataclass(frozen=True, slots=True)
class Voussoir:
    """One stone.

    Attributes
    ----------
    low, high : Smooth parts of intrados and extrados from left to right, equally many.
    start, end : Labels of the left and the right joint.
    """

    low: tuple[Run, ...]
    high: tuple[Run, ...]
    start: str = "radial"
    end: str = "radial"

    @classmethod
    def between(cls, faces: Sequence[Offset], left: Ends, right: Ends, *labels: str) -> Voussoir:
        """The stone of a smooth intrados and extrados, given their parameters at its joints."""
        low, high = ((Run(face, float(a), float(b)),) for face, a, b in zip(faces, left, right, strict=True))
        return cls(low, high, *labels)

    def faces(self, straight: bool) -> tuple[FloatArray, FloatArray]:
        """Points of intrados and extrados from left to right, shapes (n, 2)."""
        facets = 1 if straight else FACETS
        return _chained(self.low, facets), _chained(self.high, facets)


def _chained(runs: tuple[Run, ...], facets: int) -> FloatArray:
    parts = [run.points(facets if run.curve.line.bend(np.zeros(1))[0] else 1) for run in runs]
    return np.concatenate([parts[0], *(part[1:] for part in parts[1:])])


def cut_line(line: Line, start: float, end: float, thickness: float, count: int, cut: str) -> list[Voussoir]:
    """Stones along a line that is symmetrical about the vertical.

    Parameters
    ----------
    line : Mean line of the arch.
    start, end : Its parameters at the springings.
    thickness : Of the arch, normal to the line [m].
    count : Number of stones.
    cut : ``radial`` joints are normal to the line and divide it into equal lengths; ``vertical`` ones
        divide the span of the intrados equally, between springing joints that stay normal to the line.
    """
    faces = [Offset(line, side * thickness / 2) for side in (-1, 1)]
    if cut == "radial":
        joints = np.repeat(equal_parts(line, start, end, count)[:, None], 2, axis=1)
    else:
        joints = np.array([_upright(faces, start, end, k / count) for k in range(count + 1)])
    labels = [cut if 0 < k < count else "radial" for k in range(count + 1)]
    return [Voussoir.between(faces, *joints[k : k + 2], labels[k], labels[k + 1]) for k in range(count)]


def _upright(faces: list[Offset], start: float, end: float, part: float) -> tuple[float, float]:
    """Parameters on both faces of the vertical joint at that part of the intrados' span."""
    if part in {0.0, 1.0}:
        return (end, end) if part else (start, start)
    left, right = faces[0].at(np.array([start, end]))
    place = left + part * (right - left)
    across = np.array([1.0, 0.0])
    low, high = (crossing(face, start, end, place, across) for face in faces)
    return low, high
