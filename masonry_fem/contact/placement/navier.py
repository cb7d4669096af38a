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
from masonry_fem.solid.pose import FloatArray

ROUND_FACES = True  # joints may be all patches that two round faces have in common
# From here on corners have the second moment of the face with areas that leave some to the centroid, on
# rectangles and in 2D.
LEAST_INSET = 3.0**-0.5


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
    spots = [[] if len(joint) > 1 else [_placed(joint[0], rule)] for joint in joints]
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
    if patch.degenerate:
        return corners.points(patch, rule)
    centroid, at, share = corners.about(patch, rule)
    away = at - centroid
    # the corners' areas of a skew polygon do not have its centroid
    tilt = np.linalg.solve((share[:, None] * away).T @ away, share @ away)
    area = share * (1.0 - away @ tilt)
    square = _mean_square(patch.polygon - centroid)
    area *= min(1.0, square * share.sum() / float(area @ (away**2).sum(axis=1)))
    area = np.append(area, share.sum() - area.sum())
    return Spots(patch, np.concatenate([at, centroid[None]]), area, np.full((len(area), 2), -1))


def _mean_square(polygon: FloatArray) -> float:
    """Mean square of the distance of a polygon's points from its centroid [m²], (k, d − 1) from there."""
    if polygon.shape[1] == 1:
        return float(np.ptp(polygon)) ** 2 / 12.0
    after = np.roll(polygon, -1, axis=0)
    # twice the areas of triangles at the centroid
    area = polygon[:, 0] * after[:, 1] - polygon[:, 1] * after[:, 0]
    squares = (polygon**2 + after**2 + (polygon + after) ** 2).sum(axis=1)
    return float(area @ squares) / (12.0 * area.sum())


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
    row, node, value = pieces.means((start[:, None] + within)[pieces.on], share)
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
