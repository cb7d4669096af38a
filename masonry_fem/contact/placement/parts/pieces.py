"""Pieces: the common parts of the facets of two faces, with points to integrate over them.

    pieces = Pieces.of(patches)             # of all patches that two round faces have in common, or of one
    pieces.functions(0, facets, nodes)      # shape functions of the candidate at the points

A round face is flat facet by facet, and each pair of facets that look at each other is a patch of its own
plane. Facets, nodes and vertices are numbered through the mesh: what patches share has one number.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from masonry_fem.contact.contacts import height
from masonry_fem.contact.interpolation import CORNERS_OF, KINDS, weights_at
from masonry_fem.contact.placement.parts.cuts import gauss_planes
from masonry_fem.contact.placement.parts.patch import TOLERANCE, Patch, Side
from masonry_fem.contact.placement.parts.quadrature import gauss_lines
from masonry_fem.contact.smooth import curvatures
from masonry_fem.errors import GeometryError
from masonry_fem.solid.mesh import IntArray, Mesh
from masonry_fem.solid.pose import FloatArray

EXACT = 1e-13  # relative error of the integrals on distorted quadrilaterals
ROUNDING = 1e-12
MOST = 16  # Gauss points in a direction
COVERED = 0.01  # of a patch: what facets may leave uncovered

LINEAR = {"line3": "line", "triangle6": "triangle", "quad9": "quad"}
DEGREE = {
    "line": 1,
    "triangle": 1,
    "quad": 2,
    "line3": 2,
    "triangle6": 2,
    "quad9": 4,
}  # of polynomials in (x, y)


@dataclass(frozen=True, slots=True)
class Pieces:
    """q points on m pieces of k patches between the same two blocks.

    Attributes
    ----------
    patches : The patches, all with the same candidate and antagonist.
    frame, origin : Of the planes of the patches, shapes (k, d, d) and (k, d).
    polygon : Their corners in these planes, padded with the last, shape (k, n, d - 1) [m].
    patch : Patch of each point, shape (q,).
    at : The points in its plane, shape (q, d - 1) [m].
    weight : Their weights, which sum to the areas of the patches, shape (q,).
    facets : Mesh facets of candidate and antagonist at the points, −1 on a side without a mesh, shape (q, 2).
    first : First point of each piece, shape (m,); the points of a piece follow one another.
    """

    patches: Sequence[Patch]
    frame: FloatArray
    origin: FloatArray
    polygon: FloatArray
    patch: IntArray
    at: FloatArray
    weight: FloatArray
    facets: IntArray
    first: IntArray

    @classmethod
    def of(cls, patches: Sequence[Patch]) -> Pieces:
        """Points that integrate products of the shape functions of both sides over patches.

        Raises
        ------
        GeometryError : Mesh facets do not cover a patch.
        """
        frame = np.array([patch.frame for patch in patches])
        origin = np.array([patch.origin for patch in patches])
        count = np.array([len(patch.polygon) for patch in patches])
        padded = np.concatenate([patch.polygon for patch in patches])
        last = np.cumsum(count)[:, None]
        polygon = padded[np.minimum(last - count[:, None] + np.arange(count.max()), last - 1)]
        rows, corners = [], []
        for number in (0, 1):
            rows.append(_facets_of(patches, number))
            corners.append(_corners(patches[0].sides[number], rows[number][0]))
        ranges, order = [one[1] for one in rows], _order(patches)
        if polygon.shape[2] == 1:
            made = gauss_lines(polygon, origin, frame[:, 1], corners, ranges, order)
        else:
            made = gauss_planes(polygon, count, origin, frame[:, 1:], corners, ranges, order)
        patch, at, weight, facet = made
        facets = np.stack(
            [own[facet[:, number]] if len(own) else facet[:, number] for number, (own, _) in enumerate(rows)],
            axis=1,
        )
        key = np.column_stack([patch, facets])
        first = np.flatnonzero(np.append(True, (key[1:] != key[:-1]).any(axis=1)))
        weight = weight * _share(patches, patch, weight)[patch]
        return cls(patches, frame, origin, polygon, patch, at, weight, facets, first)

    @property
    def area(self) -> float:
        """Of all patches [m²; m in 2D]."""
        return float(self.weight.sum())

    def mesh(self, side: int) -> Mesh | None:
        """Mesh of one side."""
        return self.patches[0].sides[side].mesh

    def vertices(self, side: int) -> IntArray:
        """Vertices of one side's facets at the points, mesh nodes, (q, v); none on an unmeshed side."""
        mesh = self.mesh(side)
        if mesh is None:
            return np.empty((len(self.weight), 0), dtype=np.int64)
        return mesh.facets[self.facets[:, side], : CORNERS_OF[mesh.facet]]

    def nodes(self, side: int) -> FloatArray:
        """World coordinates of the nodes of one side's mesh, shape (n, d) [m]."""
        own = self.patches[0].sides[side]
        assert own.mesh is not None
        return own.pose.to_world(own.mesh.points)

    def flat(self, points: FloatArray, patch: IntArray) -> FloatArray:
        """Coordinates in the planes of patches, shape (m, n, d - 1) [m].

        Parameters
        ----------
        points : World coordinates, shape (m, n, d) [m].
        patch : In the plane of which patch, shape (m,).
        """
        found: FloatArray = np.einsum(
            "mnd,mpd->mnp", points - self.origin[patch, None], self.frame[patch, 1:]
        )
        return found

    def functions(self, side: int) -> FloatArray:
        """Shape functions of one side's facets at the points, shape (q, nodes of a facet)."""
        mesh = self.mesh(side)
        assert mesh is not None
        nodes = self.flat(self.nodes(side)[mesh.facets[self.facets[:, side]]], self.patch)
        found: FloatArray = weights_at(KINDS[mesh.facet], nodes, self.at)
        return found

    def on_side(self, side: int) -> FloatArray:
        """The points projected to one side's facets, world coordinates, shape (q, d) [m]."""
        mesh = self.mesh(side)
        if mesh is not None:
            nodes = self.nodes(side)[mesh.facets[self.facets[:, side]]]
            on_mesh: FloatArray = np.einsum("qn,qnd->qd", self.functions(side), nodes)
            return on_mesh
        own = [patch.sides[side] for patch in self.patches]
        solid, surface = own[0].surface.solid, own[0].surface
        corner = own[0].pose.to_world(solid.vertices[[solid.faces[one.face][0] for one in own]])
        outward = surface.normals[[one.face for one in own]] @ own[0].pose.rotation.T
        middle = self.origin[self.patch] + np.einsum("qp,qpd->qd", self.at, self.frame[self.patch, 1:])
        normal = self.frame[self.patch, 0]
        away = height(middle, normal, corner[self.patch], outward[self.patch])
        on_plane: FloatArray = middle + away[:, None] * normal
        return on_plane

    def bulge(self, side: int) -> FloatArray:
        """How far one side's round face is in front of its facets at the points, shape (q,) [m].

        0 where it has no mesh, and on facets of second order, which are as round as their nodes. Where
        normals turn by dn = S dx, a chord from x_i to x_j misses the face by (x_j − x_i)·S (x_j − x_i) / 8 in
        its middle; with the linear functions L_i of all vertices, x = Σ L_i x_i, that is
        (Σ L_i x_i·S x_i − x·S x) / 2.
        """
        mesh = self.mesh(side)
        if mesh is None or mesh.facet in LINEAR:
            return np.zeros(len(self.weight))
        facets, of = np.unique(self.facets[:, side], return_inverse=True)
        vertices = mesh.facets[facets, : CORNERS_OF[mesh.facet]]
        turning = curvatures(mesh, facets, self.patches[0].sides[side].surface.smooth)[of]
        shares = self.linear(side, self.nodes(side)[vertices][of])
        at = mesh.points[vertices]
        at = (at - at.mean(axis=1, keepdims=True))[of]
        here = np.einsum("qv,qvd->qd", shares, at)
        square = np.einsum("qv,qvd,qde,qve->q", shares, at, turning, at)
        found: FloatArray = 0.5 * (square - np.einsum("qd,qde,qe->q", here, turning, here))
        return found

    def linear(self, side: int, vertices: FloatArray) -> FloatArray:
        """Linear functions of facets with given vertices at the points, shape (q, v).

        Parameters
        ----------
        side : Whose facets.
        vertices : World coordinates, shape (q, v, d) [m].
        """
        mesh = self.mesh(side)
        assert mesh is not None
        kind = KINDS[LINEAR.get(mesh.facet, mesh.facet)]
        found: FloatArray = weights_at(kind, self.flat(vertices, self.patch), self.at)
        return found

    def to_rim(self, side: int) -> tuple[IntArray, FloatArray]:
        """Vertices of one side that lie outside of all patches, and the nearest points of these.

        Parameters
        ----------
        side : Whose vertices.

        Returns
        -------
        Mesh nodes (n,) and world coordinates (n, d) [m].
        """
        nodes = self.nodes(side)
        vertices = self.vertices(side)[self.first]
        pairs = np.stack(np.broadcast_arrays(self.patch[self.first, None], vertices), axis=2).reshape(-1, 2)
        patch, node = np.unique(pairs, axis=0).T
        away = nodes[node] - self.origin[patch]
        at = np.einsum("nd,npd->np", away, self.frame[patch, 1:])
        height = np.einsum("nd,nd->n", away, self.frame[patch, 0])
        polygon = self.polygon[patch]
        nearest, far = _nearest(polygon, at)
        size = np.ptp(polygon, axis=1).max(axis=1)
        inside = np.zeros(len(nodes), dtype=bool)
        inside[node[far <= TOLERANCE * size]] = True
        out = np.flatnonzero(~inside[node])
        out = out[np.lexsort([far[out], node[out]])]  # of each node the nearest patch first
        out = out[np.unique(node[out], return_index=True)[1]]
        world = self.origin[patch[out]] + height[out, None] * self.frame[patch[out], 0]
        return node[out], world + np.einsum("np,npd->nd", nearest[out], self.frame[patch[out], 1:])

    def sizes(self, side: int) -> FloatArray:
        """Areas of all boundary facets of one side's mesh [m²; m in 2D], shape (f,)."""
        own = self.patches[0].sides[side]
        assert own.mesh is not None
        at = own.mesh.points[own.mesh.facets[:, : CORNERS_OF[own.mesh.facet]]]
        if at.shape[2] == 2:
            return np.linalg.norm(at[:, 1] - at[:, 0], axis=1)
        spokes = at[:, 1:] - at[:, :1]
        area: FloatArray = 0.5 * np.linalg.norm(np.cross(spokes[:, :-1], spokes[:, 1:]).sum(axis=1), axis=1)
        return area


