"""Surface: what contact sees of a shape: convex pieces of its faces, and their mesh facets.

    surface = Surface.of(shape)
    faces = pose_faces(assembly, surfaces)      # all faces of all blocks in the world, as arrays

A convex face is one piece; any other is cut into triangles. Surfaces stand in the shape's frame
and are shared by congruent blocks.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from masonry_fem.contact.contacts import local_frames
from masonry_fem.contact.interpolation import CORNERS_OF
from masonry_fem.contact.smooth import smooth_faces
from masonry_fem.solid.assembly import Assembly, Shape
from masonry_fem.solid.mesh import IntArray, Mesh
from masonry_fem.solid.polytope import Polytope
from masonry_fem.solid.pose import FloatArray

FLAT = 1e-9  # relative to the shape's size: what counts as on a plane or on a line


@dataclass(frozen=True, slots=True)
class FaceMesh:
    """Mesh facets of one face, or of several, in the shape's frame.

    Attributes
    ----------
    facets : Their numbers in the mesh, shape (f,).
    corners : Their corner points, outward order, shape (f, k, d) [m].
    nodes : Distinct nodes on the face, ascending, shape (n,).
    points : Where they are, shape (n, d) [m].
    carrier : For each of them the first facet (row of ``facets``) that has it, shape (n,).
    rows : Nodes of the facets as rows of ``nodes``, shape (f, nodes of a facet).
    distortion : By how much the Jacobian of its quadrilaterals varies at most, relative to its mean.
    """

    facets: IntArray
    corners: FloatArray
    nodes: IntArray
    points: FloatArray
    carrier: IntArray
    rows: IntArray
    distortion: float


@dataclass(frozen=True, slots=True)
class Surface:
    """Boundary of a shape, in its own frame.

    Attributes
    ----------
    name : The shape's name, for messages.
    solid : Its polytope.
    mesh : Its mesh, or None.
    pieces : Convex pieces of the faces, outward loops padded with their last corner, (p, k, d) [m].
    corners : Number of corners of each piece, shape (p,).
    face : Face that each is a piece of, shape (p,).
    normals : Outward unit normals of the faces, shape (f, d).
    areas : Areas of the pieces, shape (p,) [m²; m in 2D].
    depths : How far the solid reaches behind its faces, shape (f,) [m].
    smooth : Number of the round face that each face is a part of, shape (f,).
    convex : True for a convex solid.
    face_meshes : Mesh facets by face; empty where there is no mesh.
    size : d-th root of the volume [m].
    """

    name: str
    solid: Polytope
    mesh: Mesh | None
    pieces: FloatArray
    corners: IntArray
    face: IntArray
    normals: FloatArray
    areas: FloatArray
    depths: FloatArray
    smooth: IntArray
    convex: bool
    face_meshes: tuple[FaceMesh, ...]
    size: float

    @classmethod
    def of(cls, shape: Shape) -> Surface:
        """The surface of one shape."""
        solid = shape.solid
        normals = np.array([solid.normal(face) for face in range(len(solid.faces))])
        loops, face = [], []
        for number in range(len(solid.faces)):
            for loop in convex_pieces(solid, number, normals[number]):
                loops.append(solid.vertices[loop])
                face.append(number)
        most = max(len(loop) for loop in loops)
        padded = np.array(
            [np.concatenate([loop, np.repeat(loop[-1:], most - len(loop), 0)]) for loop in loops]
        )
        meshes: tuple[FaceMesh, ...] = ()
        if shape.mesh is not None:
            meshes = tuple(face_mesh(shape.mesh, (number,)) for number in range(len(solid.faces)))
        return cls(
            name=shape.name,
            solid=solid,
            mesh=shape.mesh,
            pieces=padded,
            corners=np.array([len(loop) for loop in loops]),
            face=np.array(face),
            normals=normals,
            areas=_areas(padded),
            depths=_depths(solid, normals),
            smooth=smooth_faces(solid, normals),
            convex=_is_convex(solid, normals),
            face_meshes=meshes,
            size=abs(solid.mass_properties().volume) ** (1 / solid.dimension),
        )


def surfaces_of(assembly: Assembly) -> tuple[Surface, ...]:
    """The surfaces of an assembly's shapes; make them once for several calls of ``detect`` and ``place``."""
    return tuple(Surface.of(shape) for shape in assembly.shapes)


