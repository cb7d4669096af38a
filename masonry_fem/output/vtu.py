"""VTU: field files that ParaView opens, written without VTK.

Points are those of the reference, of blocks, contact points and faces of joints alike; ``displacement`` leads
to where they are. Arrays are compressed and in base64. VTK, ParaView and meshio read all of it: as some of
them take neither polyhedra beside other cells nor texts, rigid blocks are no polyhedra, and names stand as
bytes in the field data (``named``).

Files hold no NaN: an array ``has_NAME`` tells where NAME has a value, and where 0 stands for none. Rigid
blocks have no stress, open joints no centre of pressure.
"""

from __future__ import annotations

import base64
import zlib
from collections.abc import Container, Iterable, MutableMapping
from pathlib import Path
from typing import Any
from xml.etree import ElementTree
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray

from masonry_fem.host.atomic import PART, settle, write_atomic
from masonry_fem.march.model import Model
from masonry_fem.march.state import SystemState
from masonry_fem.output import fields, interface_fields
from masonry_fem.output.fields import Arrays
from masonry_fem.output.grid import VERTEX, Grid
from masonry_fem.output.interface_fields import InterfaceFields

# whose mask tells of an array that may lack values; all that is made of the stress shares its mask
MASK_OF = {
    **dict.fromkeys((fields.STRESS, fields.VON_MISES, fields.PRINCIPAL, *fields.DIRECTIONS), fields.STRESS),
    **{name: name for name in (fields.STRESS_ERROR, fields.ADHESION, fields.UTILISATION)},
    **{name: name for name in (interface_fields.CENTRE, interface_fields.ECCENTRICITY)},
    **{name: name for name in (interface_fields.KERN, interface_fields.PRESSURE)},
}

BLOCK_BYTES = 1 << 20
LEVEL = 1  # of zlib: higher levels hardly compress fields better, and take ten times as long
VTK_NAMES = {"f8": "Float64", "f4": "Float32", "i8": "Int64", "i4": "Int32", "u1": "UInt8", "i1": "Int8"}
COMPONENTS = ("XX", "YY", "ZZ", "XY", "YZ", "XZ")


def without_nan(arrays: Arrays) -> Arrays:
    """The arrays with 0 for NaN, and the masks of those that may lack values."""
    made: Arrays = {}
    for name, values in arrays.items():
        unknown = np.isnan(values) if np.issubdtype(values.dtype, np.floating) else np.zeros(1, bool)
        if name in MASK_OF or unknown.any():
            known = ~unknown.reshape(len(values), -1).any(axis=1)
            made.setdefault(f"has_{MASK_OF.get(name, name)}", known.astype(np.uint8))
            made[name] = np.where(unknown, 0.0, values)
        else:
            made[name] = values
    return made


def with_nan(arrays: MutableMapping[str, Any]) -> None:
    """Put NaN back where a mask says that there is no value."""
    for name in list(arrays):
        mask = f"has_{MASK_OF.get(name, name)}"
        if mask in arrays:
            values = np.array(arrays[name])
            values[np.asarray(arrays[mask]) == 0] = np.nan
            arrays[name] = values


class Series:
    """A ``.pvd`` collection: files and the times that they belong to.

    Parameters
    ----------
    directory : Results folder.
    name : Of the collection, with which names of its files begin.
    """

    def __init__(self, directory: Path, name: str) -> None:
        self.path = directory / f"{name}.pvd"
        self._directory, self._name = directory, name
        self._entries: dict[str, float] = {}
        self._settled: set[str] = set()

    def next_path(self, index: int) -> Path:
        """Where the file of a step goes."""
        return self._directory / "fields" / f"{self._name}_{index:06d}.vtu"

    def saved(self) -> dict[str, float]:
        """Times by the files' names, relative to the results folder; the files are on the disk by then."""
        settle_files(self._directory, self._entries, self._settled)
        return dict(self._entries)

    def go_on(self, entries: dict[str, float]) -> None:
        """Keep the files of the same collection that are there; those of steps to be made anew go."""
        self._entries = {str(name): float(time) for name, time in entries.items()}
        self._settled = set(self._entries)
        remove_others(self._directory, f"{self._name}_*.vtu", self._entries)

    def add(self, path: Path, time: float) -> None:
        """Enter a file that is complete and rewrite the collection."""
        name = path.relative_to(self._directory).as_posix()
        self._entries[name] = time
        self._settled.discard(name)
        self.write()

    def take_over(self, path: Path, since: float) -> None:
        """Enter the files of another collection, which may not be there.

        Parameters
        ----------
        path : Of the collection, in a folder of the directory.
        since : What is added to its times.
        """
        if not path.exists():
            return
        folder = path.parent.relative_to(self._directory)
        for entry in ElementTree.parse(path).iter("DataSet"):
            self._entries[(folder / str(entry.get("file"))).as_posix()] = since + float(
                entry.get("timestep", 0)
            )

    def write(self) -> bool:
        """Write the collection, if it has files; whether it has."""
        if not self._entries:
            return False
        lines = "".join(
            f'    <DataSet timestep="{time:.17g}" part="0" file={quoteattr(name)}/>\n'
            for name, time in self._entries.items()
        )
        write_atomic(
            self.path,
            b'<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1" byte_order="LittleEndian">\n'
            b"  <Collection>\n" + lines.encode() + b"  </Collection>\n</VTKFile>\n",
        )
        return True


