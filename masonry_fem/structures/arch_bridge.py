"""Arch bridge: a segmental barrel between two abutments, and the fill on it up to a level road.

The fill is one block. Its lower side has a facet on each voussoir, with corners at the joints, so that its
elements stand on the voussoirs node on node; they reach from there up to the road.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import ceil
from typing import Annotated

import numpy as np
from msgspec import Meta

from masonry_fem.errors import GeometryError
from masonry_fem.records.record import Count, Length, Metres, Point
from masonry_fem.records.structure import Foreseen, Structure
from masonry_fem.solid.assembly import Assembly, Block, Shape
from masonry_fem.solid.pose import FloatArray, Pose
from masonry_fem.solid.prism import prism
from masonry_fem.structures.parts.curve import Circle
from masonry_fem.structures.parts.quarry import Quarry, lay_arch, rails_of
from masonry_fem.structures.parts.voussoir import cut_line


class ArchBridgeStructure(Structure, frozen=True, kw_only=True, tag="arch_bridge"):
    """Segmental barrel of ``voussoirs`` stones, its abutments, and fill up to a level road.

    Stones have chords in place of arcs. The abutments are supports, level behind the springings. The fill
    is one block, ``NAME.fill``, whose elements end where stones meet; an entry of ``overrides`` gives it a
    material, a fidelity and a mesh of its own. ``[[supports]]`` with ``components = ["x"]`` hold its ends as
    smooth walls do, which earth at rest presses.

    Attributes
    ----------
    span : clear span between the abutments
    rise : rise of the intrados, at most half the span
    thickness : thickness of the barrel
    voussoirs : number of stones, numbered from the left
    cover : height of the fill above the extrados at the crown
    approach : length of the fill behind each springing of the extrados; half the span by default
    filled : with the fill; without it the barrel stands alone
    strip : both ends along x of a part of the road that is a face ``strip`` of its own, where elements end
    depth : width of the bridge, along y; not used in 2D
    centre : middle between the springings of the intrados, at the front; the origin by default

    Examples
    --------
    kind = "arch_bridge"
    name = "bridge"
    material = "stone"
    span = 6.0
    rise = 1.5
    thickness = 0.3
    voussoirs = 20
    cover = 0.2
    strip = [-1.8, -1.2]
    depth = 4.0
    """

    span: Length
    rise: Length
    thickness: Length
    voussoirs: Count
    cover: Length
    approach: Length | None = None
    filled: bool = True
    strip: Annotated[tuple[Metres, ...], Meta(min_length=2, max_length=2)] | None = None
    depth: Length = 1.0
    centre: Point | None = None

    @property
    def carries(self) -> bool:
        """It brings its abutments."""
        return True

    @property
    def half(self) -> float:
        """Half the opening angle of the barrel [rad]."""
        return 2 * float(np.arctan(2 * self.rise / self.span))

    @property
    def radius(self) -> float:
        """Of the mean line of the barrel [m]."""
        return self.span / 2 / float(np.sin(self.half)) + self.thickness / 2

    @property
    def ends(self) -> float:
        """Distance of the ends of the road from the middle of the span [m]."""
        behind = self.span / 2 if self.approach is None else self.approach
        return (self.radius + self.thickness / 2) * float(np.sin(self.half)) + behind

    def foreseen(self, dimension: int) -> Foreseen:
        """Its voussoirs, two abutments and the fill."""
        return Foreseen(self.voussoirs + 2 + self.filled, ("voussoirs",))

    def faults(self, dimension: int) -> Iterator[tuple[str, str]]:
        """A barrel that overhangs, and a strip beside the road or narrower than the fill's elements."""
        if self.rise > self.span / 2:
            yield "rise", f"at most half the span ({self.span / 2:g} m)"
        if self.strip is not None:
            low, high = self.strip
            end = self.ends
            if not -end <= low < high <= end:
                yield "strip", f"both ends in order, on the road from {-end:g} to {end:g} m"


