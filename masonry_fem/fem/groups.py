"""Groups: sort elastic blocks by mesh, material and clamping, and assemble all of them at once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import repeat

import numpy as np

from masonry_fem.bodies.support import Clamp
from masonry_fem.contact.interfaces import numbered
from masonry_fem.errors import GeometryError, LawError, SceneError
from masonry_fem.fem.assemble import ShapeOperators, assemble_shapes
from masonry_fem.fem.clamp import Faces
from masonry_fem.fem.constitution import Constitution, LinearElasticity
from masonry_fem.fem.corotational import CorotationalGroup
from masonry_fem.fem.elastic import ElasticGroup
from masonry_fem.fem.expansion import Change, ThermoElasticity, Warming
from masonry_fem.fem.inelastic import Inelasticity
from masonry_fem.fem.material import ElasticMaterial, Plane
from masonry_fem.fem.promotion import Promotion
from masonry_fem.fem.reduced import ReducedCorotationalGroup, ReducedElasticGroup
from masonry_fem.solid.assembly import Assembly, taken
from masonry_fem.solid.mesh import IntArray, Mesh

Group = ElasticGroup | CorotationalGroup
_Stuff = tuple[int, bytes, ElasticMaterial]
SAME_TURN = 1e-12  # rotations that differ by less are one: poses carry rounding errors


@dataclass(frozen=True, slots=True)
class _Kind:
    """What the blocks of a group have in common; ``turn`` is set where the mesh is turned to the world.

    Those with another number ``apart`` are in another group.
    """

    shape: int
    material: ElasticMaterial
    held: Faces
    turn: bytes
    apart: int

    @property
    def stuff(self) -> _Stuff:
        """Mesh and material: what has one stiffness."""
        return self.shape, self.turn, self.material


def elastic_groups(
    assembly: Assembly,
    materials: Mapping[int, ElasticMaterial],
    clamps: Mapping[int, Sequence[Clamp]] | None = None,
    plane: Plane = "strain",
    lumped: bool = False,
    before: Sequence[Group] = (),
    turns: bool = False,
    kind: str = "elastic",
    warming: Mapping[int, Sequence[Change]] | None = None,
    apart: Mapping[int, int] | None = None,
) -> tuple[Group, ...]:
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
    turns : Whether elastic blocks that nothing clamps turn without bound; else kinematics are small.
    kind : Name of their fidelity.
    warming : Strains by temperature, by block.
    apart : Numbers by block; blocks of different ones are in different groups, as their materials may change.

    Raises
    ------
    GeometryError
        If the shape of an elastic block has no mesh.
    SceneError
        If a material's law does not go with its stone or its elements.
    """
    clamped = clamps or {}
    kinds = _kinds(assembly, materials, clamped, apart or {})
    operators = _operators(assembly, kinds, plane, lumped, before)
    groups = []
    for alike, members in kinds.items():
        warm = Warming.of(warming or {}, members)
        own = _constitution(operators[alike.stuff], assembly.blocks.names[members[0]], warm)
        group = _group(assembly, alike, members, operators[alike.stuff], own, clamped, turns, kind)
        for known in before:
            group.share(known)
        groups.append(group)
    return tuple(groups)


def _kinds(
    assembly: Assembly,
    materials: Mapping[int, ElasticMaterial],
    clamps: Mapping[int, Sequence[Clamp]],
    apart: Mapping[int, int],
) -> dict[_Kind, IntArray]:
    """The blocks of each kind, ascending, in the order of their first ones."""
    blocks = np.array(sorted(materials), dtype=np.int64)
    own = np.fromiter(map(id, map(materials.__getitem__, blocks.tolist())), np.int64, len(blocks))
    other = np.fromiter(map(apart.get, blocks.tolist(), repeat(0)), np.int64, len(blocks))
    # blocks that are held are looked at one by one
    single = np.where(np.isin(blocks, list(clamps)), blocks, -1)
    number, first = numbered(np.column_stack([assembly.blocks.shape[blocks], own, other, single]))
    order = np.argsort(number, kind="stable")
    members = np.split(blocks[order], np.cumsum(np.bincount(number))[:-1])
    kinds: dict[_Kind, list[IntArray]] = {}
    for block, alike in zip(blocks[first].tolist(), members, strict=False):
        found = _kind(assembly, block, materials[block], clamps.get(block, ()), apart.get(block, 0))
        kinds.setdefault(found, []).append(alike)
    return {kind: np.sort(np.concatenate(alike)) for kind, alike in kinds.items()}


