"""Nodes: the mesh nodes of the finer side that lie in the polygon, its boundary included.

A node's area is the integral of its shape function over the polygon. A node outside whose facets reach into
the polygon is moved to the polygon's nearest point, so that contact ends where the faces do, whatever the
mesh; a corner of the polygon that still has no point nearby gets one. The finer side becomes the candidate.
"""

from __future__ import annotations

import numpy as np

from masonry_fem.contact.interpolation import KINDS, weights_at
from masonry_fem.contact.placement import corners
from masonry_fem.contact.placement.gauss import on_pieces
from masonry_fem.contact.placement.parts.patch import Patch
from masonry_fem.contact.placement.parts.rule import Rule, Spots
from masonry_fem.errors import GeometryError
from masonry_fem.solid.pose import FloatArray

SMALLEST = 1e-9  # of the polygon: an area below it is rounding
SAME = 1e-6  # of the polygon's size: two points nearer than that are one
NEAR = 0.1  # of a facet's size: a corner that is farther from all points gets one of its own


def points(patch: Patch, rule: Rule) -> Spots:
    """Nodes of the finer side; corners where blocks touch at a point or an edge, or where no node is inside.

    Parameters
    ----------
    patch : The interface.
    rule : Not used: this rule has no parameters.

    Raises
    ------
    GeometryError : Neither side has a mesh.
    """
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
    nodes = patch.flat(0, own.points[chosen])
    area, beyond = _areas(patch, chosen)
    placed, area = _to_the_edge(patch, nodes, beyond, area)
    facets = patch.facets_at(placed)
    facets[: len(chosen), 0] = own.facets[own.carrier[chosen]]
    return Spots(patch, placed, area, facets)


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


def _areas(patch: Patch, chosen: np.ndarray) -> tuple[FloatArray, np.ndarray]:
    """Tributary areas of the chosen nodes (rows of the face's nodes) and of those beyond, and these rows.

    Beyond are the nodes outside whose shape function reaches into the polygon.
    """
    side = patch.sides[0]
    own, mesh = side.facets, side.mesh
    assert mesh is not None
    placed, weight, _, rows = on_pieces(patch, (True, False), 1)
    kind, facet = KINDS[mesh.facet], rows[:, 0]
    nodes = np.ascontiguousarray(patch.flat(0, own.points[own.rows[facet]]))
    share = weight[:, None] * weights_at(kind, nodes, placed)
    by_facet = np.zeros(own.rows.shape)
    np.add.at(by_facet, facet, share)
    borne = np.bincount(own.rows.ravel(), by_facet.ravel(), len(own.nodes)) > SMALLEST * patch.interface.area
    inside = np.zeros(len(own.nodes), dtype=bool)
    inside[chosen] = True
    beyond = np.flatnonzero(borne & ~inside)
    inside[beyond] = True
    area = np.bincount(own.rows.ravel(), np.where(inside[own.rows], by_facet, 0.0).ravel(), len(own.nodes))
    lost = np.where(inside[own.rows], 0.0, by_facet).sum(axis=1)
    if np.abs(lost).max() > 1e-12 * patch.interface.area:
        area += _handed_on(patch, lost, inside)
    tributary: FloatArray = area[np.concatenate([chosen, beyond])]
    return tributary, beyond


def _to_the_edge(
    patch: Patch, nodes: FloatArray, beyond: np.ndarray, area: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Points at the nodes, then along the edge where the nodes beyond come to stand, and their areas."""
    if len(beyond) == 0:
        return nodes, area
    own = patch.sides[0].facets
    placed, areas = list(nodes), list(area[: len(nodes)])

    def nearest(point: FloatArray) -> tuple[int, float]:
        away = np.linalg.norm(np.array(placed) - point, axis=1)
        return int(away.argmin()), float(away.min())

    for point, share in zip(
        patch.nearest(patch.flat(0, own.points[beyond])), area[len(nodes) :], strict=True
    ):
        at, away = nearest(point)
        if away <= SAME * patch.size:
            areas[at] += share
        else:
            placed.append(point)
            areas.append(share)
    dimension = patch.polygon.shape[1]
    near = NEAR * _spacing(patch, 0, beyond) ** (1.0 / dimension)
    for corner in patch.polygon:
        at, away = nearest(corner)
        if away > near:
            placed.append(corner)
            areas.append(0.5 * areas[at])
            areas[at] *= 0.5
    return np.array(placed), np.array(areas)


def _handed_on(patch: Patch, lost: FloatArray, inside: np.ndarray) -> FloatArray:
    """Areas of nodes that bear nothing given in equal parts to those that do on the same facet.

    A facet without any gives to the nearest that does.
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
