"""Traction: consistent nodal weights of a uniform load on one face of a shape."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from masonry_fem.errors import GeometryError
from masonry_fem.fem.lagrange import fine_quadrature, lagrange
from masonry_fem.solid.mesh import Mesh

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
    facets = mesh.facets[mesh.facet_face == face]
    if not len(facets):
        raise GeometryError(
            f"block '{block}': face {face} carries a load but has no mesh facets, expected at least one; "
            "check that the mesh assigns its facets to the faces of the solid"
        )
    element, (points, weights) = lagrange(mesh.facet), fine_quadrature(mesh.facet)
    tangents = np.einsum("fkd,pkt->fpdt", mesh.points[facets], element.gradients(points))
    gram = np.einsum("fpdt,fpds->fpts", tangents, tangents)
    areas = np.sqrt(np.linalg.det(gram)) * weights
    shares = areas @ element.values(points)
    total: FloatArray = np.bincount(facets.ravel(), shares.ravel(), len(mesh.points))
    return total
