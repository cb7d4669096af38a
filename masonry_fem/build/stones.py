"""Stones: the blocks of a scene with what the scene says of each.

Which blocks are supports and as what the others are computed, of which material, clamped on which faces and
moving how; shapes meshed where a block deforms, once for each distinct shape and mesh.

    stones = meshed(lay(scene, base))
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from msgspec import structs

from masonry_fem.bodies.support import Clamp, Motion
from masonry_fem.build.supports import motion_of
from masonry_fem.errors import SceneError
from masonry_fem.fem.material_kinds import names
from masonry_fem.fidelities import deforms
from masonry_fem.fidelities import fidelity as fidelity_of
from masonry_fem.host.phases import At
from masonry_fem.scene import specs
from masonry_fem.scene.selector import matches, select, split_face
from masonry_fem.solid.assembly import Assembly, Shape
from masonry_fem.solid.mesh import IntArray, Mesh
from masonry_fem.structures import assemble, build_structures


@dataclass(frozen=True, slots=True)
class Stones:
    """Blocks and what they are, all tuples by block number.

    Attributes
    ----------
    assembly : Geometry; after ``meshed`` with the meshes of the blocks that deform.
    fidelity : As what each is computed, a name of ``fidelities``; None: it is a support.
    material : Name in the scene.
    motion : Prescribed motion of supports that move.
    clamps : Held faces of blocks that deform.
    mesh : What elements such a block has.
    given : Blocks whose shapes came with their elements.
    """

    assembly: Assembly
    fidelity: tuple[str | None, ...]
    material: tuple[str, ...]
    motion: dict[int, Motion]
    clamps: dict[int, tuple[Clamp, ...]]
    mesh: tuple[specs.MeshSettings, ...]
    given: frozenset[int] = frozenset()

    def meshes(self) -> dict[tuple[str, specs.MeshSettings], Shape]:
        """Meshed shapes by name and settings."""
        pairs = [
            (self.assembly.shapes[block.shape], wanted)
            for block, wanted in zip(self.assembly.blocks, self.mesh, strict=True)
        ]
        return {(shape.name, wanted): shape for shape, wanted in pairs if shape.mesh is not None}

    def of(self, fidelity: str | None) -> list[int]:
        """Numbers of the blocks of a fidelity; None: of the supports."""
        return [block for block, own in enumerate(self.fidelity) if own == fidelity]

    @property
    def deforming(self) -> list[int]:
        """Numbers of the blocks that deform."""
        return [block for block, own in enumerate(self.fidelity) if deforms(own)]

    @property
    def yielding(self) -> list[int]:
        """Numbers of the blocks whose material may yield or crack."""
        return [
            block for block, own in enumerate(self.fidelity) if own is not None and fidelity_of(own).yields
        ]


def block_names(assembly: Assembly) -> list[tuple[str, ...]]:
    """What a selector is matched against, by block: its name and its groups."""
    return [(block.name, *block.groups) for block in assembly.blocks]


def lay(scene: specs.Scene, base: Path) -> Stones:
    """Generate or read all structures and decide what each block is.

    Parameters
    ----------
    scene : The scene.
    base : Folder that its paths are relative to.

    Raises
    ------
    GeometryError : A structure is impossible, or a file cannot be read.
    SceneError : A selector selects nothing.
    """
    meshes = [_mesh_of(scene, structure) for structure in scene.structures]
    parts = build_structures(scene.structures, scene.dimension, base, meshes, scene.reading)
    owner = [structure for structure, part in zip(scene.structures, parts, strict=True) for _ in part.blocks]
    assembly, owner = _remaining(scene, assemble(parts), owner)
    names = block_names(assembly)
    told = _told(scene, owner, names)
    free = [None if block.support else own[0] for block, own in zip(assembly.blocks, told, strict=True)]
    motion, clamps = _supports(scene, assembly, names, free, base)
    materials, meshes_of = tuple(own[1] for own in told), tuple(own[2] for own in told)
    _check_materials(scene, assembly, free, materials)
    solids = enumerate(assembly.shapes[block.shape] for block in assembly.blocks)
    given = frozenset(number for number, shape in solids if shape.mesh is not None)
    return Stones(assembly, tuple(free), materials, motion, clamps, meshes_of, given)


def _remaining(
    scene: specs.Scene, assembly: Assembly, owner: list[specs.Structure]
) -> tuple[Assembly, list[specs.Structure]]:
    """The blocks that a scene does not leave out, and the structure of each."""
    if not scene.without:
        return assembly, owner
    absent = set(absentees(scene, block_names(assembly)))
    here = [number for number in range(len(assembly.blocks)) if number not in absent]
    blocks = tuple(assembly.blocks[number] for number in here)
    return replace(assembly, blocks=blocks), [owner[number] for number in here]


def absentees(scene: specs.Scene, names: list[tuple[str, ...]]) -> list[int]:
    """Numbers of the blocks that a scene leaves out.

    Parameters
    ----------
    scene : The scene. names : Of all blocks of its structures.

    Raises
    ------
    SceneError : A selector selects nothing, or nothing is left.
    """
    found = [
        block
        for index, selector in enumerate(scene.without)
        for block in select(selector, names, f"without.{index}")
    ]
    if len(set(found)) == len(names):
        raise SceneError("without leaves all blocks out, expected some that stay")
    return found


def present(scene: specs.Scene, base: Path) -> specs.Scene:
    """The scene without what it says of blocks that it leaves out.

    Parameters
    ----------
    scene : The scene. base : Folder that its paths are relative to.

    Raises
    ------
    SceneError : A selector of blocks to leave out selects nothing.
    """
    if not scene.without:
        return scene
    meshes = [_mesh_of(scene, structure) for structure in scene.structures]
    parts = build_structures(scene.structures, scene.dimension, base, meshes, scene.reading)
    names = block_names(assemble(parts))
    absent = set(absentees(scene, names))

    def stays(record: Any) -> bool:
        selectors = [getattr(record, key) for key in ("on", "blocks", "block") if hasattr(record, key)]
        if isinstance(record, specs.Tie):
            selectors = [point.block for point in record.points]
        for selector in (*selectors, *getattr(record, "between", ())):
            blocks = split_face(selector)[0]
            chosen = [number for number, own in enumerate(names) if matches(blocks, own)]
            if chosen and absent.issuperset(chosen):
                return False
        return True

    def without(record: Any) -> Any:
        lists = {key: getattr(record, key) for key in record.__struct_fields__}
        kept = {key: tuple(filter(stays, value)) for key, value in lists.items() if isinstance(value, tuple)}
        return structs.replace(record, **kept)

    made: specs.Scene = structs.replace(without(scene), loads=without(scene.loads), without=scene.without)
    return made


def _told(
    scene: specs.Scene, owner: list[specs.Structure], names: list[tuple[str, ...]]
) -> list[tuple[str, str, specs.MeshSettings]]:
    """Fidelity, material and elements of each block, as its structure and then overrides say."""
    told = [(one.fidelity or scene.fidelity, one.material, _mesh_of(scene, one)) for one in owner]
    for index, override in enumerate(scene.overrides):
        own = override.fidelity, override.material, override.mesh
        for block in select(override.blocks, names, f"overrides.{index}.blocks"):
            fidelity, material, mesh = told[block]
            told[block] = own[0] or fidelity, own[1] or material, own[2] or mesh
    return told


def _mesh_of(scene: specs.Scene, structure: specs.Structure) -> specs.MeshSettings:
    return structure.mesh or scene.mesh


def _supports(
    scene: specs.Scene,
    assembly: Assembly,
    names: list[tuple[str, ...]],
    fidelity: list[str | None],
    base: Path,
) -> tuple[dict[int, Motion], dict[int, tuple[Clamp, ...]]]:
    """Turn blocks into supports and faces into clamps; ``fidelity`` is changed in place."""
    motion: dict[int, Motion] = {}
    clamps: dict[int, tuple[Clamp, ...]] = {}
    for index, support in enumerate(scene.supports):
        key = f"supports.{index}.on"
        blocks, face = split_face(support.on)
        chosen = select(blocks, names, key)
        _refuse_turns(support, len(chosen), index)
        moves = None if support.motion is None else motion_of(scene, support.motion, base)
        for block in chosen:
            if face is None or not deforms(fidelity[block]):
                _refuse_partial(assembly, block, support, key)
                fidelity[block] = None
                if moves is not None:
                    motion[block] = moves
                continue
            axes = tuple("xyz".index(axis) for axis in support.components or "xyz"[: scene.dimension])
            held = tuple(Clamp(f, axes, moves) for f in faces_of(assembly, block, face, key))
            clamps[block] = clamps.get(block, ()) + held
    return motion, {block: held for block, held in clamps.items() if deforms(fidelity[block])}


def _refuse_partial(assembly: Assembly, block: int, support: specs.Support, key: str) -> None:
    if support.components is not None:
        raise SceneError(
            f"{key}: block '{assembly.blocks[block].name}' is not elastic, so it is held as a whole and "
            f"components = {list(support.components)} means nothing; leave components out, or make "
            "the block elastic and hold a face of it"
        )


def _refuse_turns(support: specs.Support, count: int, index: int) -> None:
    """Several blocks that turn each about its own middle are not one support that turns."""
    motion = support.motion
    if count > 1 and motion is not None and motion.rotation is not None and motion.pivot is None:
        raise SceneError(
            f"supports.{index}.motion turns {count} blocks of '{support.on}' and has no pivot, expected one "
            "[m] that they share; give it, or a [[supports]] for each block that turns about its own middle"
        )


def faces_of(assembly: Assembly, block: int, pattern: str, key: str) -> list[int]:
    """Numbers of a block's faces whose names match a pattern.

    Parameters
    ----------
    assembly : All blocks.
    block : Number of the block.
    pattern : Shell-style pattern of face names.
    key : Where the pattern stands, for the message.

    Raises
    ------
    SceneError : No face matches.
    """
    solid = assembly.shapes[assembly.blocks[block].shape].solid
    named = [(name,) if name else () for name in solid.names]
    return select(pattern, named, key, noun=f"face of block '{assembly.blocks[block].name}'")


def _check_materials(
    scene: specs.Scene, assembly: Assembly, fidelity: list[str | None], material: tuple[str, ...]
) -> None:
    for block, (own, name) in enumerate(zip(fidelity, material, strict=True)):
        if deforms(own) and not scene.materials[name].stiff:
            raise SceneError(
                f"materials.{name}.young is missing: block '{assembly.blocks[block].name}' is {own} and "
                "needs Young's modulus in Pa; give it, or set fidelity = 'rigid'"
            )
        if own is not None and fidelity_of(own).yields and scene.materials[name].inelastic is None:
            raise SceneError(
                f"materials.{name}.inelastic is missing: block '{assembly.blocks[block].name}' is {own} and "
                f"needs a table with the law by which its stone yields, one of {_laws()}; give it, or set "
                "fidelity = 'elastic'"
            )


def _laws() -> str:
    return ", ".join(f"law = '{name}'" for name in names())


def meshed(stones: Stones, before: Stones | None = None, at: At | None = None) -> Stones:
    """The stones with a mesh for each elastic block, shared by blocks of equal shape and settings.

    Parameters
    ----------
    stones : As ``lay`` made them.
    before : Earlier stones, whose meshes are used again where solid and settings are the same.
    at : Is told how many meshes there are.

    Raises
    ------
    GeometryError : A shape cannot be meshed.
    """
    known = {} if before is None else before.meshes()
    if stones.deforming:
        from masonry_fem.meshing.faceted import faceted  # noqa: PLC0415
        from masonry_fem.meshing.mesher import mesh_shape  # noqa: PLC0415  brings gmsh
    assembly = stones.assembly
    shapes: list[Shape] = []
    origins: list[IntArray | None] = []  # old face of each face, where these have changed
    number: dict[tuple[int, specs.MeshSettings | None], int] = {}
    blocks = []
    for block, own, wanted in zip(assembly.blocks, stones.fidelity, stones.mesh, strict=True):
        key = (block.shape, wanted if deforms(own) else None)
        if key not in number:
            number[key] = len(shapes)
            shape, origin = assembly.shapes[block.shape], None
            if not deforms(own):
                shape = replace(shape, mesh=None)
            else:
                fine = shape
                if shape.mesh is None:
                    fine, origin = faceted(shape, wanted)
                mesh = _again(known, fine, wanted) or shape.mesh
                mesh = mesh or mesh_shape(shape, wanted, assembly.dimension, fine.solid)
                shape = replace(fine, mesh=mesh)
            shapes.append(shape)
            origins.append(origin)
            if at is not None:
                at(len(shapes), total=len(assembly.shapes))
        blocks.append(replace(block, shape=number[key]))
    clamps = {block: _moved(held, origins[blocks[block].shape]) for block, held in stones.clamps.items()}
    return replace(stones, assembly=Assembly(assembly.dimension, tuple(shapes), tuple(blocks)), clamps=clamps)


def _moved(held: tuple[Clamp, ...], origin: IntArray | None) -> tuple[Clamp, ...]:
    """Clamps on the faces that have taken the place of theirs; ``origin`` is the old face of each, if any."""
    if origin is None:
        return held
    return tuple(
        replace(clamp, face=face) for clamp in held for face in np.flatnonzero(origin == clamp.face).tolist()
    )


def _again(
    known: dict[tuple[str, specs.MeshSettings], Shape], shape: Shape, wanted: specs.MeshSettings
) -> Mesh | None:
    """The mesh that the same solid has already had, where it did not come with another one."""
    found = known.get((shape.name, wanted))
    if found is None or not np.array_equal(found.solid.vertices, shape.solid.vertices):
        return None
    mesh, given = found.mesh, shape.mesh
    if mesh is None or given is None:
        return mesh
    same = np.array_equal(mesh.points, given.points) and np.array_equal(mesh.cells, given.cells)
    return mesh if same else None


def typical_length(assembly: Assembly) -> float:
    """Mean over the blocks of the d-th root of their volume [m]."""
    volumes = [shape.solid.mass_properties().volume for shape in assembly.shapes]
    total = sum(volumes[block.shape] ** (1 / assembly.dimension) for block in assembly.blocks)
    return total / max(1, len(assembly.blocks)) if assembly.blocks else math.nan
