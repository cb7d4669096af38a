"""Grid: the cells of all blocks of a model as one unstructured mesh in VTK's terms. NumPy only.

Blocks share no nodes: a grid is their disjoint union, ordered by group and by block within the group, so
that a group's fields fill one slice. A rigid block is one VTK cell if it has the form of one. Otherwise it
is a
polyhedron or, since few programs read polyhedra beside other cells, the polygons of its faces.
"""

from __future__ import annotations

import functools
import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from masonry_fem.bodies.base import Shown
from masonry_fem.bodies.support import SupportGroup
from masonry_fem.fidelities import fidelities
from masonry_fem.march.model import Model
from masonry_fem.solid.tiled import tiled

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

VERTEX, POLYGON, POLYHEDRON = 1, 7, 42
TETRA, HEXAHEDRON, PYRAMID = 10, 12, 14
SOLIDS = {(3, 3, 3, 3): TETRA, (3, 3, 3, 3, 4): PYRAMID, (4,) * 6: HEXAHEDRON}
VTK_TYPE = {
    "triangle": 5, "quad": 9, "tetra": 10, "hexahedron": 12,
    "triangle6": 22, "tetra10": 24, "quad9": 28, "hexahedron27": 29,
}  # fmt: skip
SUPPORT = 0  # among ``fidelity_names``


@dataclass(frozen=True, slots=True)
class Grid:
    """n nodes and m cells of all blocks.

    Attributes
    ----------
    dimension : 2 or 3, that of the model; points always have three components.
    points : Reference positions [m], shape (n, 3).
    connectivity : Nodes of the cells one after another, shape (k,).
    offsets : End of each cell in ``connectivity``, shape (m,).
    types : VTK cell types, shape (m,).
    faces : VTK face streams of the polyhedra one after another; empty where there are none.
    face_offsets : End of each cell in ``faces``, −1 for a cell that is no polyhedron, shape (m,).
    point_block, cell_block : Block number in the assembly, shapes (n,) and (m,).
    cell_group : Body group of each cell, shape (m,).
    cell_fidelity : Number of its block's fidelity in ``fidelity_names``, shape (m,).
    group_points, group_cells : Range (start, stop) of each body group's nodes and cells.
    """

    dimension: int
    points: FloatArray
    connectivity: IntArray
    offsets: IntArray
    types: NDArray[np.uint8]
    faces: IntArray
    face_offsets: IntArray
    point_block: IntArray
    cell_block: IntArray
    cell_group: IntArray
    cell_fidelity: IntArray
    group_points: tuple[tuple[int, int], ...]
    group_cells: tuple[tuple[int, int], ...]


@dataclass(frozen=True, slots=True)
class _Cells:
    """Cells of one block over its own nodes."""

    sizes: IntArray
    connectivity: IntArray
    kind: int
    stream: IntArray


def grid_of(model: Model, *, shells: bool = False) -> Grid:
    """The grid of a model.

    Parameters
    ----------
    model : The model.
    shells : Use polygons of faces in place of polyhedra.
    """
    groups = model.groups
    parts: list[_Cells] = []  # of each kind of block in each group
    alike = []  # which of them each block has
    for group in groups:
        _, first, own = np.unique(group.alike, return_index=True, return_inverse=True)
        alike.append(own + len(parts))
        parts += [_cells(group, body, shells) for body in first.tolist()]
    part = np.concatenate(alike)
    blocks = np.concatenate([group.blocks for group in groups])
    nodes = np.concatenate([np.diff(group.first) for group in groups])
    start = np.cumsum(nodes) - nodes
    sizes, owner = tiled([one.sizes for one in parts], part)
    connectivity, of_block = tiled([one.connectivity for one in parts], part)
    faces, face_offsets = _streams(parts, part, start)
    group_of_block = np.repeat(np.arange(len(groups)), [len(group.blocks) for group in groups])
    fidelity = np.array([fidelity_names().index(group.kind) for group in groups])
    of_cell = group_of_block[owner]
    return Grid(
        dimension=model.assembly.dimension,
        points=np.concatenate([three(group.places) for group in groups]),
        connectivity=connectivity + start[of_block],
        offsets=np.cumsum(sizes),
        types=np.array([one.kind for one in parts])[part][owner].astype(np.uint8),
        faces=faces,
        face_offsets=face_offsets,
        point_block=np.repeat(blocks, nodes),
        cell_block=blocks[owner],
        cell_group=of_cell,
        cell_fidelity=fidelity[of_cell],
        group_points=_ranges(np.repeat(group_of_block, nodes), len(groups)),
        group_cells=_ranges(of_cell, len(groups)),
    )


