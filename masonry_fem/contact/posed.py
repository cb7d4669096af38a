"""Posed: corners, edges and face planes of all blocks where they stand, as padded arrays."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from masonry_fem.contact.crossing import edges_of
from masonry_fem.contact.surface import Surface
from masonry_fem.host.compiled import compiled
from masonry_fem.solid.assembly import Assembly
from masonry_fem.solid.mesh import IntArray
from masonry_fem.solid.polytope import Polytope
from masonry_fem.solid.pose import FloatArray


@dataclass(frozen=True, slots=True)
class Posed:
    """Vertices and face planes of all blocks in the world, padded by repetition.

    Attributes
    ----------
    solids : Polytopes by shape. shape : Shape of each block, shape (b,).
    vertices : shape (b, v, d) [m]. count : How many are real, shape (b,).
    on_face, normal : A point and the outward normal of each face, shape (b, f, d).
    faces : Number of faces, shape (b,).
    convex : Whether the block is, shape (b,).
    edges : Edges of each block (``crossing.edges_of``), padded, shape (b, e, 4).
    edge_count : How many are real, shape (b,).
    support : Whether the block is one, shape (b,).
    labels : Of the faces of all shapes, one shape after another.
    first : First face of each shape, shape (s,).
    """

    solids: tuple[Polytope, ...]
    shape: IntArray
    vertices: FloatArray
    count: IntArray
    on_face: FloatArray
    normal: FloatArray
    faces: IntArray
    convex: np.ndarray
    edges: IntArray
    edge_count: IntArray
    support: np.ndarray
    labels: NDArray[np.object_]
    first: IntArray

    @classmethod
    def of(cls, assembly: Assembly, surfaces: tuple[Surface, ...]) -> Posed:
        """Vertices and faces of the blocks of an assembly."""
        solids = tuple(surface.solid for surface in surfaces)
        shape, rotation, translation = poses(assembly)
        vertices, count = corners(assembly)
        on_face, faces = _padded(
            [np.array([solid.face_points(f)[0] for f in range(len(solid.faces))]) for solid in solids]
        )
        normal, _ = _padded([surface.normals for surface in surfaces])
        turned = [np.einsum("bij,bkj->bki", rotation, array[shape]) for array in (on_face, normal)]
        return cls(
            solids,
            shape,
            vertices,
            count,
            turned[0] + translation[:, None],
            turned[1],
            faces[shape],
            np.array([surface.convex for surface in surfaces])[shape],
            *_all_edges(solids, shape),
            assembly.blocks.support,
            np.array([text for solid in solids for text in solid.labels], dtype=object),
            np.cumsum([0, *(len(solid.labels) for solid in solids)])[:-1],
        )

    def shared_labels(self, blocks: IntArray, faces: IntArray) -> list[str]:
        """Joint labels that faces of two blocks share, or "".

        Parameters
        ----------
        blocks, faces : Shape (m, 2).
        """
        one, two = self.labels[self.first[self.shape[blocks]] + faces].T
        found: list[str] = np.where(one == two, one, "").tolist()
        return found


def corners(assembly: Assembly) -> tuple[FloatArray, IntArray]:
    """Corners of all blocks in the world, padded by repetition, (b, v, d) [m]; how many are real, (b,)."""
    shape, rotation, translation = poses(assembly)
    vertices, count = _padded([one.solid.vertices for one in assembly.shapes])
    turned = np.einsum("bij,bkj->bki", rotation, vertices[shape])
    return turned + translation[:, None], count[shape]


def _all_edges(solids: tuple[Polytope, ...], shape: IntArray) -> tuple[IntArray, IntArray]:
    """Edges of all blocks, padded, and their numbers: (b, e, 4), (b,)."""
    edges = [edges_of(solid) for solid in solids]
    padded = np.zeros((len(edges), max(len(own) for own in edges), 4), dtype=np.int64)
    for row, own in zip(padded, edges, strict=True):
        row[: len(own)] = own
    return padded[shape], np.array([len(own) for own in edges])[shape]


def _padded(arrays: list[FloatArray]) -> tuple[FloatArray, IntArray]:
    """The arrays in one, the last row of each repeated, and how many rows of each are real."""
    count = np.array([len(array) for array in arrays])
    each = zip(arrays, count.max() - count, strict=True)
    return np.array(
        [np.concatenate([array, np.repeat(array[-1:], lacking, 0)]) for array, lacking in each]
    ), count


@compiled
def clearances(
    vertices: FloatArray,
    count: IntArray,
    blocks: IntArray,
    on_plane: FloatArray,
    normal: FloatArray,
) -> FloatArray:
    """Smallest height of blocks above planes, one plane per block, shape (m,) [m].

    Parameters
    ----------
    vertices : Corners of all blocks, padded, shape (b, k, d) [m].
    count : Number of corners of each block, shape (b,).
    blocks : Block numbers, shape (m,).
    on_plane : A point of each plane, shape (m, d) [m].
    normal : Unit normal of each plane, shape (m, d).
    """
    result = np.full(len(blocks), np.inf)
    for m in range(len(blocks)):
        for v in range(count[blocks[m]]):
            height = 0.0
            for c in range(vertices.shape[2]):
                height += (vertices[blocks[m], v, c] - on_plane[m, c]) * normal[m, c]
            result[m] = min(result[m], height)
    return result


def poses(assembly: Assembly) -> tuple[IntArray, FloatArray, FloatArray]:
    """Shape (b,), rotation (b, d, d) and translation (b, d) of each block."""
    return (
        assembly.blocks.shape,
        assembly.blocks.rotation,
        assembly.blocks.translation,
    )
