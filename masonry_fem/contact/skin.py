"""Skin: the boundaries of all blocks as arrays over their nodes, wherever the blocks have moved.

    skin = Skin.of(assembly, parts)            # once
    skin.areas(points), skin.boxes(points)     # facets' normals, blocks' boxes for nodes (n, d) [m]

Rigid blocks contribute the convex pieces of their faces, meshed blocks the facets of their mesh; facets of
second order are divided into straight parts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from masonry_fem.contact.crossing import edges_of
from masonry_fem.contact.smooth import smooth_faces
from masonry_fem.contact.surface import convex_pieces
from masonry_fem.solid.assembly import Assembly, Shape
from masonry_fem.solid.mesh import IntArray
from masonry_fem.solid.pose import FloatArray

# straight parts of a facet, by its nodes in VTK order
PARTS = {
    "line": ((0, 1),),
    "triangle": ((0, 1, 2),),
    "quad": ((0, 1, 2, 3),),
    "line3": ((0, 2), (2, 1)),
    "triangle6": ((0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5)),
    "quad9": ((0, 4, 8, 7), (4, 1, 5, 8), (8, 5, 2, 6), (7, 8, 6, 3)),
}


@dataclass(frozen=True, slots=True)
class Layout:
    """Where the nodes of blocks of one shape stand among all nodes.

    Attributes
    ----------
    shape : Number of the shape. meshed : Whether the nodes are those of its mesh, or the solid's vertices.
    blocks : Numbers of the blocks, shape (b,). start : First node of each, shape (b,).
    """

    shape: int
    meshed: bool
    blocks: IntArray
    start: IntArray


@dataclass(frozen=True, slots=True)
class Skin:
    """p facets with at most k corners and f faces of b blocks; facets and faces stand block by block.

    Attributes
    ----------
    corners : Nodes of the facets, padded with the last, shape (p, k). count : How many, shape (p,).
    face : Face that each is a part of, counted through, shape (p,).
    side : Round face that each is a part of, by one of its faces, shape (p,).
    first : First facet of each block and, last, p, shape (b + 1,).
    first_face : First face of each block and, last, f, shape (b + 1,).
    nodes : First node of each block and the one after its last, shape (b, 2).
    edges : Edges of the blocks that keep their shape, two nodes each, (e, 2), in 3D.
    first_edge : First edge of each block and, last, e, shape (b + 1,).
    hollow : How far a vertex of each block lies in front of a face; 0: convex, shape (b,) [m].
    size : Least extent of each block along an axis of its shape, shape (b,) [m].
    meshed, support : Which blocks are, shape (b,).
    """

    corners: IntArray
    count: IntArray
    face: IntArray
    side: IntArray
    first: IntArray
    first_face: IntArray
    nodes: IntArray
    edges: IntArray
    first_edge: IntArray
    hollow: FloatArray
    size: FloatArray
    meshed: np.ndarray
    support: np.ndarray

    @classmethod
    def of(cls, assembly: Assembly, layouts: Sequence[Layout]) -> Self:
        """The skin of an assembly; each block is in one of the layouts."""
        b, d = len(assembly.blocks), assembly.dimension
        own = [_Facets.of(assembly.shapes[one.shape], one.meshed) for one in layouts]
        most = max(facets.loops.shape[1] for facets in own)
        corners, counts, faces, sides, edges = [], [], [], [], []
        owner: list[list[IntArray]] = [[], []]
        face_count = np.zeros(b, dtype=np.int64)
        nodes, meshed = np.zeros((b, 2), dtype=np.int64), np.zeros(b, dtype=bool)
        hollow, size = np.zeros(b), np.zeros(b)
        for layout, facets in zip(layouts, own, strict=True):
            loops = np.pad(facets.loops, ((0, 0), (0, most - facets.loops.shape[1])), mode="edge")
            corners.append((layout.start[:, None, None] + loops).reshape(-1, most))
            counts.append(np.tile(facets.count, len(layout.blocks)))
            faces.append(np.tile(facets.face, len(layout.blocks)))
            sides.append(np.tile(facets.smooth[facets.face], len(layout.blocks)))
            edges.append((layout.start[:, None, None] + facets.edges).reshape(-1, 2))
            owner[0].append(np.repeat(layout.blocks, len(loops)))
            owner[1].append(np.repeat(layout.blocks, len(facets.edges)))
            face_count[layout.blocks] = facets.faces
            nodes[layout.blocks] = np.stack([layout.start, layout.start + facets.nodes], axis=1)
            meshed[layout.blocks], hollow[layout.blocks] = layout.meshed, facets.hollow
            size[layout.blocks] = facets.size
        of_facet, of_edge = (np.concatenate(part) for part in owner)
        order, edge_order = (np.argsort(part, kind="stable") for part in (of_facet, of_edge))
        first_face = np.concatenate([[0], np.cumsum(face_count)])
        return cls(
            corners=np.concatenate(corners)[order],
            count=np.concatenate(counts)[order],
            face=(np.concatenate(faces) + first_face[of_facet])[order],
            side=(np.concatenate(sides) + first_face[of_facet])[order],
            first=np.searchsorted(of_facet[order], np.arange(b + 1)),
            first_face=first_face,
            nodes=nodes,
            edges=np.concatenate(edges)[edge_order] if d == 3 else np.empty((0, 2), dtype=np.int64),
            first_edge=np.searchsorted(of_edge[edge_order], np.arange(b + 1)),
            hollow=hollow,
            size=size,
            meshed=meshed,
            support=assembly.blocks.support,
        )

    def boxes(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Lowest and highest coordinates of the blocks, each (b, d) [m]."""
        order = np.argsort(self.nodes[:, 0], kind="stable")
        low, high = np.empty((2, len(order), points.shape[1]))
        low[order] = np.minimum.reduceat(points, self.nodes[order, 0])
        high[order] = np.maximum.reduceat(points, self.nodes[order, 0])
        return low, high

    def areas(self, points: FloatArray) -> FloatArray:
        """Outward normals of the facets, as long as these are large, shape (p, d)."""
        at = points[self.corners]
        if points.shape[1] == 2:
            along = at[:, 1] - at[:, 0]
            return np.stack([along[:, 1], -along[:, 0]], axis=1)
        spokes = at[:, 1:] - at[:, :1]
        return 0.5 * np.cross(spokes[:, :-1], spokes[:, 1:]).sum(axis=1)

    def face_areas(self, areas: FloatArray) -> FloatArray:
        """The same of the faces, from those of the facets, shape (f, d)."""
        total = int(self.first_face[-1])
        return np.stack([np.bincount(self.face, part, total) for part in areas.T], axis=1)


