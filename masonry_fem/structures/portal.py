"""Portal: the stones of an arch on two piers of blocks, each pier on a support of its own."""

from __future__ import annotations

import numpy as np

from masonry_fem.scene.specs import PortalStructure
from masonry_fem.solid.assembly import Assembly, Block, Shape
from masonry_fem.solid.polytope import Polytope
from masonry_fem.solid.pose import FloatArray, Pose
from masonry_fem.structures.curve import Circle, Ellipse
from masonry_fem.structures.ground import slab
from masonry_fem.structures.pointed_arch import stones_of
from masonry_fem.structures.quarry import Quarry, lay_arch
from masonry_fem.structures.voussoir import Voussoir, cut_line


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
            foot = slab(spec.name, low, low + size, spec.pier_width / 2)
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
