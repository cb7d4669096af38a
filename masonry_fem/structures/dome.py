"""Dome: rings of equal stones about a centre, cut by parallels and meridians.

The stones of a ring share one shape. In its own frame the stone lies on the meridian through the world's x
axis, its axes along the parallel (x), up the meridian (y) and radial (z). Its edges are chords, so that all
faces are flat: meridian joints lie in planes through the axis, bed joints in planes through the centre.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import repeat
from typing import Annotated

import numpy as np
from msgspec import Meta

from masonry_fem.errors import GeometryError
from masonry_fem.records.record import Angle, Count, Length, Point
from masonry_fem.records.structure import Foreseen, Structure
from masonry_fem.solid.assembly import Assembly, Block, Blocks, Shape
from masonry_fem.solid.polytope import Polytope
from masonry_fem.solid.pose import FloatArray, Pose
from masonry_fem.structures.parts.drum import depth_below, drum_stones
from masonry_fem.structures.parts.ring import MARGIN, about_axis, ring_stone


class DomeStructure(Structure, frozen=True, kw_only=True, tag="dome"):
    """Spherical dome about the mean ``radius``: ``rings`` of ``slices`` equal stones, all faces flat.

    ``springing`` and ``oculus`` are the angles of the base and of the oculus from the crown; without an
    oculus a crown stone closes the dome. ``staggered`` rotates every other ring by half a stone. A
    ``sweep`` below
    360 deg makes a sector that begins at the x axis, with supports on its ``sides``.

    If ``springing`` is 90 deg, the dome may stand on a drum of ``drum_courses`` with ``drum_stones`` stones
    each, and the drum, or the dome itself, on ``piers``. Drum and piers are as thick as the dome, or
    ``drum_width`` from the intrados outwards.

    Attributes
    ----------
    radius : radius of the mean surface
    thickness : distance between intrados and extrados
    rings : number of rings between base and oculus
    slices : number of stones in a ring, all equal
    springing : angle of the base from the crown
    oculus : angle of the open oculus from the crown; with 0 a crown stone closes the dome
    centre : centre of the sphere; the origin by default
    staggered : every other ring is rotated by half a stone
    base : a support below each stone of the lowest ring, or of the drum, or below each pier
    sweep : angle of longitude of a sector
    sides : supports on both meridian planes of a sector
    drum_courses : number of courses of a drum under the dome
    drum_height : height of all courses together
    drum_stones : number of stones in a course; that of slices by default
    drum_width : width of drum and piers, from the intrados outwards; the dome's thickness by default
    piers : number of piers under the drum, or under the dome
    pier_height : height of the piers below the drum
    pier_slices : width of a pier in slices of the dome
    pier_courses : number of blocks of a pier

    Examples
    --------
    kind = "dome"
    name = "dome"
    material = "stone"
    radius = 4.0
    thickness = 0.4
    rings = 3
    slices = 8
    """

    radius: Length
    thickness: Length
    rings: Count
    slices: Count
    springing: Angle = 90.0
    oculus: Annotated[float, Meta(ge=0, lt=180, extra={"unit": "deg"})] = 0.0
    centre: Point | None = None
    staggered: bool = False
    base: bool = True
    sweep: Angle = 360.0
    sides: bool = False
    drum_courses: Annotated[int, Meta(ge=0)] = 0
    drum_height: Length | None = None
    drum_stones: Count | None = None
    drum_width: Length | None = None
    piers: Annotated[int, Meta(ge=0)] = 0
    pier_height: Length | None = None
    pier_slices: Count | None = None
    pier_courses: Count = 1

    @property
    def carries(self) -> bool:
        """Whether it brings a base or sides."""
        return self.base or self.sides

    @property
    def width(self) -> float:
        """Of drum and piers [m]."""
        return self.thickness if self.drum_width is None else self.drum_width

    @property
    def stones(self) -> int:
        """In a course of the drum."""
        return self.slices if self.drum_stones is None else self.drum_stones

    def foreseen(self, dimension: int) -> Foreseen:
        """The stones of its rings, drum and piers, and their supports."""
        crown = 0 if self.oculus else 1
        under = self.piers or (self.stones if self.drum_courses else self.slices)
        blocks = self.rings * self.slices + crown + self.drum_courses * self.stones
        blocks += self.piers * self.pier_courses + self.base * under + 2 * self.sides
        keys = ("rings", "slices", "drum_courses", "drum_stones", "piers", "pier_courses")
        return Foreseen(blocks, keys)

    def faults(self, dimension: int) -> Iterator[tuple[str, str]]:
        """Drums and piers without a height, under slopes, or out of step with the dome's stones."""
        if self.drum_height is not None and not self.drum_courses:
            yield "drum_courses", "at least 1 for a drum of that height"
        if self.pier_height is not None and not self.piers:
            yield "piers", "at least 1 of that height"
        if self.drum_courses or self.piers:
            yield from self._fit_faults()
        if self.piers:
            yield from self._pier_faults()

    def _fit_faults(self) -> Iterator[tuple[str, str]]:
        """What does not fit between the dome and what is under it."""
        if self.springing != 90:
            yield "springing", "90 deg above a drum or piers"
        if self.width < self.thickness:
            yield "drum_width", f"at least the dome's thickness ({self.thickness:g} m)"
        if self.drum_courses and self.drum_height is None:
            yield "drum_height", "a length > 0 in m: the drum's height"
        if self.slices % self.stones:
            yield "drum_stones", f"a divisor of the dome's slices ({self.slices})"
        if self.drum_courses and self.sweep / self.stones > 180:
            yield "drum_stones", "at least 2: a stone of the drum spans half of it at most"

    def _pier_faults(self) -> Iterator[tuple[str, str]]:
        if self.sweep != 360:
            yield "piers", "0 under a sector"
        if self.slices % self.piers:
            yield "piers", f"a divisor of the dome's slices ({self.slices})"
        if self.pier_height is None:
            yield "pier_height", "a length > 0 in m: the piers' height"
        between = self.slices // self.piers
        if self.pier_slices is None or self.pier_slices >= between:
            yield "pier_slices", f"less than the slices from pier to pier ({between})"
        elif self.drum_courses and not self.staggered and self.pier_slices % 2:
            yield "pier_slices", "an even number under a drum, whose joints lie on the middles of piers"


