"""Staircase: steps built into a wall at their back end, each resting on the one below.

The wall is as many stones as hold the steps: one below and one above each built-in end, all equal.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from masonry_fem.records.record import Count, Length, Point
from masonry_fem.records.structure import Foreseen, Structure
from masonry_fem.solid.assembly import Assembly, Block, Shape
from masonry_fem.solid.polytope import Polytope
from masonry_fem.solid.pose import Pose
from masonry_fem.structures.parts.ground import ground


class StaircaseStructure(Structure, frozen=True, kw_only=True, tag="staircase"):
    """Hanging (cantilevered) staircase of ``steps`` steps: masons' *escalier suspendu*, without a string.

    It rises along x. Each step extends by ``width`` from the wall and by ``bearing`` into it, and its front
    edge rests on the step below over the ``lap``. Wall stones above and below the built-in ends hold these;
    they are supports.

    Attributes
    ----------
    steps : number of steps, all equal
    going : distance from step to step along x
    rise : height from step to step, and of a step
    width : length of a step clear of the wall, along y
    lap : how far a step covers the one below
    bearing : how far the steps go into the wall
    position : lower front corner of the first step's free end [m]; the origin by default
    ground : a support under the structure, wider than it

    Examples
    --------
    kind = "staircase"
    name = "staircase"
    material = "stone"
    steps = 6
    going = 0.3
    rise = 0.17
    width = 1.2
    lap = 0.02
    bearing = 0.2
    """

    steps: Count
    going: Length
    rise: Length
    width: Length
    lap: Length
    bearing: Length
    position: Point | None = None
    ground: bool = True

    @property
    def carries(self) -> bool:
        """Always: the stones of its wall."""
        return True

    def foreseen(self, dimension: int) -> Foreseen:
        """Its steps, and the stones of the wall below and above each."""
        return Foreseen(3 * self.steps, ("steps",))

    def faults(self, dimension: int) -> Iterator[tuple[str, str]]:
        """A plane staircase, a lap as long as a step."""
        if dimension == 2:
            yield "width", "a scene of dimension 3: the wall stands behind the steps"
        if self.lap >= self.going:
            yield "lap", f"less than the going ({self.going:g} m)"


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
