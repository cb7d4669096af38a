"""Stones: the blocks of a scene with what the scene says of each.

Which blocks are supports and as what the others are computed, of which material, clamped on which faces and
moving how; shapes meshed where a block deforms, once for each distinct shape and mesh.

    stones = meshed(lay(scene, base))
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from msgspec import structs
from numpy.typing import NDArray

from masonry_fem.bodies.support import Clamp, Motion
from masonry_fem.build.selection import matching, select_blocks
from masonry_fem.build.supports import motion_of
from masonry_fem.contact.interfaces import numbered
from masonry_fem.errors import SceneError
from masonry_fem.fem.material_kinds import names
from masonry_fem.fidelities import deforms
from masonry_fem.fidelities import fidelity as fidelity_of
from masonry_fem.host.phases import At
from masonry_fem.scene import specs
from masonry_fem.scene.selector import select, split_face
from masonry_fem.solid.assembly import Assembly, Blocks, Shape, first_of_each, taken
from masonry_fem.solid.mesh import IntArray, Mesh
from masonry_fem.structures import assemble, build_structures

Mask = NDArray[np.bool_]


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
        pairs = dict.fromkeys(zip(self.assembly.blocks.shape.tolist(), self.mesh, strict=True))
        shapes = [(self.assembly.shapes[number], wanted) for number, wanted in pairs]
        return {(shape.name, wanted): shape for shape, wanted in shapes if shape.mesh is not None}

    def where(self, holds: Callable[[str | None], bool]) -> Mask:
        """Whether something holds for the fidelity of each block, shape (b,).

        Parameters
        ----------
        holds : Asked once for each fidelity there is; None stands for supports.
        """
        known = {own: holds(own) for own in set(self.fidelity)}
        return np.fromiter(map(known.__getitem__, self.fidelity), bool)

    def of(self, fidelity: str | None) -> list[int]:
        """Numbers of the blocks of a fidelity; None: of the supports."""
        found: list[int] = np.flatnonzero(self.where(lambda own: own == fidelity)).tolist()
        return found

    @property
    def deforming(self) -> list[int]:
        """Numbers of the blocks that deform."""
        found: list[int] = np.flatnonzero(self.where(deforms)).tolist()
        return found

    @property
    def yielding(self) -> list[int]:
        """Numbers of the blocks whose material may yield or crack."""
        yields = self.where(lambda own: own is not None and fidelity_of(own).yields)
        found: list[int] = np.flatnonzero(yields).tolist()
        return found


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
    owner = np.repeat(np.arange(len(parts)), [len(part.blocks) for part in parts])
    assembly, owner = _remaining(scene, assemble(parts), owner)
    blocks = assembly.blocks
    told, of_block = _told(scene, owner, blocks)
    fidelity = np.array([own[0] for own in told], dtype=object)[of_block]
    fidelity[blocks.support] = None
    free: list[str | None] = fidelity.tolist()
    materials = taken([own[1] for own in told], of_block)
    motion, clamps = _supports(scene, assembly, free, base)
    _check_materials(scene, assembly, free, materials)
    given = frozenset(np.flatnonzero(assembly.meshed).tolist())
    mesh = taken([own[2] for own in told], of_block)
    return Stones(assembly, tuple(free), materials, motion, clamps, mesh, given)


def _remaining(
    scene: specs.Scene, assembly: Assembly, owner: IntArray
) -> tuple[Assembly, IntArray]:  # fmt: skip
    """The blocks that a scene does not leave out, and the structure of each."""
    if not scene.without:
        return assembly, owner
    here = ~absent(scene, assembly.blocks)
    return replace(assembly, blocks=assembly.blocks.only(here)), owner[here]


def absent(scene: specs.Scene, blocks: Blocks) -> Mask:
    """Whether a scene leaves each block out, shape (b,).

    Parameters
    ----------
    scene : The scene. blocks : All blocks of its structures.

    Raises
    ------
    SceneError : A selector selects nothing, or nothing is left.
    """
    found = np.zeros(len(blocks), dtype=bool)
    for index, selector in enumerate(scene.without):
        found[select_blocks(selector, blocks, f"without.{index}")] = True
    if found.all():
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
    all_blocks = assemble(parts).blocks
    gone = absent(scene, all_blocks)

    def stays(record: Any) -> bool:
        selectors = [getattr(record, key) for key in ("on", "blocks", "block") if hasattr(record, key)]
        if isinstance(record, specs.Tie):
            selectors = [point.block for point in record.points]
        for selector in (*selectors, *getattr(record, "between", ())):
            chosen = matching(split_face(selector)[0], all_blocks)
            if chosen.any() and gone[chosen].all():
                return False
        return True

    def without(record: Any) -> Any:
        lists = {key: getattr(record, key) for key in record.__struct_fields__}
        kept = {key: tuple(filter(stays, value)) for key, value in lists.items() if isinstance(value, tuple)}
        return structs.replace(record, **kept)

    made: specs.Scene = structs.replace(without(scene), loads=without(scene.loads), without=scene.without)
    return made


def _told(
    scene: specs.Scene, owner: IntArray, blocks: Blocks
) -> tuple[list[tuple[str, str, specs.MeshSettings]], IntArray]:
    """Fidelities, materials and elements that structures and overrides give, and number of each block's."""
    told = [
        (one.fidelity or scene.fidelity, one.material, _mesh_of(scene, one)) for one in scene.structures
    ]  # fmt: skip
    of_block = owner.copy()
    for index, override in enumerate(scene.overrides):
        chosen = np.array(select_blocks(override.blocks, blocks, f"overrides.{index}.blocks"))
        before = of_block[chosen]
        for number in np.unique(before).tolist():
            fidelity, material, mesh = told[number]
            of_block[chosen[before == number]] = len(told)
            told.append((override.fidelity or fidelity, override.material or material, override.mesh or mesh))
    return told, of_block


