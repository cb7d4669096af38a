"""Stack: equal boxes on top of each other, straight or shifted like a staircase."""

from __future__ import annotations

import numpy as np

from masonry_fem.records.record import Count, Distance, Metres, Point, Sizes
from masonry_fem.records.structure import Foreseen, Structure
from masonry_fem.solid.assembly import Assembly, Block, Shape
from masonry_fem.solid.polytope import Polytope
from masonry_fem.solid.pose import Pose
from masonry_fem.structures.parts.ground import ground


class StackStructure(Structure, frozen=True, kw_only=True, tag="stack"):
    """``count`` boxes on top of each other, each shifted by ``offset`` along x from the one below.

    Attributes
    ----------
    size : size of each box
    count : number of boxes
    position : lower left front corner [m]; the origin by default
    offset : offset along x of each box from the one below
    gap : gap between the boxes, and to the ground
    ground : a support under the structure, wider than it

    Examples
    --------
    kind = "stack"
    name = "stack"
    material = "stone"
    size = [1.0, 1.0, 0.5]
    count = 5
    """

    size: Sizes
    count: Count
    position: Point | None = None
    offset: Metres = 0.0
    gap: Distance = 0.0
    ground: bool = True

    def foreseen(self, dimension: int) -> Foreseen:
        """Its boxes, and the ground."""
        return Foreseen(self.count + self.ground, ("count",))


def build(spec: StackStructure, dimension: int) -> Assembly:
    """Blocks ``name.b1`` (lowest) upwards and, where asked, ``name.ground``.

    ``gap`` opens every joint, that on the ground too.
    """
    size, origin = np.array(spec.size, dtype=float), np.zeros(dimension)
    if spec.position is not None:
        origin = np.array(spec.position, dtype=float)
    shapes = [Shape(f"{spec.name}.block", Polytope.box((0.0,) * dimension, spec.size))]
    blocks = []
    if spec.ground:
        reach = np.zeros(dimension)
        reach[0] = spec.offset * (spec.count - 1)
        low, high = origin + np.minimum(reach, 0), origin + size + np.maximum(reach, 0)
        shape, block = ground(spec.name, 1, low, high, float(size[-1]))
        shapes.append(shape)
        blocks.append(block)
    for level in range(spec.count):
        corner = origin.copy()
        corner[0] += level * spec.offset
        corner[-1] += level * size[-1] + (level + (1 if spec.ground else 0)) * spec.gap
        pose = Pose(np.eye(dimension), corner)
        blocks.append(Block(f"{spec.name}.b{level + 1}", 0, pose, (spec.name,)))
    return Assembly(dimension, tuple(shapes), tuple(blocks))