@dataclass(frozen=True, slots=True)
class PosedFaces:
    """Convex face pieces of all blocks in the world, ordered by block and piece (n of them).

    Attributes
    ----------
    block, piece, face : Whose they are, shape (n,).
    points : Outward loops, padded, shape (n, k, d) [m]. corners : Their lengths, shape (n,).
    normal : Outward unit normals, shape (n, d). area : Areas, shape (n,).
    depth : How far the block reaches behind the face, shape (n,) [m].
    first : First piece of each block and, last, n; shape (blocks + 1,).
    """

    block: IntArray
    piece: IntArray
    face: IntArray
    points: FloatArray
    corners: IntArray
    normal: FloatArray
    area: FloatArray
    depth: FloatArray
    first: IntArray


def pose_faces(assembly: Assembly, surfaces: tuple[Surface, ...]) -> PosedFaces:
    """The faces of all blocks in world coordinates.

    Parameters
    ----------
    assembly : Blocks with their poses.
    surfaces : Surface of each of its shapes, from ``surfaces_of``.
    """
    d = assembly.dimension
    of_block = assembly.blocks.shape
    count = np.array([len(surface.face) for surface in surfaces], dtype=np.int64)[of_block]
    first = np.concatenate([[0], np.cumsum(count)])
    total, most = int(first[-1]), max(surface.pieces.shape[1] for surface in surfaces)
    rotation = assembly.blocks.rotation
    translation = assembly.blocks.translation
    points, normal = np.empty((total, most, d)), np.empty((total, d))
    index = np.arange(total)
    block = np.repeat(np.arange(len(of_block)), count)
    piece = index - first[block]
    face, corners = np.empty(total, dtype=np.int64), np.empty(total, dtype=np.int64)
    area, depth = np.empty(total), np.empty(total)
    for number, surface in enumerate(surfaces):
        own = np.flatnonzero(of_block == number)
        if len(own) == 0:
            continue
        rows = (first[own][:, None] + np.arange(len(surface.face))).ravel()
        width = surface.pieces.shape[1]
        world = np.einsum("bij,pkj->bpki", rotation[own], surface.pieces) + translation[own, None, None]
        points[rows, :width] = world.reshape(-1, width, d)
        points[rows, width:] = points[rows, width - 1 : width]
        normal[rows] = np.einsum("bij,pj->bpi", rotation[own], surface.normals[surface.face]).reshape(-1, d)
        face[rows] = np.tile(surface.face, len(own))
        corners[rows] = np.tile(surface.corners, len(own))
        area[rows] = np.tile(surface.areas, len(own))
        depth[rows] = np.tile(surface.depths[surface.face], len(own))
    return PosedFaces(block, piece, face, points, corners, normal, area, depth, first)


def typical_size(assembly: Assembly, surfaces: tuple[Surface, ...]) -> float:
    """Median over the blocks of the d-th root of their volume [m]; one wide floor does not change it.

    Parameters
    ----------
    assembly : Blocks.
    surfaces : Surface of each of its shapes.
    """
    return float(np.median(np.array([surface.size for surface in surfaces])[assembly.blocks.shape]))


def face_mesh(mesh: Mesh, faces: Sequence[int]) -> FaceMesh:
    """Mesh facets of one face, or of several, face by face.

    Parameters
    ----------
    mesh : Of the shape.
    faces : Numbers of the faces.
    """
    facets = np.concatenate([np.flatnonzero(mesh.facet_face == face) for face in faces])
    connectivity = mesh.facets[facets]
    nodes, at, rows = np.unique(connectivity, return_index=True, return_inverse=True)
    carrier = at // connectivity.shape[1] if len(facets) else at
    corners = mesh.points[connectivity[:, : CORNERS_OF[mesh.facet]]]
    rows = rows.reshape(connectivity.shape)
    return FaceMesh(facets, corners, nodes, mesh.points[nodes], carrier, rows, _distortion(corners))


