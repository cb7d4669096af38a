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

References
----------
Wohlmuth, A mortar finite element method using dual spaces for the Lagrange multiplier, SIAM J. Numer. Anal.
38 (2000). Popp, Gitterle, Gee, Wall, A dual mortar approach for 3D finite deformation contact with consistent
linearization, Int. J. Numer. Meth. Engng 83 (2010).
"""

from __future__ import annotations

import math

import numpy as np

from masonry_fem.contact.interpolation import CORNERS_OF, KINDS, weights_at
from masonry_fem.contact.placement import corners
from masonry_fem.contact.placement.gauss import on_pieces
from masonry_fem.contact.placement.parts.patch import Patch, Side
from masonry_fem.contact.placement.parts.rule import Means, Rule, Spots
from masonry_fem.solid.mesh import IntArray
from masonry_fem.solid.pose import FloatArray

LEAST = 1e-2  # of the largest area: a vertex with less gives it to its neighbours
SHAPELY = 1e-2  # a facet's least corner over its largest, by the area that its two edges span
DISTINCT = 5e-2  # least eigenvalue of a facet's ∫ L_i L_j over √(∫ L_i ∫ L_j); 1/9 on a parallelogram
EXACT = 1e-13  # relative error of the integrals on distorted quadrilaterals
ROUNDING = 1e-12
MOST = 16  # Gauss points in a direction

LINEAR = {"line3": "line", "triangle6": "triangle", "quad9": "quad"}
DEGREE = {
    "line": 1,
    "triangle": 1,
    "quad": 2,
    "line3": 2,
    "triangle6": 2,
    "quad9": 4,
}  # of polynomials in (x, y)


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
    placed, weight, _, rows = on_pieces(patch, (True, True), 1, _order(patch))
    vertices = [_vertices(side, rows[:, number]) for number, side in enumerate(patch.sides)]
    finer = int(len(np.unique(vertices[1])) > len(np.unique(vertices[0])))
    # of each piece the points follow one another
    first = np.flatnonzero(np.append(True, (rows[1:] != rows[:-1]).any(axis=1)))
    share = weight[:, None] * _dual(patch, finer, rows[:, finer], first, placed, weight)
    contact = _contacts(patch.sides[finer], vertices[finer], share)
    area = np.bincount(contact.ravel(), share.ravel())
    moment = [np.bincount(contact.ravel(), (share * along[:, None]).ravel()) for along in placed.T]
    means = []
    for number, side in enumerate(patch.sides):
        if side.mesh is not None:
            values = _functions(patch, number, rows[:, number], placed)
            product = np.add.reduceat(share[:, :, None] * values[:, None], first) / area[contact[first], None]
            nodes = side.mesh.facets[side.facets.facets[rows[first, number]]]
            shape = product.shape
            row = np.broadcast_to(2 * contact[first][:, :, None] + number, shape).ravel()
            means.append((row, np.broadcast_to(nodes[:, None], shape).ravel(), product.ravel()))
    joined = Means(*(np.concatenate(parts) for parts in zip(*means, strict=True)))
    return Spots(patch, np.stack(moment, axis=1) / area[:, None], area, np.full((len(area), 2), -1), joined)


def _order(patch: Patch) -> int:
    """Gauss points in a direction that integrate the products of the functions of both sides.

    On a quadrilateral that is no parallelogram these are polynomials in its own coordinates only: where its
    Jacobian varies by ±r they have poles, by which n Gauss points miss ρ^(−2n) with ρ = 1/r + √(1/r² − 1).
    """
    meshed = [(number, side.mesh.facet) for number, side in enumerate(patch.sides) if side.mesh]
    weights = max(DEGREE[LINEAR.get(kind, kind)] for _, kind in meshed)
    order = (weights + max(DEGREE[kind] for _, kind in meshed) + 3) // 2
    varies = max(patch.sides[number].facets.distortion for number, _ in meshed)
    if varies >= 1:
        return MOST
    if varies > ROUNDING:
        base = 1 / varies + math.sqrt(1 / varies**2 - 1)
        order = max(order, math.ceil(-math.log(EXACT) / (2 * math.log(base))))
    return min(order, MOST)


def _vertices(side: Side, rows: IntArray) -> IntArray:
    """Vertices of one side's facets, rows of the nodes of its face, (m, v); none on an unmeshed side."""
    if side.mesh is None:
        return np.empty((len(rows), 0), dtype=np.int64)
    return side.facets.rows[rows, : CORNERS_OF[side.mesh.facet]]


def _functions(patch: Patch, number: int, rows: IntArray, at: FloatArray) -> FloatArray:
    """Shape functions of one side's facets at plane points, (m, n)."""
    side = patch.sides[number]
    assert side.mesh is not None
    nodes = patch.flat(number, side.facets.points)[side.facets.rows]
    found: FloatArray = weights_at(KINDS[side.mesh.facet], nodes[rows], at)
    return found


def _dual(
    patch: Patch, number: int, rows: IntArray, first: IntArray, at: FloatArray, weight: FloatArray
) -> FloatArray:
    """Weights of vertices at the points, (m, v): ∫ ψ_i L_j = δ_ij ∫ L_i, or N_i where it cannot be."""
    mesh = patch.sides[number].mesh
    assert mesh is not None
    used, facet = np.unique(rows, return_inverse=True)
    own, moved = _places(patch, number, used)
    kind = KINDS[LINEAR.get(mesh.facet, mesh.facet)]
    linear = weights_at(kind, moved[facet], at)
    products = np.add.reduceat((weight[:, None] * linear)[:, :, None] * linear[:, None], first)
    mass = np.zeros((len(used), *products.shape[1:]))
    np.add.at(mass, facet[first], products)
    integral, distinct = mass.sum(axis=2), _distinct(mass)
    if not distinct.all():
        linear = np.where(distinct[facet, None], linear, weights_at(kind, own[facet], at))
    change = np.tile(np.eye(linear.shape[1]), (len(used), 1, 1))
    change[distinct] = integral[distinct, :, None] * np.linalg.inv(mass[distinct])
    weights: FloatArray = np.einsum("mij,mj->mi", change[facet], linear)
    return weights


def _places(patch: Patch, number: int, rows: IntArray) -> tuple[FloatArray, FloatArray]:
    """Vertices of facets, and these with those outside of the interface moved to its rim, (f, v, d - 1) each.

    Facets that are hardly convex then keep theirs.
    """
    side = patch.sides[number]
    vertices = _vertices(side, rows)
    places = patch.flat(number, side.facets.points)
    moved = places.copy()
    outside = np.setdiff1d(vertices, np.flatnonzero(patch.holds(places)))
    if len(outside):
        moved[outside] = patch.nearest(places[outside])
    own, moved = places[vertices], moved[vertices]
    spanned = _spanned(moved) * np.sign(_spanned(own))
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


def _contacts(side: Side, vertices: IntArray, share: FloatArray) -> IntArray:
    """The contact that each vertex of facets gives its shares of the area to, shape (m, v).

    That is its own one, but the nearest where hardly any of its support lies in the interface.
    """
    used, at = np.unique(vertices, return_inverse=True)
    at = at.reshape(vertices.shape)
    area = np.bincount(at.ravel(), share.ravel())
    kept = area >= LEAST * area.max()
    if kept.all():
        return at
    places = side.facets.points[used]
    to = np.cumsum(kept) - 1
    for lost in np.flatnonzero(~kept):
        to[lost] = np.linalg.norm(places[kept] - places[lost], axis=1).argmin()
    return to[at]
