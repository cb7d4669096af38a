"""Locate: which cell contains a point, and the weights of its nodes there."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from masonry_fem.contact.interpolation import weights
from masonry_fem.errors import GeometryError
from masonry_fem.fem.lagrange import is_simplex, lagrange, linear
from masonry_fem.solid.mesh import FACET_OF, NODES_OF, Mesh

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

NEWTON_STEPS = 12  # straight cells need one; curved and distorted ones four or five
SHARED = 1e-9  # of a facet: a point this near to two facets lies on their common edge
REACH = 0.1  # of the mesh's size: how far outside a point may lie (arcs, gaps) and still belong


def in_cells(mesh: Mesh, point: FloatArray, what: str) -> tuple[IntArray, FloatArray]:
    """Nodes and weights that interpolate a field at a point; exact for linear fields.

    Parameters
    ----------
    mesh : Elements of a block.
    point : Coordinates in the mesh's frame, shape (d,) [m].
    what : What the point is, for the error message.

    Returns
    -------
    Node numbers and weights of the cell that contains the point, each of shape (k,). A point slightly outside
    belongs to the nearest cell.

    Raises
    ------
    GeometryError : The point is far outside the mesh.
    """
    element, corners = lagrange(mesh.cell), mesh.points[mesh.cells]
    local = np.full((len(mesh.cells), mesh.dimension), 0.25 if is_simplex(mesh.cell) else 0.5)
    for _ in range(NEWTON_STEPS):
        miss = np.einsum("mk,mkd->md", element.values(local), corners) - point
        jacobian = np.einsum("mkd,mkt->mdt", corners, element.gradients(local))
        change = np.linalg.solve(jacobian, miss[..., None])[..., 0]
        local = np.clip(local - change, -5.0, 6.0)  # for cells far from the point: avoids overflow
        if np.abs(change).max() < 1e-14:
            break
    inside = _clipped(local, mesh.cell)
    distance = np.linalg.norm(np.einsum("mk,mkd->md", element.values(inside), corners) - point, axis=1)
    cell = int(distance.argmin())
    size = float(np.ptp(mesh.points, axis=0).max())
    if distance[cell] > REACH * size:
        raise GeometryError(
            f"{what}: the point is {distance[cell]:.3g} m outside the block, expected inside or on its "
            "faces; give a point of the block in world coordinates"
        )
    nodes: IntArray = mesh.cells[cell]
    return nodes, element.values(local[cell : cell + 1])[0]


def _clipped(local: FloatArray, cell: str) -> FloatArray:
    """The nearest reference points, roughly, of the cell itself."""
    inside = np.clip(local, 0.0, 1.0)
    if is_simplex(cell):
        inside = inside / np.maximum(inside.sum(axis=1, keepdims=True), 1.0)
    return inside


def on_facets(mesh: Mesh, facets: IntArray, points: FloatArray) -> tuple[IntArray, FloatArray]:
    """Nodes and weights that interpolate a field at points on the boundary.

    Parameters
    ----------
    mesh : Elements of a block.
    facets : Row of ``mesh.facets`` that each point lies on, −1 for the nearest one, shape (k,).
    points : Coordinates in the mesh's frame, shape (k, d) [m].

    Returns
    -------
    Node numbers and weights, each of shape (k, nodes of a facet).
    """
    carrier = np.array(facets, dtype=np.int64)
    for index in np.flatnonzero(carrier < 0):
        carrier[index] = _nearest_facet(mesh, points[index])
    return mesh.facets[carrier], weights(mesh, carrier, points)


def _nearest_facet(mesh: Mesh, point: FloatArray) -> int:
    """The facet that holds a point; of facets that share it, the first.

    A point is judged by the weights of the facets' corners, which unlike second-order ones are
    between 0 and 1 exactly on the facet.
    """
    cell = linear(mesh.cell)
    corners = mesh.facets[:, : NODES_OF[FACET_OF[cell]]]
    straight = Mesh(mesh.points, cell, mesh.cells, corners, mesh.facet_face)
    everywhere = np.tile(point, (len(corners), 1))
    share = weights(straight, np.arange(len(corners)), everywhere)
    places = mesh.points[corners]
    off = np.linalg.norm(np.einsum("fk,fkd->fd", share, places) - point, axis=1)
    size = np.linalg.norm(np.ptp(places, axis=1), axis=1)
    distance = off + size * np.maximum(-share, 0).sum(axis=1)
    return int(np.flatnonzero(distance <= distance.min() + SHARED * size.max())[0])
