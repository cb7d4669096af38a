"""Assembly: the blocks of a structure as shapes and poses.

Congruent blocks share one Shape, so that everything that is costly (mesh, stiffness, factor)
is done once for each distinct shape.
"""

from __future__ import annotations

from dataclasses import dataclass

from masonry_fem.solid.mesh import Mesh
from masonry_fem.solid.polytope import Polytope
from masonry_fem.solid.pose import Pose


@dataclass(frozen=True, slots=True)
class Shape:
    """Geometry of a block in its own frame; equal blocks share a shape.

    Attributes
    ----------
    name : Its name in messages and mesh files.
    solid : Flat-faced solid, from which contact faces and rigid mass are computed.
    mesh : Elements, if they were read from a mesh file; None: it is meshed later.
    arcs : Edges that are circular arcs rather than straight: ``(vertex, vertex, centre)`` with
        the centre in shape coordinates; the mesher places nodes on them.
    rails : Of a solid with six sides (four in 2D), some of which consist of several facets: the chains
        of vertices along its first axis, low and high, in 3D those of the front, then of the back.
        The mesher places nodes on them.
    parts : Number of equal parts of the rails; where two parts meet there is a kink and a node.
    """

    name: str
    solid: Polytope
    mesh: Mesh | None = None
    arcs: tuple[tuple[int, int, tuple[float, ...]], ...] = ()
    rails: tuple[tuple[int, ...], ...] = ()
    parts: int = 1


@dataclass(frozen=True, slots=True)
class Block:
    """One stone: a shape in a pose.

    Attributes
    ----------
    name : Unique in the scene, such as ``wall.c2.b3``.
    shape : Index into ``Assembly.shapes``.
    pose : Its place and orientation.
    groups : Names by which a scene may select it (its structure, course, ...).
    support : True for a block that its structure adds to carry the others (ground, springing).
    """

    name: str
    shape: int
    pose: Pose
    groups: tuple[str, ...] = ()
    support: bool = False


@dataclass(frozen=True, slots=True)
class Assembly:
    """All blocks of a structure or of a scene.

    Attributes
    ----------
    dimension : 2 or 3.
    shapes : Distinct shapes.
    blocks : Blocks; the place in this tuple is the number of a block everywhere in the program.
    """

    dimension: int
    shapes: tuple[Shape, ...]
    blocks: tuple[Block, ...]

    def solid(self, block: int) -> Polytope:
        """The solid of one block in world coordinates."""
        stone = self.blocks[block]
        return self.shapes[stone.shape].solid.moved(stone.pose)
