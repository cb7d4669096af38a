"""Traction: consistent nodal weights of a load on one face of a shape, uniform or by depth."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from masonry_fem.errors import GeometryError
from masonry_fem.fem.lagrange import fine_quadrature, is_simplex, lagrange, order, rule
from masonry_fem.solid.mesh import Mesh
from masonry_fem.solid.submerged import Submerged, below

FloatArray = NDArray[np.float64]


def face_weights(mesh: Mesh, face: int, block: str) -> FloatArray:
    """∫ N dA over a face of the solid for each node, shape (nodes,) [m²; m in 2D].

    Parameters
    ----------
    mesh : Elements of the shape.
    face : Number of the face.
    block : Name of the block, for the error message.

    Raises
    ------
    GeometryError : No facet of the mesh lies on the face.
    """
    facets = _facets(mesh, face, block)
    element, (points, weights) = lagrange(mesh.facet), fine_quadrature(mesh.facet)
    tangents = np.einsum("fkd,pkt->fpdt", mesh.points[facets], element.gradients(points))
    gram = np.einsum("fpdt,fpds->fpts", tangents, tangents)
    areas = np.sqrt(np.linalg.det(gram)) * weights
    shares = areas @ element.values(points)
    total: FloatArray = np.bincount(facets.ravel(), shares.ravel(), len(mesh.points))
    return total


def submerged_weights(mesh: Mesh, face: int, block: str, places: FloatArray, factor: Submerged) -> FloatArray:
    """∫ N f dA over the part of a face below a level for each node, shape (nodes,) [m²; m in 2D].

    Facets are cut where a straight line between the crossings of their edges leads; of parallelograms, and
    of triangles, that is where the level lies.

    Parameters
    ----------
    mesh : Elements of the shape.
    face : Number of the face.
    block : Name of the block, for the error message.
    places : Nodes in world axes, shape (nodes, d) [m].
    factor : The factor f by depth.

    Raises
    ------
    GeometryError : No facet of the mesh lies on the face.
    """
    facets = _facets(mesh, face, block)
    element = lagrange(mesh.facet)
    tangential = element.nodes.shape[1]
    corners = (
        [[0, 1]] if tangential == 1 else [[0, 1, 2]] if is_simplex(mesh.facet) else [[0, 1, 2], [0, 2, 3]]
    )
    whole = element.nodes[corners]  # lines or triangles that make up the reference facet, (c, k, t)
    simplex = "line" if tangential == 1 else "triangle"
    at, weights = rule(simplex, 2 * order(mesh.facet) + 3)
    shares = np.column_stack([1 - at.sum(axis=1), at])
    depth = factor.depth(places[facets])[:, corners]
    cut = below(depth.reshape(-1, depth.shape[-1]))
    size = np.abs(np.linalg.det(cut)).reshape(len(facets), len(corners), -1)
    cut = cut.reshape(*size.shape, *cut.shape[-2:])
    points = np.einsum("qk,fcskm,cmt->fcsqt", shares, cut, whole)
    size = size * np.abs(np.linalg.det(whole[:, 1:] - whole[:, :1]))[:, None]
    flat = points.reshape(-1, tangential)
    values = element.values(flat).reshape(*points.shape[:-1], -1)
    gradients = element.gradients(flat).reshape(*values.shape, tangential)
    own = places[facets]
    tangents = np.einsum("fkd,fcsqkt->fcsqdt", own, gradients)
    gram = np.einsum("fcsqdt,fcsqdu->fcsqtu", tangents, tangents)
    areas = np.sqrt(np.linalg.det(gram)) * size[..., None] * weights
    pressed = areas * factor(np.einsum("fcsqk,fkd->fcsqd", values, own))
    nodal = np.einsum("fcsq,fcsqk->fk", pressed, values)
    total: FloatArray = np.bincount(facets.ravel(), nodal.ravel(), len(mesh.points))
    return total


def _facets(mesh: Mesh, face: int, block: str) -> NDArray[np.int64]:
    """Facets of the mesh on a face; an error where there are none."""
    facets: NDArray[np.int64] = mesh.facets[mesh.facet_face == face]
    if not len(facets):
        raise GeometryError(
            f"block '{block}': face {face} carries a load but has no mesh facets, expected at least one; "
            "check that the mesh assigns its facets to the faces of the solid"
        )
    return facets
