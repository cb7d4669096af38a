"""Wall: bricks in the courses of a bond, cut at openings, with lintels above these."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from itertools import chain
from typing import Annotated, Literal

import numpy as np
from msgspec import Meta

from masonry_fem.records.opening import Opening
from masonry_fem.records.record import Count, Degrees, Point, Sizes
from masonry_fem.records.structure import Foreseen, Structure
from masonry_fem.solid.assembly import Assembly, Block, Blocks, Shape
from masonry_fem.solid.mesh import IntArray
from masonry_fem.solid.polytope import Polytope
from masonry_fem.solid.pose import FloatArray, Pose
from masonry_fem.structures.parts.bond import Bond, Piece, period_of, rows_of
from masonry_fem.structures.parts.ground import ground
from masonry_fem.structures.parts.opening import ROUNDING, SLIVER, Span, fitted, solid_stretches

Lengths = Annotated[
    tuple[float, ...],
    Meta(min_length=1, extra={"expected": "a list of lengths in bricks, openings negative"}),
]


class WallStructure(Structure, frozen=True, kw_only=True, tag="wall"):
    """Wall of ``courses`` courses in a ``bond``, ``columns`` bricks long and ``wythes`` bricks thick.

    In running bond half bricks close every other course; if ``columns`` ends in a half, each course has
    one half brick, at alternate ends. Headers are half a brick long in the face and go through two wythes, or
    ``through`` all of them. In English bond courses of headers and of stretchers alternate, in Flemish bond a
    header follows each stretcher, and with ``header_courses`` = n every n-th course of a running or stack
    bond consists of headers. At ends and openings bricks are cut, but never shorter than a quarter.

    Instead, a ``pattern`` lists the courses from below brick by brick, and is repeated upwards:
    ``[[1, 1, 1], [0.5, -1.5, 1]]`` has an opening of 1.5 bricks in every other course.

    With ``cut`` each brick consists of two halves, whose joint, labelled ``brick``, lets it crack in the
    middle.

    A wall with a ``rotation`` of 90 deg runs along y. Four walls whose patterns occupy the corners in turns
    form a tower.

    Attributes
    ----------
    brick : length, (depth,) height of a brick
    columns : number of bricks in a course, a multiple of a half; not with a pattern
    courses : number of courses
    bond : how bricks of neighbouring courses overlap
    pattern : courses from below, brick by brick, repeated upwards
    wythes : number of bricks in the wall's thickness, each with the depth of ``brick``
    header_courses : every so many courses of a running or stack bond one is of headers; none by default
    through : headers go through all wythes, not only through two
    openings : doors and windows
    position : lower left front corner [m]; the origin by default
    rotation : angle about the vertical through the lower left front corner
    half_bricks : courses that half bricks close; with ``none`` the shifted courses are a brick shorter
    cut : each whole brick consists of two halves with a joint ``brick`` between them, where it may crack
    ground : a support under the structure, wider than it

    Examples
    --------
    kind = "wall"
    name = "wall"
    material = "stone"
    brick = [0.5, 0.25, 0.25]
    columns = 6
    courses = 5
    """

    brick: Sizes
    columns: Annotated[float, Meta(ge=1, multiple_of=0.5)] | None = None
    courses: Count
    bond: Bond = "running"
    pattern: tuple[Lengths, ...] = ()
    wythes: Count = 1
    header_courses: Count | None = None
    through: bool = False
    openings: tuple[Opening, ...] = ()
    position: Point | None = None
    rotation: Degrees = 0.0
    half_bricks: Literal["even", "odd", "none"] = "even"
    cut: bool = False
    ground: bool = True

    @property
    def length(self) -> float:
        """Of the wall [m]."""
        if self.columns is not None:
            return self.columns * self.brick[0]
        return max(sum(map(abs, lengths)) for lengths in self.pattern) * self.brick[0]

    @property
    def spans(self) -> tuple[Span, ...]:
        """What each opening takes from the courses."""
        length, height = self.brick[0], self.brick[-1]
        return tuple(
            Span.of(one, length=length, height=height, courses=self.courses) for one in self.openings
        )

    def foreseen(self, dimension: int) -> Foreseen:
        """Its bricks as if there were no openings, whole ones where they are cut at the ends."""
        added = self.ground + sum(one.lintel for one in self.openings)
        if self.pattern:
            row = sum(length > 0 for lengths in self.pattern for length in lengths) / len(self.pattern)
            keys: tuple[str, ...] = ("courses", "wythes")
        else:
            row, keys = self.columns or 0.0, ("columns", "courses", "wythes")
        through = self.through or self.wythes <= 2
        headers = 2 * row if through else row * self.wythes  # seen in the face, a header is half as long
        course = row * self.wythes
        match self.bond:
            case "header":
                course = headers
            case "english":
                course = (course + headers) / 2
            case "flemish":
                course = (course + row) / 1.5
            case _ if self.header_courses is not None:
                course += (headers - course) / self.header_courses
        return Foreseen(self.courses * course * (1 + self.cut) + added, keys)

    def faults(self, dimension: int) -> Iterator[tuple[str, str]]:
        """A bond that its keys contradict, openings off the courses or too near to each other."""
        yield from self._pattern_faults()
        yield from self._bond_faults(dimension)
        if not self.pattern and self.columns is not None:
            yield from self._opening_faults()

    def _pattern_faults(self) -> Iterator[tuple[str, str]]:
        if not self.pattern:
            if self.columns is None:
                yield "columns", "the bricks of a course (or a pattern that lists them)"
            return
        for key, usual in (("columns", None), ("bond", "running"), ("half_bricks", "even"),
                           ("header_courses", None), ("through", False), ("openings", ())):  # fmt: skip
            if getattr(self, key) != usual:
                yield key, "none beside a pattern, which says how the courses are laid"
        if len(self.pattern) > self.courses:
            yield "courses", f"at least {len(self.pattern)}, so many courses does the pattern have"
        if any(length == 0 for lengths in self.pattern for length in lengths):
            yield "pattern", "lengths that are not 0"
        if any(all(length < 0 for length in lengths) for lengths in self.pattern):
            yield "pattern", "at least one brick (a length > 0) in each course"

    def _bond_faults(self, dimension: int) -> Iterator[tuple[str, str]]:
        if dimension == 2 and self.wythes > 1:
            yield "wythes", "1 in a 2D scene, which shows a wall from the front"
        if dimension == 2 and self.rotation:
            yield "rotation", "0 in a 2D scene, which shows a wall from the front"
        if self.header_courses is not None and self.bond not in ("running", "stack"):
            yield "header_courses", f"none in {self.bond} bond (running and stack bond have it)"
        if self.half_bricks != "even" and self.bond != "running":
            yield "half_bricks", f"none in {self.bond} bond (running bond has it)"
        if self.bond == "flemish" and self.wythes > 2 and not self.through:
            yield "wythes", "1 or 2 in Flemish bond, or through = true"

    def _opening_faults(self) -> Iterator[tuple[str, str]]:
        if self.openings and self.half_bricks == "none":
            yield "half_bricks", "'even' or 'odd' in a wall with openings"
        # the first fault of their places hides the others, which may follow from it
        first = next(chain(self._places(), self._slivers()), None)
        yield from self._jambs() if first is None else [first]

    def _places(self) -> Iterator[tuple[str, str]]:
        """Openings off the courses, or beyond the wall."""
        for number, span in enumerate(self.spans):
            for key, expected in self._misplaced(self.openings[number], span):
                yield f"openings.{number}.{key}", expected

    def _slivers(self) -> Iterator[tuple[str, str]]:
        """Stretches of wall that are too short for a brick."""
        spans, rounding = self.spans, ROUNDING * self.brick[0]
        # courses between the lower and upper ends of openings and lintels are alike
        changes = {span.bottom for span in spans} | {span.top for span in spans}
        changes |= {span.top + span.lintel for span in spans}
        for course in sorted(one for one in {0, *changes} if one < self.courses):
            for a, b in solid_stretches(spans, course, (0.0, self.length), rounding):
                if b - a < SLIVER * self.brick[0] - rounding:
                    yield (
                        "openings",
                        f"at least a quarter of a brick ({SLIVER * self.brick[0]:g} m), or nothing, between "
                        f"openings, lintels and the wall's ends (in course {course + 1} there are {b - a:g} m"
                        f" from {a:g} m on)",
                    )

    def _jambs(self) -> Iterator[tuple[str, str]]:
        """Lintels whose ends would rest on another opening."""
        spans, rounding = self.spans, ROUNDING * self.brick[0]
        for number, span in enumerate(spans):
            if span.lintel and any(
                one.open_in(span.top - 1)
                and one.left < span.right + span.bearing - rounding
                and one.right > span.left - span.bearing + rounding
                for one in spans
                if one is not span
            ):
                yield f"openings.{number}", "jambs below both ends of its lintel: another opening is there"

    def _misplaced(self, opening: Opening, span: Span) -> Iterator[tuple[str, str]]:
        """What an opening's place and size should be."""
        height = self.brick[-1]
        for key, level, course in (
            ("position", opening.position[1], span.bottom),
            ("size", opening.position[1] + opening.size[1], span.top),
        ):
            if abs(level - course * height) > ROUNDING * height or course > self.courses:
                near = min(course, self.courses) * height
                edge = "lower" if key == "position" else "upper"
                yield (
                    key,
                    f"an opening whose {edge} edge lies on a bed joint (a multiple of {height:g} m): at "
                    f"{near:g} m, not at {level:g} m",
                )
        if span.right > self.length * (1 + ROUNDING):
            yield "position", f"an opening within the wall's length of {self.length:g} m"
        if span.top + span.lintel > self.courses:
            yield (
                "lintel_courses",
                f"at most {self.courses - span.top}, so many courses lie above the opening",
            )


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
    # nearly every wall has these two shapes; the others are numbered in order of appearance
    stones.number_of(stones.size(spec.brick[0]), name="brick")
    stones.number_of(stones.size(spec.brick[0] / 2), name="half")
    parts = []
    if spec.ground:
        high = origin + stones.size(spec.length, spec.wythes)
        slab, block = ground(spec.name, len(stones.shapes), origin, high, float(spec.brick[-1]))
        stones.shapes.append(slab)
        parts.append(Blocks.of([block], dimension))
    parts += _courses(spec, stones, origin)
    parts.append(Blocks.of(_lintels(spec, stones, origin), dimension))
    blocks = Blocks.joined(parts)
    if spec.rotation:
        blocks = _turned(blocks, spec.rotation, origin)
    return Assembly(dimension, stones.shapes, blocks)


