"""Pointed arch: stones between two arcs that meet at the crown, with a keystone or a joint there."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from math import asin, pi, sin

import numpy as np

from masonry_fem.records.record import Length
from masonry_fem.solid.assembly import Assembly
from masonry_fem.structures.parts.curve import Circle, Offset, crossing
from masonry_fem.structures.parts.quarry import arch_of
from masonry_fem.structures.parts.voussoir import Run, Voussoir
from masonry_fem.structures.parts.voussoir_row import Cut, VoussoirStructure


class PointedArchStructure(VoussoirStructure, frozen=True, kw_only=True, tag="pointed_arch"):
    """Arch of two arcs of a circle about centres on the springing line; springings as supports.

    Its form is given by ``rise`` or by the ``radius`` of the arcs (``radius = span`` is the equilateral
    arch). An odd number of ``voussoirs`` has a keystone, an even one a joint at the crown. Radial joints
    are normal to the arcs and divide them into equal lengths; vertical ones divide the span of the intrados
    into equal parts.

    Attributes
    ----------
    thickness : distance between intrados and extrados, normal to the arcs
    span : span of the mean line
    rise : rise of the mean line, in place of the radius
    radius : radius of the mean line's arcs, in place of the rise
    cut : ``radial`` joints are normal to the mean line, or all joints between the springings are vertical
    straight : voussoirs have chords in place of arcs

    Examples
    --------
    kind = "pointed_arch"
    name = "pointed_arch"
    material = "stone"
    span = 4.0
    radius = 4.0
    thickness = 0.4
    voussoirs = 8
    """

    span: Length
    rise: Length | None = None
    radius: Length | None = None
    cut: Cut = "radial"
    straight: bool = False

    @property
    def arc(self) -> float:
        """Radius of the mean line [m]."""
        if self.radius is not None:
            return self.radius
        rise = self.span / 2 if self.rise is None else self.rise
        return rise * rise / self.span + self.span / 4

    @property
    def offset(self) -> float:
        """Distance of the arcs' centres from the middle [m]."""
        return self.arc - self.span / 2

    @property
    def crown(self) -> float:
        """Angle from the vertical at which the mean line meets the middle, at its arc's centre [rad]."""
        return asin(self.offset / self.arc)

    def faults(self, dimension: int) -> Iterator[tuple[str, str]]:
        """No form, or two; flatter than a semicircle; joints beside the keystone that cross."""
        if (self.rise is None) == (self.radius is None):
            yield "rise", f"one of 'rise' and 'radius' (radius is {self.radius})"
            return
        half = self.span / 2
        if self.rise is not None and self.rise < half:
            yield "rise", f"at least half the span ({half:g} m)"
        elif self.radius is not None and self.radius < half:
            yield "radius", f"at least half the span ({half:g} m)"
        elif self.thickness >= self.span:
            yield "thickness", f"less than the span ({self.span:g} m)"
        elif self.cut == "radial" and self.voussoirs > 1 and not self.parted():
            yield "voussoirs", "fewer: joints beside the crown would cross within the thickness"

    def parted(self) -> bool:
        """Whether the last radial joint stays on its side of the middle."""
        joints = self.voussoirs / 2
        nearest = (pi / 2 - self.crown) * (0.5 if self.voussoirs % 2 else 1.0) / joints
        angle = self.crown + nearest
        return (self.arc - self.thickness / 2) * sin(angle) > self.offset


def build(spec: PointedArchStructure, dimension: int) -> Assembly:
    """Voussoirs ``name.v01`` ... from the left, ``name.springing_left`` and ``_right``."""
    return arch_of(spec, stones_of(spec), dimension, spec.straight)


def stones_of(spec: PointedArchStructure) -> list[Voussoir]:
    """All stones from the left."""
    left, right = (
        [Offset(Circle(spec.arc, x), side * spec.thickness / 2) for side in (-1, 1)]
        for x in (spec.offset, -spec.offset)
    )
    tops = [-float(np.arcsin(spec.offset / (spec.arc + curve.by))) for curve in left]
    joints = _joints(spec, left, tops)
    labels = ["radial", *[spec.cut] * (len(joints) - 1)]
    halves = list(zip(pairwise(joints), pairwise(labels), strict=True))
    stones = [Voussoir.between(left, a, b, *names) for (a, b), names in halves]
    mirrored = [
        Voussoir.between(right, [-p for p in b], [-p for p in a], *names[::-1]) for (a, b), names in halves
    ]
    if spec.voussoirs % 2:
        low, high = (
            (Run(one, joints[-1][k], tops[k]), Run(two, -tops[k], -joints[-1][k]))
            for k, (one, two) in enumerate(zip(left, right, strict=True))
        )
        stones.append(Voussoir(low, high, labels[-1], labels[-1]))
    return [*stones, *mirrored[::-1]]


def _joints(spec: PointedArchStructure, faces: list[Offset], tops: list[float]) -> list[tuple[float, float]]:
    """Parameters of the left half's joints on its intrados and extrados, which end at ``tops``."""
    half, first = spec.voussoirs / 2, -np.pi / 2
    count = int(half)
    if spec.cut == "radial":  # equal parts of the mean line
        angles = first + np.arange(count + 1) * (-spec.crown - first) / half
        joints = [(float(angle), float(angle)) for angle in angles]
    else:
        inner = (spec.span - spec.thickness) / 2
        places = [np.array([inner * (k / half - 1), 0.0]) for k in range(1, count + 1)]
        joints = [(first, first)]
        for place in places[: count if spec.voussoirs % 2 else count - 1]:
            low, high = (
                crossing(face, first, top, place, np.array([1.0, 0.0]))
                for face, top in zip(faces, tops, strict=True)
            )
            joints.append((low, high))
        if spec.voussoirs % 2 == 0:
            joints.append((0.0, 0.0))
    if spec.voussoirs % 2 == 0:  # the joint at the crown is vertical
        joints[-1] = (tops[0], tops[1])
    return joints
