"""Principal: isotropic laws written in principal stresses, and turned back with their tangents.

values, axes = principal(trial)                     # greatest first
tensors(values, axes)                               # back
tangents(moduli, sheared(strains, stress, moduli), axes)     # of derivatives by principal strains
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


def sheared(strains: FloatArray, stress: FloatArray, moduli: FloatArray) -> FloatArray:
    """τ over γ in the planes (1, 2), (2, 3) and (1, 3), as the axes turn with the strain, shape (q, 3) [Pa].

    ½ (σ_i − σ_j)/(ε_i − ε_j), and where the strains are equal its limit ½ (D_ii − D_ij).

    Parameters
    ----------
    strains : Principal strains that have the axes of the stress, shape (q, 3).
    stress : Principal stresses, shape (q, 3) [Pa].
    moduli : Derivatives of these by principal strains, shape (q, 3, 3) [Pa].

    References
    ----------
    de Souza Neto, Perić, Owen, Computational Methods for Plasticity (Wiley 2008), A.5.
    """
    shears = np.empty_like(strains)
    size = np.abs(strains).max(axis=1)
    for row, (i, j) in enumerate(((0, 1), (1, 2), (0, 2))):
        apart = strains[:, i] - strains[:, j]
        equal = apart <= 1e-8 * size
        ratio = (stress[:, i] - stress[:, j]) / np.where(equal, 1.0, apart)
        shears[:, row] = 0.5 * np.where(equal, moduli[:, i, i] - moduli[:, i, j], ratio)
    return shears
