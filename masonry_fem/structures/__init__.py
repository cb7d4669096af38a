"""Structures: families of blocks, one file each, which holds its record and its function ``build``.

``build(spec, dimension)`` makes the ``Assembly`` of a record in a scene of dimension 2 or 3, and raises
GeometryError where the record's values do not go together. Structures that are read from files get two
arguments more: the folder that their path is relative to, and the settings of the mesh.

What several structures need is in ``parts``. They are listed nowhere; ``kind`` loads the one with a name.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from masonry_fem.errors import ExtensionError, GeometryError, SceneError
from masonry_fem.records import discovery
from masonry_fem.records.structure import MeshSettings, Reading, Structure
from masonry_fem.solid.assembly import Assembly, Blocks, Shape

__all__ = ["Kind", "assemble", "build_structure", "build_structures", "kind", "kinds", "names", "record"]


@dataclass(frozen=True, slots=True)
class Kind:
    """A structure that scene files can ask for.

    Attributes
    ----------
    record : What a scene file says of it. file : Where record and ``build`` stand.
    build : Makes its blocks from record and dimension; with a ``source`` from folder and mesh settings, too.
    """

    record: type[Structure]
    build: Callable[..., Assembly]
    file: str


def names() -> tuple[str, ...]:
    """The structures that a scene may ask for; none is loaded."""
    return discovery.names(__path__)


@cache
def kind(name: str) -> Kind:
    """The kind of structure with a name: record and ``build``."""
    found = discovery.discovered(__name__, name, Structure, "structure")
    record = found.kind.__name__
    signature = f"build(spec: {record}, dimension: int) -> Assembly"
    build = discovery.function(found.module.__name__, signature, f"makes the blocks of a {record}")
    return Kind(found.kind, build, found.file)


def kinds() -> Mapping[str, Kind]:
    """Every kind of structure by its name in scene files."""
    return {name: kind(name) for name in names()}


def record(name: str) -> type[Structure]:
    """What a scene file says of the structure with a name."""
    return kind(name).record


def build_structure(spec: Structure, dimension: int, base: Path, mesh: MeshSettings) -> Assembly:
    """The blocks of one structure.

    Parameters
    ----------
    spec : Its record. dimension : Of the scene.
    base : Folder of its files. mesh : Of files that are meshed here.

    Raises
    ------
    ExtensionError : What the structure's file builds is no assembly in this dimension.
    """
    own = kind(str(spec.__struct_config__.tag))
    made = own.build(spec, dimension) if spec.source is None else own.build(spec, dimension, base, mesh)
    if fault := _fault(made, dimension):
        raise ExtensionError(f"{own.file}: build gives {fault}; correct it")
    return made


def _fault(made: Any, dimension: int) -> str:
    """What is wrong with what a ``build`` has made, and what was expected; empty where nothing is."""
    if not isinstance(made, Assembly):
        return f"a {type(made).__name__}, expected an Assembly"
    for shape in made.shapes:
        if shape.solid.dimension != dimension:
            return f"the {shape.solid.dimension}D shape '{shape.name}', expected one in {dimension}D"
    blocks = made.blocks
    for block in np.flatnonzero((blocks.shape < 0) | (blocks.shape >= len(made.shapes))).tolist():
        expected = f"expected 0 to {len(made.shapes) - 1}"
        return f"block '{blocks.names[block]}' the shape {blocks.shape[block]}, {expected}"
    if made.dimension != dimension:
        return f"an Assembly in {made.dimension}D, expected one in {dimension}D"
    return ""


def build_structures(
    structures: Sequence[Structure],
    dimension: int,
    base: Path,
    meshes: Sequence[MeshSettings],
    reading: Reading,
) -> list[Assembly]:
    """The blocks of each structure; those of files are read in another process, within its limits.

    Parameters
    ----------
    structures : Records of the scene.
    dimension : 2 or 3.
    base : Folder that the paths of files are relative to.
    meshes : Mesh settings of each structure.
    reading : Limits on time and memory for reading files.

    Raises
    ------
    GeometryError : Values that do not go together, or a file that cannot be read.
    """
    wanted = [(one, dimension, base.resolve(), mesh) for one, mesh in zip(structures, meshes, strict=True)]
    foreign = {
        at: f"structures.{one.name}.path '{one.source}'"
        for at, one in enumerate(structures)
        if one.source is not None
    }
    read: dict[int, Assembly] = {}
    if foreign:
        from masonry_fem.importing.apart import Errand, done_apart  # noqa: PLC0415  files are rare

        errands = [Errand(title, build_structure, wanted[at]) for at, title in foreign.items()]
        read = dict(zip(foreign, done_apart(errands, reading), strict=True))
    return [read[at] if at in read else build_structure(*one) for at, one in enumerate(wanted)]


def assemble(parts: Sequence[Assembly]) -> Assembly:
    """Several structures as one; shapes that are equal bit for bit are shared.

    Raises
    ------
    SceneError : Two blocks have one name.
    GeometryError : There is no block.
    """
    shapes: list[Shape] = []
    laid: list[Blocks] = []
    for part in parts:
        numbers = np.array([_number(shapes, shape) for shape in part.shapes], dtype=np.int64)
        laid.append(replace(part.blocks, shape=numbers[part.blocks.shape]))
    if not any(map(len, laid)):
        raise GeometryError("structures: there is no block at all; add a structure")
    blocks = Blocks.joined(laid)
    if len(set(blocks.names)) < len(blocks):
        repeated, _ = Counter(blocks.names).most_common(1)[0]
        raise SceneError(
            f"structures: two blocks are called '{repeated}', expected different names; rename a structure"
        )
    return Assembly(parts[0].dimension, shapes, blocks)


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
