"""File: blocks that were drawn elsewhere."""

from __future__ import annotations

from collections.abc import Iterator

from masonry_fem.scene.record import FilePath, Positive
from masonry_fem.scene.structures.base import Structure


class FileStructure(Structure, frozen=True, kw_only=True, tag="file"):
    """Blocks read from a file; its ending tells what it holds.

    ``.msh``, ``.geo``, ``.step``: volume groups are blocks, surface groups name faces. ``.vtu``, ``.vtk``:
    elements, with the cell ``field`` whose whole numbers tell the blocks (``block`` where the file has it),
    or a block each connected part. ``.stl``, ``.obj``, ``.ply``: closed surfaces, a block each solid, object,
    group or connected part. ``.json``: assemblies, models and meshes of COMPAS, with the supports that they
    mark.
    """

    path: FilePath
    scale: Positive = 1.0
    field: str | None = None
    supports: tuple[str, ...] = ()

    @property
    def carries(self) -> bool:
        """Whether it names supports; a file of COMPAS may mark them itself."""
        return bool(self.supports) or self.path.lower().endswith(".json")

    def faults(self, dimension: int) -> Iterator[tuple[str, str]]:
        """A field where the file has none."""
        if self.field is not None and not self.path.lower().endswith((".vtu", ".vtk")):
            yield "field", "none: only .vtu and .vtk files have cell fields"
