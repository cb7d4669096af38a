"""Rubble: Voronoi cells of random points in a box, without slivers, with joints cut out between them."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from dataclasses import replace
from typing import Annotated

import numpy as np
from msgspec import Meta

from masonry_fem.errors import GeometryError
from masonry_fem.records.record import Count, Distance, Point, Positive, Sizes
from masonry_fem.records.remark import remark
from masonry_fem.records.structure import Foreseen, Structure
from masonry_fem.solid.assembly import Assembly, Block, Shape
from masonry_fem.solid.polytope import Polytope
from masonry_fem.solid.pose import Pose
from masonry_fem.structures.parts.ground import ground
from masonry_fem.structures.parts.healing import edge_lengths, healed
from masonry_fem.structures.parts.voronoi import INNER, Tiling, in_order


class RubbleStructure(Structure, frozen=True, kw_only=True, tag="rubble"):
    """Rubble masonry (*blocage*): a box divided into ``stones`` random convex stones.

    Stones are Voronoi cells of random points. ``relaxation`` repeatedly moves each point to its cell's
    centroid, which makes the stones more equal. Then points are moved until no edge is shorter than
    ``shortest`` times the stones' mean size. A ``joint`` is cut out between the stones, half from each: then
    there are contacts only if ``contact.reach`` exceeds it, and dry stones bear on each other only after
    closing it. The same seed gives the same stones.

    Attributes
    ----------
    size : size of the whole box
    stones : number of stones
    seed : seed of the random points
    relaxation : number of Lloyd's steps towards stones of equal size
    shortest : length of a stone's shortest edge over the mean size of stones, before they are stretched
    elongation : length of stones over their height
    joint : thickness of the joints; with 0 the stones touch
    position : lower left front corner [m]; the origin by default
    ground : a support under the structure, wider than it

    Examples
    --------
    kind = "rubble"
    name = "rubble"
    material = "stone"
    size = [2.0, 1.0, 1.0]
    stones = 12
    """

    size: Sizes
    stones: Count
    seed: Annotated[int, Meta(ge=0)] = 0
    relaxation: Annotated[int, Meta(ge=0, le=100)] = 2
    shortest: Annotated[float, Meta(ge=0, le=0.2)] = 0.1
    elongation: Positive = 1.0
    joint: Distance = 0.0
    position: Point | None = None
    ground: bool = True

    @property
    def stone_size(self) -> float:
        """Mean size of a stone [m], before it is flattened to its elongation."""
        volume = self.elongation
        for length in self.size:
            volume *= length
        return float((volume / self.stones) ** (1 / len(self.size)))

    def foreseen(self, dimension: int) -> Foreseen:
        """Its stones, with about 14 faces each in 3D, and the ground."""
        return Foreseen(self.stones + self.ground, ("stones",), sides=6 if dimension == 2 else 14)

    def faults(self, dimension: int) -> Iterator[tuple[str, str]]:
        """Joints that leave no stones between them."""
        height = self.stone_size / max(1.0, self.elongation)
        if self.joint > height / 4:
            yield "joint", f"at most a quarter of the stones' mean size ({height / 4:.3g} m)"


logger = logging.getLogger(__name__)


def build(spec: RubbleStructure, dimension: int) -> Assembly:
    """Stones ``name.s01`` ... from below, and ``name.ground``."""
    origin = np.zeros(dimension) if spec.position is None else np.array(spec.position, dtype=float)
    solids = stones_of(spec)
    middles = [solid.mass_properties().centroid for solid in solids]
    digits = max(2, len(str(spec.stones)))
    shapes, blocks = [], []
    if spec.ground:
        height = spec.stone_size / spec.elongation
        shape, block = ground(spec.name, 0, origin, origin + np.array(spec.size), height)
        shapes.append(shape)
        blocks.append(block)
    for number, cell in enumerate(sorted(range(spec.stones), key=lambda cell: middles[cell][-1]), start=1):
        name = f"{spec.name}.s{number:0{digits}d}"
        corner = solids[cell].vertices.min(axis=0)
        solid = replace(solids[cell], vertices=solids[cell].vertices - corner)
        blocks.append(Block(name, len(shapes), Pose(np.eye(dimension), origin + corner), (spec.name,)))
        shapes.append(Shape(name, solid))
    return Assembly(dimension, tuple(shapes), tuple(blocks))


def stones_of(spec: RubbleStructure) -> list[Polytope]:
    """The stones, the box's lower corner at the origin."""
    stretch = np.ones(len(spec.size))
    stretch[-1] = spec.elongation  # points are drawn in a space in which stones are as long as high
    size = np.array(spec.size) * stretch
    points = np.random.default_rng(spec.seed).uniform(size=(spec.stones, len(size))) * size
    for _ in range(spec.relaxation):
        cells = Tiling.of(points, size).solids()
        points = np.array([cell.mass_properties().centroid for cell in cells])
    wanted = spec.shortest * spec.stone_size + spec.joint
    tiling = healed(Tiling.of(points, size), wanted)
    reached = float(edge_lengths(tiling).min())
    logger.info("rubble '%s': %d stones, shortest edge %.3g m", spec.name, spec.stones, reached)
    if reached < wanted:
        remark(
            "short_edge",
            f"rubble '{spec.name}' has an edge of {reached:.3g} m where "
            f"structures.{spec.name}.shortest asks for {wanted:.3g} m; take another seed, more "
            "relaxation, or ask for less",
        )
    solids = [replace(solid, vertices=solid.vertices / stretch) for solid in tiling.solids()]
    return [_shrunk(solid, spec) for solid in solids] if spec.joint else solids


def _shrunk(solid: Polytope, spec: RubbleStructure) -> Polytope:
    """The stone with half a joint cut off at each of its inner faces."""
    from scipy.spatial import ConvexHull, HalfspaceIntersection, QhullError  # noqa: PLC0415  slow to load

    faces = range(len(solid.faces))
    normals = np.array([solid.normal(face) for face in faces])
    inset = np.array([spec.joint / 2 if solid.labels[face] == INNER else 0.0 for face in faces])
    planes = np.array([normals[face] @ solid.face_points(face)[0] for face in faces]) - inset
    middle = solid.mass_properties().centroid
    try:
        corners = HalfspaceIntersection(np.column_stack([normals, -planes]), middle).intersections
        corners = corners[ConvexHull(corners).vertices]
    except QhullError as error:
        raise GeometryError(
            f"structures.{spec.name}.joint is {spec.joint:g} m, expected less: a stone has no room "
            "between its joints; take fewer stones or more relaxation"
        ) from error
    rounding = 1e-9 * float(np.ptp(corners, axis=0).max())
    on = np.abs(corners @ normals.T - planes) < rounding
    kept = [face for face in faces if on[:, face].sum() >= len(middle)]
    loops = tuple(in_order(corners, np.flatnonzero(on[:, face]), normals[face]) for face in kept)
    names, labels = (tuple(words[face] for face in kept) for words in (solid.names, solid.labels))
    return Polytope(corners, loops, names, labels)
