"""Groups: sort elastic blocks by mesh, material and clamping, and assemble all of them at once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from masonry_fem.bodies.support import Clamp
from masonry_fem.errors import GeometryError
from masonry_fem.fem.assemble import assemble_shapes
from masonry_fem.fem.clamp import Faces
from masonry_fem.fem.elastic import ElasticGroup
from masonry_fem.fem.material import ElasticMaterial, Plane
from masonry_fem.solid.assembly import Assembly
from masonry_fem.solid.mesh import Mesh
from masonry_fem.solid.pose import Pose

SAME_TURN = 1e-12  # rotations that differ by less are one: poses carry rounding errors


@dataclass(frozen=True, slots=True)
class _Kind:
    """What the blocks of a group have in common; ``turn`` is set where the mesh is turned to the world."""

    shape: int
    material: ElasticMaterial
    held: Faces
    turn: bytes


def elastic_groups(
    assembly: Assembly,
    materials: Mapping[int, ElasticMaterial],
    clamps: Mapping[int, Sequence[Clamp]] | None = None,
    plane: Plane = "strain",
    lumped: bool = False,
    before: Sequence[ElasticGroup] = (),
) -> tuple[ElasticGroup, ...]:
    """Groups of the elastic blocks of an assembly, in the order of their first blocks.

    Parameters
    ----------
    assembly : Blocks and meshed shapes.
    materials : Material of each elastic block, by its number; other blocks are left out.
    clamps : Held faces, by block.
    plane : What 2D means.
    lumped : Diagonal instead of consistent mass.
    before : Groups of another build of the scene, with the same plane and mass: what they have of the same
        mesh and material is used again.

    Raises
    ------
    GeometryError
        If the shape of an elastic block has no mesh.
    """
    held_faces = clamps or {}
    kinds: dict[_Kind, list[int]] = {}
    for block in sorted(materials):
        kind = _kind(assembly, block, materials[block], held_faces.get(block, ()))
        kinds.setdefault(kind, []).append(block)
    meshes: dict[tuple[int, bytes], Mesh] = {}
    for kind, members in kinds.items():
        meshes.setdefault((kind.shape, kind.turn), _mesh(assembly, members[0], kind))
    pairs = list(dict.fromkeys((kind.shape, kind.turn, kind.material) for kind in kinds))
    operators = {
        pair: group.operators
        for pair in pairs
        for group in before
        if group.mesh is meshes[pair[:2]] and group.operators.material == pair[2]
    }
    new = [pair for pair in pairs if pair not in operators]
    made = assemble_shapes([meshes[pair[:2]] for pair in new], [pair[2] for pair in new], plane, lumped)
    operators |= dict(zip(new, made, strict=True))
    groups = []
    for kind, members in kinds.items():
        stones = [assembly.blocks[block] for block in members]
        poses = [
            Pose(np.eye(assembly.dimension), stone.pose.translation) if kind.turn else stone.pose
            for stone in stones
        ]
        groups.append(
            ElasticGroup(
                np.array(members),
                [stone.name for stone in stones],
                poses,
                operators[kind.shape, kind.turn, kind.material],
                kind.held,
                [[clamp.motion for clamp in held_faces.get(block, ())] for block in members],
                assembly.shapes[kind.shape].solid.names,
            )
        )
        for known in before:
            groups[-1].share(known)
    return tuple(groups)


def _kind(assembly: Assembly, block: int, material: ElasticMaterial, clamps: Sequence[Clamp]) -> _Kind:
    stone, everything = assembly.blocks[block], tuple(range(assembly.dimension))
    held = tuple((clamp.face, tuple(sorted(clamp.components or everything))) for clamp in clamps)
    # components are world axes: if only some of them are held, the mesh is rotated into the world's axes
    partial = any(components != everything for _, components in held)
    turned = partial and not np.array_equal(stone.pose.rotation, np.eye(assembly.dimension))
    turn = np.rint(stone.pose.rotation / SAME_TURN).astype(np.int64).tobytes() if turned else b""
    return _Kind(stone.shape, material, held, turn)


def _mesh(assembly: Assembly, block: int, kind: _Kind) -> Mesh:
    stone = assembly.blocks[block]
    shape = assembly.shapes[stone.shape]
    if shape.mesh is None:
        raise GeometryError(
            f"block '{stone.name}' is elastic but its shape '{shape.name}' has no mesh, expected one; mesh "
            "the shape first, or make the block rigid"
        )
    if kind.turn:
        return replace(shape.mesh, points=shape.mesh.points @ stone.pose.rotation.T)
    return shape.mesh