def _mesh_of(scene: specs.Scene, structure: specs.Structure) -> specs.MeshSettings:
    return structure.mesh or scene.mesh


def _supports(
    scene: specs.Scene,
    assembly: Assembly,
    fidelity: list[str | None],
    base: Path,
) -> tuple[dict[int, Motion], dict[int, tuple[Clamp, ...]]]:
    """Turn blocks into supports and faces into clamps; ``fidelity`` is changed in place."""
    motion: dict[int, Motion] = {}
    clamps: dict[int, tuple[Clamp, ...]] = {}
    for index, support in enumerate(scene.supports):
        key = f"supports.{index}.on"
        blocks, face = split_face(support.on)
        chosen = select_blocks(blocks, assembly.blocks, key)
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
            f"{key}: block '{assembly.blocks.names[block]}' is not elastic, so it is held as a whole and "
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
    solid = assembly.shapes[assembly.blocks.shape[block]].solid
    named = [(name,) if name else () for name in solid.names]
    return select(pattern, named, key, noun=f"face of block '{assembly.blocks.names[block]}'")


def _check_materials(
    scene: specs.Scene, assembly: Assembly, fidelity: list[str | None], material: tuple[str, ...]
) -> None:
    for (own, name), block in first_of_each(list(zip(fidelity, material, strict=True))).items():
        if deforms(own) and not scene.materials[name].stiff:
            raise SceneError(
                f"materials.{name}.young is missing: block '{assembly.blocks.names[block]}' is {own} and "
                "needs Young's modulus in Pa; give it, or set fidelity = 'rigid'"
            )
        if own is not None and fidelity_of(own).yields and scene.materials[name].inelastic is None:
            raise SceneError(
                f"materials.{name}.inelastic is missing: block '{assembly.blocks.names[block]}' is {own} and "
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
    deforming = stones.where(deforms)
    meshes = {mesh: at for at, mesh in enumerate(dict.fromkeys(stones.mesh))}
    wanted_of = np.fromiter(map(meshes.__getitem__, stones.mesh), np.int64)
    kinds = np.column_stack([assembly.blocks.shape, np.where(deforming, wanted_of, -1)])
    number, first = numbered(kinds)
    for block in first.tolist():
        shape, origin = assembly.shapes[assembly.blocks.shape[block]], None
        if not deforming[block]:
            shape = replace(shape, mesh=None)
        else:
            fine, wanted = shape, stones.mesh[block]
            if shape.mesh is None:
                fine, origin = faceted(shape, wanted)
            mesh = _again(known, fine, wanted) or shape.mesh
            mesh = mesh or mesh_shape(shape, wanted, assembly.dimension, fine.solid)
            shape = replace(fine, mesh=mesh)
        shapes.append(shape)
        origins.append(origin)
        if at is not None:
            at(len(shapes), total=len(assembly.shapes))
    clamps = {block: _moved(held, origins[number[block]]) for block, held in stones.clamps.items()}
    made = Assembly(assembly.dimension, shapes, replace(assembly.blocks, shape=number))
    return replace(stones, assembly=made, clamps=clamps)


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
    volumes = np.array([shape.solid.mass_properties().volume for shape in assembly.shapes])
    lengths = volumes[assembly.blocks.shape] ** (1 / assembly.dimension)
    return float(lengths.mean()) if len(lengths) else math.nan
