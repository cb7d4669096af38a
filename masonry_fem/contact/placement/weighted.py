"""Weighted: contacts that are means over the interface, with weights that follow the finer of the two meshes.

Contact i belongs to a vertex of the finer side s. With its weight ψ_i on the interface Γ, Σ_i ψ_i = 1,

    a_i = ∫_Γ ψ_i dΓ,        v_i = (1/a_i) ∫_Γ ψ_i (u_s − u_m) dΓ

so that a uniform traction t gives both meshes its exact consistent forces with impulses p_i = h a_i t,
whatever the two meshes. This is the mortar method of contact mechanics, integrated on segments: the common
part of a facet of each side and the polygon. On facets of second order the shape functions N_i of the
vertices are the linear ones, as the quadratic ones of a triangle's vertices integrate to zero.

The weights are dual, ∫ ψ_i L_j = δ_ij ∫ L_i, to the linear functions L_i of the vertices. Vertices outside of
the interface are moved to its rim: with linear elements the mean of u_s is that at the vertex, or at the rim.
So joints bear up to their rims, and linear meshes that match have the contacts of ``nodes``. (If vertices
outside kept their places, there would be more contacts along a cut than the meshes can distinguish, and
Newton's method would take 200 steps instead of 9 on a wall.) A facet that the moved vertices distort too
much, as where a corner of the interface lies within it, keeps its own, and ψ_i = N_i there. A vertex that
hardly reaches into the interface gives its weight to the nearest.

On round faces Γ is all patches that the two faces have in common: weights reach over the edges between facets
of either side, and the frame of a contact has the mean of the normals about it. Facets of length e that do
not coincide are apart or overlap by e²/8R, which is far more than stone deforms. So the gap of a contact is
computed between curved faces, whose curvature follows from the angles between facets.

References
----------
Wohlmuth, A mortar finite element method using dual spaces for the Lagrange multiplier, SIAM J. Numer. Anal.
38 (2000). Popp, Gitterle, Gee, Wall, A dual mortar approach for 3D finite deformation contact with consistent
linearization, Int. J. Numer. Meth. Engng 83 (2010).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from masonry_fem.contact.contacts import local_frames
from masonry_fem.contact.placement import corners
from masonry_fem.contact.placement.parts.cover import Joint
from masonry_fem.contact.placement.parts.patch import Patch
from masonry_fem.contact.placement.parts.pieces import Pieces, batches
from masonry_fem.contact.placement.parts.rule import Means, Round, Rule, Spots
from masonry_fem.solid.mesh import IntArray
from masonry_fem.solid.pose import FloatArray

LEAST = 1e-2  # of its support: a vertex with less of it in the interface gives its area to its neighbours
SHAPELY = 1e-2  # a facet's least corner over its largest, by the area that its two edges span
DISTINCT = 5e-2  # least eigenvalue of a facet's ∫ L_i L_j over √(∫ L_i ∫ L_j); 1/9 on a parallelogram


ROUND_FACES = True  # joints may be all patches that two round faces have in common


def points(patch: Patch, rule: Rule) -> Spots:
    """One contact for each vertex of the finer mesh whose support reaches into the interface.

    Where blocks touch only at a point or along an edge, and where no side is meshed, these are the corners.

    Parameters
    ----------
    patch : The interface.
    rule : Not used: this rule has no parameters.

    Raises
    ------
    GeometryError : Mesh facets do not cover the interface.
    """
    return together([[patch]], rule)[0][0]


def together(joints: Sequence[Joint], rule: Rule) -> list[list[Spots]]:
    """The same on many joints, and on round faces, where supports reach over the edges between facets.

    Parameters
    ----------
    joints : Each one patch, or all of some area that two round faces have in common, with the same candidate.
    rule : Not used: this rule has no parameters.

    Returns
    -------
    For each joint its contacts in one, on all patches; where no side is meshed corners, patch by patch.

    Raises
    ------
    GeometryError : Mesh facets do not cover a patch.
    """
    spots, numbers = corners.where_unmeshed(joints, Rule())
    for rows, pieces in batches([joints[number] for number in numbers]):
        found = on_pieces(pieces, np.ones(len(rows), dtype=bool))
        for row, one in found.items():
            spots[numbers[rows[row]]] = [one]
    return spots


def on_pieces(pieces: Pieces, chosen: np.ndarray) -> dict[int, Spots]:
    """The weighted contacts of some joints, by their numbers.

    Parameters
    ----------
    pieces : Of the joints, at least one side meshed.
    chosen : Which of them, shape (J,).
    """
    finer = pieces.many(1) > pieces.many(0)
    found: dict[int, Spots] = {}
    for side in (0, 1):
        own = chosen & (finer == side)
        if own.any():
            found |= _of_side(pieces.only(own), side, np.flatnonzero(own))
    return found


def _of_side(pieces: Pieces, finer: int, numbers: IntArray) -> dict[int, Spots]:
    """Contacts at the vertices of one side, joint by joint.

    Parameters
    ----------
    pieces : Of the joints. finer : The side. numbers : Of the joints, ascending.
    """
    share = pieces.weight[:, None] * _dual(pieces, finer)
    of, joint = _contacts(pieces, finer, np.add.reduceat(share, pieces.first))
    contact = of[pieces.piece]
    area = np.bincount(contact.ravel(), share.ravel())
    start, end = (np.searchsorted(joint, numbers, side) for side in ("left", "right"))
    of_joint = pieces.joint[pieces.on]
    row, node, weight = pieces.means(of, share / area[contact])
    row -= 2 * (start[np.searchsorted(numbers, of_joint)])[:, None]

    def mean(values: FloatArray) -> FloatArray:
        """Of what points have, (q, ...), over the parts of contacts, (c, ...)."""
        columns = values.reshape(len(values), -1).T
        sums = [np.bincount(contact.ravel(), (share * column[:, None]).ravel()) for column in columns]
        return (np.stack(sums, axis=1) / area[:, None]).reshape(len(area), *values.shape[1:])

    at = mean(pieces.at)
    low, high = (np.searchsorted(of_joint, numbers, side) for side in ("left", "right"))
    first = np.searchsorted(pieces.joint, numbers)
    rounds = _rounds(pieces, mean, contact, share) if len(pieces.joints[0]) > 1 else None
    spots = {}
    ranges = zip(
        numbers.tolist(), first.tolist(), *(one.tolist() for one in (start, end, low, high)), strict=True
    )
    for number, patch, a, b, i, j in ranges:
        spots[number] = Spots(
            patch=pieces.patches[patch],
            points=at[a:b],
            area=area[a:b],
            facets=np.full((b - a, 2), -1),
            means=Means(row[i:j].ravel(), node[i:j].ravel(), weight[i:j].ravel()),
            round=None if rounds is None else rounds(a, b, patch, number),
        )
    return spots


def _rounds(
    pieces: Pieces, mean: Callable[[FloatArray], FloatArray], contact: IntArray, share: FloatArray
) -> Callable[[int, int, int, int], Round]:
    """Where contacts on round faces are, from means over their parts: of a range, first patch and joint."""
    normal = mean(pieces.planes.frame[pieces.patch, 0])
    frame = local_frames(normal / np.linalg.norm(normal, axis=1)[:, None])
    at = np.stack([mean(pieces.on_side(side)) for side in (0, 1)], axis=1)
    bulge = pieces.bulge(0) + pieces.bulge(1)
    rise = np.full(len(pieces.joints), -np.inf)
    np.maximum.at(rise, pieces.joint[pieces.patch], bulge)
    bulges, fullest = mean(bulge), _fullest(pieces, contact, share)

    def of(start: int, end: int, patch: int, joint: int) -> Round:
        return Round(
            patch=fullest[start:end] - patch,
            frame=frame[start:end],
            points=at[start:end],
            bulge=bulges[start:end],
            rise=float(rise[joint]),
        )

    return of


def _fullest(pieces: Pieces, contact: IntArray, share: FloatArray) -> IntArray:
    """The patch that each contact has most of its area in, the first of equal ones."""
    count = len(pieces.patches)
    key, of = np.unique((contact * count + pieces.patch[:, None]).ravel(), return_inverse=True)
    area = np.bincount(of, share.ravel())
    order = np.lexsort([key, -area, key // count])
    _, best = np.unique(key[order] // count, return_index=True)
    found: IntArray = key[order[best]] % count
    return found


def _dual(pieces: Pieces, side: int) -> FloatArray:
    """Weights of vertices at the points, (q, v): ∫ ψ_i L_j = δ_ij ∫ L_i, or N_i where it cannot be."""
    used, start, of = np.unique(pieces.facets[:, side], return_index=True, return_inverse=True)
    own, moved = _places(pieces, side, used, start)
    linear = pieces.linear(side, moved[of])
    products = np.add.reduceat((pieces.weight[:, None] * linear)[:, :, None] * linear[:, None], pieces.first)
    order = np.argsort(of, kind="stable")
    mass = np.add.reduceat(products[order], np.flatnonzero(np.diff(of[order], prepend=-1)))
    integral, distinct = mass.sum(axis=2), _distinct(mass)
    if not distinct.all():
        linear = np.where(distinct[of][pieces.piece, None], linear, pieces.linear(side, own[of]))
    change = np.tile(np.eye(linear.shape[1]), (len(used), 1, 1))
    change[distinct] = integral[distinct, :, None] * np.linalg.inv(mass[distinct])
    weights: FloatArray = np.einsum("qij,qj->qi", change[of][pieces.piece], linear)
    return weights


def _places(pieces: Pieces, side: int, facets: IntArray, start: IntArray) -> tuple[FloatArray, FloatArray]:
    """Vertices of facets, and these with those outside of all patches moved to their rim, (f, v, d) each.

    Facets that are hardly convex then keep theirs. ``start`` has a piece of each facet.
    """
    cover = pieces.cover(side)
    vertices = cover.vertices[facets]
    outside, rim = pieces.to_rim(side)
    own, places = cover.world[vertices], cover.world.copy()
    places[outside] = rim
    moved = places[vertices]
    patch = pieces.on[start]
    spanned = _spanned(pieces.planes.flat(moved, patch)) * np.sign(_spanned(pieces.planes.flat(own, patch)))
    convex = spanned.min(axis=1) > SHAPELY * spanned.max(axis=1)
    return own, np.where(convex[:, None, None], moved, own)


def _spanned(corners_at: FloatArray) -> FloatArray:
    """Twice the signed area of the triangle at each corner of facets; of lines their length, (f, v)."""
    ahead = np.roll(corners_at, -1, axis=1) - corners_at
    if corners_at.shape[2] == 1:
        length: FloatArray = ahead[:, :1, 0]
        return length
    behind = np.roll(corners_at, 1, axis=1) - corners_at
    area: FloatArray = ahead[:, :, 0] * behind[:, :, 1] - ahead[:, :, 1] * behind[:, :, 0]
    return area


def _distinct(mass: FloatArray) -> np.ndarray:
    """Whether functions of matrices ∫ L_i L_j, (f, v, v), are positive in the mean and told apart, (f,)."""
    integral = mass.sum(axis=2)
    positive = np.isfinite(mass).all(axis=(1, 2)) & (integral > 0).all(axis=1)
    size = np.sqrt(np.where(positive[:, None], integral, 1.0))
    scaled = np.where(positive[:, None, None], mass, 0.0) / (size[:, :, None] * size[:, None])
    distinct: np.ndarray = np.linalg.eigvalsh(scaled)[:, 0] >= DISTINCT
    return distinct


def _contacts(pieces: Pieces, side: int, share: FloatArray) -> tuple[IntArray, IntArray]:
    """The contact that each vertex of facets gives its shares of the area to, (m, v), and joints of contacts.

    That is its own one, but the nearest of the joint where hardly any of its support lies in the patches.
    Contacts are numbered joint by joint.

    Parameters
    ----------
    pieces : Of the joints. side : Whose vertices.
    share : Area of each vertex in the pieces, shape (m, v) [m²; m in 2D].
    """
    cover, vertices = pieces.cover(side), pieces.vertices(side)
    used, at = np.unique(vertices, return_inverse=True)
    at = at.reshape(vertices.shape)
    joint = cover.joint[used]
    area = np.bincount(at.ravel(), share.ravel())
    facet, start = np.unique(pieces.facets[:, side], return_index=True)
    size = np.broadcast_to(cover.areas(facet)[:, None] / vertices.shape[1], at[start].shape)
    support = np.bincount(at[start].ravel(), size.ravel())
    greatest = np.full(len(pieces.joints), -np.inf)
    np.maximum.at(greatest, joint, area)
    kept = area >= LEAST * np.minimum(support, greatest[joint])
    if kept.all():
        return at, joint
    to = np.cumsum(kept) - 1
    to[~kept] = to[kept][_nearest(cover.own[used], joint, kept)]
    return to[at], joint[kept]


def _nearest(places: FloatArray, joint: IntArray, kept: np.ndarray) -> IntArray:
    """Of each vertex that is not kept the nearest one of its joint that is, as a number among these.

    Parameters
    ----------
    places : Of the vertices, shape (n, d) [m]. joint : Theirs, ascending, shape (n,). kept : Which are kept.
    """
    lost, left = np.flatnonzero(~kept), np.flatnonzero(kept)
    low, high = (np.searchsorted(joint[left], joint[lost], side) for side in ("left", "right"))
    count = high - low
    first = np.cumsum(count) - count
    one = np.repeat(np.arange(len(lost)), count)
    other = np.arange(len(one)) + np.repeat(low - first, count)
    away = np.linalg.norm(places[lost[one]] - places[left[other]], axis=1)
    order = np.lexsort([away, one])  # stable: the first of equally near ones
    found: IntArray = other[order[first]]
    return found
