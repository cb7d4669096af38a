"""Reading: an Abaqus file as blocks and named faces."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from masonry_fem.errors import GeometryError
from masonry_fem.importing.abaqus.card import cards
from masonry_fem.importing.abaqus.elements import completed, divided, halves
from masonry_fem.importing.abaqus.part import Part
from masonry_fem.importing.abaqus.placing import Placing
from masonry_fem.importing.naming import UNSELECTABLE, Names, tell_renamed
from masonry_fem.meshing.session import Elements
from masonry_fem.solid.mesh import IntArray
from masonry_fem.solid.pose import FloatArray

FACES = {  # corners of faces S1, S2 ..., as both programs number them
    "tetra": ((0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0)),
    "hexahedron": ((0, 1, 2, 3), (4, 7, 6, 5), (0, 4, 5, 1), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0)),
    "wedge": ((0, 1, 2), (3, 5, 4), (0, 3, 4, 1), (1, 4, 5, 2), (2, 5, 3, 0)),
    "triangle": ((0, 1), (1, 2), (2, 0)),
    "quad": ((0, 1), (1, 2), (2, 3), (3, 0)),
}


@dataclass(frozen=True, slots=True)
class Read:
    """What a file holds.

    Attributes
    ----------
    points : Nodes, shape (n, 3). parts : Name ("" where there are no sets) and elements of each block.
    named : Names of faces by the sorted rows of their corners.
    """

    points: FloatArray
    parts: list[tuple[str, Elements]]
    named: dict[tuple[int, ...], str]


def read_abaqus(path: Path, dimension: int, title: str) -> Read:
    """Elements of the scene's dimension, block by block.

    Parameters
    ----------
    path : The file. dimension : 2 or 3. title : Name of the file in messages.

    Raises
    ------
    GeometryError : A line that cannot be read, solids of a kind that is not known, several kinds in a block.
    """
    placing = Placing()
    for card in cards(path, title):
        placing.take(card)
    points: list[FloatArray] = []
    parts: list[tuple[str, Elements]] = []
    named: dict[tuple[int, ...], str] = {}
    names = Names(UNSELECTABLE)
    for prefix, part, move in placing.placed():
        first = sum(map(len, points))
        made = _made(part, dimension, title)
        points.append(move(made.points))
        for name, elements in made.parts:
            whole = names.of(".".join(filter(None, (prefix, name)))) if prefix or name else ""
            parts.append((whole, Elements(elements.kind, elements.nodes + first)))
        for corners, name in made.named.items():
            named[tuple(first + corner for corner in corners)] = names.of(name)
    tell_renamed(title, names.changed)
    if not parts:
        body = {2: "plane (CPS, CPE)", 3: "solid (C3D)"}[dimension]
        raise GeometryError(
            f"{title} has no {body} elements, expected a meshed {dimension}D model; export the mesh itself"
        )
    return Read(np.concatenate(points), parts, named)


def _made(part: Part, dimension: int, title: str) -> Read:
    """Nodes by rows, blocks and named faces of a part."""
    tags = np.array(sorted(part.nodes), dtype=np.int64)
    points = np.array([part.nodes[tag] for tag in tags.tolist()], dtype=float).reshape(-1, 3)
    solids = part.solids(dimension)
    parts: list[tuple[str, Elements]] = []
    for name, members in part.blocks(set(solids), title).items():
        kinds: dict[str, list[list[int]]] = {}
        for kind, nodes in (solids[one] for one in members):
            kinds.setdefault(kind, []).append(nodes)
        if name and len(kinds) > 1:
            raise GeometryError(
                f"{title}: the set '{name}' has elements of several kinds, expected one; mesh it anew, or "
                "part it"
            )
        for kind, nodes_of in kinds.items():
            simple, rows = divided(kind, _rows(np.array(nodes_of), tags, name, title))
            whole, rows, points = completed(simple, rows, points)
            parts.append((name, Elements(whole, rows)))
    return Read(points, parts, _named(part, solids, tags))


def _rows(nodes: IntArray, tags: IntArray, name: str, title: str) -> IntArray:
    """Rows of nodes by their numbers."""
    rows = np.searchsorted(tags, nodes)
    lost = rows == len(tags)
    lost |= tags[np.where(lost, 0, rows)] != nodes
    if lost.any():
        raise GeometryError(
            f"{title}: an element of '{name}' has the node {nodes[lost][0]}, expected one of the file's; "
            "export it again"
        )
    return rows


def _named(
    part: Part, solids: dict[int, tuple[str, list[int]]], tags: IntArray
) -> dict[tuple[int, ...], str]:
    """Names of faces, by the sorted rows of their corners."""
    row = {tag: number for number, tag in enumerate(tags.tolist())}
    named: dict[tuple[int, ...], str] = {}
    for name, pairs in part.surfaces.items():
        for which, side in pairs:
            members = {int(which)} if which.isdigit() else part.members(which, "")
            for member in members & set(solids):
                kind, nodes = solids[member]
                faces = FACES[kind.rstrip("0123456789")]
                number = int(side[1:]) - 1 if side[1:].isdigit() else -1
                if 0 <= number < len(faces):
                    corners = [row[nodes[corner]] for corner in faces[number]]
                    for face in halves(corners) if kind == "wedge" else [corners]:
                        named[tuple(sorted(face))] = name
    return named