def _facets_of(patches: Sequence[Patch], number: int) -> tuple[IntArray, IntArray]:
    """Mesh facets of one side's faces, face by face, and the range of them of each patch, (k, 2).

    None, and empty ranges, where the side has no mesh.
    """
    mesh = patches[0].sides[number].mesh
    if mesh is None:
        return np.empty(0, dtype=np.int64), np.full((len(patches), 2), -1)
    order = np.argsort(mesh.facet_face, kind="stable")
    faces = np.array([patch.sides[number].face for patch in patches])
    sorted_faces = mesh.facet_face[order]
    ranges = [np.searchsorted(sorted_faces, faces, side) for side in ("left", "right")]
    return order, np.stack(ranges, axis=1)


def _corners(side: Side, facets: IntArray) -> FloatArray:
    """World coordinates of the corners of mesh facets, shape (f, v, d) [m]."""
    if side.mesh is None:
        return np.empty((0, 2, len(side.pose.translation)))
    corners = side.mesh.facets[facets, : CORNERS_OF[side.mesh.facet]]
    return np.ascontiguousarray(side.pose.to_world(side.mesh.points[corners]))


def _order(patches: Sequence[Patch]) -> int:
    """Gauss points in a direction that integrate the products of the functions of both sides.

    On a quadrilateral that is no parallelogram these are polynomials in its own coordinates only: where its
    Jacobian varies by ±r they have poles, by which n Gauss points miss ρ^(−2n) with ρ = 1/r + √(1/r² − 1).
    """
    sides = patches[0].sides
    meshed = [(number, side.mesh.facet) for number, side in enumerate(sides) if side.mesh]
    weights = max(DEGREE[LINEAR.get(kind, kind)] for _, kind in meshed)
    order = (weights + max(DEGREE[kind] for _, kind in meshed) + 3) // 2
    faces = {(number, patch.sides[number].face) for number, _ in meshed for patch in patches}
    varies = max(sides[number].surface.face_meshes[face].distortion for number, face in faces)
    if varies >= 1:
        return MOST
    if varies > ROUNDING:
        base = 1 / varies + math.sqrt(1 / varies**2 - 1)
        order = max(order, math.ceil(-math.log(EXACT) / (2 * math.log(base))))
    return min(order, MOST)


