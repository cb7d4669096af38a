"""Auto: contacts at the nodes of the finer mesh where that is exact, ``weighted`` ones elsewhere.

Contacts at nodes are exact where they bring a uniform pressure to the right nodes of both sides: where meshes
match, or one divides the facets of the other. On round faces vertices must also face vertices, since there
is a gap between an arc and the middle of a facet. Rigid faces have contacts at corners.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from masonry_fem.contact.placement import corners, nodes, weighted
from masonry_fem.contact.placement.parts.cover import Joint
from masonry_fem.contact.placement.parts.patch import Patch
from masonry_fem.contact.placement.parts.pieces import Pieces, batches
from masonry_fem.contact.placement.parts.rule import Rule, Spots
from masonry_fem.host.compiled import compiled
from masonry_fem.solid.mesh import IntArray
from masonry_fem.solid.pose import FloatArray

WHOLE, MOST = 0.99, 0.5  # of a facet, and of the area that two round faces have in common
SAME = 1e-6  # of the interface's size: vertices nearer than that are one
# Of a uniform pressure, at the wrong nodes: what contacts at nodes may do. Stresses err by three times that.
MISPLACED = 1e-4
ROUND_FACES = True  # joints may be all patches that two round faces have in common


def points(patch: Patch, rule: Rule) -> Spots:
    """Nodes or weighted, where a side is meshed, else corners.

    Parameters
    ----------
    patch : The interface.
    rule : Its ``inset`` is that of ``corners``.

    Raises
    ------
    GeometryError : Mesh facets do not cover the interface.
    """
    return together([[patch]], rule)[0][0]


def together(joints: Sequence[Joint], rule: Rule) -> list[list[Spots]]:
    """The same on many joints, and on round faces, where nodes are exact or not on all patches together.

    Parameters
    ----------
    joints : Each one patch, or all of some area that two round faces have in common, with the same candidate.
    rule : As above.

    Returns
    -------
    For each joint its contacts patch by patch, or in one on all of them.

    Raises
    ------
    GeometryError : Mesh facets do not cover a patch.
    """
    spots, numbers = corners.where_unmeshed(joints, rule)
    for rows, pieces in batches([joints[number] for number in numbers]):
        borne = [None if cover is None else pieces.borne(side) for side, cover in enumerate(pieces.covers)]
        known = (pieces.covers, borne) if len(pieces.joints[0]) == 1 else None
        placed = nodes.on_patches(pieces.patches, pieces.planes, known)
        means = _apart(pieces) | (misplaced(placed, pieces, borne) > MISPLACED)
        for row, one in weighted.on_pieces(pieces, means).items():
            spots[numbers[rows[row]]] = [one]
        at_nodes: dict[int, Spots] = {}
        for part in placed:
            at_nodes |= part.spots(~means[pieces.joint])
        for number, row in enumerate(pieces.joint.tolist()):
            if not means[row]:
                spots[numbers[rows[row]]].append(at_nodes[number])
    return spots


def _apart(pieces: Pieces) -> np.ndarray:
    """Which joints are two round faces with meshes whose vertices do not face each other, shape (J,).

    They do where most facets do, or all vertices are the same.
    """
    if len(pieces.joints[0]) == 1 or None in pieces.covers:
        return np.zeros(len(pieces.joints), dtype=bool)
    area = np.add.reduceat(pieces.weight, pieces.first)
    least = np.max([pieces.cover(side).areas(pieces.facets[:, side]) for side in (0, 1)], axis=0)
    facing = np.bincount(
        pieces.joint[pieces.on], np.where(area >= WHOLE * least, area, 0.0), len(pieces.joints)
    )
    apart = facing < MOST * pieces.area
    found: np.ndarray = apart & ~_alike(pieces, apart)
    return found


def _alike(pieces: Pieces, asked: np.ndarray) -> np.ndarray:
    """In which joints of meshes both have the same vertices in the patches, shape (J,).

    Parameters
    ----------
    pieces : Of the joints. asked : Which are to be looked at; the others are not.
    """
    if not asked.any():
        return np.zeros(len(asked), dtype=bool)
    pieces = pieces.only(asked)
    places, first = [], []
    for side in (0, 1):
        cover = pieces.cover(side)
        within = np.zeros(len(cover.node), dtype=bool)
        within[pieces.vertices(side)] = True
        within[pieces.to_rim(side)[0]] = False
        places.append(cover.world[within])
        first.append(np.concatenate([[0], np.cumsum(within)])[cover.nodes_from])
    size = np.zeros(len(asked))
    np.maximum.at(size, pieces.joint, pieces.planes.size)
    return _same(*places, *first, SAME * size)  # type: ignore[no-any-return]


@compiled
def _same(
    one: FloatArray, other: FloatArray, one_from: IntArray, other_from: IntArray, within: FloatArray
) -> np.ndarray:
    """In which joints there are as many points of both, each within a distance of one of the others, (J,).

    Parameters
    ----------
    one, other : The points, joint by joint, shape (n, d) each [m].
    one_from, other_from : First of each joint and, last, all; shape (J + 1,) each.
    within : The distance, shape (J,) [m].
    """
    found = np.zeros(len(within), dtype=np.bool_)
    for j in range(len(within)):
        here, there = one[one_from[j] : one_from[j + 1]], other[other_from[j] : other_from[j + 1]]
        found[j] = 0 < len(here) == len(there)
        if not found[j]:
            continue
        for i in range(len(here)):
            near = False
            for k in range(len(there)):
                if np.sqrt(((here[i] - there[k]) ** 2).sum()) <= within[j]:
                    near = True
                    break
            if not near:
                found[j] = False
                break
    return found


def misplaced(
    placed: Sequence[nodes.AtNodes], pieces: Pieces, borne: Sequence[FloatArray | None]
) -> FloatArray:
    """Share of a uniform pressure that contacts bring to other nodes of a side than its shape functions do.

    Parameters
    ----------
    placed : Contacts that are points, on the patches of the joints.
    pieces : Of the joints.
    borne : ∫ N of each node of each facet of both sides, None without a mesh.

    Returns
    -------
    The greater of Σ |Σ_c a_c N_i(x_c) − ∫ N_i| / 2A over the nodes i of either side, shape (J,); 0 on
    one without a mesh.
    """
    error = np.zeros(len(pieces.joints))
    for side, (cover, own_area) in enumerate(zip(pieces.covers, borne, strict=True)):
        if cover is None or own_area is None:
            continue
        away = np.bincount(cover.rows.ravel(), own_area.ravel(), len(cover.node))
        many = int(cover.node.max()) + 1
        key = cover.joint * many + cover.node  # ascending
        for part in placed:
            own = part.covers[1 - side if part.exchanged else side]
            assert own is not None
            rows, at = part.functions(1 - side if part.exchanged else side)
            joint = pieces.joint[part.numbers][part.patch]
            node = np.searchsorted(key, joint[:, None] * many + own.node[rows])
            away -= np.bincount(node.ravel(), (part.area[:, None] * at).ravel(), len(away))
        error = np.maximum(error, np.bincount(cover.joint, np.abs(away), len(error)) / (2 * pieces.area))
    return error
