"""Volumes: elements of blocks from ``.vtu`` and ``.vtk`` files.

    mesh = read_volumes(Path("arch.vtu"), 3, None, "structures.arch.path 'arch.vtu'")

An integer cell field gives the number of each cell's block. It is called ``block`` unless the scene names
another; without it each connected part is a block.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from masonry_fem.errors import GeometryError
from masonry_fem.importing.foreign import quietly_read
from masonry_fem.meshing.session import Elements
from masonry_fem.solid.mesh import NODES_OF, IntArray
from masonry_fem.solid.pose import FloatArray

FIELD = "block"
LARGEST = 2**53  # whole number of a block: up to here all of them are floats, too
CELLS = {
    2: ("triangle", "quad", "triangle6", "quad9"),
    3: ("tetra", "hexahedron", "tetra10", "hexahedron27"),
}


@dataclass(frozen=True, slots=True)
class Volumes:
    """Elements of a file.

    Attributes
    ----------
    points : Nodes, shape (n, 3). parts : Name ("" where no field tells) and elements of each block.
    """

    points: FloatArray
    parts: list[tuple[str, Elements]]


def read_volumes(path: Path, dimension: int, field: str | None, title: str) -> Volumes:
    """Elements of the scene's dimension, block by block; elements of lower dimension are ignored.

    Parameters
    ----------
    path : The file.
    dimension : 2 or 3.
    field : Name of the cell field with the blocks' numbers; None for ``block``, if there is one.
    title : Name of the file in messages.

    Raises
    ------
    GeometryError : The file is unreadable, has no elements or unknown ones, several kinds in a block, or
        lacks the field.
    """
    mesh = quietly_read(path, title)
    cells = _cells(mesh, dimension, title)
    values = _field(mesh, [number for number, _ in cells], field, title)
    parts: dict[str, list[tuple[str, IntArray]]] = {}
    for (_, one), own in zip(cells, values, strict=True):
        data = np.asarray(one.data, dtype=np.int64)
        for value in np.unique(own):
            name = f"b{value}" if field or _has(mesh, FIELD) else ""
            parts.setdefault(name, []).append((str(one.type), data[own == value]))
    _check_kinds(parts, field or FIELD, title)
    return Volumes(_points(mesh), [entry for name, found in parts.items() for entry in _joined(name, found)])


def _cells(mesh: Any, dimension: int, title: str) -> list[tuple[int, Any]]:
    """The cell blocks of the scene's dimension, with their numbers in the file."""
    cells = [(number, one) for number, one in enumerate(mesh.cells) if one.dim == dimension and len(one.data)]
    if not cells:
        body = {2: "surface", 3: "volume"}[dimension]
        raise GeometryError(
            f"{title} has no {body} elements, expected a meshed {dimension}D model; export the {body} mesh, "
            "or a surface as .stl, .obj or .ply"
        )
    for _, one in cells:
        if one.type not in CELLS[dimension] or one.data.shape[1] != NODES_OF[one.type]:
            raise GeometryError(
                f"{title} has elements '{one.type}', expected {', '.join(CELLS[dimension])}; mesh it "
                "with these"
            )
    return cells


def _check_kinds(parts: dict[str, list[tuple[str, IntArray]]], field: str, title: str) -> None:
    """A block that a field numbers has elements of one kind."""
    for name, found in parts.items():
        if name and len(kinds := sorted({kind for kind, _ in found})) > 1:
            raise GeometryError(
                f"{title}: the block {name.removeprefix('b')} of the cell field '{field}' has "
                f"elements of several kinds ({', '.join(kinds)}), expected one; mesh it anew, or part it"
            )


def _points(mesh: Any) -> FloatArray:
    points = np.asarray(mesh.points, dtype=float)
    return np.pad(points, ((0, 0), (0, 3 - points.shape[1])))


def _has(mesh: Any, name: str) -> bool:
    return name in mesh.cell_data


def _field(mesh: Any, numbers: list[int], field: str | None, title: str) -> list[IntArray]:
    """The block of each cell, by cell block; 0 if there is no field."""
    name = field or FIELD
    if not _has(mesh, name):
        if field is not None:
            known = ", ".join(f"'{one}'" for one in mesh.cell_data) or "none"
            raise GeometryError(
                f"{title} has no cell field '{field}', expected one of its own ({known}); name that, or "
                "leave 'field' out for a block a connected part"
            )
        return [np.zeros(len(mesh.cells[number].data), dtype=np.int64) for number in numbers]
    values = [np.asarray(mesh.cell_data[name][number]) for number in numbers]
    if not all(map(_one_number_a_cell, values)):
        raise GeometryError(
            f"{title}: the cell field '{name}' is not one whole number a cell, expected the number of its "
            "block; name another field"
        )
    return [one.astype(np.int64) for one in values]


def _one_number_a_cell(values: IntArray | FloatArray) -> bool:
    return values.ndim == 1 and bool((np.abs(values) < LARGEST).all() and (values % 1 == 0).all())


def _joined(name: str, found: list[tuple[str, IntArray]]) -> list[tuple[str, Elements]]:
    """Elements of a block by kind; without a field, different kinds are different blocks."""
    kinds = dict.fromkeys(kind for kind, _ in found)
    return [
        (name, Elements(kind, np.concatenate([rows for own, rows in found if own == kind]))) for kind in kinds
    ]
