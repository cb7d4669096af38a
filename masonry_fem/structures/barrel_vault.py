"""Barrel vault: courses of straight stones about an axis, every other course shifted by half a stone.

All stones share two shapes, a whole stone and a half one, or each has its own where joints are irregular.
Their frames are those of a voussoir at the crown.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated

import numpy as np
from msgspec import Meta

from masonry_fem.errors import GeometryError
from masonry_fem.records.record import Angle, Count, Length
from masonry_fem.records.structure import Foreseen
from masonry_fem.solid.assembly import Assembly, Blocks, Shape
from masonry_fem.solid.polytope import Polytope
from masonry_fem.solid.pose import FloatArray
from masonry_fem.structures.arch import polar, turned
from masonry_fem.structures.parts.curve import Circle, Offset
from masonry_fem.structures.parts.quarry import Quarry, lay_springings, roles, wedge
from masonry_fem.structures.parts.voussoir import Voussoir
from masonry_fem.structures.parts.voussoir_row import VoussoirStructure


class BarrelVaultStructure(VoussoirStructure, frozen=True, kw_only=True, tag="barrel_vault"):
    """Circular vault about the mean ``radius`` of ``voussoirs`` courses along y; springings as supports.

    A course has ``stones`` equal stones with flat faces over the vault's ``depth``. In ``staggered`` vaults
    every other course is shifted by half a stone, and half stones close it at both ends. With an
    ``irregularity`` all joints are displaced at random, beds by up to that share of a course and heads by up
    to that share of a stone: then no two stones are alike. The same seed gives the same stones.

    Attributes
    ----------
    thickness : distance between intrados and extrados
    voussoirs : number of courses from springing to springing
    depth : length of the vault along its axis y
    centre : centre of the circle at the front; the origin by default
    radius : radius of the mean surface
    embrace : full opening angle
    stones : number of stones in a course without half stones
    staggered : every other course is shifted by half a stone
    irregularity : greatest displacement of a joint over the size of a regular stone
    seed : seed of the random displacements

    Examples
    --------
    kind = "barrel_vault"
    name = "barrel_vault"
    material = "stone"
    radius = 3.0
    thickness = 0.3
    depth = 4.0
    voussoirs = 7
    stones = 4
    """

    radius: Length
    embrace: Angle = 180.0
    stones: Count
    staggered: bool = True
    irregularity: Annotated[float, Meta(ge=0, le=0.2)] = 0.0
    seed: Annotated[int, Meta(ge=0)] = 0

    def foreseen(self, dimension: int) -> Foreseen:
        """Its stones, in every other staggered course one more, and two springings."""
        more = self.voussoirs // 2 if self.staggered else 0
        blocks = self.voussoirs * self.stones + more + 2 * self.springings
        return Foreseen(blocks, ("voussoirs", "stones"))

    def faults(self, dimension: int) -> Iterator[tuple[str, str]]:
        """Stones without an intrados, or of more than half a circle."""
        if self.thickness >= 2 * self.radius:
            yield "thickness", f"less than twice the mean radius ({2 * self.radius:g} m)"
        if self.embrace / self.voussoirs >= 180:
            least = f"{self.embrace / 180:g}"
            yield "voussoirs", f"more than {least}, so that a course spans less than half a circle"


def build(spec: BarrelVaultStructure, dimension: int) -> Assembly:
    """Stones ``name.c1.s1`` ... course by course from the left, ``name.springing_left`` and ``_right``.

    Groups: ``name.c1`` ..., ``name.springers`` (the lowest courses), ``name.keystone`` (that at the crown).
    """
    if dimension != 3:
        raise GeometryError(
            f"structures.{spec.name} is a vault in a scene of dimension {dimension}, expected 3; "
            "correct one (an arch is its plane section)"
        )
    origin = np.zeros(3) if spec.centre is None else np.array(spec.centre, dtype=float)
    quarry = Quarry(spec.name, 3, spec.depth, origin)
    half, step = np.radians(spec.embrace) / 2, np.radians(spec.embrace) / spec.voussoirs
    if spec.springings:
        faces = [Offset(Circle(spec.radius), side * spec.thickness / 2) for side in (-1, 1)]
        lay_springings(quarry, [Voussoir.between(faces, (-half, -half), (half, half))])
    first, length = len(quarry.shapes), spec.depth / spec.stones
    random = np.random.default_rng(spec.seed)
    beds = half - step * _displaced(np.arange(spec.voussoirs + 1.0), spec, random)
    shapes: list[Shape] = []
    kinds: dict[tuple[float, float], int] = {}
    parts = [Blocks.of(quarry.blocks, 3)]
    for course in range(spec.voussoirs):
        group, turn = f"{spec.name}.c{course + 1}", turned((beds[course] + beds[course + 1]) / 2, 3)
        groups = (spec.name, group, *roles(spec.name, course, spec.voussoirs))
        span = beds[course] - beds[course + 1] if spec.irregularity else step
        heads = _displaced(_heads(spec, course), spec, random)
        names = list(map(f"{group}.s{{}}".format, range(1, len(heads))))
        lengths, foremost, of = np.unique(np.diff(heads), return_index=True, return_inverse=True)
        number = np.empty(len(lengths), dtype=np.int64)
        for at in np.argsort(foremost).tolist():
            part, kind = lengths[at], (span, lengths[at])
            if kind not in kinds:
                kinds[kind] = first + len(kinds)
                own = names[foremost[at]]
                noun = own if spec.irregularity else f"{spec.name}.{'stone' if part == 1 else 'half'}"
                shapes.append(Shape(noun, _stone(spec, span, part * length)))
            number[at] = kinds[kind]
        place = np.tile(origin, (len(names), 1))
        place[:, 1] += heads[:-1] * length
        parts.append(Blocks.laid(names, number[of], turn, place, [groups]))
    return Assembly(3, (*quarry.shapes, *shapes), Blocks.joined(parts))


def _heads(spec: BarrelVaultStructure, course: int) -> FloatArray:
    """Head joints of a course, its ends among them, in stones from the front."""
    whole = np.arange(spec.stones + 1.0)
    if not (spec.staggered and course % 2):
        return whole
    return np.concatenate([whole[:1], whole[:-1] + 0.5, whole[-1:]])


def _displaced(joints: FloatArray, spec: BarrelVaultStructure, random: np.random.Generator) -> FloatArray:
    """Joints displaced by up to the vault's irregularity; the first and the last stay."""
    shift = spec.irregularity * random.uniform(-1, 1, len(joints))
    shift[[0, -1]] = 0.0
    return joints + shift


def _stone(spec: BarrelVaultStructure, step: float, length: float) -> Polytope:
    inner, outer = spec.radius - spec.thickness / 2, spec.radius + spec.thickness / 2
    outline: FloatArray = np.array(
        [polar(inner, step / 2), polar(inner, -step / 2), polar(outer, -step / 2), polar(outer, step / 2)]
    )
    return wedge(outline, 2, ("radial", "radial"), length, 3, sides="head")
