"""Auto: contacts at the nodes of the finer mesh, at corners between rigid faces.

It measures what share of a uniform pressure these contacts bring to the wrong nodes. Where that is much,
``weighted`` would be exact, but Newton's method may need ten times as many steps with it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from masonry_fem.contact.interpolation import KINDS, weights_at
from masonry_fem.contact.placement import corners, nodes
from masonry_fem.contact.placement.gauss import on_pieces
from masonry_fem.contact.placement.parts.patch import Patch
from masonry_fem.contact.placement.parts.rule import Rule, Spots
from masonry_fem.solid.mesh import IntArray
from masonry_fem.solid.pose import FloatArray


def points(patch: Patch, rule: Rule) -> Spots:
    """Nodes, where a side is meshed, else corners.

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
    return replace(spots, error=max(misplaced(spots, side) for side in (0, 1)))


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
