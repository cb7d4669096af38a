"""Error estimate: energy norm of the difference between recovered stress and the elements' own stress.

    estimate = ErrorEstimate.of(mesh, material)
    squares = estimate.squares(gauss)              # e² of each cell of each block, (b, m)

e² = ∫ (σ* − σ_h) : C⁻¹ : (σ* − σ_h) with the recovered stress σ*. It is compared with the norm of the stress
itself, ‖u_h‖² = ∫ σ_h : C⁻¹ : σ_h, which is twice the strain energy. All maps are linear and made once for
each shape.

References
----------
Zienkiewicz, Zhu, A simple error estimator and adaptive procedure for practical engineering analysis, Int. J.
Numer. Meth. Engng 24 (1987).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from masonry_fem.fem.lagrange import is_simplex, lagrange, order, quadrature
from masonry_fem.fem.material import ElasticMaterial
from masonry_fem.fem.recovery import superconvergent
from masonry_fem.solid.mesh import Mesh

FloatArray = NDArray[np.float64]

AT_ONCE = 4_000_000  # stress components held at once: blocks are taken in portions


@dataclass(frozen=True, slots=True)
class ErrorEstimate:
    """Linear maps of one shape from stresses at Gauss points to the recovered stress less them.

    Attributes
    ----------
    nodal : Values at Gauss points to recovered values at nodes, shape (nodes, m p).
    there : Nodal values to the q points of each cell where both are compared, shape (m q, nodes).
    here : Gauss values to the same points, shape (m q, m p).
    volume : What each point stands for, shape (m, q) [m³; m² in 2D].
    material : For C⁻¹.
    """

    nodal: sparse.csr_array
    there: sparse.csr_array
    here: sparse.csr_array
    volume: FloatArray
    material: ElasticMaterial

    @classmethod
    def of(cls, mesh: Mesh, material: ElasticMaterial) -> Self:
        """The maps of one shape."""
        points, weights = comparison(mesh.cell)
        element, m, q = lagrange(mesh.cell), len(mesh.cells), len(points)
        jacobian = np.einsum("mkd,pkt->mpdt", mesh.points[mesh.cells], element.gradients(points))
        values = np.broadcast_to(element.values(points), (m, q, len(element.nodes)))
        rows = np.repeat(np.arange(m * q), len(element.nodes))
        columns = np.broadcast_to(mesh.cells[:, None], values.shape).ravel()
        there = sparse.csr_array((values.ravel(), (rows, columns)), shape=(m * q, len(mesh.points)))
        here = sparse.kron(sparse.eye_array(m), sparse.csr_array(_own(mesh.cell, points)))
        volume = np.linalg.det(jacobian) * weights
        return cls(superconvergent(mesh), there, sparse.csr_array(here), volume, material)

    def squares(self, gauss: FloatArray) -> FloatArray:
        """e² of each cell of b blocks from their stresses (b, m, p, 6), any axes, shape (b, m) [J]."""
        b, m = len(gauss), len(self.volume)
        result = np.empty((b, m))
        portion = max(1, AT_ONCE // (6 * self.volume.size))
        for first in range(0, b, portion):
            part = gauss[first : first + portion]
            flat = np.ascontiguousarray(part.reshape(len(part), -1, 6).transpose(1, 0, 2)).reshape(
                -1, 6 * len(part)
            )
            missing = self.there @ (self.nodal @ flat) - self.here @ flat
            density = energy_density(missing.reshape(-1, len(part), 6), self.material)
            result[first : first + portion] = np.einsum(
                "mqb,mq->bm", density.reshape(*self.volume.shape, len(part)), self.volume
            )
        return result


def energy_density(stress: FloatArray, material: ElasticMaterial) -> FloatArray:
    """σ : C⁻¹ : σ of stresses (..., 6) [J/m³]; plane cases bring their own σ_zz."""
    trace = stress[..., :3].sum(axis=-1)
    square = np.square(stress[..., :3]).sum(axis=-1) + 2 * np.square(stress[..., 3:]).sum(axis=-1)
    density: FloatArray = ((1 + material.poisson) * square - material.poisson * trace**2) / material.young
    return density


def comparison(cell: str) -> tuple[FloatArray, FloatArray]:
    """Points and weights that integrate the square of a recovered stress: degree 2 or 4."""
    if not is_simplex(cell):
        return quadrature(cell)
    if order(cell) == 1:
        return quadrature({"triangle": "triangle6", "tetra": "tetra10"}[cell])
    return _triangle_of_degree_4() if cell == "triangle6" else _tetra_of_degree_5()


def _own(cell: str, points: FloatArray) -> FloatArray:
    """A cell's stress at reference points from its Gauss values, shape (q, p)."""
    known, _ = quadrature(cell)
    if len(known) == len(points) and np.array_equal(known, points):
        return np.eye(len(points))
    if len(known) == 1:
        return np.ones((len(points), 1))
    fit = lagrange({"triangle6": "triangle", "tetra10": "tetra"}[cell])
    values: FloatArray = fit.values(points) @ np.linalg.inv(fit.values(known))
    return values


def _triangle_of_degree_4() -> tuple[FloatArray, FloatArray]:
    """Six points of degree 4 (Dunavant, Int. J. Numer. Meth. Engng 21, 1985)."""
    points, weights = [], []
    for a, w in ((0.445948490915965, 0.223381589678011), (0.091576213509771, 0.109951743655322)):
        points += [(a, a), (1 - 2 * a, a), (a, 1 - 2 * a)]
        weights += [0.5 * w] * 3
    return np.array(points), np.array(weights)


def _tetra_of_degree_5() -> tuple[FloatArray, FloatArray]:
    """Walkington's fourteen points, all weights positive."""
    points, weights = [], []
    for a, w in (
        (0.31088591926330060980, 0.11268792571801585080),
        (0.092735250310891226402, 0.073493043116361949544),
    ):
        points += [(a, a, a), (1 - 3 * a, a, a), (a, 1 - 3 * a, a), (a, a, 1 - 3 * a)]
        weights += [w / 6] * 4
    a, w = 0.045503704125649649492, 0.042546020777081466438
    b = 0.5 - a
    points += [(a, a, b), (a, b, a), (b, a, a), (b, b, a), (b, a, b), (a, b, b)]
    weights += [w / 6] * 6
    return np.array(points), np.array(weights)
