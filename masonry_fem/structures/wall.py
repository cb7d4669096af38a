"""Wall: bricks in the courses of a bond, cut at openings, with lintels above these."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from masonry_fem.scene.specs import WallStructure
from masonry_fem.scene.structures.opening import ROUNDING, Span, solid_stretches
from masonry_fem.solid.assembly import Assembly, Block, Shape
from masonry_fem.solid.polytope import Polytope
from masonry_fem.solid.pose import FloatArray, Pose
from masonry_fem.structures.bond import Piece, rows_of
from masonry_fem.structures.ground import ground
from masonry_fem.structures.jambs import fitted

# a cut brick's halves by name: how many half bricks each is moved, and the face of their joint
HALVES = {"l": (0, "right"), "r": (1, "left")}
QUARTER = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])  # turn about the vertical


def build(spec: WallStructure, dimension: int) -> Assembly:
    """Blocks ``name.c1.b1`` ... course by course from below, ``name.lintel1`` ... and ``name.ground``.

    Without half bricks the shifted courses are a brick shorter. Cut bricks are a left and a right half,
    ``name.c1.b1.l`` and ``name.c1.b1.r``.
    """
    origin = np.zeros(dimension)
    if spec.position is not None:
        origin = np.array(spec.position, dtype=float)
    stones = _Stones(spec, dimension)
    # the two that nearly every wall has; the numbers of the others follow from where they come first
    stones.number_of(stones.size(spec.brick[0]), name="brick")
    stones.number_of(stones.size(spec.brick[0] / 2), name="half")
    blocks = []
    if spec.ground:
        high = origin + stones.size(spec.length, spec.wythes)
        slab, block = ground(spec.name, len(stones.shapes), origin, high, float(spec.brick[-1]))
        stones.shapes.append(slab)
        blocks.append(block)
    for course in range(1, spec.courses + 1):
        blocks += _course(spec, course, stones, origin)
    blocks += _lintels(spec, stones, origin)
    if spec.rotation:
        blocks = _turned(blocks, spec.rotation, origin)
    return Assembly(dimension, tuple(stones.shapes), tuple(blocks))


def _turned(blocks: list[Block], angle: float, origin: FloatArray) -> list[Block]:
    """Blocks turned about the vertical through the wall's corner by ``angle`` [deg]."""
    # by the quarter and the rest, so that quarter turns are exact: walls at right angles share planes
    quarters, rest = divmod(angle, 90.0)
    turn = np.linalg.matrix_power(QUARTER, int(quarters) % 4)
    if rest:
        cosine, sine = np.cos(np.radians(rest)), np.sin(np.radians(rest))
        turn = turn @ np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
    return [
        replace(one, pose=Pose(turn @ one.pose.rotation, turn @ (one.pose.translation - origin) + origin))
        for one in blocks
    ]


@dataclass(slots=True)
class _Stones:
    """The shapes of a wall's stones, each made once."""

    spec: WallStructure
    dimension: int
    shapes: list[Shape] = field(default_factory=list)
    numbers: dict[tuple[object, ...], int] = field(default_factory=dict)

    def size(self, length: float, wythes: int = 1, courses: int = 1) -> FloatArray:
        """Sizes of a stone [m], shape (d,)."""
        depth = [self.spec.brick[1] * wythes] if self.dimension == 3 else []
        return np.array([length, *depth, self.spec.brick[-1] * courses])

    def number_of(self, size: FloatArray, joint: str = "", name: str = "") -> int:
        """Number of the shape of this size whose face ``joint`` is labelled ``brick``."""
        quarter = self.spec.brick[0] / 4
        count = round(size[0] / quarter)
        length = count * quarter if abs(size[0] - count * quarter) < ROUNDING * quarter else float(size[0])
        key = (round(length / (ROUNDING * quarter)), *size[1:].tolist(), joint)
        if key not in self.numbers:
            self.numbers[key] = len(self.shapes)
            solid = Polytope.box((0.0,) * self.dimension, (length, *size[1:]))
            name = f"{self.spec.name}.{name or f'stone{len(self.shapes)}'}"
            self.shapes.append(Shape(name, self._labelled(solid, joint)))
        return self.numbers[key]

    def _labelled(self, solid: Polytope, joint: str) -> Polytope:
        """Joint ``brick`` on one face, and ``collar`` between the wythes."""
        own = {joint: "brick"}
        if self.spec.wythes > 1:
            own |= {"front": "collar", "back": "collar"}
        labels = zip(solid.names, solid.labels, strict=True)
        return replace(solid, labels=tuple(own.get(face, label) for face, label in labels))


