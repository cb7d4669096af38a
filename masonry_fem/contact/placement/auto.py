"""Auto: contacts at the nodes of the finer mesh where that is exact, ``weighted`` ones elsewhere.

Contacts at nodes are exact where they bring a uniform pressure to the right nodes of both sides: where meshes
match, or one divides the facets of the other. Where the vertices of one mesh are among those of the other,
but facets are of another kind, they stay at the nodes, too, and the error is told: on domes, whose crown has
tetrahedra, weighted ones take Newton's method ten times as many steps. Rigid faces have them at corners.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from masonry_fem.contact.interpolation import CORNERS_OF, KINDS, weights_at
from masonry_fem.contact.placement import corners, nodes, weighted
from masonry_fem.contact.placement.gauss import on_pieces
from masonry_fem.contact.placement.parts.patch import Patch
from masonry_fem.contact.placement.parts.rule import Rule, Spots
from masonry_fem.solid.mesh import IntArray
from masonry_fem.solid.pose import FloatArray

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
    spots = nodes.points(patch, rule)
    error = max(misplaced(spots, side) for side in (0, 1))
    if error <= MISPLACED:
        return spots
    return replace(spots, error=error) if _nested(patch) else weighted.points(patch, rule)


def _nested(patch: Patch) -> bool:
    """Whether the vertices that one mesh has in the interface are among those of the other."""
    within = []
    for side, own in enumerate(patch.sides):
        if own.mesh is None:
            return False
        vertices = np.unique(own.facets.rows[:, : CORNERS_OF[own.mesh.facet]])
        places = patch.flat(side, own.facets.points[vertices])
        within.append(places[patch.holds(places)])
    fewer, more = sorted(within, key=len)
    if len(fewer) == 0:
        return False
    away = np.linalg.norm(fewer[:, None] - more, axis=2).min(axis=1)
    return bool((away <= SAME * patch.size).all())


def misplaced(spots: Spots, side: int) -> float:
    """Share of a uniform pressure that contacts bring to other nodes of a side than its shape functions do.

    Parameters
    ----------
    spots : Contacts that are points.
    side : 0 for the candidate, 1 for the antagonist.

    Returns
    -------
    Σ |Σ_c a_c N_i(x_c) − ∫ N_i| / 2A over the nodes i; 0 on a side without a mesh.
    """
    patch = spots.patch
    if patch.sides[side].mesh is None:
        return 0.0
    placed, weight, facets, _ = on_pieces(patch, (side == 0, side == 1), 1)
    exact = _nodal(patch, side, facets[:, side], placed, weight)
    own = _nodal(patch, side, spots.facets[:, side], spots.points, spots.area)
    return float(np.abs(own - exact).sum()) / (2 * patch.interface.area)


def _nodal(patch: Patch, side: int, facets: IntArray, at: FloatArray, force: FloatArray) -> FloatArray:
    """Forces of a side's nodes from forces at plane points on its mesh facets."""
    mesh = patch.sides[side].mesh
    assert mesh is not None
    nodes_of = mesh.facets[facets]
    share = force[:, None] * weights_at(KINDS[mesh.facet], patch.flat(side, mesh.points[nodes_of]), at)
    return np.bincount(nodes_of.ravel(), share.ravel(), len(mesh.points))
