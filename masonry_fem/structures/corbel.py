"""Corbel: equal boxes, each projecting beyond the one below."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

import numpy as np

from masonry_fem.records.record import Count, Metres, Point, Sizes
from masonry_fem.records.structure import Foreseen, Structure
from masonry_fem.solid.assembly import Assembly, Block, Shape
from masonry_fem.solid.polytope import Polytope
from masonry_fem.solid.pose import FloatArray, Pose
from masonry_fem.structures.parts.ground import ground


class CorbelStructure(Structure, frozen=True, kw_only=True, tag="corbel"):
    """``count`` boxes on top of each other, each projecting along x beyond the one below.

    All project by the same ``offset``; or in a ``harmonic`` profile the topmost one by it, and the next ones
    below by its half, third ... With a ``table`` the ground ends where the lowest box begins to project.
    Rigid boxes of length L stand up to an offset of L / count (L / (count + 1) on a table), and in the
    harmonic profile on a table up to L / 2: the greatest overhang that a stack can have.

    Attributes
    ----------
    size : size of each box
    count : number of boxes
    offset : offset along x of each box from the one below; of the topmost box if the profile is harmonic
    profile : all offsets are equal, or that of the k-th box from the top is offset / k
    position : lower left front corner [m]; the origin by default
    table : the ground ends at the end of the boxes, so that the lowest box projects, too
    ground : a support under the structure, wider than it

    Examples
    --------
    kind = "corbel"
    name = "corbel"
    material = "stone"
    size = [1.0, 0.5, 0.25]
    count = 4
    offset = 0.1
    """

    size: Sizes
    count: Count
    offset: Metres
    profile: Literal["equal", "harmonic"] = "equal"
    position: Point | None = None
    table: bool = False
    ground: bool = True

    def foreseen(self, dimension: int) -> Foreseen:
        """Its boxes, and the ground."""
        return Foreseen(self.count + self.ground, ("count",))

    def faults(self, dimension: int) -> Iterator[tuple[str, str]]:
        """Boxes that do not lie on one another, a table without ground."""
        if abs(self.offset) >= self.size[0]:
            yield "offset", f"less than the length of a box ({self.size[0]:g} m)"
        if self.table and not self.ground:
            yield "table", "false without a ground"


def build(spec: CorbelStructure, dimension: int) -> Assembly:
    """Blocks ``name.b1`` (lowest) upwards and ``name.ground``, which is a table that ends below them."""
    size, origin = np.array(spec.size, dtype=float), np.zeros(dimension)
    if spec.position is not None:
        origin = np.array(spec.position, dtype=float)
    places = np.cumsum(offsets(spec))
    shapes = [Shape(f"{spec.name}.block", Polytope.box((0.0,) * dimension, tuple(size)))]
    blocks = []
    if spec.ground:
        low, high = origin.copy(), origin + size
        low[0] += min(0.0, places.min())
        high[0] += max(0.0, places.max())
        slab, block = ground(spec.name, 1, low, high, float(size[-1]))
        if spec.table:
            slab = _table(slab, spec, origin)
        shapes.append(slab)
        blocks.append(block)
    for level, place in enumerate(places):
        corner = origin.copy()
        corner[0] += place
        corner[-1] += level * size[-1]
        blocks.append(Block(f"{spec.name}.b{level + 1}", 0, Pose(np.eye(dimension), corner), (spec.name,)))
    return Assembly(dimension, tuple(shapes), tuple(blocks))


def offsets(spec: CorbelStructure) -> FloatArray:
    """How far each box projects beyond what is below it [m], from the lowest, shape (count,)."""
    made = np.full(spec.count, spec.offset)
    if spec.profile == "harmonic":
        made /= np.arange(spec.count, 0, -1)
    if not spec.table:
        made[0] = 0.0
    return made


def _table(slab: Shape, spec: CorbelStructure, origin: FloatArray) -> Shape:
    """The ground, cut at the edge over which the boxes stand out."""
    edge = origin[0] + (spec.size[0] if spec.offset >= 0 else 0.0)
    low, high = slab.solid.vertices.min(axis=0), slab.solid.vertices.max(axis=0)
    if spec.offset >= 0:
        high[0] = edge
    else:
        low[0] = edge
    return Shape(slab.name, Polytope.box(tuple(low), tuple(high)))
