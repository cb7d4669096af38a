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
    """Linear elasticity.

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
        """Stress of a strain, shape (6, 6) [Pa]."""
        matrix: FloatArray = self.bulk * np.outer(UNIT, UNIT) + 2 * self.shear * DEVIATOR
        return matrix


@dataclass(frozen=True, slots=True)
class Response:
    """What a material does in a step, at q points; k is the law's number of internal variables.

    Its work is accounted for without a rest: stress · (strain − start) = change of ``stored`` +
    ``dissipation`` + ``excess``.

    Attributes
    ----------
    stress : At the end, shape (q, 6) [Pa].
    tangent : Its derivative by the strain, consistent with the step, shape (q, 6, 6) [Pa].
    internal : Trial internal variables, shape (q, k).
    stored : Energy density that the material can give back, shape (q,) [J/m³].
    dissipation : Energy density lost in the step, ≥ 0, shape (q,) [J/m³].
    excess : What the stress of the end works more than that, as it is reached only there: of second order in
        the step, > 0 where stress grows, shape (q,) [J/m³].
    changed : Points whose tangent is not the elastic one, shape (q,).
    held : The derivative where damage stays as it is at the end, which has no slope downwards, shape
        (q, 6, 6) [Pa]; None: the law has none.
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
    """What every material law can do.

    A law is its parameters: the fields of a dataclass, whose annotations say unit and range.
    """

    __slots__ = ()

    name: ClassVar[str]
    variables: ClassVar[int]  # internal variables a point

    def __post_init__(self) -> None:
        """Refuse parameters out of their range."""
        check_ranges(self)

    @property
    def softens(self) -> bool:
        """Whether it loses strength as it is strained further; a message on missing balance depends on it."""
        return False

    def initial(self, count: int) -> FloatArray:
        """Internal variables of the fresh material at ``count`` points, shape (count, k)."""
        return np.zeros((count, self.variables))

    def refuse(self, elastic: Isotropic, size: FloatArray) -> None:  # noqa: B027 - most laws refuse nothing
        """Raise LawError where the law does not go with its stone or its elements.

        Parameters
        ----------
        elastic : Of the intact material. size : Of the elements at q points, shape (q,) [m].
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
        """The material after a step.

        Parameters
        ----------
        elastic : Of the intact material.
        start, strain : Strains at the start and the end of the step, shape (q, 6).
        committed : Internal variables at the start, shape (q, k); they are left as they are.
        size : Width of the band that strains localise in where the law softens: that of the element, or of
            its half if it is quadratic, shape (q,) [m].
        """

    def yields(self, elastic: Isotropic, strain: FloatArray, size: FloatArray) -> BoolArray:
        """Whether fresh material that is strained from rest does not stay elastic, shape (q,).

        Parameters
        ----------
        elastic : Of the intact material.
        strain : At q points, shape (q, 6).
        size : Of the elements, as in ``update``, shape (q,) [m].
        """
        count = len(strain)
        return self.update(elastic, np.zeros_like(strain), strain, self.initial(count), size).changed

    @abstractmethod
    def measures(self, internal: FloatArray) -> Mapping[str, FloatArray]:
        """What fields and tables show of the internal variables (q, k): by name, shape (q,)."""
