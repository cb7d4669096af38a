"""Strains: from nodal displacements to strains at Gauss points, and from stresses there to nodal forces.

    strains = Strains.of(mesh)
    strain = strains.at_points(displacement)            # (b, n) -> (b, m, p, 6)
    force = strains.forces(stress)                      # (b, m, p, 6) -> (b, n)
    tangent = strains.stiffness(moduli)                 # of one block: (m, p, 6, 6) -> (n, n)

Points and weights are those of the elastic stiffness, so that elastic moduli give that.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from masonry_fem.fem.lagrange import lagrange, order, quadrature
from masonry_fem.solid.mesh import Mesh

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

_PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))
_IN_PLANE = {2: [0, 1, 3], 3: [0, 1, 2, 3, 4, 5]}  # components that displacements strain


@dataclass(frozen=True, slots=True)
class Strains:
    """Gradients of a mesh at its Gauss points: m cells of k nodes, p points each, n = nodes · d.

    Attributes
    ----------
    mesh : Elements.
    matrix : Strains, shears as angles, of a cell's nodal displacements, without the components that a
        plane mesh cannot strain, shape (m, p, 3 | 6, k d) [1/m].
    weight : Volume of each Gauss point, shape (m, p) [m³; m² in 2D].
    dofs : Of each cell, shape (m, k d).
    pattern : Where each entry of the cells' matrices is in a sparse one, shape (m k² d²,).
    columns, pointers : Of that sparse matrix.
    """

    mesh: Mesh
    matrix: FloatArray
    weight: FloatArray
    dofs: IntArray
    pattern: IntArray
    columns: IntArray
    pointers: IntArray

    @classmethod
    def of(cls, mesh: Mesh) -> Self:
        """Those of one mesh."""
        points, weights = quadrature(mesh.cell)
        reference = lagrange(mesh.cell).gradients(points)
        jacobian = np.einsum("mkd,pkt->mpdt", mesh.points[mesh.cells], reference)
        gradient = np.einsum("pkt,mptd->mpkd", reference, np.linalg.inv(jacobian))
        volume = np.linalg.det(jacobian) * weights
        m, p, k, d = gradient.shape
        rows = _IN_PLANE[d]
        matrix = np.zeros((m, p, len(rows), k, d))
        for row, component in enumerate(rows):
            i, j = _PAIRS[component]
            matrix[:, :, row, :, i] += gradient[..., j]
            if i != j:
                matrix[:, :, row, :, j] += gradient[..., i]
        dofs = (mesh.cells[:, :, None] * d + np.arange(d)).reshape(m, k * d)
        n = mesh.points.size
        places = (dofs[:, :, None] * n + dofs[:, None, :]).ravel()
        known, pattern = np.unique(places, return_inverse=True)
        pointers = np.searchsorted(known, np.arange(n + 1) * n)
        return cls(
            mesh, matrix.reshape(m, p, len(rows), k * d), volume, dofs, pattern.ravel(), known % n, pointers
        )

    def at_points(self, displacement: FloatArray) -> FloatArray:
        """Strains of displacements (b, n), shape axes, (b, m, p, 6)."""
        b, (m, p) = len(displacement), self.weight.shape
        strain = np.zeros((b, m, p, 6))
        own = np.matmul(self.matrix, displacement[:, self.dofs][:, :, None, :, None])[..., 0]
        strain[..., self._rows] = own
        return strain

    def forces(self, stress: FloatArray) -> FloatArray:
        """Nodal forces ∫ Bᵀ σ of stresses (b, m, p, 6) [Pa], shape (b, n) [N]."""
        b, n = len(stress), self.mesh.points.size
        weighted = (stress * self.weight[:, :, None])[..., self._rows]
        cells = np.einsum("mpsi,bmps->bmi", self.matrix, weighted, optimize=True)
        own = self.dofs.ravel() + n * np.arange(b)[:, None]
        return np.bincount(own.ravel(), cells.ravel(), b * n).reshape(b, n)

    def stiffness(self, moduli: FloatArray) -> sparse.csr_array:
        """∫ Bᵀ D B of one block for moduli D (m, p, 6, 6) [Pa], shape (n, n) [N/m]."""
        m, p = self.weight.shape
        rows = self._rows
        own = self.weight[:, :, None, None] * moduli[:, :, rows][:, :, :, rows]
        half = np.matmul(own, self.matrix).reshape(m, p * len(rows), -1)
        cells = np.matmul(self.matrix.reshape(m, p * len(rows), -1).transpose(0, 2, 1), half)
        data = np.bincount(self.pattern, cells.ravel(), len(self.columns))
        n = self.mesh.points.size
        return sparse.csr_array((data, self.columns, self.pointers), shape=(n, n))

    def integral(self, density: FloatArray) -> FloatArray:
        """∫ of a density (b, m, p), shape (b,)."""
        total: FloatArray = np.einsum("bmp,mp->b", density, self.weight)
        return total

    @property
    def band(self) -> FloatArray:
        """Width of the band that localised strains have at the points, shape (m, p) [m].

        The d-th root of an element's volume, over its order: the crack band of Bažant and Oh (1983).
        """
        width = self.weight.sum(axis=1) ** (1.0 / self.mesh.dimension) / order(self.mesh.cell)
        return np.repeat(width[:, None], self.weight.shape[1], axis=1)

    @property
    def _rows(self) -> list[int]:
        return _IN_PLANE[self.mesh.dimension]
