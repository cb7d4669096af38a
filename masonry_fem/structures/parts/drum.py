"""Drum: courses of stones in a ring under a dome, and the piers under them.

All faces continue the flat pieces of the dome's lowest ring, so that drum and dome meet without gaps.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from masonry_fem.errors import GeometryError
from masonry_fem.solid.assembly import Block, Shape
from masonry_fem.solid.pose import FloatArray, Pose
from masonry_fem.structures.parts.ring import MARGIN, about_axis, ring_stone

if TYPE_CHECKING:
    from masonry_fem.structures.dome import DomeStructure

FACES = ("intrados", "extrados", "lower", "upper", "left", "right")
JOINTS = ("", "", "bed", "bed", "meridian", "meridian")


@dataclass(frozen=True, slots=True)
class Layer:
    """A ring of equal stones.

    Attributes
    ----------
    names, groups : Of its stones. below, above : Levels under the springing [m].
    pieces : Of a stone, each as long as a piece of the dome's. starts : First piece of each stone.
    """

    names: list[str]
    groups: list[tuple[str, ...]]
    below: float
    above: float
    pieces: int
    starts: list[int]


def depth_below(spec: DomeStructure) -> float:
    """Height of all that is below the dome [m]."""
    drum = spec.drum_height or 0.0 if spec.drum_courses else 0.0
    return drum + (spec.pier_height or 0.0 if spec.piers else 0.0)


def drum_stones(
    spec: DomeStructure, pieces: int, low: float, centre: FloatArray, shapes: list[Shape]
) -> list[Block]:  # fmt: skip
    """Stones ``name.d1.s1`` ..., piers ``name.p1.c1`` ... from below, and ``name.base`` under the lowest.

    Parameters
    ----------
    spec : The dome.
    pieces : Flat pieces of a stone's curved face.
    low : Radius of the intrados [m].
    centre : Of the dome, shape (3,) [m].
    shapes : List that their shapes are appended to.

    Raises
    ------
    GeometryError : Values of the record that do not go together.
    """
    faults = list(spec.faults(3))
    if faults:
        key, expected = faults[0]
        raise GeometryError(
            f"structures.{spec.name}.{key} is {getattr(spec, key)}, expected {expected}; change it"
        )
    turn = np.radians(spec.sweep) / (spec.slices * pieces)
    high = low + spec.width
    blocks: list[Block] = []

    def lay(layer: Layer, shape: Shape, support: bool = False) -> None:
        shapes.append(shape)
        for name, groups, start in zip(layer.names, layer.groups, layer.starts, strict=True):
            pose = Pose(about_axis(start * turn), centre)
            blocks.append(Block(name, len(shapes) - 1, pose, (spec.name, *groups), support))

    layers = [*_piers(spec, pieces), *_courses(spec, pieces)]
    if spec.base:
        margin, lowest = MARGIN * spec.width, layers[0]
        base = f"{spec.name}.base"
        names = [base + name.removeprefix(spec.name).replace(".d1", "") for name in lowest.names]
        under = Layer(
            [name.removesuffix(".c1") for name in names], [(base,)] * len(names),
            lowest.below - spec.width, lowest.below, lowest.pieces, lowest.starts,
        )  # fmt: skip
        radii = (low - margin, high + margin)
        faces = (("", "", "", "top", "", ""), ("", "", "", "bed", "", ""))
        lay(under, _shape(base, under, radii, turn, faces), support=True)
    for layer in layers:
        lay(layer, _shape(layer.groups[0][-1], layer, (low, high), turn, (FACES, JOINTS)))
    return blocks


def _piers(spec: DomeStructure, pieces: int) -> list[Layer]:
    """Courses of all piers from below."""
    if not spec.piers or spec.pier_height is None or spec.pier_slices is None:
        return []
    height, top = spec.pier_height / spec.pier_courses, depth_below(spec) - spec.pier_height
    between = spec.slices // spec.piers * pieces
    piers = [f"{spec.name}.p{k + 1}" for k in range(spec.piers)]
    return [
        Layer(
            names=[f"{pier}.c{course + 1}" for pier in piers],
            groups=[(f"{spec.name}.piers", pier) for pier in piers],
            below=-top - spec.pier_height + course * height,
            above=-top - spec.pier_height + (course + 1) * height,
            pieces=spec.pier_slices * pieces,
            starts=[k * between for k in range(spec.piers)],
        )
        for course in range(spec.pier_courses)
    ]


def _courses(spec: DomeStructure, pieces: int) -> list[Layer]:
    """Courses of the drum from below; over piers the lowest has joints on their middles."""
    if not spec.drum_courses or spec.drum_height is None:
        return []
    height, long = spec.drum_height / spec.drum_courses, spec.slices // spec.stones * pieces
    first = 0
    if spec.piers and spec.pier_slices is not None:
        first = spec.pier_slices * pieces // 2
    elif spec.staggered and spec.drum_courses % 2:  # so that the top course is staggered with the first ring
        first = long // 2
    made = []
    for course in range(spec.drum_courses):
        turned = long // 2 if spec.staggered and course % 2 else 0
        group = f"{spec.name}.d{course + 1}"
        made.append(
            Layer(
                names=[f"{group}.s{k + 1}" for k in range(spec.stones)],
                groups=[(f"{spec.name}.drum", group)] * spec.stones,
                below=-spec.drum_height + course * height,
                above=-(spec.drum_courses - 1 - course) * height,
                pieces=long,
                starts=[first + turned + k * long for k in range(spec.stones)],
            )
        )
    return made


def _shape(
    name: str,
    layer: Layer,
    radii: tuple[float, float],
    turn: float,
    faces: tuple[tuple[str, ...], tuple[str, ...]],
) -> Shape:
    """The stone of a layer, its left joint on the world's x axis."""
    longitudes = turn * np.arange(layer.pieces + 1)
    around = np.column_stack([np.cos(longitudes), np.sin(longitudes)])
    corners = [
        np.column_stack([radius * around, np.full(len(around), level)])
        for radius in radii
        for level in (layer.below, layer.above)
    ]
    return ring_stone(name, np.concatenate(corners), layer.pieces, *faces)