def _operators(
    assembly: Assembly,
    kinds: Mapping[_Kind, IntArray],
    plane: Plane,
    lumped: bool,
    before: Sequence[Group],
) -> dict[_Stuff, ShapeOperators]:
    """Matrices of each distinct mesh and material, those of ``before`` where it has them."""
    meshes: dict[_Stuff, Mesh] = {}
    for kind, members in kinds.items():
        meshes.setdefault(kind.stuff, _mesh(assembly, int(members[0]), kind))
    known = {(id(group.mesh), group.operators.material): group.operators for group in before}
    found = {stuff: known.get((id(mesh), stuff[2])) for stuff, mesh in meshes.items()}
    new = [stuff for stuff, own in found.items() if own is None]
    made = assemble_shapes([meshes[stuff] for stuff in new], [stuff[2] for stuff in new], plane, lumped)
    return {stuff: own for stuff, own in found.items() if own is not None} | dict(zip(new, made, strict=True))


def _constitution(operators: ShapeOperators, name: str, warming: Warming | None) -> Constitution:
    """The stresses of blocks of which the first has a name."""
    if operators.material.law is None:
        return LinearElasticity(operators) if warming is None else ThermoElasticity(operators, warming)
    try:
        kind = Promotion if operators.material.promote_at else Inelasticity
        return kind(operators, warming)
    except LawError as error:
        raise SceneError(f"block '{name}': {error}") from error


def _group(
    assembly: Assembly,
    kind: _Kind,
    members: IntArray,
    operators: ShapeOperators,
    constitution: Constitution,
    clamps: Mapping[int, Sequence[Clamp]],
    turns: bool,
    fidelity: str,
) -> Group:
    """The blocks of one kind."""
    blocks, names = assembly.blocks, taken(assembly.blocks.names, members)
    poses = blocks.rotation[members], blocks.translation[members]
    reduced = operators.material.degree > 0
    if turns and not kind.held:
        turning = ReducedCorotationalGroup if reduced else CorotationalGroup
        return turning(members, names, poses, operators, constitution, fidelity)
    if kind.turn:
        poses = np.tile(np.eye(assembly.dimension), (len(members), 1, 1)), poses[1]
    small = ReducedElasticGroup if reduced else ElasticGroup
    return small(
        members,
        names,
        poses,
        operators,
        kind.held,
        [[clamp.motion for clamp in own] for own in map(clamps.get, members.tolist(), repeat(()))]
        if kind.held
        else [[]] * len(members),
        assembly.shapes[kind.shape].solid.names,
        constitution,
        fidelity,
    )


def _kind(
    assembly: Assembly, block: int, material: ElasticMaterial, clamps: Sequence[Clamp], apart: int
) -> _Kind:
    stone, everything = assembly.blocks[block], tuple(range(assembly.dimension))
    held = tuple((clamp.face, tuple(sorted(clamp.components or everything))) for clamp in clamps)
    # components are world axes: if only some of them are held, the mesh is rotated into the world's axes
    partial = any(components != everything for _, components in held)
    turned = partial and not np.array_equal(stone.pose.rotation, np.eye(assembly.dimension))
    if turned and material.orthotropic is not None:
        material = replace(material, orthotropic=material.orthotropic.turned(stone.pose.rotation))
    turn = np.rint(stone.pose.rotation / SAME_TURN).astype(np.int64).tobytes() if turned else b""
    return _Kind(stone.shape, material, held, turn, apart)


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