@dataclass(frozen=True, slots=True)
class _Facets:
    """Facets of one shape over its own nodes; ``smooth`` by face; edges only where it keeps its shape."""

    loops: IntArray
    count: IntArray
    face: IntArray
    smooth: IntArray
    edges: IntArray
    faces: int
    nodes: int
    hollow: float
    size: float

    @classmethod
    def of(cls, shape: Shape, meshed: bool) -> Self:
        solid, mesh = shape.solid, shape.mesh
        normals = np.array([solid.normal(face) for face in range(len(solid.faces))])
        on_face = solid.vertices[[loop[0] for loop in solid.faces]]
        smooth = smooth_faces(solid, normals)
        extent = np.ptp(solid.vertices, axis=0)
        out = float((solid.vertices @ normals.T - (on_face * normals).sum(axis=1)).max())
        whole = len(solid.faces), out if out > 1e-9 * extent.max() else 0.0, float(extent.min())
        if meshed and mesh is not None:
            parts = np.array(PARTS[mesh.facet])
            loops = mesh.facets[:, parts].reshape(-1, parts.shape[1])
            face, edges = np.repeat(mesh.facet_face, len(parts)), np.empty((0, 2), dtype=np.int64)
            count = np.full(len(loops), parts.shape[1])
            return cls(loops, count, face, smooth, edges, whole[0], len(mesh.points), *whole[1:])
        pieces = [
            (face, loop) for face in range(len(normals)) for loop in convex_pieces(solid, face, normals[face])
        ]
        count = np.array([len(loop) for _, loop in pieces])
        loops = np.array([[*loop, *loop[-1:] * (count.max() - len(loop))] for _, loop in pieces])
        return cls(
            loops, count, np.array([face for face, _ in pieces]), smooth, edges_of(solid)[:, :2],
            whole[0], len(solid.vertices), *whole[1:],
        )  # fmt: skip