def _distortion(corners: FloatArray) -> float:
    """By how much the Jacobian of quadrilaterals (f, 4, 3) varies about its mean; 0 for other facets."""
    if corners.shape[1:] != (4, 3) or not len(corners):
        return 0.0
    edges = np.roll(corners, -1, axis=1) - corners
    jacobian = np.cross(np.roll(edges, 1, axis=1), edges)
    mean = jacobian.mean(axis=1, keepdims=True)
    away = np.linalg.norm(jacobian - mean, axis=2) / np.linalg.norm(mean, axis=2)
    return float(away.max())


def _areas(pieces: FloatArray) -> FloatArray:
    if pieces.shape[2] == 2:
        return np.linalg.norm(pieces[:, 1] - pieces[:, 0], axis=1)
    spokes = pieces - pieces[:, :1]
    return 0.5 * np.linalg.norm(np.cross(spokes[:, 1:-1], spokes[:, 2:]).sum(axis=1), axis=1)


def _depths(solid: Polytope, normals: FloatArray) -> FloatArray:
    """How far a solid reaches behind each of its faces, shape (f,) [m]."""
    on = solid.vertices[[loop[0] for loop in solid.faces]]
    depths: FloatArray = ((on * normals).sum(axis=1) - (solid.vertices @ normals.T).min(axis=0)).astype(float)
    return depths


def _is_convex(solid: Polytope, normals: FloatArray) -> bool:
    size = float(np.ptp(solid.vertices, axis=0).max())
    heights = [
        ((solid.vertices - solid.face_points(face)[0]) @ normal).max() for face, normal in enumerate(normals)
    ]
    return bool(max(heights) <= 1e-6 * size)


def convex_pieces(solid: Polytope, face: int, normal: FloatArray) -> list[list[int]]:
    """Vertex loops of the convex pieces of a face: the face itself, or else triangles.

    Parameters
    ----------
    solid : The solid.
    face : Number of the face.
    normal : Its outward unit normal, shape (3,).

    References
    ----------
    Meisters, Polygons have ears, Am. Math. Monthly 82 (1975): a polygon is cut by removing ears, that is,
    triangles of three consecutive corners that contain no other corner.
    """
    loop = list(solid.faces[face])
    if solid.dimension == 2:
        return [loop]
    size2 = float(np.ptp(solid.vertices, axis=0).max()) ** 2
    _, along, across = local_frames(normal[None])[0]
    flat = {vertex: (solid.vertices[vertex] @ along, solid.vertices[vertex] @ across) for vertex in loop}

    def turn(a: int, b: int, c: int) -> float:
        (ax, ay), (bx, by), (cx, cy) = flat[a], flat[b], flat[c]
        return float((bx - ax) * (cy - by) - (by - ay) * (cx - bx))

    def is_ear(i: int) -> bool:
        a, b, c = loop[i - 1], loop[i], loop[(i + 1) % len(loop)]
        if turn(a, b, c) <= FLAT * size2:
            return False
        others = [v for v in loop if v not in (a, b, c)]
        return not any(min(turn(a, b, v), turn(b, c, v), turn(c, a, v)) > -FLAT * size2 for v in others)

    if all(turn(loop[i - 1], loop[i], loop[(i + 1) % len(loop)]) > -FLAT * size2 for i in range(len(loop))):
        return [loop]
    pieces = []
    while len(loop) > 3:
        ear = next((i for i in range(len(loop)) if is_ear(i)), None)
        if ear is None:  # a corner on a straight side is left over
            ear = min(
                range(len(loop)), key=lambda i: abs(turn(loop[i - 1], loop[i], loop[(i + 1) % len(loop)]))
            )
        else:
            pieces.append([loop[ear - 1], loop[ear], loop[(ear + 1) % len(loop)]])
        del loop[ear]
    return [*pieces, loop]