def build(spec: ArchBridgeStructure, dimension: int) -> Assembly:
    """Voussoirs ``name.v01`` ... from the left, ``name.abutment_left`` and ``_right``, and ``name.fill``.

    Groups ``name.springers`` and ``name.keystone``. Joints of the barrel are ``radial``, those of the fill
    ``fill``.
    """
    line = Circle(spec.radius, y=spec.rise + spec.thickness / 2 - spec.radius)
    stones = cut_line(line, -spec.half, spec.half, spec.thickness, spec.voussoirs, "radial")
    origin = np.zeros(dimension) if spec.centre is None else np.array(spec.centre, dtype=float)
    quarry = Quarry(spec.name, dimension, spec.depth, origin, straight=True, extrados="fill")
    foot, head = (side[-1] for side in stones[-1].faces(straight=True))
    for side, mirror in (("left", -1.0), ("right", 1.0)):
        _abutment(spec, quarry, side, mirror, foot, head)
    lay_arch(quarry, stones)
    if spec.filled:
        extrados = np.array([stone.faces(straight=True)[1][0] for stone in stones] + [head])
        _fill(spec, quarry, extrados)
    return Assembly(dimension, tuple(quarry.shapes), tuple(quarry.blocks))


def _abutment(
    spec: ArchBridgeStructure, quarry: Quarry, side: str, mirror: float, foot: FloatArray, head: FloatArray
) -> None:
    """Add a support below the fill and below a springing joint, on the right from ``foot`` to ``head``."""
    base = foot[1] - spec.thickness
    outline = np.array([foot, (foot[0], base), (spec.ends, base), (spec.ends, head[1]), head])
    names = ["", "", "", "top", "springing"]
    if mirror < 0:  # as many corners, the other way round
        outline = outline[::-1] * [-1.0, 1.0]
        names = [*names[-2::-1], names[-1]]
    labels = [{"top": "fill", "springing": "radial"}.get(name, "") for name in names]
    _add(quarry, f"abutment_{side}", outline, names, labels, support=True)


def _fill(spec: ArchBridgeStructure, quarry: Quarry, extrados: FloatArray) -> None:
    """Add the fill on the joints of the extrados, shape (voussoirs + 1, 2), and on the abutments."""
    outer, level = extrados[-1]
    count = ceil((spec.ends - outer) / (extrados[-1, 0] - extrados[0, 0]) * spec.voussoirs)
    behind = np.linspace(outer, spec.ends, count + 1)[1:]
    beside = np.column_stack([behind, np.full(count, level)])
    low = np.concatenate([beside[::-1] * [-1.0, 1.0], extrados, beside])
    road, loaded = _road(spec, low[:, 0])
    high = np.column_stack([road, np.full(len(road), spec.rise + spec.thickness + spec.cover)])
    below = len(low) - 1
    above = ["strip" if loaded.start <= piece < loaded.stop else "road" for piece in range(below)]
    names = ["base"] * below + ["right", *above[::-1], "left"]
    labels = ["fill" if name == "base" else "" for name in names]
    outline = np.concatenate([low, high[::-1]])
    _add(quarry, "fill", outline, names, labels, rails=len(low))


def _road(spec: ArchBridgeStructure, below: FloatArray) -> tuple[FloatArray, range]:
    """Where corners of the road stand above those ``below``, and which pieces are the strip."""
    if spec.strip is None:
        return below, range(0)
    first, last = (int(np.abs(below - end).argmin()) for end in spec.strip)
    if first == last:
        raise GeometryError(
            f"structures.{spec.name}.strip is {list(spec.strip)} m, narrower than the fill's elements there, "
            "which are as wide as a voussoir; raise voussoirs, or widen the strip"
        )
    road = below.copy()
    road[[first, last]] = spec.strip
    return road, range(first, last)


def _add(
    quarry: Quarry, noun: str, outline: FloatArray, names: list[str], labels: list[str],
    *, rails: int = 0, support: bool = False,
) -> None:  # fmt: skip
    """Add a block of an outline, whose first ``rails`` corners are its lower rail."""
    d, name = quarry.dimension, f"{quarry.name}.{noun}"
    solid = prism(outline, names, labels, quarry.depth, d)
    quarry.blocks.append(
        Block(name, len(quarry.shapes), Pose(np.eye(d), quarry.origin), (quarry.name,), support)
    )
    chains = rails_of(len(outline), rails, d) if rails else ()
    quarry.shapes.append(Shape(name, solid, rails=chains, parts=max(1, rails - 1)))
