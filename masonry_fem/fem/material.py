"""ElasticMaterial: linear elasticity with Rayleigh damping, and a law of yielding, SI units."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from masonry_fem.errors import SceneError
from masonry_fem.fem.material_law import MaterialLaw
from masonry_fem.fem.orthotropic import Orthotropic

Plane = Literal["strain", "stress"] | None
_COMPONENT = np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2]])  # of (xx, yy, zz, xy, yz, xz)


@dataclass(frozen=True, slots=True)
class ElasticMaterial:
    """What an elastic block is made of.

    Attributes
    ----------
    young : Young's modulus [Pa].
    poisson : Poisson's ratio, −1 < ν < ½.
    orthotropic : In place of both, of stone with axes of its own.
    density : Mass density [kg/m³].
    mass_damping : α of C = α M + β K [1/s].
    stiffness_damping : β of C = α M + β K [s].
    law : By which inelastic blocks yield; None: they stay elastic.
    promote_at : Share of the stress of first yield from which on the law is used; 0: from the start on.
    degree : Of the polynomials by which reduced blocks deform; 0: they deform as their mesh does.

    Raises
    ------
    SceneError
        If a value is outside its range.
    """

    young: float
    poisson: float
    density: float
    mass_damping: float = 0.0
    stiffness_damping: float = 0.0
    law: MaterialLaw | None = None
    promote_at: float = 0.0
    orthotropic: Orthotropic | None = None
    degree: int = 0

    def __post_init__(self) -> None:
        checks = (
            ("young", self.young, self.young > 0, "> 0 Pa"),
            ("poisson", self.poisson, -1 < self.poisson < 0.5, "between -1 and 0.5, both excluded"),
            ("density", self.density, self.density > 0, "> 0 kg/m³"),
            ("mass_damping", self.mass_damping, self.mass_damping >= 0, ">= 0 1/s"),
            ("stiffness_damping", self.stiffness_damping, self.stiffness_damping >= 0, ">= 0 s"),
        )
        for name, value, holds, expected in checks:
            if not holds:
                raise SceneError(
                    f"elastic material: {name} is {value}, expected {expected}; correct the value"
                )

    def lame(self, plane: Plane) -> tuple[float, float]:
        """Lamé's λ and μ [Pa]; in plane stress the reduced λ, so that σ = λ tr ε I + 2μ ε in the plane."""
        E, nu = self.young, self.poisson
        mu = E / (2 * (1 + nu))
        if plane == "stress":
            return E * nu / (1 - nu**2), mu
        return E * nu / ((1 + nu) * (1 - 2 * nu)), mu

    def moduli(self, plane: Plane) -> NDArray[np.float64]:
        """Stress (xx, yy, zz, xy, yz, xz) of strains with angles, shape (6, 6) [Pa].

        In plane stress that of σ_zz = 0, whose ε_zz follows.
        """
        if self.orthotropic is not None:
            matrix = self.orthotropic.matrix
            return matrix - np.outer(matrix[2], matrix[2]) / matrix[2, 2] if plane == "stress" else matrix
        lam, mu = self.lame(plane)
        axes = 2 if plane == "stress" else 3
        matrix = np.zeros((6, 6))
        matrix[:axes, :axes] = lam
        matrix[range(axes), range(axes)] += 2 * mu
        matrix[[3, 4, 5], [3, 4, 5]] = mu
        return matrix

    def stress_matrix(self, dimension: int, plane: Plane) -> NDArray[np.float64]:
        """Stress (xx, yy, zz, xy, yz, xz) of a displacement gradient, shape (6, d, d): σ = D : ∇u."""
        place = _COMPONENT[:dimension, :dimension]
        return self.moduli(plane if dimension == 2 else None)[:, place]
