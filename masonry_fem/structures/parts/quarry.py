"""Quarry: voussoirs as shapes and blocks; congruent voussoirs share one shape.

    quarry = Quarry("arch", dimension=2, depth=1.0, origin=np.zeros(2))
    lay_arch(quarry, stones)
    quarry.shapes, quarry.blocks

A shape's frame has its origin at the foot of its left joint, x normal to the joint and the last axis along
it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from masonry_fem.solid.assembly import Assembly, Block, Shape
from masonry_fem.solid.polytope import Polytope
from masonry_fem.solid.pose import FloatArray, Pose
from masonry_fem.solid.prism import prism
from masonry_fem.structures.parts.voussoir import Voussoir
from masonry_fem.structures.parts.voussoir_row import VoussoirStructure

if TYPE_CHECKING:
    from masonry_fem.structures.arch import ArchStructure

ALIKE = 1e-9  # of a stone's size: outlines that differ by less are one shape
MARGIN = 0.25  # of the joint's length: how far a support extends beyond it


@dataclass(slots=True)
class Quarry:
    """Shapes and blocks of the stones laid so far; stones that are alike share a shape.

    Attributes
    ----------
    name : The structure's. dimension : 2 or 3. depth : Along y in 3D [m]. straight : Chords for curves.
    origin : Where the arch's plane has its origin in the world, shape (d,) [m].
    extrados : Joint label of the stones' extrados.
    """

    name: str
    dimension: int
    depth: float
    origin: FloatArray
    straight: bool = False
    shapes: list[Shape] = field(default_factory=list)
    blocks: list[Block] = field(default_factory=list)
    extrados: str = ""

    def lay(self, name: str, stone: Voussoir, groups: tuple[str, ...]) -> None:
        """Add a stone."""
        low, high = stone.faces(self.straight)
        self._add(name, "voussoir", low, high, len(stone.low), (stone.start, stone.end), groups, False)

    def support(self, name: str, foot: FloatArray, head: FloatArray, left: bool, label: str) -> None:
        """Add a support beside the joint from ``foot`` up to ``head``, on its left or its right."""
        along = head - foot
        across = np.array([along[1], -along[0]])  # to the right
        ends = np.array([foot - MARGIN * along, head + MARGIN * along])
        rows = [ends - across, ends] if left else [ends, ends + across]
        labels = ("", label) if left else (label, "")
        low, high = (np.array([row[k] for row in rows]) for k in (0, 1))
        self._add(name, name.removeprefix(f"{self.name}."), low, high, 1, labels, (), True)

    def _add(
        self, name: str, noun: str, low: FloatArray, high: FloatArray, parts: int,
        labels: tuple[str, str], groups: tuple[str, ...], support: bool,
    ) -> None:  # fmt: skip
        foot, along = low[0], (high[0] - low[0]) / np.linalg.norm(high[0] - low[0])
        frame = np.array([[along[1], along[0]], [-along[0], along[1]]])  # across and along the joint
        outline = (np.concatenate([low, high[::-1]]) - foot) @ frame
        number = self._number(noun, outline, len(low), parts, labels)
        flat = self.dimension == 2
        pose = Pose(frame if flat else _spatial(frame), self.origin + (foot if flat else _placed(foot)))
        self.blocks.append(Block(name, number, pose, (self.name, *groups), support))

    def _number(
        self, noun: str, outline: FloatArray, low: int, parts: int, labels: tuple[str, str]
    ) -> int:  # fmt: skip
        made = wedge(outline, low, (*labels, self.extrados), self.depth, self.dimension)
        for number, known in enumerate(self.shapes):
            if _alike(known, made, parts):
                return number
        rails = rails_of(len(outline), low, self.dimension)
        self.shapes.append(Shape(f"{self.name}.{noun}{len(self.shapes) + 1}", made, rails=rails, parts=parts))
        return len(self.shapes) - 1


def arch_of(
    spec: VoussoirStructure | ArchStructure, stones: Sequence[Voussoir], dimension: int, straight: bool
) -> Assembly:
    """An arch of given stones, between its springings.

    Parameters
    ----------
    spec : Name, depth, centre, and whether there are springings.
    stones : The voussoirs from the left, in the arch's plane.
    dimension : 2 or 3.
    straight : Whether intrados and extrados are straight between the joints of a stone.
    """
    origin = np.zeros(dimension) if spec.centre is None else np.array(spec.centre, dtype=float)
    quarry = Quarry(spec.name, dimension, spec.depth, origin, straight)
    if spec.springings:
        lay_springings(quarry, stones)
    lay_arch(quarry, stones)
    return Assembly(dimension, tuple(quarry.shapes), tuple(quarry.blocks))


def lay_arch(quarry: Quarry, stones: Sequence[Voussoir]) -> None:
    """Add stones ``name.v01`` ... from the left, with groups ``name.springers`` and ``name.keystone``.

    Parameters
    ----------
    quarry : Where shapes and blocks are added.
    stones : The voussoirs from the left.
    """
    digits = max(2, len(str(len(stones))))
    for number, stone in enumerate(stones):
        groups = roles(quarry.name, number, len(stones))
        quarry.lay(f"{quarry.name}.v{number + 1:0{digits}d}", stone, groups)


def roles(name: str, number: int, count: int) -> tuple[str, ...]:
    """Groups of a stone by its place: a springer at either end, the keystone in the middle.

    Parameters
    ----------
    name : Of the structure.
    number : Of the stone from the left, 0 for the first.
    count : Of all stones.
    """
    made = (f"{name}.springers",) if number in {0, count - 1} else ()
    return (*made, f"{name}.keystone") if 2 * number + 1 == count else made


def lay_springings(quarry: Quarry, stones: Sequence[Voussoir]) -> None:
    """Add the supports ``name.springing_left`` and ``name.springing_right`` of a row of stones.

    Parameters
    ----------
    quarry : Where shapes and blocks are added.
    stones : The voussoirs from the left.
    """
    for side, stone, at, label in (
        ("left", stones[0], 0, stones[0].start),
        ("right", stones[-1], -1, stones[-1].end),
    ):
        low, high = stone.faces(straight=True)
        quarry.support(f"{quarry.name}.springing_{side}", low[at], high[at], side == "left", label)


def wedge(
    outline: FloatArray, low: int, labels: tuple[str, ...], depth: float, dimension: int, sides: str = ""
) -> Polytope:
    """The solid of a voussoir.

    Parameters
    ----------
    outline : Corners in counter-clockwise order, the intrados first, shape (n, 2) [m].
    low : Number of corners on the intrados.
    labels : Joint labels of the faces ``start`` (left), ``end`` (right) and, if it has one, ``extrados``.
    depth : Along y in 3D [m].
    dimension : 2 or 3.
    sides : Joint label of the faces ``front`` and ``back``.
    """
    names = ["intrados"] * (low - 1) + ["end"] + ["extrados"] * (len(outline) - low - 1) + ["start"]
    of_name = dict(zip(("start", "end", "extrados"), labels, strict=False))
    return prism(outline, names, [of_name.get(name, "") for name in names], depth, dimension, sides)


def rails_of(n: int, low: int, dimension: int) -> tuple[tuple[int, ...], ...]:
    """Vertices along a prism from left to right: those below and above, in 3D of the front, then of the back.

    Parameters
    ----------
    n : Corners of its outline in counter-clockwise order, the lower ones first.
    low : Number of the lower ones.
    dimension : 2 or 3.
    """
    rails = (tuple(range(low)), tuple(range(n - 1, low - 1, -1)))
    if dimension == 2:
        return rails
    return (*rails, *(tuple(vertex + n for vertex in rail) for rail in rails))


def _alike(known: Shape, made: Polytope, parts: int) -> bool:
    solid = known.solid
    if (known.parts, solid.faces, solid.labels) != (parts, made.faces, made.labels):
        return False
    size = np.ptp(made.vertices, axis=0).max()
    return bool(np.abs(solid.vertices - made.vertices).max() <= ALIKE * size)


def _placed(point: FloatArray) -> FloatArray:
    """A point of the arch's plane in world coordinates."""
    return np.array([point[0], 0.0, point[1]])


def _spatial(turn: FloatArray) -> FloatArray:
    """A rotation in the arch's plane as a rotation in 3D."""
    rotation = np.eye(3)
    rotation[np.ix_([0, 2], [0, 2])] = turn
    return rotation
