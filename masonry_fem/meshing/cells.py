"""Cells: the local node numbers of elements and of their facets, in VTK's order."""

from __future__ import annotations

import numpy as np

from masonry_fem.solid.mesh import FACET_OF, IntArray

# corners, edges, faces, centre of a cell in VTK's order, as positions 0, 1, 2 along each axis
QUAD = ((0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1), (1, 1))
WORDS = (
    "000 200 220 020 002 202 222 022 100 210 120 010 102 212 122 012 "
    "001 201 221 021 011 211 101 121 110 112 111"
)
HEXAHEDRON = tuple(tuple(int(c) for c in word) for word in WORDS.split())
TETRA_EDGES = ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3))
TRIANGLE_EDGES = ((0, 1), (1, 2), (0, 2))
HEX_LOOPS = ((0, 4, 7, 3), (1, 2, 6, 5), (0, 1, 5, 4), (3, 7, 6, 2), (0, 3, 2, 1), (4, 5, 6, 7))
# corners of a mirrored cell turned right again
TURNED: dict[str, tuple[int, ...]] = {
    "triangle": (0, 2, 1),
    "quad": (0, 3, 2, 1),
    "tetra": (0, 2, 1, 3),
    "hexahedron": (4, 5, 6, 7, 0, 1, 2, 3),
}
TETRA_LOOPS = ((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2))


def boundary_facets(cells: IntArray, cell: str) -> IntArray:
    """Facets that belong to one cell only, oriented outwards, shape (f, nodes of a facet).

    Parameters
    ----------
    cells : Node numbers, shape (m, nodes of a cell).
    cell : Kind of the cells, such as ``hexahedron27``.
    """
    facets = np.concatenate([cells[:, list(local)] for local in local_facets(cell)])
    corners = corner_count(FACET_OF[cell])
    _, first, count = np.unique(
        np.sort(facets[:, :corners], axis=1), axis=0, return_index=True, return_counts=True
    )
    return np.asarray(facets[np.sort(first[count == 1])])


def corner_count(kind: str) -> int:
    """Number of corners of a cell or facet."""
    return {"line": 2, "triangle": 3, "quad": 4, "tetra": 4, "hexahedron": 8}[kind.rstrip("0123456789")]


def turned(cell: str) -> list[int]:
    """Local node numbers of a mirrored cell in the order that makes its volume positive."""
    linear = cell.rstrip("0123456789")
    corners = TURNED[linear]
    if cell == linear:
        return list(corners)
    middle = _middles(linear)
    groups = sorted(middle, key=middle.__getitem__)
    return [*corners, *(middle[frozenset(corners[c] for c in group)] for group in groups)]


def local_facets(cell: str) -> list[list[int]]:
    """Local node numbers of the facets of a cell, outward, corners first."""
    linear = cell.rstrip("0123456789")
    loops: tuple[tuple[int, ...], ...] = {
        "triangle": ((0, 1), (1, 2), (2, 0)),
        "quad": ((0, 1), (1, 2), (2, 3), (3, 0)),
        "tetra": TETRA_LOOPS,
        "hexahedron": HEX_LOOPS,
    }[linear]
    if cell == linear:
        return [list(loop) for loop in loops]
    middle = _middles(linear)
    return [[*loop, *(middle[frozenset(group)] for group in _groups(loop))] for loop in loops]


def _groups(loop: tuple[int, ...]) -> list[tuple[int, ...]]:
    """Corners whose mean is each further node of a facet: its edges, then the centre of a quad."""
    if len(loop) == 2:
        return [loop]
    edges: list[tuple[int, ...]] = list(zip(loop, (*loop[1:], loop[0]), strict=True))
    return [*edges, loop] if len(loop) == 4 else edges


def _middles(linear: str) -> dict[frozenset[int], int]:
    """Number of each second-order node by the corners that it is the mean of."""
    if linear in {"triangle", "tetra"}:
        edges = TRIANGLE_EDGES if linear == "triangle" else TETRA_EDGES
        return {frozenset(edge): corner_count(linear) + i for i, edge in enumerate(edges)}
    nodes = np.array(QUAD if linear == "quad" else HEXAHEDRON)
    corners = corner_count(linear)
    found = {}
    for number in range(corners, len(nodes)):
        near = np.abs(nodes[:corners] - nodes[number]).max(axis=1) <= 1
        found[frozenset(int(i) for i in np.flatnonzero(near))] = number
    return found
