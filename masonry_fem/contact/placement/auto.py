"""Auto: contacts at the nodes of the finer mesh where that is exact, ``weighted`` ones elsewhere.

Contacts at nodes are exact where they bring a uniform pressure to the right nodes of both sides: where meshes
match, or one divides the facets of the other. Where the vertices of one mesh are among those of the other,
but facets are of another kind, they stay at the nodes, too, and the error is told: on domes, whose crown has
tetrahedra, weighted ones take Newton's method ten times as many steps. On round faces vertices have to face
vertices as well: one that faces the middle of a facet is apart from it by what the facet misses the arc.
Rigid faces have them at corners.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from masonry_fem.contact.interpolation import KINDS, weights_at
from masonry_fem.contact.placement import corners, nodes, weighted
from masonry_fem.contact.placement.parts.patch import Patch
from masonry_fem.contact.placement.parts.pieces import Pieces
from masonry_fem.contact.placement.parts.rule import Rule, Spots

WHOLE, MOST = 0.99, 0.5  # of a facet, and of the area that two round faces have in common
SAME = 1e-6  # of the interface's size: vertices nearer than that are one
MISPLACED = (
    0.01  # of a uniform pressure, at the wrong nodes: what contacts at nodes may do, stresses err by 3 %
)


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
    if patch.degenerate or not any(side.mesh for side in patch.sides):
        return corners.points(patch, rule)
    return together([patch], rule)[0]


def together(patches: Sequence[Patch], rule: Rule) -> list[Spots]:
    """The same on two round faces, where nodes are exact or not on all patches together.

    Parameters
    ----------
    patches : The patches that the faces have in common, of some area, with the same candidate.
    rule : As above.

    Returns
    -------
    Contacts patch by patch, or in one on all of them.

    Raises
    ------
    GeometryError : Mesh facets do not cover a patch.
    """
    if not any(side.mesh for side in patches[0].sides):
        return [corners.points(patch, rule) for patch in patches]
    pieces = Pieces.of(patches)
    if _apart(patches, pieces):
        return [weighted.on_pieces(pieces)]
    spots = [nodes.points(patch, rule) for patch in patches]
    error = max(misplaced(spots, pieces, side) for side in (0, 1))
    if error <= MISPLACED:
        return spots
    if _nested(pieces):
        return [replace(one, error=error) for one in spots]
    return [weighted.on_pieces(pieces)]


def _apart(patches: Sequence[Patch], pieces: Pieces) -> bool:
    """Whether these are two round faces with meshes whose vertices do not face each other."""
    return len(patches) > 1 and all(side.mesh for side in patches[0].sides) and not _facing(pieces)


def _facing(pieces: Pieces) -> bool:
    """Whether vertices of two round faces face each other: most facets do, or all vertices are the same."""
    area, facets = np.add.reduceat(pieces.weight, pieces.first), pieces.facets[pieces.first]
    least = np.max([pieces.sizes(side)[facets[:, side]] for side in (0, 1)], axis=0)
    return float(area[area >= WHOLE * least].sum()) >= MOST * pieces.area or _nested(pieces, alike=True)


def _nested(pieces: Pieces, *, alike: bool = False) -> bool:
    """Whether the vertices that one mesh has in the patches are among those of the other, or all of these."""
    from scipy.spatial import KDTree  # noqa: PLC0415 - only joints whose meshes do not match need it

    within = []
    for side in (0, 1):
        if pieces.mesh(side) is None:
            return False
        vertices = np.unique(pieces.vertices(side))
        within.append(pieces.nodes(side)[np.setdiff1d(vertices, pieces.to_rim(side)[0])])
    fewer, more = sorted(within, key=len)
    if len(fewer) == 0 or (alike and len(fewer) < len(more)):
        return False
    size = float(np.ptp(pieces.polygon, axis=1).max())
    return bool(np.all(np.asarray(KDTree(more).query(fewer)[0]) <= SAME * size))


def misplaced(spots: Sequence[Spots], pieces: Pieces, side: int) -> float:
    """Share of a uniform pressure that contacts bring to other nodes of a side than its shape functions do.

    Parameters
    ----------
    spots : Contacts that are points, one a patch.
    pieces : Of these patches.
    side : 0 for the candidate of the patches, 1 for the antagonist.

    Returns
    -------
    Σ |Σ_c a_c N_i(x_c) − ∫ N_i| / 2A over the nodes i; 0 on a side without a mesh.
    """
    mesh = pieces.mesh(side)
    if mesh is None:
        return 0.0
    share = pieces.weight[:, None] * pieces.functions(side)
    away = np.bincount(mesh.facets[pieces.facets[:, side]].ravel(), share.ravel(), len(mesh.points))
    for one in spots:
        own = next(k for k in (0, 1) if one.patch.sides[k].block == pieces.patches[0].sides[side].block)
        nodes_of = mesh.facets[one.facets[:, own]]
        at = weights_at(KINDS[mesh.facet], one.patch.flat(own, mesh.points[nodes_of]), one.points)
        np.add.at(away, nodes_of, -one.area[:, None] * at)
    return float(np.abs(away).sum()) / (2 * pieces.area)
