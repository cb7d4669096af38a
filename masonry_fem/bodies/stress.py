"""Stress: invariants of Cauchy stress tensors with components (xx, yy, zz, xy, yz, xz)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def tensor(stress: FloatArray) -> FloatArray:
    """The symmetric matrices of components (..., 6), shape (..., 3, 3)."""
    components: FloatArray = stress[..., [0, 3, 5, 3, 1, 4, 5, 4, 2]]
    matrices: FloatArray = components.reshape(*stress.shape[:-1], 3, 3)
    return matrices


def von_mises(stress: FloatArray) -> FloatArray:
    """Von Mises equivalent of stresses (..., 6), same unit, shape (...)."""
    xx, yy, zz, xy, yz, xz = np.moveaxis(stress, -1, 0)
    normal = 0.5 * ((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2)
    squared: FloatArray = normal + 3.0 * (xy**2 + yz**2 + xz**2)
    return np.sqrt(squared)


def principal(stress: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Principal stresses, largest (most tensile) first, (..., 3), and unit directions, rows, (..., 3, 3)."""
    values, vectors = np.linalg.eigh(tensor(stress))
    return values[..., ::-1], np.swapaxes(vectors, -1, -2)[..., ::-1, :]
