"""Weighted: contacts that are means over the interface, with weights that follow the finer of the two meshes.

Contact i belongs to a vertex of the finer side s. With its weight ψ_i on the interface Γ, Σ_i ψ_i = 1,

    a_i = ∫_Γ ψ_i dΓ,        v_i = (1/a_i) ∫_Γ ψ_i (u_s − u_m) dΓ

so that a uniform traction t gives both meshes its exact consistent forces with impulses p_i = h a_i t,
whatever the two meshes. This is the mortar method of contact mechanics, integrated on segments: the common
part of a facet of each side and the polygon. On facets of second order the shape functions N_i of the
vertices are the linear ones, as the quadratic ones of a triangle's vertices integrate to zero.

The weights are dual, ∫ ψ_i L_j = δ_ij ∫ L_i, to the linear functions L_i of the vertices, of which those
outside of the interface are moved to its rim: of linear elements the mean of u_s is that at the vertex, or at
the rim. So joints bear up to their rims, and linear meshes that match have the contacts of ``nodes``. With
weights from vertices outside there are more contacts along a cut than what both meshes can do there tells
apart, and Newton's method takes 200 steps on a wall that takes 9. A facet of which the moved vertices make
nothing useful, as where a corner of the interface pokes into it, keeps its own, and ψ_i = N_i there. A vertex
that hardly reaches into the interface gives its weight to the nearest.

On round faces Γ is all patches that the two have in common: weights reach over the edges between facets of
either side, and the frame of a contact has the mean of the normals about it. Facets that do not coincide are
apart and overlap by themselves, by e²/8R, which is far more than stone gives way. So the gap of a contact is
the mean of what faces have between them that are as round as their facets turn.

References
----------
Wohlmuth, A mortar finite element method using dual spaces for the Lagrange multiplier, SIAM J. Numer. Anal.
38 (2000). Popp, Gitterle, Gee, Wall, A dual mortar approach for 3D finite deformation contact with consistent
linearization, Int. J. Numer. Meth. Engng 83 (2010).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from masonry_fem.contact.contacts import local_frames
from masonry_fem.contact.interpolation import CORNERS_OF
from masonry_fem.contact.placement import corners
from masonry_fem.contact.placement.parts.patch import Patch
from masonry_fem.contact.placement.parts.pieces import Pieces
from masonry_fem.contact.placement.parts.rule import Means, Round, Rule, Spots
from masonry_fem.solid.mesh import IntArray
from masonry_fem.solid.pose import FloatArray

LEAST = 1e-2  # of its support: a vertex with less of it in the interface gives its area to its neighbours
SHAPELY = 1e-2  # a facet's least corner over its largest, by the area that its two edges span
DISTINCT = 5e-2  # least eigenvalue of a facet's ∫ L_i L_j over √(∫ L_i ∫ L_j); 1/9 on a parallelogram


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
    if patch.degenerate or not any(side.mesh for side in patch.sides):
        return corners.points(patch, Rule())
    return on_pieces(Pieces.of([patch]))


def together(patches: Sequence[Patch], rule: Rule) -> list[Spots]:
    """The same on two round faces: supports reach over the edges between their facets.

    Parameters
    ----------
    patches : The patches that the faces have in common, of some area, with the same candidate.
    rule : Not used: this rule has no parameters.

    Returns
    -------
    Contacts in one on all patches; where no side is meshed corners, patch by patch.

    Raises
    ------
    GeometryError : Mesh facets do not cover a patch.
    """
    if not any(side.mesh for side in patches[0].sides):
        return [corners.points(patch, Rule()) for patch in patches]
    return [on_pieces(Pieces.of(patches))]


def on_pieces(pieces: Pieces) -> Spots:
    """The weighted contacts of one patch, or of those that two round faces have in common.

    Parameters
    ----------
    pieces : Of the patches, at least one side meshed.
    """
    vertices = [pieces.vertices(side) for side in (0, 1)]
    finer = int(len(np.unique(vertices[1])) > len(np.unique(vertices[0])))
    share = pieces.weight[:, None] * _dual(pieces, finer)
    contact = _contacts(pieces, finer, vertices[finer], share)
    area = np.bincount(contact.ravel(), share.ravel())
    first = pieces.first
    means = []
    for side in (0, 1):
        mesh = pieces.mesh(side)
        if mesh is not None:
            product = np.add.reduceat(share[:, :, None] * pieces.functions(side)[:, None], first)
            product /= area[contact[first], None]
            nodes = mesh.facets[pieces.facets[first, side]]
            shape = product.shape
            row = np.broadcast_to(2 * contact[first][:, :, None] + side, shape).ravel()
            means.append((row, np.broadcast_to(nodes[:, None], shape).ravel(), product.ravel()))
    joined = Means(*(np.concatenate(parts) for parts in zip(*means, strict=True)))

    def mean(values: FloatArray) -> FloatArray:
        """Of what points have, (q, ...), over the parts of contacts, (c, ...)."""
        columns = values.reshape(len(values), -1).T
        sums = [np.bincount(contact.ravel(), (share * column[:, None]).ravel()) for column in columns]
        return (np.stack(sums, axis=1) / area[:, None]).reshape(len(area), *values.shape[1:])

    none = np.full((len(area), 2), -1)
    found = Spots(pieces.patches[0], mean(pieces.at), area, none, joined)
    if len(pieces.patches) == 1:
        return found
    return replace(found, round=_round(pieces, mean, _fullest(pieces, contact, share)))


def _round(pieces: Pieces, mean: Callable[[FloatArray], FloatArray], patch: IntArray) -> Round:
    """Where contacts on a round face are, from means over their parts."""
    normal = mean(pieces.frame[pieces.patch, 0])
    bulge = pieces.bulge(0) + pieces.bulge(1)
    return Round(
        patch=patch,
        frame=local_frames(normal / np.linalg.norm(normal, axis=1)[:, None]),
        points=np.stack([mean(pieces.on_side(side)) for side in (0, 1)], axis=1),
        bulge=mean(bulge),
        rise=float(bulge.max()),
    )


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
    used, start, facet = np.unique(pieces.facets[:, side], return_index=True, return_inverse=True)
    own, moved = _places(pieces, side, used, start)
    linear = pieces.linear(side, moved[facet])
    products = np.add.reduceat((pieces.weight[:, None] * linear)[:, :, None] * linear[:, None], pieces.first)
    mass = np.zeros((len(used), *products.shape[1:]))
    np.add.at(mass, facet[pieces.first], products)
    integral, distinct = mass.sum(axis=2), _distinct(mass)
    if not distinct.all():
        linear = np.where(distinct[facet, None], linear, pieces.linear(side, own[facet]))
    change = np.tile(np.eye(linear.shape[1]), (len(used), 1, 1))
    change[distinct] = integral[distinct, :, None] * np.linalg.inv(mass[distinct])
    weights: FloatArray = np.einsum("qij,qj->qi", change[facet], linear)
    return weights


def _places(pieces: Pieces, side: int, facets: IntArray, start: IntArray) -> tuple[FloatArray, FloatArray]:
    """Vertices of facets, and these with those outside of all patches moved to their rim, (f, v, d) each.

    Facets that are hardly convex then keep theirs. ``start`` has a point of each facet.
    """
    places = pieces.nodes(side)
    mesh = pieces.mesh(side)
    assert mesh is not None
    vertices = mesh.facets[facets, : CORNERS_OF[mesh.facet]]
    outside, rim = pieces.to_rim(side)
    own = places[vertices]
    places[outside] = rim
    moved = places[vertices]
    patch = pieces.patch[start]
    spanned = _spanned(pieces.flat(moved, patch)) * np.sign(_spanned(pieces.flat(own, patch)))
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


def _contacts(pieces: Pieces, side: int, vertices: IntArray, share: FloatArray) -> IntArray:
    """The contact that each vertex of facets gives its shares of the area to, shape (q, v).

    That is its own one, but the nearest where hardly any of its support lies in the patches.
    """
    mesh = pieces.mesh(side)
    assert mesh is not None
    used, at = np.unique(vertices, return_inverse=True)
    at = at.reshape(vertices.shape)
    area = np.bincount(at.ravel(), share.ravel())
    facet, start = np.unique(pieces.facets[:, side], return_index=True)
    size = np.broadcast_to(pieces.sizes(side)[facet, None] / vertices.shape[1], at[start].shape)
    support = np.bincount(at[start].ravel(), size.ravel())
    kept = area >= LEAST * np.minimum(support, area.max())
    if kept.all():
        return at
    places = mesh.points[used]
    to = np.cumsum(kept) - 1
    to[~kept] = np.linalg.norm(places[~kept, None] - places[kept], axis=2).argmin(axis=1)
    return to[at]
