"""Arch: equal voussoirs about a centre, between two springings.

With radial joints all voussoirs share one shape. In its own frame it is the voussoir at the crown: its joints
are symmetrical about the vertical, its axes tangential (x), along the depth (y, in 3D only) and radial
(last).
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from masonry_fem.errors import GeometryError
from masonry_fem.records.record import Angle, Count, Length, Point
from masonry_fem.records.structure import Foreseen, Structure
from masonry_fem.solid.assembly import Assembly, Block, Shape
from masonry_fem.solid.polytope import Polytope
from masonry_fem.solid.pose import FloatArray, Pose
from masonry_fem.solid.prism import prism
from masonry_fem.structures.parts.curve import Circle
from masonry_fem.structures.parts.quarry import arch_of, roles
from masonry_fem.structures.parts.voussoir import cut_line
from masonry_fem.structures.parts.voussoir_row import Cut


class ArchStructure(Structure, frozen=True, kw_only=True, tag="arch"):
    """Circular arch of ``voussoirs`` equal stones about the mean ``radius``; springings as supports.

    Joints are radial, or between the springings vertical: then they divide the span of the intrados into
    equal parts.

    Attributes
    ----------
    radius : radius of the mean line
    thickness : distance between intrados and extrados
    voussoirs : number of stones, all equal
    embrace : full opening angle
    depth : length along y; not used in 2D
    centre : centre of the circle; the origin by default
    straight : voussoirs have chords in place of arcs
    springings : a support at each end
    cut : ``radial`` joints are normal to the mean line, or all joints between the springings are vertical

    Examples
    --------
    kind = "arch"
    name = "arch"
    material = "stone"
    radius = 5.0
    thickness = 0.7
    voussoirs = 9
    """

    radius: Length
    thickness: Length
    voussoirs: Count
    embrace: Angle = 180.0
    depth: Length = 1.0
    centre: Point | None = None
    straight: bool = False
    springings: bool = True
    cut: Cut = "radial"

    @property
    def carries(self) -> bool:
        """Whether it brings its springings."""
        return self.springings

    def foreseen(self, dimension: int) -> Foreseen:
        """Its voussoirs, and two springings."""
        return Foreseen(self.voussoirs + 2 * self.springings, ("voussoirs",))

    def faults(self, dimension: int) -> Iterator[tuple[str, str]]:
        """Stones without an intrados, or of more than half a circle; upright joints that miss a face."""
        if self.thickness >= 2 * self.radius:
            yield "thickness", f"less than twice the mean radius ({2 * self.radius:g} m)"
        if self.embrace / self.voussoirs >= 180:
            least = f"{self.embrace / 180:g}"
            yield "voussoirs", f"more than {least}, so that a stone spans less than half a circle"
        if self.cut == "vertical" and self.embrace > 180:
            yield "embrace", "at most 180 with vertical joints"


FACETS = 16  # flat facets for the arc of a voussoir


def build(spec: ArchStructure, dimension: int) -> Assembly:
    """Voussoirs ``name.v01`` ... from the left, ``name.springing_left`` and ``_right``."""
    if spec.thickness >= 2 * spec.radius:
        raise GeometryError(
            f"structures.{spec.name}.thickness is {spec.thickness} m, expected less than twice the radius "
            f"({spec.radius} m); the intrados would have no radius left"
        )
    if spec.cut == "vertical":
        half = np.radians(spec.embrace) / 2
        stones = cut_line(Circle(spec.radius), -half, half, spec.thickness, spec.voussoirs, spec.cut)
        return arch_of(spec, stones, dimension, spec.straight)
    centre = np.zeros(dimension) if spec.centre is None else np.array(spec.centre, dtype=float)
    step = np.radians(spec.embrace) / spec.voussoirs
    shapes = [voussoir(spec, step, dimension)]
    left = np.radians(spec.embrace) / 2
    digits = max(2, len(str(spec.voussoirs)))
    blocks = []
    if spec.springings:
        for side, sign in (("left", 1.0), ("right", -1.0)):
            shapes.append(Shape(f"{spec.name}.springing_{side}", springing(spec, sign, dimension)))
            pose = Pose(turned(sign * left, dimension), centre)
            name = f"{spec.name}.springing_{side}"
            blocks.append(Block(name, len(shapes) - 1, pose, (spec.name,), support=True))
    for number in range(spec.voussoirs):
        pose = Pose(turned(left - (number + 0.5) * step, dimension), centre)
        groups = (spec.name, *roles(spec.name, number, spec.voussoirs))
        blocks.append(Block(f"{spec.name}.v{number + 1:0{digits}d}", 0, pose, groups))
    return Assembly(dimension, tuple(shapes), tuple(blocks))


def turned(angle: float, dimension: int) -> FloatArray:
    """Rotation in the arch's plane, counter-clockwise seen from the front (x to the right), shape (d, d).

    Parameters
    ----------
    angle : [rad].
    dimension : d, 2 or 3.
    """
    c, s = np.cos(angle), np.sin(angle)
    if dimension == 2:
        return np.array([[c, -s], [s, c]])
    return np.array([[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]])


def voussoir(spec: ArchStructure, step: float, dimension: int) -> Shape:
    """The shape of all voussoirs: an exact sector, or straight between its corners."""
    inner, outer = spec.radius - spec.thickness / 2, spec.radius + spec.thickness / 2
    if spec.straight:
        half = step / 2
        outline = [polar(inner, half), polar(inner, -half), polar(outer, -half), polar(outer, half)]
        names = ["intrados", "end", "extrados", "start"]
        return Shape(f"{spec.name}.voussoir", plate(np.array(outline), names, spec.depth, dimension))
    # The corners are exact; the points between them lie a little outside the arc, so that
    # the polygon has the sector's area: rigid voussoirs have their exact mass.
    angles = step / 2 - step * np.arange(FACETS + 1) / FACETS
    low, high = (arc_points(r, angles) for r in (inner, outer))
    outline = [*low, *high[::-1]]
    names = ["intrados"] * FACETS + ["end"] + ["extrados"] * FACETS + ["start"]
    solid = plate(np.array(outline), names, spec.depth, dimension)
    n = len(outline)
    origin = (0.0,) * dimension
    corners = [(0, FACETS), (FACETS + 1, n - 1)]
    arcs = [(a, b, origin) for a, b in corners]
    if dimension == 3:
        back = (0.0, spec.depth, 0.0)
        arcs += [(a + n, b + n, back) for a, b in corners]
    return Shape(f"{spec.name}.voussoir", solid, arcs=tuple(arcs))


def arc_points(radius: float, angles: FloatArray) -> list[FloatArray]:
    """Points of an arc's facets; ends on the arc, the others moved out to keep the sector's area."""
    delta = abs(angles[1] - angles[0])
    n = len(angles) - 1
    # area of the fan with ends at r and inner points at k r: sin δ/2 (2k + (n−2) k²) = n δ/2
    a, b, c = (n - 2) * np.sin(delta), 2 * np.sin(delta), -n * delta
    k = -c / b if a == 0 else (-b + np.sqrt(b * b - 4 * a * c)) / (2 * a)
    factors = np.full(n + 1, k)
    factors[[0, -1]] = 1.0
    return [radius * f * polar(1.0, angle) for f, angle in zip(factors, angles, strict=True)]


def polar(radius: float, angle: float) -> FloatArray:
    """Point of the arch's plane, relative to the centre, shape (2,) [m].

    Parameters
    ----------
    radius : [m].
    angle : From the vertical, counter-clockwise [rad].
    """
    return radius * np.array([-np.sin(angle), np.cos(angle)])


def plate(outline: FloatArray, names: list[str], depth: float, dimension: int) -> Polytope:
    """Prism whose faces ``start`` and ``end`` are joint faces."""
    labels = ["radial" if name in {"start", "end"} else "" for name in names]
    return prism(outline, names, labels, depth, dimension)


def springing(spec: ArchStructure, sign: float, dimension: int) -> Polytope:
    """Support below a springing, in a frame rotated with the springing's joint.

    Parameters
    ----------
    spec : The arch.
    sign : 1 for the left springing, −1 for the right one.
    dimension : 2 or 3.
    """
    inner, outer = spec.radius - spec.thickness / 2, spec.radius + spec.thickness / 2
    margin = 0.25 * spec.thickness
    low, high, width = inner - margin, outer + margin, spec.thickness
    if sign > 0:
        outline = [(-width, low), (0.0, low), (0.0, high), (-width, high)]
        names = ["", "end", "", ""]
    else:
        outline = [(0.0, low), (width, low), (width, high), (0.0, high)]
        names = ["", "", "", "start"]
    return plate(np.array(outline), names, spec.depth, dimension)
