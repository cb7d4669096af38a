"""Voussoir: a stone between an intrados and an extrados, cut off by two straight joints.

    low, high = (Run(Offset(line, by), p, q) for by in (-t / 2, t / 2))
    stone = Voussoir((low,), (high,))

Stones stand in the arch's plane (x right, y up). Those that are congruent by a turn become one shape,
its own axes across (x) and along (last) its left joint, the origin at that joint's foot.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from masonry_fem.geometry.curve import Line, Offset, crossing, equal_parts, swept
from masonry_fem.scene.structures import ArchStructure, VoussoirStructure
from masonry_fem.solid.assembly import Assembly, Block, Shape
from masonry_fem.solid.polytope import Polytope
from masonry_fem.solid.pose import FloatArray, Pose

Ends = Sequence[float] | FloatArray  # of a joint: parameters on intrados and extrados

FACETS = 16  # flat facets for each smooth part of a curved face
ALIKE = 1e-9  # of a stone's size: outlines that differ by less are one shape
MARGIN = 0.25  # of the joint: how far a support stands out beside it


@dataclass(frozen=True, slots=True)
class Run:
    """A smooth part of a face, from parameter ``start`` to ``end`` of ``curve``."""

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


@dataclass(slots=True)
class Quarry:
    """Shapes and blocks of the stones laid so far; stones that are alike share a shape.

    Attributes
    ----------
    name : The structure's. dimension : 2 or 3. depth : Along y in 3D [m]. straight : Chords for curves.
    origin : Where the arch's plane has its origin in the world, shape (d,) [m].
    """

    name: str
    dimension: int
    depth: float
    origin: FloatArray
    straight: bool = False
    shapes: list[Shape] = field(default_factory=list)
    blocks: list[Block] = field(default_factory=list)

    def lay(self, name: str, stone: Voussoir, groups: tuple[str, ...]) -> None:
        """Add a stone."""
        low, high = stone.faces(self.straight)
        self._add(name, "voussoir", low, high, len(stone.low), (stone.start, stone.end), groups, False)

    def support(self, name: str, foot: FloatArray, head: FloatArray, left: bool, label: str) -> None:
        """Add a support beside the joint from ``foot`` up to ``head``, on its left or its right."""
        along = head - foot
        across = np.array([along[1], -along[0]])  # to the right
        ends = np.array([foot - MARGIN * along, head + MARGIN * along])
        rows = [ends - across, ends] if left else [ends, ends + across]
        labels = ("", label) if left else (label, "")
        low, high = (np.array([row[k] for row in rows]) for k in (0, 1))
        self._add(name, name.removeprefix(f"{self.name}."), low, high, 1, labels, (), True)

    def _add(
        self, name: str, noun: str, low: FloatArray, high: FloatArray, parts: int,
        labels: tuple[str, str], groups: tuple[str, ...], support: bool,
    ) -> None:  # fmt: skip
        foot, along = low[0], (high[0] - low[0]) / np.linalg.norm(high[0] - low[0])
        frame = np.array([[along[1], along[0]], [-along[0], along[1]]])  # across and along the joint
        outline = (np.concatenate([low, high[::-1]]) - foot) @ frame
        number = self._number(noun, outline, len(low), parts, labels)
        flat = self.dimension == 2
        pose = Pose(frame if flat else _spatial(frame), self.origin + (foot if flat else _placed(foot)))
        self.blocks.append(Block(name, number, pose, (self.name, *groups), support))

    def _number(
        self, noun: str, outline: FloatArray, low: int, parts: int, labels: tuple[str, str]
    ) -> int:  # fmt: skip
        made = prism(outline, low, labels, self.depth, self.dimension)
        for number, known in enumerate(self.shapes):
            if _alike(known, made, parts):
                return number
        rails = _rails(len(outline), low, self.dimension)
        self.shapes.append(Shape(f"{self.name}.{noun}{len(self.shapes) + 1}", made, rails=rails, parts=parts))
        return len(self.shapes) - 1


def arch_of(
    spec: VoussoirStructure | ArchStructure, stones: Sequence[Voussoir], dimension: int, straight: bool
) -> Assembly:
    """The arch of those stones about a scene's ``centre``, between its springings."""
    origin = np.zeros(dimension) if spec.centre is None else np.array(spec.centre, dtype=float)
    quarry = Quarry(spec.name, dimension, spec.depth, origin, straight)
    if spec.springings:
        lay_springings(quarry, stones)
    lay_arch(quarry, stones)
    return Assembly(dimension, tuple(quarry.shapes), tuple(quarry.blocks))