@dataclass(frozen=True, slots=True)
class Cut:
    """How a dome is cut into stones.

    Attributes
    ----------
    parallels : Angles from the crown of the joints between rings, from the base up [rad], (rings + 1,).
    slice : Angle of longitude of a stone [rad]. pieces : Flat pieces of each of its curved faces.
    low, high : Radii of intrados and extrados [m].
    """

    parallels: FloatArray
    slice: float
    pieces: int
    low: float
    high: float

    @classmethod
    def of(cls, spec: DomeStructure) -> Cut:
        """The cut that a scene asks for; the crown stone is as wide as a ring is high."""
        base = np.radians(spec.springing)
        eye = np.radians(spec.oculus) if spec.oculus else base / (2 * spec.rings + 1)
        return cls(
            parallels=np.linspace(base, eye, spec.rings + 1),
            slice=np.radians(spec.sweep) / spec.slices,
            pieces=2 if spec.staggered else 1,
            low=spec.radius - spec.thickness / 2,
            high=spec.radius + spec.thickness / 2,
        )

    @property
    def longitudes(self) -> FloatArray:
        """Of the corners of a stone about its middle [rad], shape (pieces + 1,)."""
        return self.slice * (np.arange(self.pieces + 1) / self.pieces - 0.5)


def build(spec: DomeStructure, dimension: int) -> Assembly:
    """Stones ``name.r1.s1`` ... ring by ring from below, ``name.crown``, drum, piers and supports."""
    _check(spec, dimension)
    cut = Cut.of(spec)
    centre = np.zeros(3) if spec.centre is None else np.array(spec.centre, dtype=float)
    shapes: list[Shape] = []
    parts: list[Blocks] = []
    ends = [f"s{number + 1}" for number in range(spec.slices)]

    def ring(group: str, shape: Shape, frame: FloatArray, shift: float, support: bool) -> None:
        shapes.append(shape)
        turn = about_axis(float(cut.slice) * (np.arange(spec.slices) + (0.5 + shift))) @ frame
        names, own = list(map(f"{group}.".__add__, ends)), np.arange(len(ends))
        groups = list(zip(repeat(spec.name), repeat(group), map(f"{spec.name}.".__add__, ends)))
        parts.append(Blocks.laid(names, len(shapes) - 1, turn, centre, groups, own, support=support))

    if spec.drum_courses or spec.piers:
        parts.append(Blocks.of(drum_stones(spec, cut.pieces, cut.low, centre, shapes), 3))
    elif spec.base:
        ring(f"{spec.name}.base", footing(f"{spec.name}.base", cut), np.eye(3), 0.0, support=True)
    for number in range(spec.rings):
        frame = frame_at(cut.parallels[number : number + 2].mean())
        group = f"{spec.name}.r{number + 1}"
        shift = 0.5 if spec.staggered and number % 2 else 0.0
        ring(group, stone(group, cut, number, frame), frame, shift, support=False)
    if not spec.oculus:
        shapes.append(Shape(f"{spec.name}.crown", crown(cut, spec.sweep, spec.slices)))
        name = f"{spec.name}.crown"
        parts.append(Blocks.laid([name], len(shapes) - 1, np.eye(3), centre, [(spec.name,)]))
    if spec.sides:
        parts.append(Blocks.of(_sides(spec, cut, centre, shapes), 3))
    return Assembly(3, shapes, Blocks.joined(parts))


