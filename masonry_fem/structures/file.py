"""File: blocks that were drawn elsewhere."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Self

from msgspec.structs import replace

from masonry_fem.importing import COMPAS, DRAWINGS, INPUTS, MESHES, PROGRAMS, SURFACES, VOLUMES
from masonry_fem.records.record import FilePath, Positive
from masonry_fem.records.structure import MeshSettings, ProblemFile, Structure
from masonry_fem.solid.assembly import Assembly


class FileStructure(Structure, frozen=True, kw_only=True, tag="file"):
    """Blocks read from a file; its ending tells the format ([import](import.md)).

    ``.msh``, ``.unv``, ``.med``, ``.step``, ``.geo``: groups of volumes are blocks, groups of surfaces name
    faces. ``.inp`` of Abaqus and CalculiX: sets of elements are blocks, surfaces of elements name faces.
    ``.vtu``, ``.vtk``: elements, with a cell ``field`` that has the number of each cell's block (by default
    ``block``); without it each connected part is a block. ``.stl``, ``.obj``, ``.ply``: closed surfaces; each
    solid, object, group or connected part is a block. ``.json``: assemblies, models and meshes of COMPAS,
    with the supports that they mark.

    Supports, friction and loads of a ``Problem`` of compas_dem are used, too, unless ``conditions`` is false;
    what the scene itself says has precedence.

    A ``.geo`` file is a program that may run any command of the machine: it is read only if it is
    ``trusted``.

    Attributes
    ----------
    path : ``.msh`` (2.2, 4.1), ``.unv``, ``.med``, ``.step``, ``.geo``, ``.inp``, ``.vtu``, ``.vtk``,
        ``.stl``, ``.obj``, ``.ply`` or COMPAS ``.json``, relative to the scene file
    trusted : run the file if it is a program (``.geo``): you have read it
    scale : factor from the file's unit of length to the metre
    field : cell field of a ``.vtu`` or ``.vtk`` file with the number of the block of each cell
    supports : patterns of blocks (without ``NAME.``) that are supports
    conditions : use [supports, friction and loads](import.md#files) of a COMPAS problem

    Examples
    --------
    kind = "file"
    name = "file"
    material = "stone"
    path = "keystone_arch.msh"
    """

    endings = (*MESHES, *PROGRAMS, *DRAWINGS, *VOLUMES, *INPUTS, *SURFACES, *COMPAS)

    path: FilePath
    trusted: bool = False
    scale: Positive = 1.0
    field: str | None = None
    supports: tuple[str, ...] = ()
    conditions: bool = True

    @property
    def carries(self) -> bool:
        """Whether it names supports; a file of COMPAS may mark them itself."""
        return bool(self.supports) or self.path.lower().endswith(".json")

    @property
    def source(self) -> str:
        """Its path."""
        return self.path

    @property
    def problem(self) -> ProblemFile | None:
        """Its file, unless ``conditions`` is false."""
        return ProblemFile(self.path, self.scale) if self.conditions else None

    def blocks_alone(self) -> Self:
        """The same with ``conditions`` false."""
        return replace(self, conditions=False)

    @property
    def runs(self) -> bool:
        """Whether reading the file means to run it."""
        return self.path.lower().endswith(PROGRAMS)

    def faults(self, dimension: int) -> Iterator[tuple[str, str]]:
        """A program without trust, a field where the file has none."""
        if self.runs and not self.trusted:
            yield (
                "trusted",
                f"true: '{self.path}' is a program in gmsh's language, which may run any command of this "
                "machine; read it, then set trusted = true at the structure or write --trust, or mesh it "
                "with gmsh and name the .msh",
            )
        if self.field is not None and not self.path.lower().endswith((".vtu", ".vtk")):
            yield "field", "none: only .vtu and .vtk files have cell fields"


def build(spec: FileStructure, dimension: int, base: Path, mesh: MeshSettings) -> Assembly:
    """Blocks ``name.`` and their names in the file; paths in the record are relative to ``base``."""
    from masonry_fem.importing.mesh_files import read  # noqa: PLC0415  files are rare

    return read(spec, dimension, base, mesh)
