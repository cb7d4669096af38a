"""Corners: the polygon's corners, drawn towards its centroid by the inset ξ.

Rocking blocks turn about these points: ξ = 1 is the geometric edge, ξ < 1 a rounded or crushed one.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from masonry_fem.contact.clipping import polygon_area
from masonry_fem.contact.placement.parts.cover import Joint
from masonry_fem.contact.placement.parts.patch import Patch
from masonry_fem.contact.placement.parts.rule import Rule, Spots
from masonry_fem.solid.pose import FloatArray


def points(patch: Patch, rule: Rule) -> Spots:
    """The polygon's corners, at ξ of their distance from the centroid.

    Parameters
    ----------
    patch : The interface.
    rule : Its ``inset`` is ξ.
    """
    _, placed, area = about(patch, rule)
    return Spots(patch, placed, area, patch.facets_at(placed))


def about(patch: Patch, rule: Rule) -> tuple[FloatArray, FloatArray, FloatArray]:
    """The polygon's centroid, (d − 1,), its corners drawn towards it, (k, d − 1), and their areas, (k,).

    Parameters
    ----------
    patch : The interface. rule : Its ``inset`` is ξ.
    """
    polygon = patch.polygon
    if patch.degenerate or polygon.shape[1] == 1:
        centroid = polygon.mean(axis=0)
        area = np.full(len(polygon), patch.interface.area / len(polygon))
    else:
        centroid, area = _tributary(polygon)
    return centroid, centroid + rule.inset * (polygon - centroid), area


def where_unmeshed(joints: Sequence[Joint], rule: Rule) -> tuple[list[list[Spots]], list[int]]:
    """The same patch by patch at joints without area or meshes, nothing at others, and numbers of these.

    Parameters
    ----------
    joints : Each one patch or several. rule : As above.
    """
    spots: list[list[Spots]] = []
    meshed = []
    for number, joint in enumerate(joints):
        if joint[0].degenerate or all(side.mesh is None for side in joint[0].sides):
            spots.append([points(patch, rule) for patch in joint])
        else:
            spots.append([])
            meshed.append(number)
    return spots, meshed


def _tributary(polygon: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Centroid, and the area of each corner: its kite with the centroid and the midpoints beside it."""
    after = np.roll(polygon, -1, axis=0)
    spokes = polygon - polygon[0], after - polygon[0]
    fan = spokes[0][:, 0] * spokes[1][:, 1] - spokes[0][:, 1] * spokes[1][:, 0]
    centroid = polygon[0] + (fan[:, None] * (spokes[0] + spokes[1])).sum(axis=0) / (
        3 * 2 * polygon_area(polygon)
    )
    a, b = polygon - centroid, after - centroid
    half = 0.25 * (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])  # half the triangle over each side
    return centroid, half + np.roll(half, 1)