def _check(spec: DomeStructure, dimension: int) -> None:
    key = f"structures.{spec.name}"
    if dimension != 3:
        raise GeometryError(f"{key} is a dome in a scene of dimension {dimension}, expected 3; correct one")
    if spec.thickness >= 2 * spec.radius:
        raise GeometryError(
            f"{key}.thickness is {spec.thickness} m, expected less than twice the radius ({spec.radius} m)"
        )
    if not spec.oculus < spec.springing < 180:
        raise GeometryError(
            f"{key}.springing is {spec.springing} degrees, expected between the oculus ({spec.oculus}) and "
            "180; both are measured from the crown"
        )
    if spec.sweep / spec.slices > 120:
        raise GeometryError(
            f"{key}.slices is {spec.slices}, expected at least {int(np.ceil(spec.sweep / 120))}: a stone "
            "spans 120 degrees of longitude at most"
        )
    whole = spec.sweep == 360
    if whole and spec.sides:
        raise GeometryError(f"{key}.sides is true, expected false for a whole dome; give a sweep below 360")
    if not whole and spec.staggered:
        raise GeometryError(
            f"{key}.staggered is true, expected false for a sector of {spec.sweep:g} degrees; its sides "
            "would cut stones in half"
        )
    if spec.sides and spec.sweep >= 180:
        raise GeometryError(f"{key}.sweep is {spec.sweep:g} degrees, expected below 180 between two sides")


def frame_at(parallel: float) -> FloatArray:
    """Axes of a stone at longitude 0 as columns: along the parallel, up the meridian, radial."""
    c, s = np.cos(parallel), np.sin(parallel)
    return np.array([[0.0, -c, s], [1.0, 0.0, 0.0], [0.0, s, c]])


def at(radius: float, parallel: float, longitudes: FloatArray) -> FloatArray:
    """Points on a parallel of a sphere, relative to its centre, shape (n, 3) [m].

    Parameters
    ----------
    radius : Of the sphere [m].
    parallel : Angle from the crown [rad].
    longitudes : Of the points, shape (n,) [rad].
    """
    out = radius * np.sin(parallel)
    level = np.full(len(longitudes), radius * np.cos(parallel))
    return np.column_stack([out * np.cos(longitudes), out * np.sin(longitudes), level])


