"""Wall: bricks in courses, in a bond, with openings."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Literal

from msgspec import Meta

from masonry_fem.scene.record import Count, Degrees, Point, Sizes
from masonry_fem.scene.structures.base import Foreseen, Structure
from masonry_fem.scene.structures.opening import ROUNDING, Opening, Span, solid_stretches

Bond = Literal["running", "stack", "header", "english", "flemish"]
Lengths = Annotated[
    tuple[float, ...],
    Meta(min_length=1, extra={"expected": "a list of lengths in bricks, openings negative"}),
]
SLIVER = 0.25  # of a brick: what is shorter is no stone


class WallStructure(Structure, frozen=True, kw_only=True, tag="wall"):
    """Wall of ``courses`` courses in a ``bond``, ``columns`` bricks long and ``wythes`` bricks thick.

    In running bond half bricks close every other course; where ``columns`` ends in a half, each course has
    one half brick, at alternate ends. Headers show half a brick in the face and go through two wythes, or
    ``through`` all of them: in English bond courses of them lie between courses of stretchers, in Flemish
    bond a header follows each stretcher, and with ``header_courses`` = n every n-th course of a running or
    stack bond is of headers. At ends and openings bricks are cut, never shorter than a quarter.

    A ``pattern`` lists the courses from below brick by brick instead, and is repeated upwards:
    ``[[1, 1, 1], [0.5, -1.5, 1]]`` has an opening of 1.5 bricks in every other course.

    With ``cut`` each brick is two halves whose joint, labelled ``brick``, lets it crack in the middle.

    A ``rotation`` [deg] turns the wall about the vertical through its lower left front corner: 90 deg make it
    run along y. Patterns that leave the corners to each other in turns bond walls into a tower.
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
    def carries(self) -> bool:
        """Whether it brings its ground."""
        return self.ground

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
        headers = 2 * row if through else row * self.wythes  # a header is half as long, and two wythes thick
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
        spans, rounding = self.spans, ROUNDING * self.brick[0]
        if spans and self.half_bricks == "none":
            yield "half_bricks", "'even' or 'odd' in a wall with openings"
        misplaced = [
            (f"openings.{number}.{key}", expected)
            for number, span in enumerate(spans)
            for key, expected in self._misplaced(self.openings[number], span)
        ]
        if misplaced:
            yield misplaced[0]
            return
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
                    return
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
