"""Principal: isotropic laws written in principal stresses, and turned back with their tangents.

values, axes = principal(trial)                     # greatest first
tensors(values, axes)                               # back
tangents(moduli, shears, axes)                      # of derivatives by principal strains
"""

from __future__ import annotations

import numpy as np

from masonry_fem.fem.material_law import FloatArray

_PLACE = np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2]])  # of (xx, yy, zz, xy, yz, xz)
_I, _J = np.array([0, 1, 2, 0, 1, 0]), np.array([0, 1, 2, 1, 2, 2])


def principal(stress: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Principal values (q, 3), the greatest first, and their axes as columns (q, 3, 3), of (q, 6)."""
    values, axes = np.linalg.eigh(full(stress))
    return values[:, ::-1], axes[:, :, ::-1]


def tensors(values: FloatArray, axes: FloatArray) -> FloatArray:
    """Components of tensors, shape (q, 6).

    Parameters
    ----------
    values : Principal values, shape (q, 3).
    axes : Principal axes, as columns, shape (q, 3, 3).
    """
    return components((axes * values[:, None]) @ axes.transpose(0, 2, 1))


def full(tensors: FloatArray) -> FloatArray:
    """Tensors (q, 3, 3) of components (q, 6)."""
    return tensors[:, _PLACE]


def components(matrices: FloatArray) -> FloatArray:
    """Components (q, 6) of symmetric tensors (q, 3, 3)."""
    return matrices[:, _I, _J]


def tangents(moduli: FloatArray, shears: FloatArray, axes: FloatArray) -> FloatArray:
    """Tangents by strains with angles, shape (q, 6, 6).

    Parameters
    ----------
    moduli : Derivatives of principal stresses by principal strains, shape (q, 3, 3) [Pa].
    shears : τ over γ in the planes (1, 2), (2, 3) and (1, 3), shape (q, 3) [Pa].
    axes : Principal axes, as columns, shape (q, 3, 3).
    """
    q = len(axes)
    own = np.zeros((q, 6, 6))
    own[:, :3, :3] = moduli
    own[:, [3, 4, 5], [3, 4, 5]] = shears
    # strains in the axes: ε'_ab = Σ A_ia A_jb ε_ij, with γ = 2 ε
    turn = np.einsum("qka,qlb->qabkl", axes, axes)[:, _I, _J]
    turn = 0.5 * (turn + turn.transpose(0, 1, 3, 2))
    map_ = turn[:, :, _I, _J]
    map_[:, 3:] *= 2.0  # angles in the axes
    tangent: FloatArray = map_.transpose(0, 2, 1) @ own @ map_
    return tangent
