"""File: blocks that were drawn elsewhere."""

from __future__ import annotations

from masonry_fem.scene.record import FilePath, Positive
from masonry_fem.scene.structures.base import Structure


class FileStructure(Structure, frozen=True, kw_only=True, tag="file"):
    """Blocks read from ``.msh``, ``.geo``, ``.step``: volume groups are blocks, surface groups faces."""

    path: FilePath
    scale: Positive = 1.0
    supports: tuple[str, ...] = ()

    @property
    def carries(self) -> bool:
        """Whether it names supports."""
        return bool(self.supports)
