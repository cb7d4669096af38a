"""Nodes: the mesh nodes of the finer side that lie in the polygon, its boundary included.

A node's area is the integral of its shape function over the polygon; what falls to nodes outside
goes to the nodes of the same facet that lie inside. The finer side becomes the candidate.
"""

from __future__ import annotations

import numpy as np

from masonry_fem.contact.interpolation import KINDS, weights_at
from masonry_fem.contact.placement import corners
from masonry_fem.contact.placement.gauss import on_pieces
from masonry_fem.contact.placement.patch import Patch
from masonry_fem.contact.placement.rule import Rule, Spots
from masonry_fem.errors import GeometryError
from masonry_fem.solid.pose import FloatArray


def points(patch: Patch, rule: Rule) -> Spots:
    """Nodes of the finer side; corners where blocks touch at a point or an edge, or no node is inside."""
    if patch.sides[0].mesh is None and patch.sides[1].mesh is None:
        names = "' and '".join(side.surface.name for side in patch.sides)
        raise GeometryError(
            f"placement 'nodes' between blocks {patch.interface.blocks} (shapes '{names}'): "
            "neither has a mesh, expected at least one; make one elastic, or place by 'corners' or 'gauss'"
        )
    if patch.degenerate:
        return corners.points(patch, Rule())
    within = [_within(patch, side) for side in (0, 1)]
    if max(len(nodes) for nodes in within) == 0:
        return corners.points(patch, Rule())  # meshes too coarse for this overlap
    finer = int(_spacing(patch, 1, within[1]) < _spacing(patch, 0, within[0]) * (1 - 1e-9))
    patch, chosen = (patch.exchanged(), within[1]) if finer else (patch, within[0])
    own = patch.sides[0].facets
    placed = patch.flat(0, own.points[chosen])
    facets = np.stack([own.facets[own.carrier[chosen]], patch.facets_of_side(1, placed)], axis=1)
    return Spots(patch, placed, _areas(patch, chosen), facets)


def _within(patch: Patch, side: int) -> np.ndarray:
    """Rows of the face's nodes that lie in the polygon; none on an unmeshed side."""
    if patch.sides[side].mesh is None:
        return np.empty(0, dtype=np.int64)
    return np.flatnonzero(patch.holds(patch.flat(side, patch.sides[side].facets.points)))


def _spacing(patch: Patch, side: int, within: np.ndarray) -> float:
    """Mean area of the face that a node stands for; infinite where no node lies in the polygon."""
    if len(within) == 0:
        return np.inf
    surface = patch.sides[side].surface
    face = patch.sides[side].face
    return float(surface.areas[surface.face == face].sum() / len(patch.sides[side].facets.nodes))


def _areas(patch: Patch, chosen: np.ndarray) -> FloatArray:
    """Tributary areas of the chosen nodes (rows of the face's nodes), shape (m,)."""
    side = patch.sides[0]
    own, mesh = side.facets, side.mesh
    assert mesh is not None
    placed, weight, _, rows = on_pieces(patch, (True, False), 1)
    kind, facet = KINDS[mesh.facet], rows[:, 0]
    nodes = np.ascontiguousarray(patch.flat(0, own.points[own.rows[facet]]))
    share = weight[:, None] * weights_at(kind, nodes, placed)
    by_facet = np.zeros(own.rows.shape)
    np.add.at(by_facet, facet, share)
    inside = np.zeros(len(own.nodes), dtype=bool)
    inside[chosen] = True
    area = np.bincount(own.rows.ravel(), np.where(inside[own.rows], by_facet, 0.0).ravel(), len(own.nodes))
    lost = np.where(inside[own.rows], 0.0, by_facet).sum(axis=1)
    if np.abs(lost).max() > 1e-12 * patch.interface.area:
        area += _handed_on(patch, lost, inside)
    tributary: FloatArray = area[chosen]
    return tributary


def _handed_on(patch: Patch, lost: FloatArray, inside: np.ndarray) -> FloatArray:
    """Areas of nodes outside the polygon given in equal parts to those inside on the same facet.

    A facet without any gives to the nearest node inside.
    """
    own = patch.sides[0].facets
    area = np.zeros(len(own.nodes))
    for row in np.flatnonzero(lost):
        takers = own.rows[row][inside[own.rows[row]]]
        if len(takers) == 0:
            candidates = np.flatnonzero(inside)
            away = own.points[candidates] - own.corners[row].mean(axis=0)
            takers = candidates[[np.linalg.norm(away, axis=1).argmin()]]
        area[takers] += lost[row] / len(takers)
    return area
