"""Column: drums on top of each other, each a prism (a frustum if the column tapers) about the axis."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated

import numpy as np
from msgspec import Meta

from masonry_fem.records.record import Count, Distance, Length, Point
from masonry_fem.records.structure import Foreseen, Structure
from masonry_fem.solid.assembly import Assembly, Block, Shape
from masonry_fem.solid.polytope import Polytope
from masonry_fem.solid.pose import FloatArray, Pose
from masonry_fem.structures.parts.ground import ground


class ColumnStructure(Structure, frozen=True, kw_only=True, tag="column"):
    """Column of ``drums`` equally high drums, on a square ``plinth`` and under a square ``capital``.

    A drum is a prism of several ``sides`` with the area of the circle. The ``diameter`` changes linearly from
    the foot to ``top_diameter``; an ``entasis`` adds a parabola, greatest at half height. In 2D it is the
    column's section through the axis, one metre deep.

    Attributes
    ----------
    drums : number of drums, all equally high
    height : height of all drums, without plinth and capital
    diameter : diameter at the foot, of the circle that has the drum's area
    top_diameter : the same at the top; that of the foot by default
    entasis : by how much the diameter at half height exceeds that of the straight taper
    sides : number of sides of a drum; not used in 2D
    plinth : height of the block below the drums; none by default
    capital : height of the block above the drums; none by default
    projection : how far plinth and capital extend beyond the diameter on each side
    centre : centre of the foot; the origin by default
    ground : a support under the structure, wider than it

    Examples
    --------
    kind = "column"
    name = "column"
    material = "stone"
    drums = 5
    height = 3.0
    diameter = 0.5
    """

    drums: Count
    height: Length
    diameter: Length
    top_diameter: Length | None = None
    entasis: Distance = 0.0
    sides: Annotated[int, Meta(ge=3)] = 12
    plinth: Length | None = None
    capital: Length | None = None
    projection: Distance = 0.0
    centre: Point | None = None
    ground: bool = True

    def foreseen(self, dimension: int) -> Foreseen:
        """Its drums, with their number of sides, plinth, capital and ground."""
        added = (self.plinth is not None) + (self.capital is not None) + self.ground
        sides = 4 if dimension == 2 else self.sides + 2
        return Foreseen(self.drums + added, ("drums", "sides"), sides=sides)

    def faults(self, dimension: int) -> Iterator[tuple[str, str]]:
        """A projection of nothing, more drums than tell an entasis apart."""
        if self.projection and self.plinth is None and self.capital is None:
            yield "projection", "0 without a plinth or a capital that could stand out"
        if self.entasis and self.drums == 1:
            yield "entasis", "0 for a single drum, whose sides are straight"


def build(spec: ColumnStructure, dimension: int) -> Assembly:
    """Blocks ``name.plinth``, ``name.d1`` (lowest) upwards, ``name.capital``, and ``name.ground``."""
    foot = np.zeros(dimension) if spec.centre is None else np.array(spec.centre, dtype=float)
    levels = np.linspace(0.0, 1.0, spec.drums + 1)
    diameters = diameters_at(spec, levels)
    shapes: list[Shape] = []
    numbers: dict[tuple[float, ...], int] = {}
    blocks: list[Block] = []
    level = float(foot[-1])

    def lay(name: str, height: float, solid: Polytope, key: tuple[float, ...]) -> None:
        nonlocal level
        if key not in numbers:
            numbers[key] = len(shapes)
            shapes.append(Shape(f"{spec.name}.{name}", solid))
        place = np.append(foot[:-1], level)
        blocks.append(
            Block(f"{spec.name}.{name}", numbers[key], Pose(np.eye(dimension), place), (spec.name,))
        )
        level += height

    if spec.ground:
        half = (diameters[0] / 2 + spec.projection) * np.ones(dimension - 1)
        low, high = np.append(foot[:-1] - half, level), np.append(foot[:-1] + half, level)
        slab, block = ground(spec.name, 0, low, high, spec.height / spec.drums / 2)
        shapes.append(slab)
        blocks.append(block)
    if spec.plinth is not None:
        side = float(diameters[0]) + 2 * spec.projection
        lay("plinth", spec.plinth, _slab(side, spec.plinth, dimension), (side, spec.plinth))
    height = spec.height / spec.drums
    for number in range(spec.drums):
        below, above = map(float, diameters[number : number + 2])
        solid = drum(below, above, height, spec.sides, dimension)
        lay(f"d{number + 1}", height, solid, (below, above, height))
    if spec.capital is not None:
        side = float(diameters[-1]) + 2 * spec.projection
        lay("capital", spec.capital, _slab(side, spec.capital, dimension), (side, spec.capital))
    return Assembly(dimension, tuple(shapes), tuple(blocks))


def diameters_at(spec: ColumnStructure, levels: FloatArray) -> FloatArray:
    """Diameters [m] at parts of the height (0 the foot, 1 the top), shape of ``levels``."""
    top = spec.diameter if spec.top_diameter is None else spec.top_diameter
    return np.asarray(
        spec.diameter + (top - spec.diameter) * levels + spec.entasis * 4 * levels * (1 - levels)
    )


def drum(below: float, above: float, height: float, sides: int, dimension: int) -> Polytope:
    """Frustum about the vertical axis, its foot at the origin, of the areas of circles [m]."""
    if dimension == 2:
        outline = np.array([[-below / 2, 0.0], [below / 2, 0.0], [above / 2, height], [-above / 2, height]])
        box = Polytope.box((-1.0, 0.0), (1.0, 1.0))
        return Polytope(outline, box.faces, box.names, box.labels)
    step = 2 * np.pi / sides
    angles = step * (np.arange(sides) + 0.5)
    ring = np.column_stack([np.cos(angles), np.sin(angles)]) * np.sqrt(step / np.sin(step)) / 2
    rims = [
        np.column_stack([diameter * ring, np.full(sides, z)])
        for diameter, z in ((below, 0.0), (above, height))
    ]
    following = [(i + 1) % sides for i in range(sides)]
    loops: list[tuple[int, ...]] = [(i, j, j + sides, i + sides) for i, j in enumerate(following)]
    loops += [tuple(range(sides - 1, -1, -1)), tuple(range(sides, 2 * sides))]
    names, labels = ("side",) * sides + ("bottom", "top"), ("",) * sides + ("bed", "bed")
    return Polytope(np.concatenate(rims), tuple(loops), names, labels)


def _slab(side: float, height: float, dimension: int) -> Polytope:
    """Square block about the axis, its foot at the origin."""
    half = (side / 2,) * (dimension - 1)
    return Polytope.box((*(-x for x in half), 0.0), (*half, height))
