"""Pieces: the common parts of the facets of two faces at many joints, with points to integrate over them.

    for numbers, pieces in batches(joints):
        pieces.functions(0)  # shape functions of the candidates at the points

A joint is one patch, or all that two round faces have in common: these are flat facet by facet, and each pair
of facets that look at each other is a patch of its own plane. Facets and nodes are numbered as in ``Cover``:
what patches of a joint share has one number.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from masonry_fem.contact.contacts import height
from masonry_fem.contact.interpolation import KINDS, weights_on
from masonry_fem.contact.placement.parts.cover import Cover, Joint
from masonry_fem.contact.placement.parts.cuts import gauss_planes
from masonry_fem.contact.placement.parts.patch import TOLERANCE, Patch
from masonry_fem.contact.placement.parts.planes import Planes
from masonry_fem.contact.placement.parts.quadrature import gauss_rule, triangle_rule
from masonry_fem.contact.smooth import curvatures
from masonry_fem.errors import GeometryError
from masonry_fem.solid.mesh import IntArray
from masonry_fem.solid.pose import FloatArray

EXACT = 1e-13  # relative error of the integrals on distorted quadrilaterals
ROUNDING = 1e-12
MOST = 16  # Gauss points in a direction
COVERED = 0.01  # of a patch: what facets may leave uncovered
TOGETHER = 1 << 17  # points in a batch of joints, about: memory

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
    """q points on m pieces of k patches of J joints, whose meshes have facets of the same kinds.

    Attributes
    ----------
    joints : The joints; patches of one have the same candidate and antagonist.
    patches : Their patches, joint by joint.
    joint : Joint of each patch, shape (k,).
    covers : Facets of candidates and antagonists there; None on a side without meshes.
    planes : Of the patches.
    patch : Patch of each point, shape (q,).
    at : The points in its plane, shape (q, d - 1) [m].
    weight : Their weights, which sum to the areas of the patches, shape (q,).
    piece : Piece of each point, shape (q,).
    first : First point of each piece, shape (m,); the points of a piece follow one another.
    on : Patch of each piece, shape (m,).
    facets : Its facets of candidate and antagonist, rows of the covers, −1 without a mesh, shape (m, 2).
    known : What ``functions`` gave, by side.
    """

    joints: Sequence[Joint]
    patches: Sequence[Patch]
    joint: IntArray
    covers: tuple[Cover | None, Cover | None]
    planes: Planes
    patch: IntArray
    at: FloatArray
    weight: FloatArray
    piece: IntArray
    first: IntArray
    on: IntArray
    facets: IntArray
    known: dict[int, FloatArray]

    @classmethod
    def of(cls, joints: Sequence[Joint], order: int) -> Pieces:
        """Points that integrate products of the shape functions of both sides over joints.

        Parameters
        ----------
        joints : Whose meshes have facets of the same kinds, and all one patch or all several.
        order : Gauss points in a direction, of ``order_of``.

        Raises
        ------
        GeometryError : Mesh facets do not cover a patch.
        """
        patches = [patch for joint in joints for patch in joint]
        planes = Planes.of(patches)
        one, other = (
            Cover.of(joints, side) if joints[0][0].sides[side].mesh is not None else None for side in (0, 1)
        )
        none = np.empty((0, 2, planes.origin.shape[1])), np.full((len(patches), 2), -1)
        corners, ranges = zip(
            *(none if own is None else (own.world[own.vertices], own.of_patch) for own in (one, other)),
            strict=True,
        )
        rules = gauss_rule(order), triangle_rule(order)
        patch, at, weight, facets = gauss_planes(planes, corners, ranges, rules, True)
        key = np.column_stack([patch, facets])
        starts = np.append(True, (key[1:] != key[:-1]).any(axis=1))
        first = np.flatnonzero(starts)
        return cls(
            joints=joints,
            patches=patches,
            joint=np.repeat(np.arange(len(joints)), [len(joint) for joint in joints]),
            covers=(one, other),
            planes=planes,
            patch=patch,
            at=at,
            weight=weight * covering(patches, patch, weight)[patch],
            piece=np.cumsum(starts) - 1,
            first=first,
            on=patch[first],
            facets=facets[first],
            known={},
        )

    def only(self, chosen: np.ndarray) -> Pieces:
        """The same with the pieces of some joints alone; joints and covers keep their numbers.

        Parameters
        ----------
        chosen : Which joints, shape (J,).
        """
        if chosen.all():
            return self
        pieces = chosen[self.joint[self.on]]
        points = pieces[self.piece]
        piece = (np.cumsum(pieces) - 1)[self.piece[points]]
        return replace(
            self,
            patch=self.patch[points],
            at=self.at[points],
            weight=self.weight[points],
            piece=piece,
            first=np.flatnonzero(np.diff(piece, prepend=-1)),
            on=self.on[pieces],
            facets=self.facets[pieces],
            known={side: values[points] for side, values in self.known.items()},
        )

    @property
    def area(self) -> FloatArray:
        """Of the joints [m²; m in 2D], shape (J,)."""
        return np.bincount(self.joint[self.patch], self.weight, len(self.joints))

    def cover(self, side: int) -> Cover:
        """The facets of one side, which has meshes."""
        cover = self.covers[side]
        assert cover is not None
        return cover

    def vertices(self, side: int) -> IntArray:
        """Vertices of one side's facets on the pieces, shape (m, v)."""
        return self.cover(side).vertices[self.facets[:, side]]

    def many(self, side: int) -> IntArray:
        """How many vertices of one side have facets that reach into each joint, shape (J,)."""
        cover, reached = self.covers[side], np.zeros(len(self.joints), dtype=np.int64)
        if cover is None:
            return reached
        used = np.zeros(len(cover.node), dtype=bool)
        used[self.vertices(side)] = True
        return np.bincount(cover.joint[used], minlength=len(self.joints))

    def functions(self, side: int) -> FloatArray:
        """Shape functions of one side's facets at the points, shape (q, nodes of a facet)."""
        if side not in self.known:
            cover = self.cover(side)
            nodes = self.planes.flat(cover.world[cover.rows[self.facets[:, side]]], self.on)
            self.known[side] = weights_on(KINDS[cover.kind], nodes, self.piece, self.at)
        return self.known[side]

    def means(self, contact: IntArray, share: FloatArray) -> tuple[IntArray, IntArray, FloatArray]:
        """How meshed sides carry contacts: rows, nodes and weights of ``Means``, piece by piece, (m, w) each.

        Parameters
        ----------
        contact : Those that each piece is a part of, shape (m, v).
        share : Of these in the points' weights, which sums to one over the points of a contact, (q, v).
        """
        found: list[tuple[IntArray, IntArray, FloatArray]] = []
        for side, cover in enumerate(self.covers):
            if cover is not None:
                product = np.add.reduceat(share[:, :, None] * self.functions(side)[:, None], self.first)
                nodes = cover.node[cover.rows[self.facets[:, side]]]
                row = np.broadcast_to(2 * contact[:, :, None] + side, product.shape)
                node = np.broadcast_to(nodes[:, None], product.shape)
                m = len(product)
                found.append((row.reshape(m, -1), node.reshape(m, -1), product.reshape(m, -1)))
        row, node, weight = (np.concatenate(parts, axis=1) for parts in zip(*found, strict=True))
        return row, node, weight

    def borne(self, side: int) -> FloatArray:
        """∫ N over the patches for each node of each of one side's facets, (f, n) [m²; m in 2D]."""
        rows = self.cover(side).rows
        share = np.add.reduceat(self.weight[:, None] * self.functions(side), self.first)
        place = self.facets[:, side, None] * rows.shape[1] + np.arange(rows.shape[1])
        return np.bincount(place.ravel(), share.ravel(), rows.size).reshape(rows.shape)

    def linear(self, side: int, vertices: FloatArray) -> FloatArray:
        """Linear functions of facets with given vertices at the points, shape (q, v).

        Parameters
        ----------
        side : Whose facets.
        vertices : Of the facet of each piece, world coordinates, shape (m, v, d) [m].
        """
        kind = self.cover(side).kind
        found: FloatArray = weights_on(
            KINDS[LINEAR.get(kind, kind)], self.planes.flat(vertices, self.on), self.piece, self.at
        )
        return found

    def on_side(self, side: int) -> FloatArray:
        """The points projected to one side's facets, world coordinates, shape (q, d) [m]."""
        cover = self.covers[side]
        if cover is not None:
            nodes = cover.world[cover.rows[self.facets[:, side]]][self.piece]
            on_mesh: FloatArray = np.einsum("qn,qnd->qd", self.functions(side), nodes)
            return on_mesh
        own = [patch.sides[side] for patch in self.patches]
        corner = np.array(
            [
                one.pose.to_world(one.surface.solid.vertices[one.surface.solid.faces[one.face][0]])
                for one in own
            ]
        )
        outward = np.array([one.surface.normals[one.face] @ one.pose.rotation.T for one in own])
        middle = self.planes.origin[self.patch] + np.einsum(
            "qp,qpd->qd", self.at, self.planes.frame[self.patch, 1:]
        )
        normal = self.planes.frame[self.patch, 0]
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
        cover = self.covers[side]
        if cover is None or cover.kind in LINEAR:
            return np.zeros(len(self.weight))
        vertices = self.vertices(side)
        turning = self._turning(side)[self.piece]
        shares = self.linear(side, cover.world[vertices])
        at = cover.own[vertices]
        at = (at - at.mean(axis=1, keepdims=True))[self.piece]
        here = np.einsum("qv,qvd->qd", shares, at)
        square = np.einsum("qv,qvd,qde,qve->q", shares, at, turning, at)
        found: FloatArray = 0.5 * (square - np.einsum("qd,qde,qe->q", here, turning, here))
        return found

    def _turning(self, side: int) -> FloatArray:
        """How normals turn along one side's facet of each piece, in the shapes' frames, (m, d, d) [1/m]."""
        surfaces = [joint[0].sides[side].surface for joint in self.joints]
        kinds = {id(surface): surface for surface in surfaces}
        of = np.array([id(surface) for surface in surfaces])[self.joint[self.on]]
        facets = self.cover(side).facet[self.facets[:, side]]
        d = self.planes.origin.shape[1]
        turning = np.zeros((len(facets), d, d))
        for key, surface in kinds.items():
            own = np.flatnonzero(of == key)
            if len(own) and surface.mesh is not None:
                used, place = np.unique(facets[own], return_inverse=True)
                turning[own] = curvatures(surface.mesh, used, surface.smooth)[place]
        return turning

    def to_rim(self, side: int) -> tuple[IntArray, FloatArray]:
        """Vertices of one side outside of all patches of their joint, and the nearest points of these.

        Parameters
        ----------
        side : Whose vertices.

        Returns
        -------
        Rows of the cover (n,) and world coordinates (n, d) [m].
        """
        nodes = self.cover(side).world
        key = np.unique(self.on[:, None] * len(nodes) + self.vertices(side))
        patch, node = key // len(nodes), key % len(nodes)
        away = nodes[node] - self.planes.origin[patch]
        at = np.einsum("nd,npd->np", away, self.planes.frame[patch, 1:])
        height = np.einsum("nd,nd->n", away, self.planes.frame[patch, 0])
        polygon = self.planes.polygon[patch]
        nearest, far = _nearest(polygon, at)
        inside = np.zeros(len(nodes), dtype=bool)
        inside[node[far <= TOLERANCE * self.planes.size[patch]]] = True
        out = np.flatnonzero(~inside[node])
        out = out[np.lexsort([far[out], node[out]])]  # of each node the nearest patch first
        out = out[np.unique(node[out], return_index=True)[1]]
        world = self.planes.origin[patch[out]] + height[out, None] * self.planes.frame[patch[out], 0]
        return node[out], world + np.einsum("np,npd->nd", nearest[out], self.planes.frame[patch[out], 1:])


