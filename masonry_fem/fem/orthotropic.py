"""Orthotropic: linear elasticity with three axes of its own, as bedded stone or timber has it.

    oak = Orthotropic((12e9, 1e9, 1e9), (0.4, 0.4, 0.4), (0.8e9, 0.1e9, 0.8e9), turn)
    oak.matrix                                      # stress of a strain in the shape's axes, (6, 6)

In its own axes 1, 2, 3 strains are ε_i = σ_i/E_i − Σ_j ν_ji σ_j/E_j and γ_ij = τ_ij/G_ij, with
ν_ij/E_i = ν_ji/E_j.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from masonry_fem.errors import SceneError
from masonry_fem.fem.materials.parts.principal import tangents

FloatArray = NDArray[np.float64]
Three = tuple[float, float, float]
PAIRS = ((0, 1), (1, 2), (0, 2))  # of axes, in the order of ν and G
DIGITS = 12  # of a turn: stones whose axes differ by rounding share their matrices


@dataclass(frozen=True, slots=True)
class Orthotropic:
    """Linear elasticity with three planes of symmetry.

    Attributes
    ----------
    young : E_1, E_2, E_3 [Pa].
    poisson : ν_12, ν_23, ν_13; ν_ij is how much j is narrowed by a unit stretch along i.
    shear : G_12, G_23, G_13 [Pa].
    turn : Own axes as columns, in those of the shape, shape (3, 3), row by row.

    Raises
    ------
    SceneError
        If some strain would give energy.
    """

    young: Three
    poisson: Three
    shear: Three
    turn: tuple[float, ...] = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)

    def __post_init__(self) -> None:
        if fault := unstable(self.young, self.poisson):
            raise SceneError(f"orthotropic material: {fault}; correct poisson or young")

    def turned(self, rotation: FloatArray) -> Orthotropic:
        """The material after its axes have been turned by ``rotation``, shape (d, d)."""
        axes = np.eye(3)
        d = len(rotation)
        axes[:d, :d] = rotation
        turn = axes @ np.reshape(self.turn, (3, 3))
        return replace(self, turn=tuple(np.round(turn, DIGITS).ravel().tolist()))

    @property
    def matrix(self) -> FloatArray:
        """Stress (xx, yy, zz, xy, yz, xz) of strains with angles, axes of the shape, shape (6, 6) [Pa]."""
        moduli = np.linalg.inv(compliance(self.young, self.poisson))
        axes = np.reshape(self.turn, (1, 3, 3))
        matrix: FloatArray = tangents(moduli[None], np.array([self.shear]), axes)[0]
        return 0.5 * (matrix + matrix.T)


def compliance(young: Three, poisson: Three) -> FloatArray:
    """Principal strains of principal stresses, own axes, shape (3, 3) [1/Pa].

    Parameters
    ----------
    young : E_1, E_2, E_3 [Pa]. poisson : ν_12, ν_23, ν_13.
    """
    matrix = np.diag(1 / np.array(young, dtype=float))
    for (i, j), ratio in zip(PAIRS, poisson, strict=True):
        matrix[i, j] = matrix[j, i] = -ratio / young[i]
    return matrix


def unstable(young: Three, poisson: Three) -> str:
    """Why moduli are those of no material: some strain would give energy; "" where none does.

    Parameters
    ----------
    young : E_1, E_2, E_3 [Pa]. poisson : ν_12, ν_23, ν_13.
    """
    for (i, j), ratio in zip(PAIRS, poisson, strict=True):
        most = float(np.sqrt(young[i] / young[j]))
        if abs(ratio) >= most:
            names = f"ν_{i + 1}{j + 1}", f"E_{i + 1}/E_{j + 1}"
            return f"{names[0]} is {ratio:g}, expected less than {most:.4g} in size, the root of {names[1]}"
    scale = np.sqrt(np.array(young, dtype=float))
    left = float(np.linalg.det(compliance(young, poisson) * np.outer(scale, scale)))
    if left <= 0:
        return (
            f"1 − ν_12 ν_21 − ν_23 ν_32 − ν_13 ν_31 − 2 ν_21 ν_32 ν_13 is {left:.3g}, expected more than 0, "
            "as some strain would give energy otherwise"
        )
    return ""
