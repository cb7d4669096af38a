"""Imbalance: by how much a recovered stress fails to balance what acts on a block, as energies.

    imbalance = Imbalance.of(mesh, moduli, points, weights)
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
from masonry_fem.fem.monomials import monomial_slopes, monomials
from masonry_fem.fem.recovery import blend
from masonry_fem.solid.mesh import Mesh

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

_COMPONENT = np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2]])  # of (xx, yy, zz, xy, yz, xz), by row and column
ENOUGH = 1.5  # nodes for each polynomial of degree 3
AT_ONCE = 1000  # cells at once: of all, what their points have between would be several times the maps
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
    volume : What each point stands for, shape (m, q) [m³; m² in 2D].
    """

    slopes: tuple[sparse.csc_array, ...]
    corners: sparse.csr_array
    share: tuple[sparse.csr_array, ...]
    values: FloatArray
    soft: FloatArray
    volume: FloatArray

    @classmethod
    def of(cls, mesh: Mesh, moduli: FloatArray, points: FloatArray, weights: FloatArray) -> Self:
        """The maps of a mesh.

        Parameters
        ----------
        mesh : Elements of a shape.
        moduli : Stresses (xx, yy, zz, xy, yz, xz) of strains with angles, shape (6, 6) [Pa].
        points : Reference points where stresses are compared, shape (q, d).
        weights : Of these points in an integral over the reference cell, shape (q,).
        """
        element, simple = lagrange(mesh.cell), lagrange(linear(mesh.cell))
        gradients, corners = element.gradients(points), mesh.cells[:, : len(simple.nodes)]
        d, (m, k), q = mesh.dimension, mesh.cells.shape, len(points)
        place = _COMPONENT[:d, :d]
        stiffness = moduli[place[:, :, None, None], place]  # C_ajbl
        middle, size = mesh.points.mean(axis=0), float(np.ptp(mesh.points, axis=0).max())
        degree = _degree(mesh)
        values = monomials((mesh.points - middle) / size, degree)
        # an array for each axis: SciPy copies parts of a larger one
        slopes = [np.empty((m, q, k)) for _ in range(d)]
        own, volume = np.empty((d, *corners.shape)), np.empty((m, q))
        A = np.zeros((len(values), d, len(values), d))
        for first in range(0, m, AT_ONCE):
            some = slice(first, first + AT_ONCE)
            nodes = mesh.points[mesh.cells[some]]
            jacobian = np.einsum("mkd,qkt->mqdt", nodes, gradients)
            inverse, part = np.linalg.inv(jacobian), np.linalg.det(jacobian) * weights
            for axis, slope in enumerate(slopes):
                slope[some] = np.einsum("qkt,mqt,mq->mqk", gradients, inverse[..., axis], part)
            linearly = np.einsum("qkt,mqtd->mqkd", simple.gradients(points), inverse)
            squares = np.einsum("mqkj,mqkl,mq->mkjl", linearly, linearly, part)
            own[:, some] = np.einsum("mkjl,ajal->amk", squares, stiffness)
            at = (element.values(points) @ nodes).reshape(-1, d)
            exact = monomial_slopes((at - middle) / size, degree) / size
            pulled = exact * part.reshape(-1, 1)
            A += np.einsum("tqj,ajbl,sql->tasb", pulled, stiffness, exact, optimize=True)
            volume[some] = part
        strength, modes = np.linalg.eigh(A.reshape(len(values) * d, -1))
        real = strength > RIGID * strength[-1]
        soft = (modes[:, real] / np.sqrt(strength[real])).T
        share = _shares(corners, own, len(mesh.points))
        return cls(_by_node(mesh, slopes), sparse.csr_array(blend(mesh).T), share, values, soft, volume)

    def squares(self, missing: FloatArray) -> FloatArray:
        """Energies by cell of b blocks from σ* − σ_h at the points, (m q, b, 6) [Pa], shape (b, m) [J]."""
        total = np.zeros((len(self.volume), missing.shape[1]))
        d, bending = len(self.slopes), []
        for row, share in zip(_COMPONENT[:d, :d], self.share, strict=True):
            force = np.zeros((self.corners.shape[0], missing.shape[1]))
            for k, slope in zip(row, self.slopes, strict=True):
                force += slope @ missing[..., k]
            total += share @ np.square(self.corners @ force)
            bending.append(self.values @ force)
        whole = np.stack(bending, axis=1).reshape(self.soft.shape[1], -1)
        part = self.volume.sum(axis=1) / float(self.volume.sum())
        total += part[:, None] * np.square(self.soft @ whole).sum(axis=0)
        return total.T


def _by_node(mesh: Mesh, slopes: list[FloatArray]) -> tuple[sparse.csc_array, ...]:
    """Slopes (m, q, k) along each axis as matrices: a column is a point, with the nodes of its cell."""
    m, q, k = slopes[0].shape
    rows = np.broadcast_to(mesh.cells[:, None].astype(np.int32), (m, q, k)).ravel()  # one array for all axes
    start = np.arange(0, len(rows) + 1, k, dtype=np.int32)
    shape = (len(mesh.points), m * q)
    return tuple(sparse.csc_array((values.ravel(), rows, start), shape=shape) for values in slopes)


def _shares(corners: IntArray, own: FloatArray, count: int) -> tuple[sparse.csr_array, ...]:
    """``share`` of each component.

    Parameters
    ----------
    corners : Of the cells, shape (m, k).
    own : What each cell adds to D_i there, shape (d, m, k) [N/m; N/m² in 2D].
    count : Nodes of the mesh.
    """
    rows, share = np.repeat(np.arange(len(corners), dtype=np.int32), corners.shape[1]), []
    nodes = corners.ravel().astype(np.int32)
    for part in own:
        total = np.bincount(nodes, part.ravel(), count)
        data = (part / total[corners] ** 2).ravel()
        share.append(sparse.csr_array((data, (rows, nodes)), shape=(len(corners), count)))
    return tuple(share)


def _degree(mesh: Mesh) -> int:
    """Of the polynomials over a block; of few nodes corners tell what those of degree 3 would tell again."""
    simplices = is_simplex(mesh.cell) and order(mesh.cell) == 1
    terms = comb(mesh.dimension + 3, 3) - 1
    return 3 if simplices and len(mesh.points) >= ENOUGH * terms else 2