def _turned(blocks: Blocks, angle: float, origin: FloatArray) -> Blocks:
    """Blocks turned about the vertical through the wall's corner by ``angle`` [deg]."""
    # quarter turns and the rest apart, so that quarter turns are exact and walls at right angles share planes
    quarters, rest = divmod(angle, 90.0)
    turn = np.linalg.matrix_power(QUARTER, int(quarters) % 4)
    if rest:
        cosine, sine = np.cos(np.radians(rest)), np.sin(np.radians(rest))
        turn = turn @ np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
    place = np.einsum("ij,bj->bi", turn, blocks.translation - origin) + origin
    return replace(blocks, rotation=turn @ blocks.rotation, translation=place)


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


@dataclass(frozen=True, slots=True)
class _Course:
    """The s stones of a course, row by row from the front, each from the left; many courses are alike.

    Attributes
    ----------
    names : Ends of their names, after that of the course.
    shape : Number of their shapes, shape (s,).
    start : Left ends, from that of the wall, shape (s,) [m].
    low : First wythe of each, shape (s,).
    grouping : Number of each stone's groups in ``groupings``, shape (s,).
    groupings : Ends of the names of groups after that of the wall, and of the brick after that of the course.
    """

    names: tuple[str, ...]
    shape: IntArray
    start: FloatArray
    low: FloatArray
    grouping: IntArray
    groupings: tuple[tuple[tuple[str, ...], tuple[str, ...]], ...]


