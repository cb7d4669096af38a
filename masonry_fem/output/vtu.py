"""VTU: field files that ParaView opens, written without VTK.

One ``.vtu`` a recorded step for the blocks and one for the contact points, and for each kind a
``.pvd`` series that is rewritten after every step, so that an interrupted run can be read:

    out/blocks.pvd   out/contacts.pvd   out/fields/blocks_000012.vtu   ...

What acts on the blocks beside contacts stands in ``out/fields/acting_000012.csv``.

Points are those of the reference, of blocks, contact points and faces of joints alike; ``displacement`` leads
to where they are. Arrays are compressed and in base64. VTK, ParaView and meshio read all of it: as some of
them take neither polyhedra beside other cells nor texts, rigid blocks are no polyhedra, and names stand as
bytes in the field data (``named``).
"""

from __future__ import annotations

import base64
import zlib
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray

from masonry_fem.host.atomic import write_atomic
from masonry_fem.march.model import Model
from masonry_fem.march.state import STATUS_NAMES, SystemState
from masonry_fem.output.acting_table import acting_table
from masonry_fem.output.fields import (
    DISPLACEMENT,
    MATERIAL,
    SLIP,
    VELOCITY,
    Arrays,
    cell_arrays,
    contact_arrays,
    point_arrays,
)
from masonry_fem.output.grid import FIDELITY_NAMES, VERTEX, Grid, grid_of, three
from masonry_fem.output.interface_fields import InterfaceFields
from masonry_fem.output.masks import without_nan
from masonry_fem.output.recorder import StepReport

BLOCK_BYTES = 1 << 20
LEVEL = 1  # of zlib: fields are noise to a higher one, which costs ten times the time
VTK_NAMES = {"f8": "Float64", "f4": "Float32", "i8": "Int64", "i4": "Int32", "u1": "UInt8", "i1": "Int8"}
COMPONENTS = ("XX", "YY", "ZZ", "XY", "YZ", "XZ")


class FieldFiles:
    """Recorder of block and contact fields under ``directory``."""

    dense = False
    amendable = True  # a second record of a step replaces the first

    def __init__(self, directory: Path, *, materials: Sequence[str] = (), statics: bool = False) -> None:
        """Prepare files; ``materials`` by block. In ``statics`` velocities are none, and left out."""
        self._directory = Path(directory)
        self._materials, self._statics = materials, statics
        self._blocks = Series(self._directory, "blocks")
        self._contacts = Series(self._directory, "contacts")
        self._grid: Grid | None = None

    def start(self, model: Model) -> None:
        """Fix the grid, which serves all steps."""
        self._grid = grid_of(model, shells=True)

    def record(self, model: Model, state: SystemState, report: StepReport) -> None:
        """Write one step and bring the two series up to date."""
        grid = self._grid or grid_of(model, shells=True)
        points, cells, meta = point_arrays(grid, model, state), cell_arrays(grid, model, state), {}
        if self._materials:
            names, number = np.unique(self._materials, return_inverse=True)
            cells[MATERIAL], meta["material_names"] = number[grid.cell_block], named(names)
        meta |= field_data(model, state) | {"fidelity_names": named(FIDELITY_NAMES)}
        if self._statics:
            points.pop(VELOCITY)
        path = self._blocks.next_path(state.index)
        write_vtu(path, grid, points, cells, meta)
        self._blocks.add(path, report.time)
        if model.contacts.count:
            path = self._contacts.next_path(state.index)
            reference = three(model.contacts.points[:, 0])
            arrays = {DISPLACEMENT: three(state.points) - reference} | contact_arrays(model, state)
            if self._statics:
                arrays.pop(SLIP)
            meta = field_data(model, state) | {"status_names": named(STATUS_NAMES)}
            write_points(path, reference, arrays, meta)
            self._contacts.add(path, report.time)
        if state.acting is not None:
            path = self._directory / "fields" / f"acting_{state.index:06d}.csv"
            write_atomic(path, acting_table(model, state.acting))

    def close(self, summary: Mapping[str, Any]) -> list[Path]:
        """Name the two series."""
        return [series.path for series in (self._blocks, self._contacts) if series.path.exists()]


class Series:
    """A ``.pvd`` collection: files and the times they belong to."""

    def __init__(self, directory: Path, name: str) -> None:
        self.path = directory / f"{name}.pvd"
        self._directory, self._name = directory, name
        self._entries: dict[str, float] = {}

    def next_path(self, index: int) -> Path:
        """Where the file of a step goes."""
        return self._directory / "fields" / f"{self._name}_{index:06d}.vtu"

    def add(self, path: Path, time: float) -> None:
        """Enter a file that is complete and rewrite the collection."""
        self._entries[path.relative_to(self._directory).as_posix()] = time
        lines = "".join(
            f'    <DataSet timestep="{time:.17g}" part="0" file={quoteattr(name)}/>\n'
            for name, time in self._entries.items()
        )
        write_atomic(
            self.path,
            b'<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1" byte_order="LittleEndian">\n'
            b"  <Collection>\n" + lines.encode() + b"  </Collection>\n</VTKFile>\n",
        )


