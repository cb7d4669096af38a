"""Stress of elastic blocks: from nodal displacements to Gauss points, and smoothed to nodes.

recovery = StressRecovery.of(mesh, material, plane)
field = recovery.field(displacement, rotations)      # all blocks of a group at once
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from masonry_fem.bodies.base import StressField
from masonry_fem.fem.lagrange import is_simplex, lagrange, linear, order, quadrature
from masonry_fem.fem.material import ElasticMaterial, Plane
from masonry_fem.solid.mesh import Mesh

FloatArray = NDArray[np.float64]

_COMPONENT = np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2]])  # of (xx, yy, zz, xy, yz, xz)
_ROW, _COLUMN = (0, 1, 2, 0, 1, 0), (0, 1, 2, 1, 2, 2)


@dataclass(frozen=True, slots=True)
class StressRecovery:
    """Linear maps from a shape's nodal displacements to its stresses, shape axes.

    Attributes
    ----------
    mesh : Elements: m cells of k nodes, p points in each.
    gradient : Of the shape functions, shape (m, p d, k) [1/m].
    moduli : Gradient of displacements to stresses, shape (d², 6) [Pa].
    nodal : Values at Gauss points to values at nodes, shape (nodes, m p).
    weight : Volume of each Gauss point, shape (m, p) [m³; m² in 2D].
    """

    mesh: Mesh
    gradient: FloatArray
    moduli: FloatArray
    nodal: sparse.csr_array
    weight: FloatArray

    @classmethod
    def of(cls, mesh: Mesh, material: ElasticMaterial, plane: Plane) -> Self:
        """The maps of one shape."""
        points, weights = quadrature(mesh.cell)
        reference = lagrange(mesh.cell).gradients(points)
        jacobian = np.einsum("mkd,pkt->mpdt", mesh.points[mesh.cells], reference)
        gradient = np.einsum("pkt,mptd->mpdk", reference, np.linalg.inv(jacobian))
        m, p, d, k = gradient.shape
        volume = np.linalg.det(jacobian) * weights
        D = material.stress_matrix(mesh.dimension, plane).transpose(2, 1, 0).reshape(d * d, 6)
        return cls(
            mesh,
            gradient.reshape(m, p * d, k),
            np.ascontiguousarray(D),
            _smoothing(mesh, points, volume),
            volume,
        )

    def field(self, displacement: FloatArray, rotation: FloatArray) -> StressField:
        """Stresses for displacements (b, n) of blocks whose shape axes are turned by (b, d, d)."""
        return self.smoothed(self.gauss_stress(displacement), rotation)

    def smoothed(self, stress: FloatArray, rotation: FloatArray) -> StressField:
        """Stresses at the Gauss points, shape axes, (b, m, p, 6) [Pa], in world axes and at the nodes."""
        b, (m, p) = len(stress), self.weight.shape
        gauss = _turned(stress.reshape(b, m * p, 6), rotation)
        by_point = np.ascontiguousarray(gauss.transpose(1, 0, 2)).reshape(m * p, b * 6)
        nodal = (self.nodal @ by_point).reshape(-1, b, 6).transpose(1, 0, 2)
        return StressField(gauss.reshape(b, m, p, 6), self.weight, np.ascontiguousarray(nodal))

    def gauss_stress(self, displacement: FloatArray) -> FloatArray:
        """Stresses at the Gauss points for displacements (b, n), shape axes, (b, m, p, 6) [Pa]."""
        b, (m, p), d = len(displacement), self.weight.shape, self.mesh.dimension
        # what cells' nodes are moved by has no name, so that it is let go before the stresses are made
        stretch = (self.gradient @ displacement.reshape(b, -1, d)[:, self.mesh.cells]).reshape(b, m, p, d * d)
        stress: FloatArray = stretch @ self.moduli
        return stress


def _smoothing(mesh: Mesh, points: FloatArray, volume: FloatArray) -> sparse.csr_array:
    """Extrapolation of each cell's Gauss values to its nodes, averaged by cell volume."""
    m, p = volume.shape
    nodes = lagrange(mesh.cell).nodes
    if is_simplex(mesh.cell) and order(mesh.cell) == 1:
        spread = np.ones((len(nodes), 1))
    else:  # stress is linear in a simplex of order 2; in a box it is fitted by the cell's own functions
        fit = lagrange(linear(mesh.cell) if is_simplex(mesh.cell) else mesh.cell)
        spread = fit.values(nodes) @ np.linalg.inv(fit.values(points))
    share = volume.sum(axis=1)
    total = np.bincount(mesh.cells.ravel(), np.repeat(share, len(nodes)), len(mesh.points))
    value = share[:, None, None] * spread / total[mesh.cells][:, :, None]
    rows = np.repeat(mesh.cells.ravel().astype(np.int32), p)
    columns = np.broadcast_to(np.arange(m * p, dtype=np.int32).reshape(m, 1, p), (m, len(nodes), p)).ravel()
    return sparse.csr_array((value.ravel(), (rows, columns)), shape=(len(mesh.points), m * p))


def _turned(stress: FloatArray, rotation: FloatArray) -> FloatArray:
    """Stresses (b, q, 6) from shape to world axes, R σ Rᵀ."""
    turn = np.tile(np.eye(3), (len(rotation), 1, 1))
    d = rotation.shape[1]
    turn[:, :d, :d] = rotation
    # of each component alone; to turn all as tensors would take three times the memory of the stresses
    alone = turn[:, None] @ np.eye(6)[:, _COMPONENT] @ np.swapaxes(turn, 1, 2)[:, None]
    components: FloatArray = stress @ alone[..., _ROW, _COLUMN]
    return components