def batches(joints: Sequence[Joint]) -> Iterator[tuple[IntArray, Pieces]]:
    """Joints of one kind together, no more at once than memory should hold: their numbers, and their pieces.

    Parameters
    ----------
    joints : Each with a mesh on at least one side.

    Raises
    ------
    GeometryError : Mesh facets do not cover a patch.
    """
    orders = [order_of(joint) for joint in joints]
    for numbers in alike(joints, orders):
        yield numbers, Pieces.of([joints[number] for number in numbers], orders[numbers[0]])


def alike(joints: Sequence[Joint], orders: Sequence[int]) -> list[IntArray]:
    """Numbers of joints whose meshes have facets of the same kinds, by as many as memory should hold.

    Parameters
    ----------
    joints : One patch or several each. orders : Gauss points in a direction on each.
    """
    kinds: dict[object, list[int]] = {}
    for number, (joint, order) in enumerate(zip(joints, orders, strict=True)):
        both = [side.mesh.facet if side.mesh else "" for side in joint[0].sides]
        kinds.setdefault((*both, order, len(joint) > 1), []).append(number)
    found: list[IntArray] = []
    for rows in kinds.values():
        each = orders[rows[0]] ** (joints[rows[0]][0].frame.shape[0] - 1)
        batch = np.cumsum([each * _facets(joints[row]) for row in rows]) // TOGETHER
        found += np.split(np.array(rows), np.flatnonzero(np.diff(batch)) + 1)
    return found