def _ranges(number: IntArray, count: int) -> tuple[tuple[int, int], ...]:
    """First place of each number and the next one's, of numbers that ascend."""
    return tuple(pairwise(np.searchsorted(number, np.arange(count + 1)).tolist()))


def three(vectors: FloatArray) -> FloatArray:
    """Vectors with a zero third component where they have two, shape (..., 3)."""
    if vectors.shape[-1] == 3:
        return np.asarray(vectors, float)
    return np.concatenate([vectors, np.zeros((*vectors.shape[:-1], 1))], axis=-1)


def polygon_of(edges: Sequence[Any] | IntArray) -> IntArray:
    """Node loop of a polygon given by its directed edges (a, b) in any order."""
    follower = {int(a): int(b) for a, b in edges}
    loop = [int(edges[0][0])]
    while len(loop) < len(edges):
        loop.append(follower[loop[-1]])
    return np.array(loop)


def fidelity_names() -> list[str]:
    """What the numbers of fidelities in results mean."""
    return [SupportGroup.kind, *fidelities()]


def _cells(group: Shown, body: int, shells: bool) -> _Cells:
    nothing = np.zeros(0, dtype=np.int64)
    cells = group.cells(body)
    if group.cell is not None:
        table = np.asarray(cells, dtype=np.int64)
        return _Cells(np.full(len(table), table.shape[1]), table.ravel(), VTK_TYPE[group.cell], nothing)
    if group.nodes(body).shape[1] == 2:
        loop = polygon_of(cells)
        return _Cells(np.array([len(loop)]), loop, POLYGON, nothing)
    faces = tuple(map(tuple, cells))
    if (found := standard_cell(faces)) is not None:
        kind, nodes = found
        return _Cells(np.array([len(nodes)]), np.array(nodes), kind, nothing)
    if shells:
        return _Cells(np.array([*map(len, faces)]), np.concatenate(faces), POLYGON, nothing)
    corners = np.unique(np.concatenate([np.asarray(face) for face in cells]))
    stream = np.concatenate([[len(cells)], *([len(face), *face] for face in cells)])
    return _Cells(np.array([len(corners)]), corners, POLYHEDRON, stream)


@functools.lru_cache(maxsize=4096)
def standard_cell(faces: tuple[tuple[int, ...], ...]) -> tuple[int, tuple[int, ...]] | None:
    """VTK type and corners in VTK's order of a tetrahedron, pyramid or hexahedron; None for any other block.

    Wedges are none: programs do not agree which way round these are.
    ``faces`` run counter-clockwise seen from outside.
    """
    kind = SOLIDS.get(tuple(sorted(map(len, faces))))
    if kind is None:
        return None
    base = max(faces, key=len)[::-1]  # seen from outside VTK's run clockwise
    others = {*itertools.chain.from_iterable(faces)} - {*base}
    top = _above(base, faces) if kind == HEXAHEDRON else [*others]
    if {*top} != others or len(top) != len(others):
        return None
    return kind, (*base, *top)


def _above(base: tuple[int, ...], faces: tuple[tuple[int, ...], ...]) -> list[int]:
    """Where the edges lead that rise from the corners of the base; −1 from where none does."""
    edges = [edge for one in faces for edge in zip(one, one[1:] + one[:1], strict=True)]
    above = {a: b for a, b in edges if a in base and b not in base}
    return [above.get(corner, -1) for corner in base]


def _streams(parts: Sequence[_Cells], of: IntArray, start: IntArray) -> tuple[IntArray, IntArray]:
    """Face streams with the node numbers of the grid, and where each cell's stream ends.

    Parameters
    ----------
    parts : Cells of kinds of blocks. of : Kind of each block, shape (b,).
    start : First node of each block, shape (b,).
    """
    faces, owner = tiled([one.stream for one in parts], of)
    named, _ = tiled([_nodes_of(one.stream) for one in parts], of)
    length = np.array([one.stream.size for one in parts])[of]
    cells = np.array([len(one.sizes) for one in parts])[of]  # one where there is a stream
    ends = np.repeat(np.where(length > 0, np.cumsum(length), -1), cells)
    return faces + np.where(named, start[owner], 0), ends


def _nodes_of(stream: IntArray) -> NDArray[np.bool_]:
    """Which numbers of a face stream are nodes; the others count faces and corners."""
    named, at = np.zeros(len(stream), dtype=bool), 1
    while at < len(stream):
        named[at + 1 : at + 1 + stream[at]] = True
        at += stream[at] + 1
    return named
