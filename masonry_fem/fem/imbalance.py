"""Imbalance: by how much a recovered stress fails to balance what acts on a block, as energies.

    imbalance = Imbalance.of(mesh, moduli, points, jacobian, volume)
    imbalance.squares(missing)                   # of each cell of each block, (b, m)

The elements' stress σ_h balances all that acts on the nodes, contacts and clamps too. What a recovered stress
σ* fails to balance, r(v) = ∫ (σ_h − σ*) : ε(v) with displacements v of the elements, thus needs no loads:

- of the linear functions L_i of corners, r is ∫ L_i (f + div σ*) within the block and ∮ L_i (t − σ* n) on its
  surface, where t is what contacts give, 0 where a joint is open. Its energy is r² / D_i with the stiffness
  D_i = ∫ ε(L_i) : C : ε(L_i) against moving one corner one way.
- of the values that a polynomial p of low degree has at the nodes, r tells of bending: linear elements are
  too stiff for it, all the more where they lock, and their smooth stress is too small as a whole. Its energy
  is that of the polynomial w with ∫ ε(w) : C : ε(p) = r(p) for all p: of polynomials, which do not lock.
  Their degree is 2, of linear simplices that are not few 3: these are the stiffest, of constant stress.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import comb
from typing import Self

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from masonry_fem.fem.lagrange import is_simplex, lagrange, linear, order
from masonry_fem.fem.monomials import monomials
from masonry_fem.fem.recovery import blend
from masonry_fem.solid.mesh import Mesh

FloatArray = NDArray[np.float64]

_COMPONENT = np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2]])  # of (xx, yy, zz, xy, yz, xz), by row and column
ENOUGH = 1.5  # nodes for each polynomial of degree 3
AT_ONCE = 1000  # cells whose slopes are held at once: they would be the largest array of all
RIGID = 1e-10  # of the largest stiffness of a polynomial: those with less do not strain the block


@dataclass(frozen=True, slots=True)
class Imbalance:
    """Maps from stresses at the m q points of a mesh to forces, and the energies of these.

    Attributes
    ----------
    slopes : ∂_k of the nodes' functions times the volume of each point, one matrix an axis, shapes (n, m q)
        [m²; m in 2D].
    corners : Part of each node's force that corners bear, by their linear functions, shape (n, n).
    share : Part of each cell in D_i, over D_i², one matrix a component, shapes (m, n) [m/N; m²/N in 2D].
    values : Of the polynomials at the nodes, shape (t, n) [m].
    soft : A^(−½) of the polynomials' own stiffness A, shape (modes, t d) [(N m)^(−½)].
    part : Of each cell in the volume, shape (m,).
    """

    slopes: tuple[sparse.csc_array, ...]
    corners: sparse.csr_array
    share: tuple[sparse.csr_array, ...]
    values: FloatArray
    soft: FloatArray
    part: FloatArray

    @classmethod
    def of(
        cls, mesh: Mesh, moduli: FloatArray, points: FloatArray, jacobian: FloatArray, volume: FloatArray
    ) -> Self:
        """The maps of a mesh.

        Parameters
        ----------
        mesh : Elements of a shape.
        moduli : Stresses (xx, yy, zz, xy, yz, xz) of strains with angles, shape (6, 6) [Pa].
        points : Reference points where stresses are compared, shape (q, d).
        jacobian : There, shape (m, q, d, d).
        volume : What they stand for, shape (m, q) [m³; m² in 2D].
        """
        d = mesh.dimension
        place = _COMPONENT[:d, :d]
        stiffness = moduli[place[:, :, None, None], place]  # C_ajbl
        inverse = np.linalg.inv(jacobian)
        share = _shares(mesh, stiffness, points, inverse, volume)
        slopes = _slopes(mesh, points, inverse, volume)
        middle, size = mesh.points.mean(axis=0), float(np.ptp(mesh.points, axis=0).max())
        degree = _degree(mesh)
        values, _ = monomials((mesh.points - middle) / size, degree)
        A = np.zeros((len(values), d, len(values), d))
        for first in range(0, len(mesh.cells), AT_ONCE):
            some = slice(first, first + AT_ONCE)
            at = lagrange(mesh.cell).values(points) @ mesh.points[mesh.cells[some]]
            _, exact = monomials((at.reshape(-1, d) - middle) / size, degree)
            exact /= size
            pulled = exact * volume[some].reshape(-1, 1)
            A += np.einsum("tqj,ajbl,sql->tasb", pulled, stiffness, exact, optimize=True)
        strength, modes = np.linalg.eigh(A.reshape(len(values) * d, -1))
        real = strength > RIGID * strength[-1]
        soft = (modes[:, real] / np.sqrt(strength[real])).T
        part = volume.sum(axis=1) / float(volume.sum())
        return cls(slopes, sparse.csr_array(blend(mesh).T), share, values, soft, part)

    def squares(self, missing: FloatArray) -> FloatArray:
        """Energies by cell of b blocks from σ* − σ_h at the points, (m q, b, 6) [Pa], shape (b, m) [J]."""
        total = np.zeros((len(self.part), missing.shape[1]))
        d, bending = len(self.slopes), []
        for row, share in zip(_COMPONENT[:d, :d], self.share, strict=True):
            force = np.zeros((self.corners.shape[0], missing.shape[1]))
            for k, slope in zip(row, self.slopes, strict=True):
                force += slope @ missing[..., k]
            total += share @ np.square(self.corners @ force)
            bending.append(self.values @ force)
        whole = np.stack(bending, axis=1).reshape(self.soft.shape[1], -1)
        total += self.part[:, None] * np.square(self.soft @ whole).sum(axis=0)
        return total.T


def _slopes(
    mesh: Mesh, points: FloatArray, inverse: FloatArray, volume: FloatArray
) -> tuple[sparse.csc_array, ...]:
    """``slopes`` of all nodes."""
    gradients = lagrange(mesh.cell).gradients(points)
    # column by column: the nodes of a point's cell, one array of indices for all axes
    rows = np.broadcast_to(mesh.cells[:, None].astype(np.int32), (*volume.shape, mesh.cells.shape[1])).ravel()
    start = np.arange(0, len(rows) + 1, mesh.cells.shape[1], dtype=np.int32)
    along = (np.einsum("qkt,mqt,mq->mqk", gradients, part, volume) for part in np.moveaxis(inverse, 3, 0))
    shape = (len(mesh.points), volume.size)
    return tuple(sparse.csc_array((values.ravel(), rows, start), shape=shape) for values in along)


def _shares(
    mesh: Mesh, stiffness: FloatArray, points: FloatArray, inverse: FloatArray, volume: FloatArray
) -> tuple[sparse.csr_array, ...]:
    """``share`` of the linear functions of corners."""
    simple = lagrange(linear(mesh.cell))
    k, n, m = len(simple.nodes), len(mesh.points), len(mesh.cells)
    corners = mesh.cells[:, :k]
    own = np.empty((len(stiffness), m, k))
    for first in range(0, m, AT_ONCE):
        some = slice(first, first + AT_ONCE)
        slope = np.einsum("qkt,mqtd->mqkd", simple.gradients(points), inverse[some])
        squares = np.einsum("mqkj,mqkl,mq->mkjl", slope, slope, volume[some])
        own[:, some] = np.einsum("mkjl,ajal->amk", squares, stiffness)
    share = []
    for part in own:
        total = np.bincount(corners.ravel(), part.ravel(), n)
        data = (part / total[corners] ** 2).ravel()
        share.append(sparse.csr_array((data, (np.repeat(np.arange(m), k), corners.ravel())), shape=(m, n)))
    return tuple(share)


def _degree(mesh: Mesh) -> int:
    """Of the polynomials over a block; of few nodes corners tell what those of degree 3 would tell again."""
    simplices = is_simplex(mesh.cell) and order(mesh.cell) == 1
    terms = comb(mesh.dimension + 3, 3) - 1
    return 3 if simplices and len(mesh.points) >= ENOUGH * terms else 2