def _courses(spec: WallStructure, stones: _Stones, origin: FloatArray) -> Iterator[Blocks]:
    """The bricks of each course from below; courses that are alike are laid out once."""
    known: dict[tuple[object, ...], _Course] = {}
    d = stones.dimension
    for course in range(1, spec.courses + 1):
        free = solid_stretches(spec.spans, course - 1, (0.0, spec.length), ROUNDING * spec.brick[0])
        alike = (course % period_of(spec), *free)
        if alike not in known:
            known[alike] = _course(spec, course, free, stones)
        laid = known[alike]
        place = np.tile(origin, (len(laid.names), 1))
        place[:, 0] += laid.start
        place[:, -1] += (course - 1) * spec.brick[-1]
        if d == 3:
            place[:, 1] += laid.low * spec.brick[1]
        group = f"{spec.name}.c{course}"
        names = tuple(map(f"{group}.".__add__, laid.names))
        groupings = [
            (spec.name, group, *(f"{spec.name}.{end}" for end in own), *(f"{group}.{b}" for b in brick))
            for own, brick in laid.groupings
        ]
        yield Blocks.laid(names, laid.shape, np.eye(d), place, groupings, laid.grouping)


def _course(
    spec: WallStructure, course: int, free: list[tuple[float, float]], stones: _Stones
) -> _Course:  # fmt: skip
    """A course in which ``free`` is what openings leave."""
    names, shape, start, lows, groups = [], [], [], [], []
    for number, (piece, low, high) in enumerate(_pieces(spec, course, free), start=1):
        own = (f"{piece.kind}s", *([f"w{high}"] if spec.wythes > 1 and high == low + 1 else []))
        size = stones.size(piece.length, high - low)
        whole = abs(piece.length - spec.brick[0]) < ROUNDING * spec.brick[0]
        if spec.cut and whole and piece.kind == "stretcher":
            size[0] /= 2
            made = [(f"b{number}.{side}", moved * size[0], joint) for side, (moved, joint) in HALVES.items()]
        else:
            made = [(f"b{number}", 0.0, "")]
        for name, moved, joint in made:
            names.append(name)
            shape.append(stones.number_of(size, joint))
            start.append(piece.start + moved)
            lows.append(low)
            groups.append((own, (f"b{number}",) if joint else ()))
    groupings = {one: number for number, one in enumerate(dict.fromkeys(groups))}
    return _Course(
        tuple(names),
        np.array(shape, dtype=np.int64),
        np.array(start, dtype=float),
        np.array(lows, dtype=float),
        np.array([groupings[one] for one in groups], dtype=np.int64),
        tuple(groupings),
    )


def _pieces(
    spec: WallStructure, course: int, free: list[tuple[float, float]]
) -> list[tuple[Piece, int, int]]:  # fmt: skip
    """Stones of a course, cut at openings, with the wythes that each takes."""
    brick = spec.brick[0]
    laid: list[tuple[Piece, int, int]] = []
    for row in rows_of(spec, course):
        pieces = row.pieces if spec.pattern else [
            piece for a, b in free for piece in fitted(row.pieces, a, b, brick=brick)
        ]  # fmt: skip
        for piece in pieces:
            leaves = row.high - row.low if piece.kind == "stretcher" else 1
            thickness = (row.high - row.low) // leaves
            laid += [(piece, low, low + thickness) for low in range(row.low, row.high, thickness)]
    return sorted(laid, key=lambda stone: (stone[1], stone[0].start))


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