def cut_line(line: Line, start: float, end: float, thickness: float, count: int, cut: str) -> list[Voussoir]:
    """Stones along a line that is symmetrical about the vertical.

    ``cut``: joints normal to the line that part it into equal lengths (``radial``), or vertical ones
    that part the intrados' span equally, between springing joints that stay normal to the line.
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


def lay_arch(quarry: Quarry, stones: Sequence[Voussoir]) -> None:
    """Stones ``name.v01`` ... from the left; groups ``name.springers`` and ``name.keystone``."""
    digits = max(2, len(str(len(stones))))
    for number, stone in enumerate(stones):
        groups = roles(quarry.name, number, len(stones))
        quarry.lay(f"{quarry.name}.v{number + 1:0{digits}d}", stone, groups)


def roles(name: str, number: int, count: int) -> tuple[str, ...]:
    """Groups of the stone of that number from the left (0 first): a springer, the keystone."""
    made = (f"{name}.springers",) if number in {0, count - 1} else ()
    return (*made, f"{name}.keystone") if 2 * number + 1 == count else made


def lay_springings(quarry: Quarry, stones: Sequence[Voussoir]) -> None:
    """Supports ``name.springing_left`` and ``name.springing_right`` of a row of stones."""
    for side, stone, at, label in (
        ("left", stones[0], 0, stones[0].start),
        ("right", stones[-1], -1, stones[-1].end),
    ):
        low, high = stone.faces(straight=True)
        quarry.support(f"{quarry.name}.springing_{side}", low[at], high[at], side == "left", label)


def prism(
    outline: FloatArray, low: int, labels: tuple[str, str], depth: float, dimension: int, sides: str = ""
) -> Polytope:
    """Stone of an outline (counter-clockwise, its first ``low`` points the intrados), drawn out along y.

    ``labels`` are those of the left and the right joint face, ``start`` and ``end``, ``sides`` that of
    front and back.
    """
    n = len(outline)
    names = ["intrados"] * (low - 1) + ["end"] + ["extrados"] * (n - low - 1) + ["start"]
    of_name = {"start": labels[0], "end": labels[1]}
    marks = [of_name.get(name, "") for name in names]
    following = [(i + 1) % n for i in range(n)]
    if dimension == 2:
        return Polytope(outline, tuple(zip(range(n), following, strict=True)), tuple(names), tuple(marks))
    front = np.column_stack([outline[:, 0], np.zeros(n), outline[:, 1]])
    vertices = np.concatenate([front, front + np.array([0.0, depth, 0.0])])
    around = [(i, i + n, j + n, j) for i, j in enumerate(following)]
    # seen from the front (against y) the outline runs counter-clockwise
    loops = [*around, tuple(range(n)), tuple(range(2 * n - 1, n - 1, -1))]
    return Polytope(vertices, tuple(loops), (*names, "front", "back"), (*marks, sides, sides))


def _rails(n: int, low: int, dimension: int) -> tuple[tuple[int, ...], ...]:
    """Vertices along the stone: intrados and extrados, in 3D of the front, then of the back."""
    rails = (tuple(range(low)), tuple(range(n - 1, low - 1, -1)))
    if dimension == 2:
        return rails
    return (*rails, *(tuple(vertex + n for vertex in rail) for rail in rails))


def _alike(known: Shape, made: Polytope, parts: int) -> bool:
    solid = known.solid
    if (known.parts, solid.faces, solid.labels) != (parts, made.faces, made.labels):
        return False
    size = np.ptp(made.vertices, axis=0).max()
    return bool(np.abs(solid.vertices - made.vertices).max() <= ALIKE * size)


def _placed(point: FloatArray) -> FloatArray:
    """A point of the arch's plane in space."""
    return np.array([point[0], 0.0, point[1]])


def _spatial(turn: FloatArray) -> FloatArray:
    """A turn in the arch's plane as a rotation in space."""
    rotation = np.eye(3)
    rotation[np.ix_([0, 2], [0, 2])] = turn
    return rotation
