"""MaterialLaw: stress, tangent and memory of a stone's material at its quadrature points.

    law = DruckerPrager(cohesion=2e6, friction_angle=35.0)
    committed = law.initial(count)
    made = law.update(elastic, start, strain, committed, size)     # of a step from ``start`` to ``strain``
    made.stress, made.tangent, made.internal                 # made.internal is committed once the step holds

Tensors have the components (xx, yy, zz, xy, yz, xz). Strains are small, and their shear components are the
angles γ = 2 ε_xy, so that stress · strain is work. Tension is positive. A plane strain is one whose zz, yz
and xz are 0.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from masonry_fem.joints.parameters import check_ranges

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

UNIT: FloatArray = np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
# deviator of a strain given by angles, as a tensor; and of a stress
DEVIATOR: FloatArray = np.diag([1.0, 1.0, 1.0, 0.5, 0.5, 0.5]) - np.outer(UNIT, UNIT) / 3
SHEARS: FloatArray = np.array([1.0, 1.0, 1.0, 2.0, 2.0, 2.0])  # a : b = Σ SHEARS a b of two tensors


@dataclass(frozen=True, slots=True)
class Isotropic:
    """Isotropic linear elasticity.

    Attributes
    ----------
    bulk, shear : Moduli K and G [Pa].
    """

    bulk: float
    shear: float

    @classmethod
    def of(cls, young: float, poisson: float) -> Isotropic:
        """From Young's modulus E [Pa] and Poisson's ratio ν, −1 < ν < ½."""
        return cls(young / (3 * (1 - 2 * poisson)), young / (2 * (1 + poisson)))

    @property
    def young(self) -> float:
        """E [Pa]."""
        return 9 * self.bulk * self.shear / (3 * self.bulk + self.shear)

    @property
    def poisson(self) -> float:
        """ν."""
        return (3 * self.bulk - 2 * self.shear) / (6 * self.bulk + 2 * self.shear)

    @property
    def matrix(self) -> FloatArray:
        """Matrix by which a strain is multiplied to give its stress, shape (6, 6) [Pa]."""
        matrix: FloatArray = self.bulk * np.outer(UNIT, UNIT) + 2 * self.shear * DEVIATOR
        return matrix


@dataclass(frozen=True, slots=True)
class Response:
    """What a material law returns for a step, at q points; k is its number of internal variables.

    The work of the step is fully accounted for: stress · (strain − start) = change of ``stored`` +
    ``dissipation`` + ``excess``, where the stress is that of the end and the strains are those of ``update``.

    Attributes
    ----------
    stress : Stress at the end, shape (q, 6) [Pa].
    tangent : Derivative of this stress with respect to the strain at the end, shape (q, 6, 6) [Pa].
    internal : Internal variables at the end, shape (q, k).
    stored : Density of the stored energy at the end, shape (q,) [J/m³].
    dissipation : Energy density lost in the step, ≥ 0, shape (q,) [J/m³].
    excess : What remains, since the work is that of the stress at the end, which is reached only there: of
        second order in the step, > 0 where stress grows, shape (q,) [J/m³].
    changed : True at points whose tangent is not the elastic one, shape (q,).
    held : Tangent with the damage kept as it is at the end, which has no negative slope, shape (q, 6, 6)
        [Pa]; None: the law has no damage.
    """

    stress: FloatArray
    tangent: FloatArray
    internal: FloatArray
    stored: FloatArray
    dissipation: FloatArray
    excess: FloatArray
    changed: BoolArray
    held: FloatArray | None = None


class MaterialLaw(ABC):
    """Base class of the laws by which stones yield or crack.

    The fields of a law, a dataclass, are its parameters; their annotations give unit and range. Stresses and
    strains have the components (xx, yy, zz, xy, yz, xz), tension is positive, and the shear strains are the
    angles γ = 2 ε_xy, so that stress · strain is work. q is the number of points.
    """

    __slots__ = ()

    name: ClassVar[str]
    variables: ClassVar[int]  # internal variables a point

    def __post_init__(self) -> None:
        """Refuse parameters out of their range."""
        check_ranges(self)

    @property
    def softens(self) -> bool:
        """Whether it loses strength as it is strained further; messages depend on it."""
        return False

    def initial(self, count: int) -> FloatArray:
        """Internal variables of the fresh material at ``count`` points, shape (count, k)."""
        return np.zeros((count, self.variables))

    def refuse(self, elastic: Isotropic, size: FloatArray) -> None:  # noqa: B027 - most laws refuse nothing
        """Raise LawError if the law cannot be used with these moduli or elements.

        Parameters
        ----------
        elastic : Moduli of the intact material.
        size : Sizes of the elements as in ``update``, shape (q,) [m].
        """

    @abstractmethod
    def update(
        self,
        elastic: Isotropic,
        start: FloatArray,
        strain: FloatArray,
        committed: FloatArray,
        size: FloatArray,
    ) -> Response:
        """Stress, tangent and internal variables at the end of a step.

        Parameters
        ----------
        elastic : Moduli of the intact material.
        start, strain : Strains at the start and the end of the step, shape (q, 6).
        committed : Internal variables at the start, shape (q, k); not to be changed.
        size : Width of the band in which strains localise if the law softens: the size of the element, or
            half of it if the element is quadratic, shape (q,) [m].
        """

    def yields(self, elastic: Isotropic, strain: FloatArray, size: FloatArray) -> BoolArray:
        """Where fresh material does not stay elastic when it is strained from 0 to ``strain``, shape (q,).

        Parameters
        ----------
        elastic : Moduli of the intact material.
        strain : Strains, shape (q, 6).
        size : Sizes of the elements as in ``update``, shape (q,) [m].
        """
        count = len(strain)
        return self.update(elastic, np.zeros_like(strain), strain, self.initial(count), size).changed

    @abstractmethod
    def measures(self, internal: FloatArray) -> Mapping[str, FloatArray]:
        """Quantities for fields and tables, by name, shape (q,), from the internal variables (q, k)."""
