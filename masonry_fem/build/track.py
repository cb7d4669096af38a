"""Track: the pieces of faces that a load which moves meets, along its path.

    track = track_of(faces, path, direction, across)

In the axes of a straight part of the path, which are its direction, that of the force, and in 3D the one
across both, a line of the track is a line along the first axis; it crosses edges of faces at known places.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from masonry_fem.bodies.base import FloatArray, IntArray
from masonry_fem.march.moving import Track

JOINED = 1e-9  # of the path: ends of pieces that are so near are the same


@dataclass(frozen=True, slots=True)
class TrackFaces:
    """Faces that a load may go over, by their e edges.

    Attributes
    ----------
    ends : Both ends of each edge, shape (e, 2, d) [m].
    face : Number of the face of each, shape (e,).
    group, body : The block of each face, shapes (f,).
    """

    ends: FloatArray
    face: IntArray
    group: IntArray
    body: IntArray

    @classmethod
    def of(cls, faces: Sequence[tuple[int, int, FloatArray]]) -> TrackFaces:
        """Faces as (group, body, corners in their order); in the plane a face is one edge."""
        ends, numbers = [], []
        for number, (_, _, corners) in enumerate(faces):
            edges = [corners] if corners.shape[1] == 2 else [*pairwise(corners), corners[[-1, 0]]]
            ends += [np.array(edge) for edge in edges]
            numbers += [number] * len(edges)
        groups, bodies = np.array([face[:2] for face in faces], dtype=np.int64).T
        return cls(np.array(ends), np.array(numbers, dtype=np.int64), groups, bodies)


@dataclass(frozen=True, slots=True)
class _Pieces:
    """Pieces of faces below a line, k of them, in the axes of a part of the path.

    Attributes
    ----------
    start, end : Along the path, shape (k,) [m].
    depth : Along the force at the start, shape (k,) [m]. slope : By metre of path, shape (k,).
    face : Number of the face, shape (k,).
    """

    start: FloatArray
    end: FloatArray
    depth: FloatArray
    slope: FloatArray
    face: IntArray

    def taken(self, rows: IntArray) -> _Pieces:
        """Some of them, in this order."""
        return _Pieces(*(getattr(self, name)[rows] for name in self.__slots__))

    def between(self, low: float, high: float) -> _Pieces:
        """What lies between two places."""
        own = self.taken(np.flatnonzero((self.end > low) & (self.start < high)))
        start, end = np.maximum(own.start, low), np.minimum(own.end, high)
        return _Pieces(start, end, own.depth + own.slope * (start - own.start), own.slope, own.face)


def track_of(faces: TrackFaces, path: FloatArray, direction: FloatArray, across: FloatArray) -> Track:
    """The track of a load.

    Parameters
    ----------
    faces : That it goes over.
    path : Points of its line, shape (n, d) [m].
    direction : Of the force, not along any part of the path, shape (d,).
    across : Distances of its lines from the path, to the left as seen along the force, shape (l,) [m].
    """
    steps = np.diff(path, axis=0)
    lengths = np.linalg.norm(steps, axis=1)
    corners = np.append(0.0, np.cumsum(lengths))
    parts: list[_Pieces] = []
    lines: list[IntArray] = []
    points: list[FloatArray] = []
    runs: list[FloatArray] = []
    for part, (step, length) in enumerate(zip(steps, lengths, strict=True)):
        axes = _axes(step / length, direction)
        low = -np.inf if part == 0 else corners[part]
        high = np.inf if part == len(steps) - 1 else corners[part + 1]
        seen = np.linalg.solve(axes, (faces.ends - path[part]).swapaxes(-1, -2)).swapaxes(-1, -2)
        seen[..., 0] += corners[part]
        for number, aside in enumerate(across.tolist()):
            own = _first(_crossed(seen, faces.face, aside)).between(low, high)
            point = path[part] + np.outer(own.start - corners[part], axes[:, 0])
            point += np.outer(own.depth, axes[:, 1]) + (aside * axes[:, 2] if aside else 0.0)
            parts.append(own)
            lines.append(np.full(len(own.start), number, dtype=np.int64))
            points.append(point)
            runs.append(axes[:, 0] + np.outer(own.slope, axes[:, 1]))
    line = np.concatenate(lines)
    start, end = (np.concatenate([getattr(own, name) for own in parts]) for name in ("start", "end"))
    order = np.lexsort((start, line))
    start, end, line = start[order], end[order], line[order]
    joined = (line[1:] == line[:-1]) & (np.abs(start[1:] - end[:-1]) <= JOINED * corners[-1])
    end[:-1][joined] = start[1:][joined]
    face = np.concatenate([own.face for own in parts])[order]
    return Track(
        start, end, line, faces.group[face], faces.body[face], np.concatenate(points)[order],
        np.concatenate(runs)[order], len(across),
    )  # fmt: skip


def _axes(along: FloatArray, direction: FloatArray) -> FloatArray:
    """Unit vectors along a part of the path, along the force and across both, as columns, shape (d, d)."""
    force = direction / np.linalg.norm(direction)
    if len(along) == 2:
        return np.column_stack([along, force])
    across = np.cross(along, force)
    return np.column_stack([along, force, across / np.linalg.norm(across)])


def _crossed(seen: FloatArray, face: IntArray, aside: float) -> _Pieces:
    """Where a line along the first axis lies over faces.

    Parameters
    ----------
    seen : Ends of the edges in these axes, shape (e, 2, d). face : Of each edge, shape (e,).
    aside : Place of the line along the third axis.
    """
    if seen.shape[-1] == 2:
        flat, owner = seen, face
    else:
        side = seen[..., 2] > aside
        crossing = side[:, 0] != side[:, 1]
        first, second = seen[crossing, 0], seen[crossing, 1]
        share = (aside - first[:, 2]) / (second[:, 2] - first[:, 2])
        met = first[:, :2] + share[:, None] * (second - first)[:, :2]
        order = np.lexsort((met[:, 0], face[crossing]))  # a face is entered and left in turn
        flat, owner = met[order].reshape(-1, 2, 2), face[crossing][order][::2]
    back = flat[:, 0, 0] > flat[:, 1, 0]
    flat = np.where(back[:, None, None], flat[:, ::-1], flat)
    length = flat[:, 1, 0] - flat[:, 0, 0]
    kept = length > JOINED * np.abs(flat[..., 0]).max(initial=0.0)  # not along the force
    flat, owner, length = flat[kept], owner[kept], length[kept]
    slope = (flat[:, 1, 1] - flat[:, 0, 1]) / length
    return _Pieces(flat[:, 0, 0], flat[:, 1, 0], flat[:, 0, 1], slope, owner)


def _first(pieces: _Pieces) -> _Pieces:
    """Of pieces that lie behind each other the parts that the force meets first, in their order."""
    own = pieces.taken(np.argsort(pieces.start, kind="stable"))
    near = JOINED * np.abs(own.end).max(initial=0.0)
    if not (own.start[1:] < np.maximum.accumulate(own.end)[:-1] - near).any():
        return own
    places = np.unique(np.concatenate([own.start, own.end]))
    owner = np.full(len(places) - 1, -1)
    first, last = np.searchsorted(places, own.start), np.searchsorted(places, own.end)
    middle = own.depth + 0.5 * own.slope * (own.end - own.start)
    for piece in np.argsort(-middle, kind="stable").tolist():
        owner[first[piece] : last[piece]] = piece
    shown = np.flatnonzero((owner >= 0) & (np.diff(places) > near))
    cut = own.taken(owner[shown])
    depth = cut.depth + cut.slope * (places[shown] - cut.start)
    return _Pieces(places[shown], places[shown + 1], depth, cut.slope, cut.face)


def lines_across(width: float, count: int) -> Iterator[float]:
    """Middles of equal strips of a width [m].

    Parameters
    ----------
    width : In all [m]. count : Number of strips.
    """
    for number in range(count):
        yield ((number + 0.5) / count - 0.5) * width
