"""Flying buttress: stones along an inclined line or arc, from a foot up to a wall."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from math import asin, cos, degrees, radians
from typing import Annotated, Literal

import numpy as np
from msgspec import Meta

from masonry_fem.errors import GeometryError
from masonry_fem.records.record import Count, Distance, Length, Point
from masonry_fem.records.structure import Foreseen, Structure
from masonry_fem.solid.assembly import Assembly
from masonry_fem.solid.pose import FloatArray
from masonry_fem.structures.parts.curve import Circle, Line, Offset, Segment, crossing
from masonry_fem.structures.parts.quarry import Quarry, lay_arch
from masonry_fem.structures.parts.voussoir import Voussoir


class FlyingButtressStructure(Structure, frozen=True, kw_only=True, tag="flying_buttress"):
    """Flyer of ``voussoirs`` stones that rises at ``inclination`` [deg] over ``span`` to a wall.

    Its axis is straight, or with a ``camber`` an arc; joints are normal to the axis and divide it into equal
    parts. It is on one ``side`` of the wall that its head pushes. ``head`` and ``foot`` are supports; without
    them it leans on other blocks, such as a portal's pier and a buttress.

    Attributes
    ----------
    span : horizontal distance between the ends of the axis
    inclination : angle of the axis, or of its chord, to the horizontal
    thickness : distance between intrados and extrados, normal to the axis
    voussoirs : number of stones, numbered from the foot
    camber : height of the axis above its chord; with 0 it is straight
    depth : length along y; not used in 2D
    position : where the axis meets the wall, at the front; the origin by default
    side : side of the wall on which it is
    ends : ``square`` ends are normal to the axis, ``vertical`` ones parallel to the wall; or only the
        head's is vertical
    head : a support in place of the wall
    foot : a support at the foot

    Examples
    --------
    kind = "flying_buttress"
    name = "flying_buttress"
    material = "stone"
    span = 4.0
    inclination = 40.0
    thickness = 0.5
    voussoirs = 6
    """

    span: Length
    inclination: Annotated[float, Meta(ge=0, lt=90, extra={"unit": "deg"})]
    thickness: Length
    voussoirs: Count
    camber: Distance = 0.0
    depth: Length = 1.0
    position: Point | None = None
    side: Literal["left", "right"] = "right"
    ends: Literal["square", "vertical", "vertical_head"] = "square"
    head: bool = True
    foot: bool = True

    @property
    def carries(self) -> bool:
        """Whether it brings a head or a foot."""
        return self.head or self.foot

    @property
    def chord(self) -> float:
        """Length between the ends of the axis [m]."""
        return self.span / cos(radians(self.inclination))

    @property
    def radius(self) -> float:
        """Of the axis, where it has a camber [m]."""
        return self.chord**2 / (8 * self.camber) + self.camber / 2

    @property
    def opening(self) -> float:
        """Half the angle of the axis [deg], 0 where it is straight."""
        return degrees(asin(self.chord / (2 * self.radius))) if self.camber else 0.0

    def foreseen(self, dimension: int) -> Foreseen:
        """Its voussoirs, and a support at either end."""
        return Foreseen(self.voussoirs + self.head + self.foot, ("voussoirs",))

    def faults(self, dimension: int) -> Iterator[tuple[str, str]]:
        """More than half a circle, stones without an intrados, vertical ends of a vertical axis."""
        if self.camber >= self.chord / 2:
            yield "camber", f"less than half the chord ({self.chord / 2:g} m)"
        elif self.camber and self.thickness >= 2 * self.radius:
            yield "thickness", f"less than twice the radius of the axis ({2 * self.radius:g} m)"
        elif self.ends == "vertical" and self.inclination + self.opening >= 80:
            steep = f"{self.inclination + self.opening:.3g}"
            yield "ends", f"another where the axis is as steep as {steep} degrees at its foot"


def build(spec: FlyingButtressStructure, dimension: int) -> Assembly:
    """Voussoirs ``name.v01`` ... from the foot, supports ``name.foot`` and ``name.head``.

    Joints are ``radial``, those at both ends ``head``, as between boxes. ``position`` is where the axis
    meets the wall.
    """
    origin = np.zeros(dimension) if spec.position is None else np.array(spec.position, dtype=float)
    quarry = Quarry(spec.name, dimension, spec.depth, origin)
    head_right = spec.side == "left"
    faces, joints = _cut(spec)
    labels = ["head", *["radial"] * (spec.voussoirs - 1), "head"]
    stones = [
        Voussoir.between(faces, a, b, *names)
        for (a, b), names in zip(pairwise(joints), pairwise(labels), strict=True)
    ]
    ends = [stone.faces(straight=True) for stone in stones]
    for noun, right, wanted in (("foot", not head_right, spec.foot), ("head", head_right, spec.head)):
        if wanted:
            low, high = (face[-1 if right else 0] for face in ends[-1 if right else 0])
            quarry.support(f"{spec.name}.{noun}", low, high, not right, "head")
    lay_arch(quarry, stones if head_right else stones[::-1])
    return Assembly(dimension, tuple(quarry.shapes), tuple(quarry.blocks))


def _cut(spec: FlyingButtressStructure) -> tuple[list[Offset], FloatArray]:
    """Lower and upper face, and where joints meet them from left to right, shape (voussoirs + 1, 2)."""
    line, start, end = axis(spec)
    faces = [Offset(line, side * spec.thickness / 2) for side in (-1, 1)]
    joints = np.repeat(np.linspace(start, end, spec.voussoirs + 1)[:, None], 2, axis=1)
    head, foot = (-1, 0) if spec.side == "left" else (0, -1)
    for k in {"square": (), "vertical": (head, foot), "vertical_head": (head,)}[spec.ends]:
        joints[k] = [_upright(spec, face, float(joints[k, 0])) for face in faces]
    if (np.diff(joints, axis=0) <= 0).any():
        raise GeometryError(
            f"structures.{spec.name}.voussoirs is {spec.voussoirs}, expected fewer: joints next to the "
            "vertical ends would cross within the thickness"
        )
    return faces, joints


def axis(spec: FlyingButtressStructure) -> tuple[Line, float, float]:
    """The axis from left to right, with its head at the origin, and its parameters there."""
    rise = 1.0 if spec.side == "left" else -1.0  # rises to the right where the wall is on its right
    slope, chord = rise * np.radians(spec.inclination), spec.chord
    along = np.array([np.cos(slope), np.sin(slope)])
    if not spec.camber:
        return (Segment(slope), -chord, 0.0) if rise > 0 else (Segment(slope), 0.0, chord)
    middle = -rise * chord / 2 * along
    x, y = middle - (spec.radius - spec.camber) * np.array([-along[1], along[0]])
    half = np.radians(spec.opening)
    return Circle(spec.radius, float(x), float(y)), -slope - half, -slope + half


def _upright(spec: FlyingButtressStructure, face: Offset, at: float) -> float:
    """Parameter of a face at the vertical through the axis at parameter ``at``."""
    place: FloatArray = face.line.at(np.array([at]))[0]
    reach = np.pi / 2 if spec.camber else 2 * spec.chord + 10 * spec.thickness
    low, high = (-reach, reach) if spec.camber else (at - reach, at + reach)
    across = np.array([1.0, 0.0])
    ends = (face.at(np.array([low, high])) - place) @ across
    if ends[0] >= 0 or ends[1] <= 0:
        raise GeometryError(
            f"structures.{spec.name}.ends is 'vertical', expected 'square': the flyer is too steep at its end"
        )
    return crossing(face, low, high, place, across)
