"""StrainEnergy: a law without memory that is an energy of the strain, written in UFL.

    @dataclass(frozen=True)
    class Stiffening(StrainEnergy):
        growth: float

        name: ClassVar[str] = "stiffening"

        def energy(self, strain, elastic):
            return elastic.bulk / 2 * ufl.tr(strain) ** 2 + ...

Stress and tangent are its derivatives, which UFL makes once for each law. They are evaluated in NumPy at all
Gauss points together.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from functools import cache
from typing import Any, ClassVar, override

import numpy as np

from masonry_fem.errors import LawError
from masonry_fem.fem.material_law import FloatArray, Isotropic, MaterialLaw, Response

# of the elastic modulus: a tangent that differs by less is the elastic one, as steps need it
SAME = 1e-9
# what nodes of an energy are in NumPy, by their class in UFL
OPERATIONS: Mapping[str, Any] = {
    "Sum": np.add, "Product": np.multiply, "Division": np.true_divide, "Power": np.power, "Abs": np.abs,
    "Sign": np.sign, "Sqrt": np.sqrt, "Exp": np.exp, "Ln": np.log, "Sin": np.sin, "Cos": np.cos,
    "Tan": np.tan, "Sinh": np.sinh, "Cosh": np.cosh, "Tanh": np.tanh, "Asin": np.arcsin, "Acos": np.arccos,
    "Atan": np.arctan, "Atan2": np.arctan2, "MaxValue": np.maximum, "MinValue": np.minimum,
    "Conditional": np.where, "GT": np.greater, "GE": np.greater_equal, "LT": np.less, "LE": np.less_equal,
    "EQ": np.equal, "NE": np.not_equal, "AndCondition": np.logical_and, "OrCondition": np.logical_or,
    "NotCondition": np.logical_not, "Conj": np.positive, "Real": np.positive,
}  # fmt: skip


class StrainEnergy(MaterialLaw):
    """Base class of nonlinear elastic laws, given by their energy: no energy is lost."""

    __slots__ = ()

    variables: ClassVar[int] = 0

    @abstractmethod
    def energy(self, strain: Any, elastic: Isotropic) -> Any:
        """Energy density [J/m³] as a scalar UFL expression; at small strains that of linear elasticity.

        Parameters
        ----------
        strain : The strain, a symmetric UFL tensor of shape (3, 3).
        elastic : Moduli of the stone at small strains.
        """

    @override
    def update(
        self,
        elastic: Isotropic,
        start: FloatArray,
        strain: FloatArray,
        committed: FloatArray,
        size: FloatArray,
    ) -> Response:
        stored, stress, moduli = _values(self, elastic, strain)
        before = _values(self, elastic, start)[0]
        changed = np.abs(moduli - elastic.matrix).max(axis=(1, 2)) > SAME * elastic.matrix.max()
        return Response(
            stress=stress,
            tangent=np.where(changed[:, None, None], moduli, elastic.matrix),
            internal=committed,
            stored=stored,
            dissipation=np.zeros(len(strain)),
            excess=(stress * (strain - start)).sum(axis=1) - (stored - before),
            changed=changed,
        )

    @override
    def measures(self, internal: FloatArray) -> Mapping[str, FloatArray]:
        return {}


def _values(
    law: StrainEnergy, elastic: Isotropic, strain: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Energy (q,), stress (q, 6) and tangent (q, 6, 6) of strains (q, 6)."""
    symbols, energy, slopes, curves = _derivatives(law, elastic)
    known = {id(symbol): strain[:, k] for k, symbol in enumerate(symbols)}
    q, stress, moduli = len(strain), np.empty_like(strain), np.empty((len(strain), 6, 6))
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):  # in branches that are not taken
        stored = np.broadcast_to(_value(energy, known, law), q).astype(float)
        for row in range(6):
            stress[:, row] = _value(slopes[row], known, law)
            for column in range(row + 1):
                moduli[:, row, column] = moduli[:, column, row] = _value(curves[row][column], known, law)
    return stored, stress, moduli


def _value(node: Any, known: dict[int, Any], law: StrainEnergy) -> Any:
    """The value of an expression of UFL, scalar or shape (q,); ``known`` are those of parts, by their id."""
    if id(node) in known:
        return known[id(node)]
    kind = type(node).__name__
    if kind in {"IntValue", "FloatValue", "Zero"}:
        return float(node)
    if kind not in OPERATIONS:
        raise LawError(
            f"law '{law.name}': its energy has a {kind} of UFL, expected sums, products, powers, "
            "functions such as exp and conditions, of components of the strain; write it with these"
        )
    made = OPERATIONS[kind](*(_value(part, known, law) for part in node.ufl_operands))
    known[id(node)] = made
    return made


@cache
def _derivatives(law: StrainEnergy, elastic: Isotropic) -> tuple[list[Any], Any, list[Any], list[list[Any]]]:
    """Symbols of the six components, the energy, and its first and second derivatives, as scalars of UFL."""
    from ufl.algorithms.apply_algebra_lowering import apply_algebra_lowering  # noqa: PLC0415
    from ufl.algorithms.apply_derivatives import apply_derivatives  # noqa: PLC0415
    from ufl.algorithms.expand_indices import expand_indices  # noqa: PLC0415

    from masonry_fem.fem import _compat  # noqa: PLC0415

    ufl = _compat.ufl
    domain = ufl.Mesh(_compat.lagrange_element("tetrahedron", 1, 3))
    xx, yy, zz, xy, yz, xz = symbols = [ufl.variable(ufl.Constant(domain)) for _ in range(6)]
    strain = ufl.as_matrix([[xx, xy / 2, xz / 2], [xy / 2, yy, yz / 2], [xz / 2, yz / 2, zz]])
    energy = ufl.as_ufl(law.energy(strain, elastic))
    if energy.ufl_shape:
        raise LawError(
            f"law '{law.name}': its energy has the shape {energy.ufl_shape}, expected a scalar; take a trace "
            "or an inner product"
        )

    def lowered(expression: Any) -> Any:
        return expand_indices(apply_derivatives(apply_algebra_lowering(expression)))

    slopes = [lowered(ufl.diff(energy, symbol)) for symbol in symbols]
    curves = [[lowered(ufl.diff(slope, symbol)) for symbol in symbols] for slope in slopes]
    return symbols, lowered(energy), slopes, curves
