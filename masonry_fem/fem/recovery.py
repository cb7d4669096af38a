"""Recovery: a more accurate stress, from the points where the elements' stress is most accurate.

    nodal = superconvergent(mesh)          # values at Gauss points -> values at nodes, sparse
    better = nodal @ gauss                 # linear: one matrix for all blocks and steps

Superconvergent patch recovery (Zienkiewicz and Zhu 1992): for each corner of the cells a polynomial of the
elements' order is fitted to the stress of the cells around it, at the points where finite elements are most
accurate. Corners on the surface take the polynomial of the inner corner next to them or, where there is none
(in a mesh that is one cell thick), that of the neighbouring corner with most cells. Each block has a mesh of
its own, so that no patch extends across a joint.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from masonry_fem.fem.lagrange import is_simplex, lagrange, linear, order, quadrature
from masonry_fem.fem.monomials import exponents
from masonry_fem.solid.mesh import Mesh

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
Mask = NDArray[np.bool_]

FLAT = 1e-12  # of the largest variance of sample points: axes with less are not fitted along
RANK = 1e-8  # singular values below it belong to terms that the samples do not determine
LOWER = 1e-4  # weight of a quadratic term where samples cannot tell it from a lower one, which is preferred


@dataclass(frozen=True, slots=True)
class _Samples:
    """Where stresses are read: ``take`` maps Gauss values to s samples, cell by cell, at places (s, d)."""

    take: sparse.csr_array
    places: FloatArray


def superconvergent(mesh: Mesh) -> sparse.csr_array:
    """Matrix from values at the Gauss points (rows cell, point) to values at nodes, shape (nodes, m p).

    References
    ----------
    Zienkiewicz, Zhu, The superconvergent patch recovery and a posteriori error estimates, part 1, Int. J.
    Numer. Meth. Engng 33 (1992).
    Barlow, Optimal stress locations in finite element models, Int. J. Numer. Meth. Engng 10 (1976).
    """
    return _Patches.of(mesh).fitted(mesh, _best_samples(mesh))


# --- samples ----------------------------------------------------------------------------------


def _best_samples(mesh: Mesh) -> _Samples:
    """Barlow's points: the middle of linear cells, 2 Gauss points a direction in quadratic boxes.

    Where a mesh is one linear cell thick they tell no gradient across: what the cells have of it, right or
    wrong, counts as an error. A single cell would else be thought exact.
    """
    points, weights = quadrature(mesh.cell)
    if is_simplex(mesh.cell):
        return _samples(mesh, np.eye(len(points)), points)
    if order(mesh.cell) == 1:
        return _samples(mesh, (weights / weights.sum())[None], np.full((1, mesh.dimension), 0.5))
    best, _ = quadrature(linear(mesh.cell))
    box = lagrange(mesh.cell)
    return _samples(mesh, box.values(best) @ np.linalg.inv(box.values(points)), best)


def _samples(mesh: Mesh, local: FloatArray, points: FloatArray) -> _Samples:
    """Samples of every cell alike: ``local`` maps its Gauss values to its samples at reference points."""
    count = len(mesh.cells)
    take = sparse.csr_array(sparse.kron(sparse.eye_array(count), sparse.csr_array(local)))
    places = np.einsum("pk,mkd->mpd", lagrange(mesh.cell).values(points), mesh.points[mesh.cells])
    return _Samples(take, places.reshape(-1, mesh.dimension))


# --- patches ----------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class _Patches:
    """Which cells lie about each corner, and whose polynomial each node takes.

    Attributes
    ----------
    cells : Whether a cell touches a corner, shape (nodes, m), 0 or 1; empty rows for other nodes.
    share : Weight that a node gives the polynomial of each corner, shape (nodes, nodes); rows sum to 1.
    """

    cells: sparse.csr_array
    share: sparse.csr_array

    @classmethod
    def of(cls, mesh: Mesh) -> _Patches:
        """The patches of a mesh."""
        nodes, corners = len(mesh.points), mesh.cells[:, : len(lagrange(linear(mesh.cell)).nodes)]
        where = np.repeat(np.arange(len(corners)), corners.shape[1])
        ones = np.ones(corners.size)
        cells = sparse.csr_array((ones, (corners.ravel(), where)), shape=(nodes, len(corners)))
        inner = np.zeros(nodes, dtype=bool)
        inner[corners] = True
        inner[mesh.facets] = False
        return cls(cells, sparse.csr_array(blend(mesh) @ _nearest_patch(cells, inner)))

    def fitted(self, mesh: Mesh, samples: _Samples) -> sparse.csr_array:
        """What the patches' polynomials give the nodes: Gauss values to nodes."""
        centres = np.unique(self.share.indices)  # corners whose polynomial some node takes
        belongs = sparse.csr_array(self.cells[centres])
        each = len(samples.places) // self.cells.shape[1]
        owner = np.repeat(np.arange(len(centres)), np.diff(belongs.indptr) * each)
        picked = (belongs.indices[:, None] * each + np.arange(each)).ravel()
        fit = _Fit.of(samples.places[picked], np.bincount(owner, minlength=len(centres)), order(mesh.cell))
        terms = sparse.csr_array(
            (
                fit.coefficients.ravel(),
                (
                    (owner[:, None] * fit.terms + np.arange(fit.terms)).ravel(),
                    np.repeat(picked, fit.terms),
                ),
            ),
            shape=(len(centres) * fit.terms, len(samples.places)),
        )
        share = sparse.coo_array(self.share[:, centres])
        node, centre = share.coords
        values = share.data[:, None] * fit.basis(mesh.points[node], np.asarray(centre, dtype=np.int64))
        columns = centre[:, None] * fit.terms + np.arange(fit.terms)
        evaluate = sparse.csr_array(
            (values.ravel(), (np.repeat(node, fit.terms), columns.ravel())),
            shape=(len(mesh.points), len(centres) * fit.terms),
        )
        return narrow(evaluate @ terms @ samples.take)