def _course(spec: WallStructure, course: int, stones: _Stones, origin: FloatArray) -> Iterator[Block]:
    """Bricks of a course, row by row from the front, each from the left."""
    group = f"{spec.name}.c{course}"
    for number, (piece, low, high) in enumerate(_pieces(spec, course), start=1):
        name = f"{group}.b{number}"
        groups: tuple[str, ...] = (spec.name, group, f"{spec.name}.{piece.kind}s")
        if spec.wythes > 1 and high == low + 1:
            groups = (*groups, f"{spec.name}.w{high}")
        size = stones.size(piece.length, high - low)
        corner = origin.copy()
        corner[0] += piece.start
        corner[-1] += (course - 1) * spec.brick[-1]
        if stones.dimension == 3:
            corner[1] += low * spec.brick[1]
        whole = abs(piece.length - spec.brick[0]) < ROUNDING * spec.brick[0]
        if spec.cut and whole and piece.kind == "stretcher":
            yield from _halves(stones, name, size, corner, groups)
        else:
            yield Block(name, stones.number_of(size), Pose(np.eye(stones.dimension), corner), groups)


def _pieces(spec: WallStructure, course: int) -> list[tuple[Piece, int, int]]:
    """Stones of a course, cut at openings, with the wythes that each takes."""
    brick = spec.brick[0]
    laid: list[tuple[Piece, int, int]] = []
    free = solid_stretches(spec.spans, course - 1, (0.0, spec.length), ROUNDING * brick)
    for row in rows_of(spec, course):
        pieces = row.pieces if spec.pattern else [
            piece for a, b in free for piece in fitted(row.pieces, a, b, brick=brick)
        ]  # fmt: skip
        for piece in pieces:
            leaves = row.high - row.low if piece.kind == "stretcher" else 1
            thickness = (row.high - row.low) // leaves
            laid += [(piece, low, low + thickness) for low in range(row.low, row.high, thickness)]
    return sorted(laid, key=lambda stone: (stone[1], stone[0].start))


def _halves(
    stones: _Stones, name: str, size: FloatArray, corner: FloatArray, groups: tuple[str, ...]
) -> Iterator[Block]:
    """The two halves of a brick that cracks in the middle."""
    half = size.copy()
    half[0] /= 2
    for side, (moved, joint) in HALVES.items():
        axes = np.eye(stones.dimension)
        pose = Pose(axes, corner + moved * half * axes[0])
        yield Block(f"{name}.{side}", stones.number_of(half, joint), pose, (*groups, name))


def _lintels(spec: WallStructure, stones: _Stones, origin: FloatArray) -> Iterator[Block]:
    """One stone above each opening that has a lintel, through the wall."""
    spans: list[Span] = [span for span in spec.spans if span.lintel]
    for number, span in enumerate(spans, start=1):
        size = stones.size(span.right - span.left + 2 * span.bearing, spec.wythes, span.lintel)
        corner = origin.copy()
        corner[0] += span.left - span.bearing
        corner[-1] += span.top * spec.brick[-1]
        groups = (spec.name, f"{spec.name}.c{span.top + 1}", f"{spec.name}.lintels")
        name = f"{spec.name}.lintel{number}"
        yield Block(name, stones.number_of(size), Pose(np.eye(stones.dimension), corner), groups)
