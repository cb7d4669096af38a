"""Structures, files and meshes. gmsh is imported here only, and only when something is meshed."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from importlib import import_module
from pathlib import Path

import numpy as np

from masonry_fem.errors import GeometryError, SceneError
from masonry_fem.scene import specs
from masonry_fem.solid.assembly import Assembly, Block, Shape

__all__ = ["assemble", "build_structure", "build_structures"]

# the module of this folder whose ``build`` makes a structure; a scene loads those of its own structures
BUILDERS: dict[type[specs.Structure], str] = {
    specs.BlockStructure: "block",
    specs.StackStructure: "stack",
    specs.WallStructure: "wall",
    specs.ArchStructure: "arch",
    specs.PointedArchStructure: "pointed_arch",
    specs.FlatArchStructure: "flat_arch",
    specs.EllipticalArchStructure: "elliptical_arch",
    specs.CatenaryArchStructure: "catenary_arch",
    specs.BarrelVaultStructure: "barrel_vault",
    specs.PortalStructure: "portal",
    specs.FlyingButtressStructure: "flying_buttress",
    specs.DomeStructure: "dome",
    specs.CorbelStructure: "corbel",
    specs.ButtressStructure: "buttress",
    specs.ColumnStructure: "column",
    specs.StaircaseStructure: "staircase",
    specs.RubbleStructure: "rubble",
}


def build_structure(
    spec: specs.AnyStructure, dimension: int, base: Path, mesh: specs.MeshSettings
) -> Assembly:
    """The blocks of one structure; ``base`` is the folder of its files, ``mesh`` for files to mesh."""
    if isinstance(spec, specs.FileStructure):
        from masonry_fem.importing.mesh_files import read  # noqa: PLC0415  files are rare

        return read(spec, dimension, base, mesh)
    if isinstance(spec, specs.SurveyStructure):
        from masonry_fem.importing.survey import build  # noqa: PLC0415  so are surveys

        return build(spec, dimension, base)
    builder = import_module(f"masonry_fem.structures.{BUILDERS[type(spec)]}")
    made: Assembly = builder.build(spec, dimension)
    return made


def build_structures(
    structures: Sequence[specs.AnyStructure],
    dimension: int,
    base: Path,
    meshes: Sequence[specs.MeshSettings],
    reading: specs.Reading,
) -> list[Assembly]:
    """The blocks of each structure; those of files are read in another process, within its limits."""
    wanted = [(one, dimension, base.resolve(), mesh) for one, mesh in zip(structures, meshes, strict=True)]
    foreign = {
        at: f"structures.{one.name}.path '{one.path}'"
        for at, one in enumerate(structures)
        if isinstance(one, specs.FileStructure | specs.SurveyStructure)
    }
    read: dict[int, Assembly] = {}
    if foreign:
        from masonry_fem.importing.apart import Errand, done_apart  # noqa: PLC0415  files are rare

        errands = [Errand(title, build_structure, wanted[at]) for at, title in foreign.items()]
        read = dict(zip(foreign, done_apart(errands, reading), strict=True))
    return [read[at] if at in read else build_structure(*one) for at, one in enumerate(wanted)]


def assemble(parts: Sequence[Assembly]) -> Assembly:
    """Several structures as one; shapes that are equal bit for bit are shared."""
    shapes: list[Shape] = []
    blocks: list[Block] = []
    for part in parts:
        numbers = [_number(shapes, shape) for shape in part.shapes]
        blocks += [
            Block(stone.name, numbers[stone.shape], stone.pose, stone.groups, stone.support)
            for stone in part.blocks
        ]
    repeated = [name for name, count in Counter(stone.name for stone in blocks).items() if count > 1]
    if repeated:
        raise SceneError(
            f"structures: two blocks are called '{repeated[0]}', expected different names; rename a structure"
        )
    if not blocks:
        raise GeometryError("structures: there is no block at all; add a structure")
    return Assembly(parts[0].dimension, tuple(shapes), tuple(blocks))


def _number(shapes: list[Shape], shape: Shape) -> int:
    for number, known in enumerate(shapes):
        if shape.mesh is None and known.mesh is None and _same(known, shape):
            return number
    shapes.append(shape)
    return len(shapes) - 1


def _same(one: Shape, two: Shape) -> bool:
    return (
        one.solid.faces == two.solid.faces
        and one.solid.names == two.solid.names
        and one.solid.labels == two.solid.labels
        and (one.arcs, one.rails, one.parts) == (two.arcs, two.rails, two.parts)
        and np.array_equal(one.solid.vertices, two.solid.vertices)
    )
