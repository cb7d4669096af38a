"""Error estimate: energy norm of the difference between recovered stress and the elements' own stress.

    estimate = ErrorEstimate.of(mesh, material, plane)
    squares = estimate.squares(gauss)              # e² of each cell of each block, (b, m)

With the recovered stress σ*,

    e² = ∫ (σ* − σ_h) : C⁻¹ : (σ* − σ_h) + what σ* leaves of balance, as energy (``imbalance``)

The second term is what σ* itself is wrong by: the joints' tractions that it does not meet, and the bending
that linear elements are too stiff for.

It is compared with the norm of the stress itself, ‖u_h‖² = ∫ σ_h : C⁻¹ : σ_h, which is twice the strain
energy. All maps are linear and made once for each shape.

References
----------
Zienkiewicz, Zhu, A simple error estimator and adaptive procedure for practical engineering analysis, Int. J.
Numer. Meth. Engng 24 (1987). Díez, Ródenas, Zienkiewicz, Equilibrated patch recovery error estimates: simple
and accurate upper bounds of the error, Int. J. Numer. Meth. Engng 69 (2007), for the term of balance.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from masonry_fem.fem.imbalance import Imbalance
from masonry_fem.fem.lagrange import lagrange, linear, order, quadrature, rule
from masonry_fem.fem.material import ElasticMaterial, Plane
from masonry_fem.fem.recovery import superconvergent
from masonry_fem.solid.mesh import Mesh

FloatArray = NDArray[np.float64]

CELLS = 1000  # whose own stresses are taken to the points at once
AT_ONCE = 4_000_000  # stress components held at once: blocks are taken in portions


@dataclass(frozen=True, slots=True)
class ErrorEstimate:
    """Linear maps of one shape from stresses at Gauss points to the recovered stress less them.

    Attributes
    ----------
    nodal : Values at Gauss points to recovered values at nodes, shape (nodes, m p).
    there : Nodal values to the q points of each cell where both are compared, shape (m q, nodes).
    here : A cell's Gauss values to its own points of these, shape (q, p).
    material : For C⁻¹.
    imbalance : What σ* leaves of balance.
    """

    nodal: sparse.csr_array
    there: sparse.csr_array
    here: FloatArray
    material: ElasticMaterial
    imbalance: Imbalance

    @classmethod
    def of(cls, mesh: Mesh, material: ElasticMaterial, plane: Plane = None) -> Self:
        """The maps of one shape.

        Parameters
        ----------
        mesh : Its elements.
        material : What it is made of.
        plane : ``stress`` where σ_zz is 0; else strains out of the plane are.
        """
        points, weights = comparison(mesh.cell)
        nodal, there = superconvergent(mesh), _interpolation(mesh, points)
        imbalance = Imbalance.of(mesh, material.moduli(plane), points, weights)
        return cls(nodal, there, _own(mesh.cell, points), material, imbalance)

    @property
    def volume(self) -> FloatArray:
        """What each point of comparison stands for, shape (m, q) [m³; m² in 2D]."""
        return self.imbalance.volume

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
            better = (self.there @ (self.nodal @ flat)).reshape(m, -1, 6 * len(part))
            own = flat.reshape(m, -1, 6 * len(part))
            for start in range(0, m, CELLS):  # all at once would be as large as the stresses
                better[start : start + CELLS] -= self.here @ own[start : start + CELLS]
            missing = better.reshape(-1, len(part), 6)
            density = energy_density(missing, self.material)
            result[first : first + portion] = np.einsum(
                "mqb,mq->bm", density.reshape(*self.volume.shape, len(part)), self.volume
            )
            result[first : first + portion] += self.imbalance.squares(missing)
        return result


def energy_density(stress: FloatArray, material: ElasticMaterial) -> FloatArray:
    """σ : C⁻¹ : σ, plane cases with their own σ_zz, shape (...) [J/m³].

    Parameters
    ----------
    stress : Shape (..., 6) [Pa]. material : With C.
    """
    density: FloatArray
    if material.orthotropic is not None:
        density = ((stress @ np.linalg.inv(material.orthotropic.matrix)) * stress).sum(axis=-1)
        return density
    trace = stress[..., :3].sum(axis=-1)
    square = np.square(stress[..., :3]).sum(axis=-1) + 2 * np.square(stress[..., 3:]).sum(axis=-1)
    density = ((1 + material.poisson) * square - material.poisson * trace**2) / material.young
    return density


def comparison(cell: str) -> tuple[FloatArray, FloatArray]:
    """Points and weights that integrate the square of a recovered stress: degree 2 or 4."""
    return rule(cell, 2 * order(cell))


def _interpolation(mesh: Mesh, points: FloatArray) -> sparse.csr_array:
    """Nodal values to reference points (q, d) of each cell, shape (m q, nodes)."""
    element = lagrange(mesh.cell)
    values = np.broadcast_to(element.values(points), (len(mesh.cells), len(points), len(element.nodes)))
    columns = np.broadcast_to(mesh.cells[:, None].astype(np.int32), values.shape)
    start = np.arange(0, values.size + 1, len(element.nodes), dtype=np.int32)
    shape = (len(start) - 1, len(mesh.points))
    made = sparse.csr_array((values.ravel(), columns.ravel(), start), shape=shape)
    made.sort_indices()
    return made


def _own(cell: str, points: FloatArray) -> FloatArray:
    """A cell's stress at reference points from its Gauss values, shape (q, p)."""
    known, _ = quadrature(cell)
    if len(known) == len(points) and np.array_equal(known, points):
        return np.eye(len(points))
    if len(known) == 1:
        return np.ones((len(points), 1))
    fit = lagrange(linear(cell))
    values: FloatArray = fit.values(points) @ np.linalg.inv(fit.values(known))
    return values
