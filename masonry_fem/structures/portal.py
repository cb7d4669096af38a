"""Portal: the stones of an arch on two piers of blocks, each pier on a support of its own."""

from __future__ import annotations

from collections.abc import Iterator
from math import isclose
from typing import Literal

import numpy as np

from masonry_fem.records.record import Count, Length, Point
from masonry_fem.records.structure import Foreseen, Structure
from masonry_fem.solid.assembly import Assembly, Block, Shape
from masonry_fem.solid.polytope import Polytope
from masonry_fem.solid.pose import FloatArray, Pose
from masonry_fem.structures.parts.curve import Circle, Ellipse
from masonry_fem.structures.parts.ground import slab
from masonry_fem.structures.parts.quarry import Quarry, lay_arch
from masonry_fem.structures.parts.voussoir import Voussoir, cut_line
from masonry_fem.structures.pointed_arch import PointedArchStructure, stones_of


class PortalStructure(Structure, frozen=True, kw_only=True, tag="portal"):
    """Arch of ``voussoirs`` stones on two piers, whose inner faces are flush with the intrados.

    The ``form`` of its mean line is half a circle, or pointed or elliptical with a ``rise``.
    A pier is one block, or ``courses`` equal ones.

    Attributes
    ----------
    span : span of the mean line
    thickness : thickness of the arch
    voussoirs : number of stones, numbered from the left
    pier_width : width from the intrados outwards
    pier_height : height from the ground to the springings
    form : form of the arch's mean line
    rise : rise of the mean line above the piers; half the span if it is circular
    courses : number of blocks of a pier
    depth : length along y; not used in 2D
    centre : middle between the piers on the ground, at the front; the origin by default
    straight : voussoirs have chords in place of arcs
    ground : a support under each pier

    Examples
    --------
    kind = "portal"
    name = "portal"
    material = "stone"
    span = 3.0
    thickness = 0.4
    voussoirs = 9
    pier_width = 0.8
    pier_height = 2.0
    courses = 3
    """

    span: Length
    thickness: Length
    voussoirs: Count
    pier_width: Length
    pier_height: Length
    form: Literal["circular", "pointed", "elliptical"] = "circular"
    rise: Length | None = None
    courses: Count = 1
    depth: Length = 1.0
    centre: Point | None = None
    straight: bool = False
    ground: bool = True

    def foreseen(self, dimension: int) -> Foreseen:
        """Its voussoirs and the blocks of two piers, each with its ground."""
        blocks = self.voussoirs + 2 * (self.courses + self.ground)
        return Foreseen(blocks, ("voussoirs", "courses"))

    @property
    def pointed(self) -> PointedArchStructure:
        """Its arch alone where that is pointed, about the middle between the piers' tops."""
        return PointedArchStructure(
            name=self.name,
            material=self.material,
            span=self.span,
            rise=self.rise,
            thickness=self.thickness,
            voussoirs=self.voussoirs,
        )

    def faults(self, dimension: int) -> Iterator[tuple[str, str]]:
        """A form without its rise, and impossible shapes of its arch."""
        half = self.span / 2
        if self.form == "circular" and self.rise is not None and not isclose(self.rise, half):
            yield "rise", f"half the span ({half:g} m) in a circular portal, or none"
        elif self.form != "circular" and self.rise is None:
            yield "rise", f"a length > 0 in m: a portal that is {self.form} has a rise"
        elif self.form == "pointed":
            yield from self.pointed.faults(dimension)
        elif self.rise is not None and self.thickness >= 2 * min(half**2 / self.rise, self.rise**2 / half):
            least = min(half**2 / self.rise, self.rise**2 / half)
            yield "thickness", f"less than twice the ellipse's least radius of curvature ({least:g} m)"
        elif self.thickness >= self.span:
            yield "thickness", f"less than the span ({self.span:g} m)"


def build(spec: PortalStructure, dimension: int) -> Assembly:
    """Voussoirs ``name.v01`` ..., piers ``name.left.c1`` ... and ``name.right.c1`` ... from the ground.

    Supports ``name.ground_left`` and ``name.ground_right``; groups ``name.left``, ``name.right`` (the piers),
    ``name.springers``, ``name.keystone``. Joints of piers are ``bed``, those of the arch, its springing
    joints among them, ``radial``.
    """
    origin = np.zeros(dimension) if spec.centre is None else np.array(spec.centre, dtype=float)
    size = np.array([spec.pier_width, spec.depth, spec.pier_height / spec.courses])
    size = size[[0, 2]] if dimension == 2 else size
    below, top = (_course(f"{spec.name}.{noun}", size, noun == "top") for noun in ("course", "top"))
    shapes = [top] if spec.courses == 1 else [top, below]
    blocks = []
    inner = (spec.span - spec.thickness) / 2
    for side, left in (("left", -inner - spec.pier_width), ("right", inner)):
        low = origin.copy()
        low[0] += left
        if spec.ground:
            name = f"{spec.name}.ground_{side}"
            foot = slab(low, low + size, spec.pier_width / 2)
            blocks.append(Block(name, len(shapes), Pose.identity(dimension), (spec.name,), support=True))
            shapes.append(Shape(name, foot))
        for course in range(spec.courses):
            up = np.zeros(dimension)
            up[-1] = course * size[-1]
            kind = 0 if course == spec.courses - 1 else 1
            name = f"{spec.name}.{side}.c{course + 1}"
            groups = (spec.name, f"{spec.name}.{side}")
            blocks.append(Block(name, kind, Pose(np.eye(dimension), low + up), groups))
    crowned = origin.copy()
    crowned[-1] += spec.courses * size[-1]
    quarry = Quarry(spec.name, dimension, spec.depth, crowned, spec.straight, shapes, blocks)
    lay_arch(quarry, _stones(spec))
    return Assembly(dimension, tuple(quarry.shapes), tuple(quarry.blocks))


def _course(name: str, size: FloatArray, top: bool) -> Shape:
    """A block of a pier; the top one carries a springing joint."""
    box = Polytope.box((0.0,) * len(size), tuple(size))
    if not top:
        return Shape(name, box)
    labels = tuple(
        "radial" if face == "top" else label for face, label in zip(box.names, box.labels, strict=True)
    )
    return Shape(name, Polytope(box.vertices, box.faces, box.names, labels))


def _stones(spec: PortalStructure) -> list[Voussoir]:
    """The arch's stones from the left, about the middle between the tops of the piers."""
    if spec.form == "pointed":
        return stones_of(spec.pointed)
    half, right = spec.span / 2, np.pi / 2
    line = Circle(half) if spec.form == "circular" or spec.rise is None else Ellipse(half, spec.rise)
    return cut_line(line, -right, right, spec.thickness, spec.voussoirs, "radial")
