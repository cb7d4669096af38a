"""Navier: corners and centroid of the common face, each seeing either face as the plane nearest to it.

After Navier's hypothesis that sections stay plane. With the centroid c and J = ∫ (x − c)(x − c)ᵀ / A, the
motion of a contact at x_i is that of the affine motion nearest to the face's in the sense of least squares,

    v_i = ∫ φ_i u dA,        φ_i = (1 + (x − c)·J⁻¹ (x_i − c)) / A

and its force acts as the traction φ_i. The areas of the corners and of the centroid have the centroid and
∫ |x − c|² of the face: on rectangles a twelfth each and two thirds, in 2D those of Simpson's rule. So a
pressure that varies linearly, as under an eccentric force, comes to both meshes exactly, whatever the two
are, with five contacts on a rectangle. Faces open at their edges, and hinges turn about the corners.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from masonry_fem.contact.placement import auto, corners
from masonry_fem.contact.placement.parts.cover import Joint
from masonry_fem.contact.placement.parts.patch import Patch
from masonry_fem.contact.placement.parts.pieces import Pieces, batches
from masonry_fem.contact.placement.parts.rule import Means, Rule, Spots
from masonry_fem.contact.placement.weighted import means_of
from masonry_fem.solid.pose import FloatArray

ROUND_FACES = True  # joints may be all patches that two round faces have in common


def points(patch: Patch, rule: Rule) -> Spots:
    """The corners and the centroid; the corners alone where blocks touch at a point or along an edge.

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
    """The same on many joints.

    Parameters
    ----------
    joints : Each one patch, or all that two round faces have in common, which have the contacts of ``auto``.
    rule : As above.

    Raises
    ------
    GeometryError : Mesh facets do not cover a patch.
    """
    spots = [[_placed(patch, rule) for patch in joint] for joint in joints]
    several = [number for number, joint in enumerate(joints) if len(joint) > 1]
    for number, placed in zip(several, auto.together([joints[k] for k in several], rule), strict=True):
        spots[number] = placed
    meshed = [
        number
        for number, (patch, *others) in enumerate(joints)
        if not others and not patch.degenerate and any(side.mesh is not None for side in patch.sides)
    ]
    for rows, pieces in batches([joints[number] for number in meshed]):
        own = [meshed[row] for row in rows.tolist()]
        for number, means in zip(own, _means(pieces, [spots[number][0] for number in own]), strict=True):
            spots[number] = [replace(spots[number][0], means=means)]
    return spots


def _placed(patch: Patch, rule: Rule) -> Spots:
    """Where the contacts of one patch are, the corners first, and their areas."""
    at = corners.points(patch, rule)
    if patch.degenerate:
        return at
    centroid, square = _moments(patch.polygon)
    away = at.points - centroid
    # tributary areas of skew corners have another centroid
    tilt = np.linalg.solve((at.area[:, None] * away).T @ away, at.area @ away)
    area = at.area * (1.0 - away @ tilt)
    area *= min(1.0, square * at.area.sum() / float(area @ (away**2).sum(axis=1)))
    placed = np.concatenate([at.points, centroid[None]])
    area = np.append(area, at.area.sum() - area.sum())
    return Spots(patch, placed, area, np.full((len(placed), 2), -1))


def _moments(polygon: FloatArray) -> tuple[FloatArray, float]:
    """Centroid of a polygon (k, d − 1), and the mean square of the distance from it [m²]."""
    if polygon.shape[1] == 1:
        return polygon.mean(axis=0), float(np.ptp(polygon)) ** 2 / 12.0
    one, other = polygon - polygon[0], np.roll(polygon, -1, axis=0) - polygon[0]
    area = 0.5 * (one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0])  # of triangles at the first corner
    centre = area @ (one + other) / (3.0 * area.sum())
    squares = (one**2 + other**2 + (one + other) ** 2).sum(axis=1)
    return polygon[0] + centre, float(area @ squares) / (12.0 * area.sum()) - float(centre @ centre)


def _means(pieces: Pieces, spots: Sequence[Spots]) -> list[Means]:
    """How meshed sides carry the contacts of each patch.

    Parameters
    ----------
    pieces : Of the patches. spots : Their contacts.
    """
    count = np.array([len(spot.area) for spot in spots])
    start = np.cumsum(count) - count
    within = np.minimum(np.arange(count.max()), count[:, None] - 1)  # of patches with fewer the last again
    placed = np.concatenate([spot.points for spot in spots])[start[:, None] + within]
    real = np.arange(count.max()) < count[:, None]
    patch, weight = pieces.patch, pieces.weight / pieces.area[pieces.patch]
    centroid = _sums(weight[:, None] * pieces.at, patch, len(spots))
    away = pieces.at - centroid[patch]
    spread = _sums(weight[:, None, None] * away[:, :, None] * away[:, None], patch, len(spots))
    slope = (placed - centroid[:, None]) @ np.linalg.inv(spread)
    share = weight[:, None] * (1.0 + (slope[patch] @ away[:, :, None])[:, :, 0]) * real[patch]
    row, node, value = means_of(pieces, (start[:, None] + within)[pieces.on], share)
    row -= 2 * start[pieces.on][:, None]
    first = np.searchsorted(pieces.on, np.arange(len(spots) + 1))
    return [
        Means(row[a:b].ravel(), node[a:b].ravel(), value[a:b].ravel())
        for a, b in itertools.pairwise(first.tolist())
    ]


def _sums(values: FloatArray, patch: np.ndarray, count: int) -> FloatArray:
    """Of the values of points (q, ...) on each patch, shape (count, ...)."""
    total = np.zeros((count, *values.shape[1:]))
    np.add.at(total, patch, values)
    return total