def settle_files(directory: Path, names: Iterable[str], settled: set[str]) -> None:
    """Wait until field files stand on the disk.

    Parameters
    ----------
    directory : Results folder. names : Of the files, relative to it.
    settled : Those that are known to; grows.
    """
    waiting = [name for name in names if name not in settled]
    for name in waiting:
        settle(directory / name)
    if waiting:
        settle(directory / "fields")
        settled.update(waiting)


def remove_others(directory: Path, pattern: str, names: Container[str]) -> None:
    """Remove field files, and halves of such, that a run left after its checkpoint.

    Parameters
    ----------
    directory : Results folder. pattern : Of the files' names in ``fields``.
    names : Of those that stay, relative to the results folder.
    """
    for one in (pattern, pattern + PART):
        for path in (directory / "fields").glob(one):
            if path.relative_to(directory).as_posix() not in names:
                path.unlink(missing_ok=True)


def field_data(model: Model, state: SystemState) -> Arrays:
    """What a reader must know besides the fields: time, dimension, a typical size [m], names of blocks.

    Parameters
    ----------
    model, state : Of which instant.
    """
    return {
        "block_names": named(model.assembly.blocks.names),
        "TimeValue": np.array([state.time]),
        "dimension": np.array([model.assembly.dimension]),
        "length": np.array([model.length]),
    }


def tie_names(model: Model) -> Arrays:
    """Names of the contacts that are ties, in their order; {} where there are none.

    Parameters
    ----------
    model : The structure.
    """
    numbers = model.contacts.interface[model.contacts.tied].tolist()
    return {"tie_names": named(model.interfaces[k].label for k in numbers)} if numbers else {}


def named(names: Iterable[str]) -> NDArray[np.generic]:
    """Names, number by number, as the bytes of lines of UTF-8."""
    return np.frombuffer("\n".join([*names, ""]).encode(), np.uint8)


def write_vtu(path: Path, grid: Grid, points: Arrays, cells: Arrays, meta: Arrays | None = None) -> None:
    """Write a grid with its arrays.

    Parameters
    ----------
    path : The file.
    grid : Points and cells.
    points : Nodal arrays, shape (n, ...).
    cells : Cell arrays, shape (m, ...).
    meta : Arrays for the field data.

    Raises
    ------
    OutputError : The file cannot be written.
    """
    topology: Arrays = {"connectivity": grid.connectivity, "offsets": grid.offsets, "types": grid.types}
    if grid.faces.size:
        topology |= {"faces": grid.faces, "faceoffsets": grid.face_offsets}
    _write(path, grid.points, topology, points, cells, meta or {})


def write_points(path: Path, points: NDArray[np.float64], arrays: Arrays, meta: Arrays | None = None) -> None:
    """Write a cloud of points with its arrays, each point a vertex cell.

    Parameters
    ----------
    path : The file.
    points : Shape (c, 3) [m].
    arrays : Shape (c, ...).
    meta : Arrays for the field data.

    Raises
    ------
    OutputError : The file cannot be written.
    """
    number = np.arange(len(points))
    types = np.full(len(points), VERTEX, np.uint8)
    topology: Arrays = {"connectivity": number, "offsets": number + 1, "types": types}
    _write(path, points, topology, arrays, {}, meta or {})


def write_faces(path: Path, faces: InterfaceFields, meta: Arrays | None = None) -> None:
    """Write the faces of joints with their arrays.

    Parameters
    ----------
    path : The file.
    faces : Polygons and arrays.
    meta : Arrays for the field data.

    Raises
    ------
    OutputError : The file cannot be written.
    """
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
