"""Pointed arch: voussoirs along two arcs that meet at the crown."""

from __future__ import annotations

from collections.abc import Iterator
from math import asin, pi, sin

from masonry_fem.scene.record import Length
from masonry_fem.scene.structures.voussoirs import Cut, VoussoirStructure


class PointedArchStructure(VoussoirStructure, frozen=True, kw_only=True, tag="pointed_arch"):
    """Arch of two arcs of a circle about centres on the springing line; springings as supports.

    Its form is given by ``rise`` or by the ``radius`` of the arcs (``radius = span`` is the equilateral
    arch). An odd number of ``voussoirs`` has a keystone, an even one a joint at the crown. Radial joints
    are normal to the arcs and cut them into equal lengths, vertical ones cut the intrados' span equally.
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
