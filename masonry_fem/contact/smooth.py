"""Smooth: which faces of a solid make up one round face, and how round mesh facets are.

Files bring round bodies in flat facets. Neighbouring faces that turn by less than ``SMOOTH`` are parts of one
round face, of which each mesh facet is a chord.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from masonry_fem.contact.contacts import local_frames
from masonry_fem.contact.interfaces import Interfaces, numbered
from masonry_fem.contact.interpolation import CORNERS_OF
from masonry_fem.solid.mesh import IntArray, Mesh
from masonry_fem.solid.polytope import Polytope
from masonry_fem.solid.pose import FloatArray

if TYPE_CHECKING:
    from masonry_fem.solid.assembly import Assembly

SMOOTH = 20.0  # angle [degrees] below which neighbouring faces are parts of one round face
FLAT = math.cos(math.radians(SMOOTH))  # least cosine between the normals of such faces


def smooth_faces(solid: Polytope, normals: FloatArray) -> IntArray:
    """The round face that each face is a part of, shape (f,); a flat face among edges is one of its own.

    Parameters
    ----------
    solid : The solid.
    normals : Outward unit normals of its faces, shape (f, d).
    """
    count = len(solid.faces)
    first, second = _neighbours(solid.faces, solid.dimension)
    joined = (normals[first] * normals[second]).sum(axis=1) > FLAT
    if not joined.any():
        return np.arange(count)
    pairs = first[joined], second[joined]
    graph = sparse.coo_array((np.ones(len(pairs[0])), pairs), shape=(count, count))
    return np.asarray(connected_components(graph, directed=False)[1], dtype=np.int64)


def round_joints(assembly: Assembly, interfaces: Interfaces, smooth: Sequence[IntArray]) -> IntArray:
    """The joint that each interface is a part of, numbered as they first come, shape (i,).

    Facets that two faces, round or parted, have in common under one label make up one joint; a corner, an
    edge and a tie are one of their own.

    Parameters
    ----------
    assembly : The blocks. interfaces : Where they touch.
    smooth : Of each shape the round face of each of its faces, from ``smooth_faces``.
    """
    first = np.cumsum([0, *map(len, smooth)])
    of_shape = assembly.blocks.shape
    whole = (interfaces.area > 0) & ~interfaces.tie
    faces = np.where(whole[:, None], interfaces.faces, 0)
    sides = np.stack(
        [interfaces.blocks, np.concatenate(smooth)[first[of_shape[interfaces.blocks]] + faces]], axis=2
    )
    (block, face), (facing, its) = sides[:, 0].T, sides[:, 1].T
    swapped = (block > facing) | ((block == facing) & (face > its))
    sides[swapped] = sides[swapped, ::-1]
    own = np.where(whole, -1, np.arange(len(whole)))
    return numbered(np.column_stack([sides.reshape(-1, 4), interfaces.label, own]))[0]


def joints_of(assembly: Assembly, interfaces: Interfaces) -> IntArray:
    """``round_joints`` for whoever does not have the round faces of the shapes, shape (i,).

    Parameters
    ----------
    assembly : The blocks. interfaces : Where they touch.
    """
    solids = [shape.solid for shape in assembly.shapes]
    normals = [np.array([solid.normal(face) for face in range(len(solid.faces))]) for solid in solids]
    smooth = [smooth_faces(solid, own) for solid, own in zip(solids, normals, strict=True)]
    return round_joints(assembly, interfaces, smooth)


def curvatures(mesh: Mesh, facets: IntArray, smooth: IntArray) -> FloatArray:
    """How normals turn along facets of round faces, by least squares from facets that touch them.

    Parameters
    ----------
    mesh : Of the shape.
    facets : Some of its boundary facets, shape (k,).
    smooth : The round face of each face of the shape, from ``smooth_faces``.

    Returns
    -------
    Symmetric matrices S with dn = S dx, positive where the face bulges out, shape (k, d, d) [1/m].
    """
    d = mesh.dimension
    of = smooth[mesh.facet_face]
    if not (np.bincount(smooth)[of[facets]] > 1).any():  # flat faces
        return np.zeros((len(facets), d, d))
    corners = mesh.facets[:, : CORNERS_OF[mesh.facet]]
    at = mesh.points[corners]
    normal, middle = _normals(at), at.mean(axis=1)
    row = np.repeat(np.arange(len(corners)), corners.shape[1])
    has = sparse.csr_array((np.ones(corners.size), (row, corners.ravel())), shape=(len(at), len(mesh.points)))
    one, other = (has @ has.T).nonzero()
    same = (of[one] == of[other]) & (one != other)
    one, other = one[same], other[same]
    away, turn = middle[other] - middle[one], normal[other] - normal[one]
    # least squares for the entries of S in an orthonormal basis of the facet's plane: S x = t
    basis = local_frames(normal)[:, 1:]
    x = np.einsum("kpd,kd->kp", basis[one], away)
    t = np.einsum("kpd,kd->kp", basis[one], turn)
    rows = x[:, :, None] if d == 2 else _symmetric(x)
    size = rows.shape[2]
    square, right = np.zeros((len(at), size, size)), np.zeros((len(at), size))
    np.add.at(square, one, np.einsum("kpa,kpb->kab", rows, rows))
    np.add.at(right, one, np.einsum("kpa,kp->ka", rows, t))
    entries = np.einsum("kab,kb->ka", np.linalg.pinv(square[facets], 1e-6, hermitian=True), right[facets])
    flat = entries[:, None] if d == 2 else entries[:, [0, 1, 1, 2]].reshape(-1, 2, 2)
    found: FloatArray = np.einsum("kpd,kpq,kqe->kde", basis[facets], flat, basis[facets])
    return found


def _symmetric(x: FloatArray) -> FloatArray:
    """S x as a product with the entries (S11, S12, S22) of S, shape (k, 2, 3)."""
    none = np.zeros(len(x))
    return np.stack(
        [np.stack([x[:, 0], x[:, 1], none], axis=1), np.stack([none, x[:, 0], x[:, 1]], axis=1)], axis=1
    )


def _neighbours(loops: tuple[tuple[int, ...], ...] | IntArray, d: int) -> tuple[IntArray, IntArray]:
    """Pairs of faces, given by their corners, that share an edge; in 2D a corner."""
    sides = np.array([len(loop) for loop in loops])
    owner = np.repeat(np.arange(len(sides)), sides)
    corner = np.concatenate([np.asarray(loop) for loop in loops])
    if d == 2:
        key = corner[:, None]
    else:
        last = np.cumsum(sides) - 1
        after = np.append(corner[1:], -1)
        after[last] = corner[last - sides + 1]
        key = np.sort(np.stack([corner, after], axis=1), axis=1)
    order = np.lexsort(key.T)
    same = (key[order][1:] == key[order][:-1]).all(axis=1)
    return owner[order[:-1][same]], owner[order[1:][same]]


def _normals(at: FloatArray) -> FloatArray:
    """Outward unit normals of facets by their corners, shape (f, k, d)."""
    if at.shape[2] == 2:
        along = at[:, 1] - at[:, 0]
        area = np.stack([along[:, 1], -along[:, 0]], axis=1)
    else:
        spokes = at[:, 1:] - at[:, :1]
        area = np.cross(spokes[:, :-1], spokes[:, 1:]).sum(axis=1)
    found: FloatArray = area / np.linalg.norm(area, axis=1)[:, None]
    return found
