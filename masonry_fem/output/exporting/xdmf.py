"""XDMF: all recorded steps in one series, for ParaView, VisIt and meshio.

The numbers stand in binary files in a folder beside the .xdmf, one an array, so that no HDF5 is needed.
Faces of rigid blocks with more than four corners are written as triangles.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np
from numpy.typing import NDArray

from masonry_fem.errors import SceneError
from masonry_fem.host.atomic import write_atomic
from masonry_fem.host.phases import counted
from masonry_fem.output.viewing.recorded import Recorded

POLYGON = 7  # VTK's number
XDMF_TYPES = {5: 4, 9: 5, 10: 6, 12: 9, 13: 8, 22: 0x24, 24: 0x26, 28: 0x23, 29: 0x32}  # by VTK's numbers
COLUMNS = {1: "Scalar", 3: "Vector", 6: "Tensor6", 9: "Tensor"}
TENSOR = (0, 3, 5, 1, 4, 2)  # XDMF's xx, xy, xz, yy, yz, zz of our xx, yy, zz, xy, yz, xz
MASK = "has_"


def write(recorded: Recorded, place: int, path: Path) -> list[Path]:
    """Write all steps up to one.

    Parameters
    ----------
    recorded : The steps. place : The last one that is written, from 0 on. path : The .xdmf file.

    Raises
    ------
    SceneError : Blocks come or go between the steps, or have cells that XDMF does not know.
    OutputError : A file cannot be written.
    """
    first = recorded.blocks(0)
    stream, rows = topology_of(first)
    data = _Data(path)
    root = ET.Element("Xdmf", Version="3.0")
    series = ET.SubElement(
        ET.SubElement(root, "Domain"), "Grid", Name="steps", GridType="Collection", CollectionType="Temporal"
    )
    topology, geometry = data.item(stream, "topology"), data.item(np.asarray(first.points, float), "points")
    for number in counted("steps", range(place + 1)):
        blocks = recorded.blocks(number)
        if blocks.n_points != first.n_points or blocks.n_cells != first.n_cells:
            raise SceneError(
                f"blocks come or go in step {number + 1} of '{recorded.directory}', which one XDMF series "
                "cannot hold; export the folder of each stage"
            )
        grid = ET.SubElement(series, "Grid", Name=f"step {number + 1}", GridType="Uniform")
        ET.SubElement(grid, "Time", Value=repr(recorded.times[number]))
        cells = ET.SubElement(grid, "Topology", TopologyType="Mixed", NumberOfElements=str(len(rows)))
        cells.append(topology)
        ET.SubElement(grid, "Geometry", GeometryType="XYZ").append(geometry)
        for centre, arrays, own in (("Node", blocks.point_data, None), ("Cell", blocks.cell_data, rows)):
            for name in arrays:
                if name.startswith(MASK):
                    continue
                values = np.asarray(arrays[name])
                values = values if own is None else values[own]
                width = 1 if values.ndim == 1 else values.shape[1]
                what = {"Name": name, "Center": centre, "AttributeType": COLUMNS.get(width, "Matrix")}
                values = values[:, TENSOR] if width == 6 else values
                item = data.item(values, f"{centre.lower()}_{name}_{number + 1:06d}")
                ET.SubElement(grid, "Attribute", what).append(item)
    ET.indent(root)
    write_atomic(path, b'<?xml version="1.0"?>\n' + ET.tostring(root) + b"\n")
    return [path]


class _Data:
    """The folder of binary files of an .xdmf file."""

    def __init__(self, path: Path) -> None:
        self._folder = path.with_name(f"{path.stem}_data")

    def item(self, values: NDArray[Any], name: str) -> ET.Element:
        """An array in a file of its own, and the element that names this."""
        whole = values.astype("<f8" if values.dtype.kind == "f" else "<i8")
        path = self._folder / f"{name}.bin"
        write_atomic(path, np.ascontiguousarray(whole).tobytes())
        what = {
            "DataType": "Float" if whole.dtype.kind == "f" else "Int", "Precision": "8", "Endian": "Little",
            "Format": "Binary", "Dimensions": " ".join(map(str, whole.shape)),
        }  # fmt: skip
        item = ET.Element("DataItem", what)
        item.text = f"{self._folder.name}/{path.name}"
        return item


def topology_of(blocks: Any) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """XDMF's stream of mixed cells, and of each cell in it the row in the grid.

    Parameters
    ----------
    blocks : Grid of a step.

    Raises
    ------
    SceneError : A cell is of a kind that XDMF does not know.
    """
    types = np.asarray(blocks.celltypes)
    table = blocks.GetCells()  # by VTK itself, as pyvista's names for it change
    offset, connectivity = (
        np.asarray(one, np.int64) for one in (table.GetOffsetsArray(), table.GetConnectivityArray())
    )
    size = np.diff(offset)
    parts, rows = [], []
    for kind in np.unique(types).tolist():
        own = np.flatnonzero(types == kind)
        if kind == POLYGON:  # a fan of triangles
            many = size[own] - 2
            own = np.repeat(own, many)
            at = np.arange(len(own)) - np.repeat(np.cumsum(many) - many, many)
            start = offset[own]
            corners = connectivity[np.stack([start, start + at + 1, start + at + 2], axis=1)]
            kind = 5  # noqa: PLW2901 - a triangle from here on
        elif kind in XDMF_TYPES:
            corners = connectivity[offset[own][:, None] + np.arange(int(size[own[0]]))]
        else:
            raise SceneError(f"a block has cells of VTK's kind {kind}, which XDMF does not know; export .vtu")
        parts.append(np.insert(corners, 0, XDMF_TYPES[kind], axis=1).ravel())
        rows.append(own)
    return np.concatenate(parts).astype(np.int64), np.concatenate(rows)
