"""Buttress: a pier of level courses between a plane face and one that slopes or is stepped back.

Across the pier, u is measured from its left face; if the pier leans, courses shift to the right with height.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from math import floor
from typing import Annotated

import numpy as np
from msgspec import Meta

from masonry_fem.records.record import Count, Length, Point
from masonry_fem.records.structure import Foreseen, Structure
from masonry_fem.solid.assembly import Assembly, Block, Shape
from masonry_fem.solid.polytope import Polytope
from masonry_fem.solid.pose import Pose
from masonry_fem.structures.parts.ground import ground


class ButtressStructure(Structure, frozen=True, kw_only=True, tag="buttress"):
    """Pier of ``courses`` equal courses, ``width`` wide at its foot and ``top`` at its top.

    Its left face is plane. If ``top`` is less than ``width``, its right face slopes, or is stepped back at
    set-offs between equal ``stages``. Both faces may ``lean`` to the right; bed joints are level.
    A course is one stone, or several ``stones``, whose joints are shifted by half a stone from course to
    course.

    Attributes
    ----------
    width : length along x at the foot
    height : height of the pier
    courses : number of courses, all equally high
    top : width at the top; that of the foot by default
    stages : number of stages between set-offs, of equal width each; without it the right face slopes
    lean : angle of both faces from the vertical, to the right
    stones : number of stones in a course as wide as the foot
    depth : length along y; not used in 2D
    position : lower left front corner [m]; the origin by default
    ground : a support under the structure, wider than it

    Examples
    --------
    kind = "buttress"
    name = "buttress"
    material = "stone"
    width = 1.0
    height = 3.0
    courses = 6
    """

    width: Length
    height: Length
    courses: Count = 1
    top: Length | None = None
    stages: Annotated[int, Meta(ge=2)] | None = None
    lean: Annotated[float, Meta(gt=-60, lt=60, extra={"unit": "deg"})] = 0.0
    stones: Count = 1
    depth: Length = 1.0
    position: Point | None = None
    ground: bool = True

    def foreseen(self, dimension: int) -> Foreseen:
        """Its courses, all as long as that at the foot, and the ground."""
        return Foreseen(self.courses * self.stones + self.ground, ("courses", "stones"))

    def faults(self, dimension: int) -> Iterator[tuple[str, str]]:
        """A top wider than the foot, stages that do not differ or have no course."""
        if self.top is not None and self.top > self.width:
            yield "top", f"at most the width at the foot ({self.width:g} m)"
        if self.stages is None:
            return
        if self.top is None:
            yield "top", "the width of the uppermost stage in m"
        elif self.top == self.width:
            yield "top", f"less than the width at the foot ({self.width:g} m), for stages to differ"
        if self.stages > self.courses:
            yield "stages", f"at most as many as courses ({self.courses})"


ROUNDING = 1e-9  # of the width: stones whose corners differ by less are the same


def build(spec: ButtressStructure, dimension: int) -> Assembly:
    """Blocks ``name.c1.b1`` ... course by course from below, and ``name.ground``."""
    origin = np.zeros(dimension) if spec.position is None else np.array(spec.position, dtype=float)
    rise, slope = spec.height / spec.courses, np.tan(np.radians(spec.lean))
    shapes: list[Shape] = []
    numbers: dict[tuple[int, ...], int] = {}
    blocks = []
    if spec.ground:
        high = origin + ([spec.width, spec.depth, rise] if dimension == 3 else [spec.width, rise])
        slab, block = ground(spec.name, 0, origin, high, rise)
        shapes.append(slab)
        blocks.append(block)
    for course in range(spec.courses):
        below, above = _widths(spec, course)
        joints = [0.0, *_joints(spec, course, above)]
        groups: tuple[str, ...] = (spec.name, f"{spec.name}.c{course + 1}")
        if spec.stages is not None:
            groups = (*groups, f"{spec.name}.stage{_stage(spec, course) + 1}")
        for number, left in enumerate(joints):
            right = joints[number + 1 : number + 2] * 2 or [below, above]
            sides = [right[0] - left, slope * rise, right[1] - left + slope * rise]
            key = tuple(round(x / (ROUNDING * spec.width)) for x in sides)
            if key not in numbers:
                numbers[key] = len(shapes)
                solid = trapezium(sides[0], sides[1], sides[2], rise, spec.depth, dimension)
                shapes.append(Shape(f"{spec.name}.stone{len(numbers)}", solid))
            corner = origin.copy()
            corner[0] += left + slope * course * rise
            corner[-1] += course * rise
            name = f"{spec.name}.c{course + 1}.b{number + 1}"
            blocks.append(Block(name, numbers[key], Pose(np.eye(dimension), corner), groups))
    return Assembly(dimension, tuple(shapes), tuple(blocks))


def trapezium(
    foot: float, top_left: float, top_right: float, height: float, depth: float, dimension: int
) -> Polytope:
    """Solid from (0, 0) to (foot, 0) below and ``top_left`` to ``top_right`` above, drawn out along y."""
    size = (foot, depth, height) if dimension == 3 else (foot, height)
    box = Polytope.box((0.0,) * dimension, size)
    corners = box.vertices.copy()
    above, right = corners[:, -1] > 0, corners[:, 0] > 0
    corners[above & ~right, 0], corners[above & right, 0] = top_left, top_right
    return replace(box, vertices=corners)


def _stage(spec: ButtressStructure, course: int) -> int:
    return course * (spec.stages or 1) // spec.courses


def _widths(spec: ButtressStructure, course: int) -> tuple[float, float]:
    """Of a course, at its lower and at its upper bed [m]."""
    less = spec.width - (spec.width if spec.top is None else spec.top)
    if spec.stages is not None:
        width = spec.width - less * _stage(spec, course) / (spec.stages - 1)
        return width, width
    return spec.width - less * course / spec.courses, spec.width - less * (course + 1) / spec.courses


def _joints(spec: ButtressStructure, course: int, width: float) -> list[float]:
    """Of the stones of a course, from its left face [m]; the last stone has half a length at least."""
    if spec.stones == 1:
        return []
    length = spec.width / spec.stones
    first = length if course % 2 == 0 else length / 2
    count = floor((width - length / 2 - first) / length + ROUNDING) + 1
    return [first + length * number for number in range(count)]
