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
    """Solid in its own frame.

    Attributes
    ----------
    name : What the mesh and messages call it.
    solid : Flat-faced solid: contact faces, rigid mass.
    mesh : Elements where the shape was read from a mesh file; None where it is still to mesh.
    arcs : Edges that are circular arcs rather than straight: ``(vertex, vertex, centre)`` with
        the centre in shape coordinates; the mesher places nodes on them.
    rails : Chains of vertices along the solid's first axis, where it is six-sided (four-sided in
        2D) in the large but some faces are in facets: low and high, in 3D those of the front,
        then of the back. The mesher places nodes on them.
    parts : Equal parts of the rails between which they have a kink, where nodes must lie.
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
    name : Unique in the scene, e.g. ``wall.c2.b3``.
    shape : Index into ``Assembly.shapes``.
    pose : Where it stands.
    groups : Names by which a scene may select it (its structure, course, ...).
    support : True where the generator made it to carry the others (ground, springing).
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
    blocks : Blocks, in a fixed order that numbers them for the whole program.
    """

    dimension: int
    shapes: tuple[Shape, ...]
    blocks: tuple[Block, ...]

    def solid(self, block: int) -> Polytope:
        """The solid of one block in world coordinates."""
        stone = self.blocks[block]
        return self.shapes[stone.shape].solid.moved(stone.pose)
