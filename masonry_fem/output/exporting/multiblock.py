"""VTK multi-block: each block of the structure is a part with its name, for ParaView's hovering and picking.

Each part is a file in a folder beside the ``.vtm``, with those fields of the step that it has (a rigid block
has no stress); ``displacement`` leads to where it is.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from masonry_fem.output import fields
from masonry_fem.output.viewing.recorded import Recorded

MASK = "has_"
VTKS_OWN = ("vtkOriginalCellIds", "vtkOriginalPointIds")


def write(recorded: Recorded, place: int, path: Path) -> list[Path]:
    """Write a step.

    Parameters
    ----------
    recorded : The steps. place : Which, from 0 on. path : The file.
    """
    import pyvista as pv  # noqa: PLC0415

    blocks = recorded.blocks(place)
    names = bytes(np.asarray(blocks.field_data["block_names"])).decode().splitlines()
    own = np.asarray(blocks.cell_data[fields.BLOCK])
    cells = np.split(np.argsort(own, kind="stable"), np.cumsum(np.bincount(own, minlength=len(names)))[:-1])
    parts = pv.MultiBlock()
    for name, rows in zip(names, cells, strict=True):
        part = blocks.extract_cells(rows)
        for data in (part.cell_data, part.point_data):
            for array in tuple(data):
                if array in VTKS_OWN or array.startswith(MASK) or _unknown(np.asarray(data[array])):
                    data.pop(array)
        parts.append(part, name)
    parts.save(path)
    return [path]


def _unknown(values: NDArray[Any]) -> bool:
    """Whether an array has no value at all; VTK's readers stumble over its range."""
    return values.dtype.kind == "f" and bool(np.isnan(values).all())