def stone(name: str, cut: Cut, ring: int, frame: FloatArray) -> Shape:
    """The stone of a ring, in its own frame.

    Parameters
    ----------
    name : Of the shape.
    cut : How the dome is cut.
    ring : Number of the ring, 0 for the lowest.
    frame : The stone's axes as columns, shape (3, 3).
    """
    below, above = cut.parallels[ring], cut.parallels[ring + 1]
    corners = [at(r, p, cut.longitudes) for r in (cut.low, cut.high) for p in (below, above)]
    return ring_stone(
        name,
        np.concatenate(corners) @ frame,
        cut.pieces,
        ("intrados", "extrados", "lower", "upper", "left", "right"),
        ("", "", "bed", "bed", "meridian", "meridian"),
    )


def footing(name: str, cut: Cut) -> Shape:
    """What carries a stone of the lowest ring: a block below its bed, a little wider."""
    parallel, depth = float(cut.parallels[0]), cut.high - cut.low
    margin = MARGIN * depth
    down = depth * np.array([np.cos(parallel), 0.0, -np.sin(parallel)])
    tops = [at(r, parallel, cut.longitudes) for r in (cut.low - margin, cut.high + margin)]
    corners = [tops[0] + down, tops[0], tops[1] + down, tops[1]]
    names, labels = ("", "", "", "top", "", ""), ("", "", "", "bed", "", "")
    return ring_stone(name, np.concatenate(corners), cut.pieces, names, labels)


def crown(cut: Cut, sweep: float, slices: int) -> Polytope:
    """The stone that closes the opening at the crown: a frustum with a side for each piece of the ring below.

    Parameters
    ----------
    cut : How the dome is cut.
    sweep : Longitude that the dome extends over [degrees].
    slices : Number of stones in a ring.
    """
    sides = slices * cut.pieces
    whole = sweep == 360
    longitudes = np.radians(sweep) * np.arange(sides + (not whole)) / sides
    rims = [at(r, float(cut.parallels[-1]), longitudes) for r in (cut.low, cut.high)]
    if not whole:  # a sector: the axis is its last edge
        rims = [np.concatenate([rim, [[0.0, 0.0, rim[0, 2]]]]) for rim in rims]
    n = len(rims[0])
    following = [(i + 1) % n for i in range(n)]
    loops: list[tuple[int, ...]] = [(i, j, j + n, i + n) for i, j in enumerate(following)]
    loops += [tuple(range(n - 1, -1, -1)), tuple(range(n, 2 * n))]
    labels = ["bed" if i < sides else "meridian" for i in range(n)]
    names = ["lower" if i < sides else "left" if i == n - 1 else "right" for i in range(n)]
    names += ["intrados", "extrados"]
    return Polytope(np.concatenate(rims), tuple(loops), tuple(names), (*labels, "", ""))


def _sides(spec: DomeStructure, cut: Cut, centre: FloatArray, shapes: list[Shape]) -> Iterator[Block]:
    """Supports beside a sector: plates on its two meridian planes."""
    margin = MARGIN * spec.thickness
    reach = max(cut.high, cut.low + spec.width) + margin
    level = min(0.0, cut.high * float(np.cos(cut.parallels[0]))) - depth_below(spec)
    for side, longitude, near in (("start", 0.0, "back"), ("end", np.radians(spec.sweep), "front")):
        depth = (-spec.thickness, 0.0) if side == "start" else (0.0, spec.thickness)
        plate = Polytope.box((-margin, depth[0], level - margin), (reach, depth[1], reach))
        labels = tuple("meridian" if name == near else "" for name in plate.names)
        name = f"{spec.name}.side_{side}"
        shapes.append(Shape(name, Polytope(plate.vertices, plate.faces, plate.names, labels)))
        pose = Pose(about_axis(longitude), centre)
        yield Block(name, len(shapes) - 1, pose, (spec.name,), support=True)