def narrow(matrix: sparse.csr_array) -> sparse.csr_array:
    """The same with indices of half the size: a large mesh has as many of them as numbers."""
    indices, pointers = matrix.indices.astype(np.int32), matrix.indptr.astype(np.int32)
    return sparse.csr_array((matrix.data, indices, pointers), shape=matrix.shape)


def blend(mesh: Mesh) -> sparse.csr_array:
    """Second-order nodes as means of the corners of the edge, face or cell they lie in; corners stay.

    Weights of corners in the value of each node, shape (nodes, nodes).
    """
    nodes = len(mesh.points)
    if order(mesh.cell) == 1:
        return sparse.csr_array(sparse.eye_array(nodes))
    simple = lagrange(linear(mesh.cell))
    weight = simple.values(lagrange(mesh.cell).nodes)  # of a cell's nodes by its corners
    local, corner = np.nonzero(weight > 1e-12)
    rows, columns = mesh.cells[:, local].ravel(), mesh.cells[:, corner].ravel()
    data = np.tile(weight[local, corner], len(mesh.cells))
    total = sparse.coo_array((data, (rows, columns)), shape=(nodes, nodes)).tocsr()
    count = np.bincount(mesh.cells.ravel(), minlength=nodes)  # each cell has contributed once
    return sparse.csr_array(sparse.diags_array(1.0 / np.maximum(count, 1)) @ total)


def _nearest_patch(cells: sparse.csr_array, inner: Mask) -> sparse.csr_array:
    """The corner whose patch each corner takes: its own inside, else the best one next to it.

    Inner ones are best, then those with most cells about them; of these the ones that share most cells.
    """
    shared = sparse.coo_array(cells @ cells.T)
    row, column, common = shared.coords[0], shared.coords[1], shared.data
    size = np.diff(cells.indptr)
    rank = (
        np.where(inner[column], size.max(initial=0) + 1, size[column]) * (size.max(initial=0) + 1.0) + common
    )
    own = inner[row]
    rank = np.where(own & (row != column), -1.0, rank)
    best = np.full(cells.shape[0], -1.0)
    np.maximum.at(best, row, rank)
    keep = rank == best[row]
    row, column = row[keep], column[keep]
    count = np.bincount(row, minlength=cells.shape[0])
    return sparse.csr_array((1.0 / count[row], (row, column)), shape=cells.shape[:1] * 2)


# --- fits -------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class _Fit:
    """Least-squares polynomials of w patches.

    Attributes
    ----------
    middle, turn : Affine map to each patch's own coordinates, shapes (w, d) and (w, d, d).
    exponents : Of the monomials, shape (t, d).
    coefficients : What each sample adds to each of its patch's terms, shape (samples, t).
    """

    middle: FloatArray
    turn: FloatArray
    exponents: IntArray
    coefficients: FloatArray

    @property
    def terms(self) -> int:
        """Number of monomials."""
        return len(self.exponents)

    @classmethod
    def of(cls, places: FloatArray, counts: IntArray, degree: int) -> _Fit:
        """Fits to samples (s, d) that lie patch by patch, ``counts`` of them in each."""
        d, start = places.shape[1], np.concatenate([[0], np.cumsum(counts)])
        powers = exponents(d, degree, lowest=0)
        dear = LOWER ** np.maximum(powers.sum(axis=1) - 1.0, 0.0)
        middle, turn = np.zeros((len(counts), d)), np.zeros((len(counts), d, d))
        coefficients = np.zeros((len(places), len(powers)))
        for count in np.unique(counts):  # patches of one size at once
            mine = np.flatnonzero(counts == count)
            rows = start[mine][:, None] + np.arange(count)
            middle[mine], turn[mine] = _whitening(places[rows])
            local = np.einsum("wij,wsj->wsi", turn[mine], places[rows] - middle[mine][:, None])
            terms = np.prod(local[:, :, None] ** powers, axis=3)
            inverse = dear[:, None] * np.linalg.pinv(terms * dear, rcond=RANK)
            coefficients[rows] = np.swapaxes(inverse, 1, 2)
        return cls(middle, turn, powers, coefficients)

    def basis(self, points: FloatArray, patch: IntArray) -> FloatArray:
        """Monomials at points (k, d), each of a patch (k,), shape (k, t)."""
        local = np.einsum("kij,kj->ki", self.turn[patch], points - self.middle[patch])
        terms: FloatArray = np.prod(local[:, None] ** self.exponents, axis=2)
        return terms


def _whitening(places: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Middle of samples (w, s, d) and the map that gives them unit spread; flat directions map to 0."""
    middle = places.mean(axis=1)
    off = places - middle[:, None]
    values, vectors = np.linalg.eigh(np.einsum("wsi,wsj->wij", off, off) / places.shape[1])
    real = values > FLAT * np.maximum(values[:, -1:], 1e-300)
    scale = np.where(real, 1.0 / np.sqrt(np.where(real, values, 1.0)), 0.0)
    return middle, scale[:, :, None] * np.swapaxes(vectors, 1, 2)
