"""Moving: a load that goes along a path over faces of blocks, and what it gives to them where it stands.

    load = Travel(track, force, axles, spread, place)
    load.forces(groups, load.place(time))           # a pattern, as that of any load

A face takes what stands on it where the force meets it, so that resultant and moment are those of the load
wherever it is. On blocks that deform a spread load acts at ``POINTS`` points of each face that it touches.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from masonry_fem.bodies.base import BodyGroup, FloatArray, IntArray

POINTS = 4  # of Gauss: exact for what elements of second order do with an even load


@dataclass(frozen=True, slots=True)
class Track:
    """Pieces of faces along a path, k of them, on one or several lines side by side.

    Attributes
    ----------
    start, end : Along the path, shape (k,) [m]. line : Number of the line of each, shape (k,).
    group, body : The block that each is of, shape (k,).
    point : Where the force meets the face at the start, shape (k, d) [m]. slope : By metre of path, (k, d).
    lines : Number of lines, which share the load evenly.
    """

    start: FloatArray
    end: FloatArray
    line: IntArray
    group: IntArray
    body: IntArray
    point: FloatArray
    slope: FloatArray
    lines: int

    def met(self, low: float, high: float) -> tuple[IntArray, FloatArray, FloatArray]:
        """Where a load meets faces that is spread evenly from one place to another [m].

        Returns
        -------
        Pieces (p,), points (p, d) [m] and shares of the load (p,); less than 1 in all where it stands beside
        the faces.
        """
        if high > low:
            first, last = np.maximum(self.start, low), np.minimum(self.end, high)
            piece = np.flatnonzero(last > first)
            nodes, weights = np.polynomial.legendre.leggauss(POINTS)
            half = 0.5 * (last - first)[piece, None]
            at = (0.5 * (last + first)[piece, None] + half * nodes).ravel()
            share = (half * weights).ravel() / (high - low)
            piece = np.repeat(piece, POINTS)
        else:
            inside = np.flatnonzero((self.start <= low) & (low <= self.end))
            _, first_of_line = np.unique(self.line[inside], return_index=True)
            piece = inside[first_of_line]
            at, share = np.full(len(piece), low), np.ones(len(piece))
        points = self.point[piece] + (at - self.start[piece])[:, None] * self.slope[piece]
        return piece, points, share / self.lines


@dataclass(frozen=True, slots=True)
class Travel:
    """A load that moves.

    Attributes
    ----------
    track : The faces that it goes over. path : Its line, shape (n, d) [m].
    force : Of each axle, shape (d,) [N]. axles : Distances behind the first one, shape (a,) [m].
    spread : Length along the path that each is spread over [m]; 0: it acts at a point.
    place : Distance of the first axle along the path at a time [m].
    """

    track: Track
    path: FloatArray
    force: FloatArray
    axles: FloatArray
    spread: float
    place: Callable[[float], float]

    def forces(self, groups: Sequence[BodyGroup], place: float) -> tuple[FloatArray | None, ...]:
        """What it gives to each group with its first axle at a place, None where it does not act.

        Parameters
        ----------
        groups : Body groups. place : Distance along the path [m].
        """
        total: list[FloatArray | None] = [None] * len(groups)
        track = self.track
        for axle in self.axles.tolist():
            middle = place - axle
            met = track.met(middle - 0.5 * self.spread, middle + 0.5 * self.spread)
            for piece, point, share in zip(met[0].tolist(), met[1], met[2].tolist(), strict=True):
                index = int(track.group[piece])
                force = groups[index].point_force(int(track.body[piece]), point, share * self.force)
                present = total[index]
                total[index] = force if present is None else present + force
        return tuple(total)

    def scaled(self, factor: float) -> Self:
        """The same with forces multiplied by a factor."""
        return replace(self, force=factor * self.force)

    def position(self, place: float) -> FloatArray:
        """The point of the path at a distance along it, straight on beyond its ends, shape (d,) [m]."""
        steps = np.diff(self.path, axis=0)
        lengths = np.linalg.norm(steps, axis=1)
        corners = np.append(0.0, np.cumsum(lengths))
        at = int(np.clip(np.searchsorted(corners, place, side="right") - 1, 0, len(steps) - 1))
        found: FloatArray = self.path[at] + (place - corners[at]) / lengths[at] * steps[at]
        return found