def _share(patches: Sequence[Patch], patch: IntArray, weight: FloatArray) -> FloatArray:
    """By what to multiply weights so that they sum to the areas of patches, (k,)."""
    whole = np.array([one.interface.area for one in patches])
    covered = np.bincount(patch, weight, len(patches))
    for k in np.flatnonzero(~(np.abs(covered - whole) <= COVERED * whole))[:1]:
        names = "' and '".join(side.surface.name for side in patches[k].sides)
        raise GeometryError(
            f"shapes '{names}', faces {patches[k].interface.faces}: their mesh facets cover {covered[k]:.6g} "
            f"of an interface of {whole[k]:.6g}; expected all of it; mesh the shapes again"
        )
    return whole / covered


def _nearest(polygon: FloatArray, at: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Nearest points of convex polygons (n, c, p) to points (n, p), and how far they are; 0 inside."""
    if at.shape[1] == 1:
        nearest = np.clip(at, polygon.min(axis=1), polygon.max(axis=1))
        return nearest, np.abs(at - nearest)[:, 0]
    along = np.roll(polygon, -1, axis=1) - polygon
    square = (along**2).sum(axis=2)
    away = at[:, None] - polygon
    share = np.einsum("ncp,ncp->nc", away, along) / np.where(square > 0, square, 1.0)
    feet = polygon + np.clip(share, 0.0, 1.0)[:, :, None] * along
    distance = np.linalg.norm(at[:, None] - feet, axis=2)
    rows, best = np.arange(len(at)), distance.argmin(axis=1)
    left = along[:, :, 0] * away[:, :, 1] - along[:, :, 1] * away[:, :, 0]
    inside = ((left >= 0) | (square == 0)).all(axis=1)
    return (
        np.where(inside[:, None], at, feet[rows, best]),
        np.where(inside, 0.0, distance[rows, best]),
    )
