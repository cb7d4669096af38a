"""Rigid modes: the motions of a block that strain nothing and that its clamps allow."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from masonry_fem.bodies.rotation import lever

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class RigidModes:
    """Mass-orthonormal rigid modes of a shape with n dofs; m = 3 in 2D, 6 in 3D.

    Columns that clamps forbid are zero: the first ``count`` are modes.

    Attributes
    ----------
    count : Number of modes that the clamps leave, 0 to m.
    modes : Φ, zero at clamped dofs, shape (n, m) [kg^−½].
    momentum : M Φ with its rows at clamped dofs, shape (n, m).
    from_motion : Φᵀ M R: U of unit velocities and unit spins about the centroid, shape (m, m).
    centroid : Centre of mass in the shape's frame, shape (d,) [m].
    """

    count: int
    modes: FloatArray
    momentum: FloatArray
    from_motion: FloatArray
    centroid: FloatArray

    def split(self, field: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Amplitudes U (k, m) of the modes in nodal fields (k, n), and what is left of these."""
        amplitudes = field @ self.momentum
        return amplitudes, field - amplitudes @ self.modes.T


def rigid_modes(points: FloatArray, mass: sparse.csr_array, free: IntArray) -> RigidModes:
    """Rigid modes of a mesh, orthonormal with respect to its mass, as far as clamps allow them.

    Parameters
    ----------
    points : Nodes, shape (k, d) [m].
    mass : Mass matrix, shape (k d, k d) [kg].
    free : Degrees of freedom that no clamp holds.
    """
    d = points.shape[1]
    unit = np.zeros((points.size, d))
    unit[np.arange(points.size), np.arange(points.size) % d] = 1.0
    nodal = mass @ unit[:, 0]
    centroid = nodal[::d] @ points / nodal.sum()
    arms = points - centroid
    size = float(np.abs(arms).max())
    motions = np.concatenate([unit, lever(arms).reshape(points.size, -1)], axis=1)
    scale = np.concatenate([np.ones(d), np.full(motions.shape[1] - d, 1 / size)])
    allowed = _allowed(motions * scale, free)
    basis = (motions * scale) @ allowed
    held = np.ones(len(basis), dtype=bool)
    held[free] = False
    basis[held] = 0.0
    basis = _orthonormalised(basis, mass)
    modes = np.zeros_like(motions)
    modes[:, : basis.shape[1]] = basis
    momentum = mass @ modes
    return RigidModes(basis.shape[1], modes, momentum, momentum.T @ motions, centroid)


def _allowed(motions: FloatArray, free: IntArray) -> FloatArray:
    """Combinations of the motions that vanish at all dofs but the free ones, as columns."""
    held = np.delete(motions, free, axis=0)
    if not len(held):
        return np.eye(motions.shape[1])
    # of a triangle with the same right singular vectors: a clamped face may have thousands of rows
    _, values, rows = np.linalg.svd(np.linalg.qr(held, mode="r"), full_matrices=True)
    rank = int((values > 1e-9 * max(values[0], 1e-300)).sum())
    return rows[rank:].T


def _orthonormalised(basis: FloatArray, mass: sparse.csr_array) -> FloatArray:
    """The same columns made mass-orthonormal, twice for accuracy."""
    for _ in range(2):
        gram = basis.T @ (mass @ basis)
        if gram.size:
            basis = np.linalg.solve(np.linalg.cholesky(gram), basis.T).T
    return basis