def _facets(joint: Joint) -> int:
    """Mesh facets of both sides of a joint."""
    return sum(
        len(side.surface.face_meshes[side.face].facets)
        for patch in joint
        for side in patch.sides
        if side.mesh is not None
    )


def order_of(patches: Joint) -> int:
    """Gauss points in a direction that integrate the products of the functions of both sides.

    On a quadrilateral that is no parallelogram these are polynomials in its own coordinates only: where its
    Jacobian varies by ±r they have poles, by which n Gauss points miss ρ^(−2n) with ρ = 1/r + √(1/r² − 1).
    """
    sides = patches[0].sides
    meshed = [(number, side.mesh.facet) for number, side in enumerate(sides) if side.mesh]
    weights = max(DEGREE[LINEAR.get(kind, kind)] for _, kind in meshed)
    order = (weights + max(DEGREE[kind] for _, kind in meshed) + 3) // 2
    varies = max(patch.sides[number].facets.distortion for number, _ in meshed for patch in patches)
    if varies >= 1:
        return MOST
    if varies > ROUNDING:
        base = 1 / varies + math.sqrt(1 / varies**2 - 1)
        order = max(order, math.ceil(-math.log(EXACT) / (2 * math.log(base))))
    return min(order, MOST)


def covering(patches: Sequence[Patch], patch: IntArray, weight: FloatArray) -> FloatArray:
    """By what to multiply weights so that they sum to the areas of patches, (k,).

    Parameters
    ----------
    patches : The patches. patch : That of each point, shape (q,). weight : Of the points, shape (q,).

    Raises
    ------
    GeometryError : They miss more than a hundredth of a patch.
    """
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
