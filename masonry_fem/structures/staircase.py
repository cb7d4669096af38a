"""Staircase: steps built into a wall at their back end, each resting on the one below.

The wall is as many stones as hold the steps: one below and one above each built-in end, all equal.
"""

from __future__ import annotations

import numpy as np

from masonry_fem.scene.specs import StaircaseStructure
from masonry_fem.solid.assembly import Assembly, Block, Shape
from masonry_fem.solid.polytope import Polytope
from masonry_fem.solid.pose import Pose
from masonry_fem.structures.ground import ground

STEP, STONE = 0, 1


def build(spec: StaircaseStructure, dimension: int) -> Assembly:
    """Steps ``name.s1`` (lowest) upwards, supports ``name.below2``, ``name.above1`` ..., ``name.ground``."""
    origin = np.zeros(3) if spec.position is None else np.array(spec.position, dtype=float)
    step = np.array([spec.going + spec.lap, spec.width + spec.bearing, spec.rise])
    stone = np.array([spec.going, spec.bearing, spec.rise])
    shapes = [
        Shape(f"{spec.name}.step", Polytope.box((0.0,) * 3, tuple(step))),
        Shape(f"{spec.name}.stone", Polytope.box((0.0,) * 3, tuple(stone))),
    ]
    blocks = []
    if spec.ground:
        slab, block = ground(spec.name, len(shapes), origin, origin + step, spec.rise)
        shapes.append(slab)
        blocks.append(block)

    def add(name: str, shape: int, x: float, y: float, level: int) -> None:
        corner = origin + np.array([x, y, level * spec.rise])
        groups = (spec.name, f"{spec.name}.wall") if shape == STONE else (spec.name, f"{spec.name}.steps")
        pose = Pose(np.eye(3), corner)
        blocks.append(Block(f"{spec.name}.{name}", shape, pose, groups, support=shape == STONE))

    for number in range(spec.steps):
        front = number * spec.going
        if number or not spec.ground:
            add(f"below{number + 1}", STONE, front + spec.lap, spec.width, number - 1)
        add(f"s{number + 1}", STEP, front, 0.0, number)
        add(f"above{number + 1}", STONE, front, spec.width, number + 1)
    return Assembly(dimension, tuple(shapes), tuple(blocks))
