"""Wall: bricks in running bond, half bricks closing every other course."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from masonry_fem.geometry.ground import ground
from masonry_fem.scene.specs import WallStructure
from masonry_fem.solid.assembly import Assembly, Block, Shape
from masonry_fem.solid.polytope import Polytope
from masonry_fem.solid.pose import Pose

WHOLE, HALF = 0, 1
# a cut brick's halves by name: shape, and how many half bricks it is moved
CUT = {"l": (2, 0), "r": (3, 1)}


def build(spec: WallStructure, dimension: int) -> Assembly:
    """Blocks ``name.c1.b1`` ... course by course from below, and ``name.ground``.

    Without half bricks the shifted courses are a brick shorter. Cut bricks are a left and a right half,
    ``name.c1.b1.l`` and ``name.c1.b1.r``.
    """
    brick, origin = np.array(spec.brick, dtype=float), np.zeros(dimension)
    if spec.position is not None:
        origin = np.array(spec.position, dtype=float)
    half = brick.copy()
    half[0] /= 2
    shapes = [
        Shape(f"{spec.name}.brick", Polytope.box((0.0,) * dimension, tuple(brick))),
        Shape(f"{spec.name}.half", Polytope.box((0.0,) * dimension, tuple(half))),
    ]
    if spec.cut:
        shapes += [
            _half(f"{spec.name}.left", shapes[HALF].solid, "right"),
            _half(f"{spec.name}.right", shapes[HALF].solid, "left"),
        ]
    blocks = []
    if spec.ground:
        high = origin + brick
        high[0] = origin[0] + spec.columns * brick[0]
        shape, block = ground(spec.name, len(shapes), origin, high, float(brick[-1]))
        shapes.append(shape)
        blocks.append(block)
    for course in range(1, spec.courses + 1):
        group = f"{spec.name}.c{course}"
        for number, (halves, kind) in enumerate(course_of(spec, course), start=1):
            corner = origin.copy()
            corner[0] += halves * half[0]
            corner[-1] += (course - 1) * brick[-1]
            name = f"{group}.b{number}"
            if spec.cut and kind == WHOLE:
                for side, (shape_of_side, moved) in CUT.items():
                    pose = Pose(np.eye(dimension), corner + moved * half * np.eye(dimension)[0])
                    blocks.append(Block(f"{name}.{side}", shape_of_side, pose, (spec.name, group, name)))
            else:
                blocks.append(Block(name, kind, Pose(np.eye(dimension), corner), (spec.name, group)))
    return Assembly(dimension, tuple(shapes), tuple(blocks))


def _half(name: str, solid: Polytope, cut: str) -> Shape:
    """A half brick whose face ``cut`` is a joint face labelled ``brick``."""
    labels = tuple(
        "brick" if face == cut else label for face, label in zip(solid.names, solid.labels, strict=True)
    )
    return Shape(name, replace(solid, labels=labels))


def course_of(spec: WallStructure, course: int) -> list[tuple[int, int]]:
    """Bricks of a course: (left end in half bricks, WHOLE or HALF)."""
    shifted = (course % 2 == 0) != (spec.half_bricks == "odd")
    length, first = round(2 * spec.columns), int(shifted)
    wholes = (length - first) // 2
    bricks = [(first + 2 * i, WHOLE) for i in range(wholes)]
    if spec.half_bricks == "none":
        return bricks
    if shifted:
        bricks.insert(0, (0, HALF))
    end = first + 2 * wholes
    return [*bricks, (end, HALF)] if end < length else bricks