def field_data(model: Model, state: SystemState) -> Arrays:
    """What a reader must know besides the fields: time, dimension, a typical size [m], names of blocks."""
    return {
        "block_names": named([block.name for block in model.assembly.blocks]),
        "TimeValue": np.array([state.time]),
        "dimension": np.array([model.assembly.dimension]),
        "length": np.array([model.length]),
    }


def named(names: Iterable[str]) -> NDArray[np.generic]:
    """Names, number by number, as the bytes of lines of UTF-8."""
    return np.frombuffer("".join(f"{name}\n" for name in names).encode(), np.uint8)


def write_vtu(path: Path, grid: Grid, points: Arrays, cells: Arrays, meta: Arrays | None = None) -> None:
    """Write a grid with nodal arrays (n, ...) and cell arrays (m, ...)."""
    topology: Arrays = {"connectivity": grid.connectivity, "offsets": grid.offsets, "types": grid.types}
    if grid.faces.size:
        topology |= {"faces": grid.faces, "faceoffsets": grid.face_offsets}
    _write(path, grid.points, topology, points, cells, meta or {})


def write_points(path: Path, points: NDArray[np.float64], arrays: Arrays, meta: Arrays | None = None) -> None:
    """Write a cloud of points (c, 3) with its arrays, each point a vertex cell."""
    number = np.arange(len(points))
    types = np.full(len(points), VERTEX, np.uint8)
    topology: Arrays = {"connectivity": number, "offsets": number + 1, "types": types}
    _write(path, points, topology, arrays, {}, meta or {})


def write_faces(path: Path, faces: InterfaceFields, meta: Arrays | None = None) -> None:
    """Write the faces of joints with their arrays."""
    topology: Arrays = {
        "connectivity": np.arange(len(faces.points)),
        "offsets": faces.offsets,
        "types": faces.types,
    }
    _write(path, faces.points, topology, faces.corner_arrays, faces.face_arrays, meta or {})


def _write(
    path: Path, points: NDArray[np.float64], topology: Arrays, nodal: Arrays, cells: Arrays, meta: Arrays
) -> None:
    lines = (
        '<?xml version="1.0"?>\n<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" '
        'header_type="UInt64" compressor="vtkZLibDataCompressor">\n  <UnstructuredGrid>',
        f"    <FieldData>{_list(meta, tuples=True)}</FieldData>",
        f'    <Piece NumberOfPoints="{len(points)}" NumberOfCells="{len(topology["types"])}">',
        f"      <PointData>{_list(without_nan(nodal))}</PointData>",
        f"      <CellData>{_list(without_nan(cells))}</CellData>",
        f"      <Points>{_list({'Points': points})}</Points>",
        f"      <Cells>{_list(topology)}</Cells>",
        "    </Piece>\n  </UnstructuredGrid>\n</VTKFile>\n",
    )
    write_atomic(path, "\n".join(lines).encode())


def _list(arrays: Arrays, *, tuples: bool = False) -> str:
    return "".join(_element(name, array, tuples) for name, array in arrays.items())


def _element(name: str, array: NDArray[np.generic], tuples: bool) -> str:
    flat = np.ascontiguousarray(array)
    attributes = f'type="{VTK_NAMES[flat.dtype.str[1:]]}" Name={quoteattr(name)}'
    if flat.ndim > 1 and flat.shape[1] > 1:
        attributes += f' NumberOfComponents="{flat.shape[1]}"'
        if flat.shape[1] == 6:
            attributes += "".join(f' ComponentName{i}="{c}"' for i, c in enumerate(COMPONENTS))
    if tuples:
        attributes += f' NumberOfTuples="{len(flat)}"'
    text = _encoded(flat.astype(flat.dtype.newbyteorder("<"), copy=False).tobytes())
    return f'\n        <DataArray {attributes} format="binary">{text}</DataArray>'


def _encoded(data: bytes) -> str:
    """Base64 of a header (blocks, block size, size of the last, compressed sizes) and of the blocks."""
    blocks = [zlib.compress(data[i : i + BLOCK_BYTES], LEVEL) for i in range(0, len(data), BLOCK_BYTES)]
    header = [len(blocks), BLOCK_BYTES, len(data) % BLOCK_BYTES, *map(len, blocks)]
    parts = np.array(header, "<u8").tobytes(), b"".join(blocks)
    return "".join(base64.b64encode(part).decode() for part in parts)
