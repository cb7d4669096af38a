"""Expansion: strains that temperature gives to stones, and the stresses of elastic stones that have them.

warming = Warming.of({0: [(8e-6 * 20.0, ramp)]}, np.arange(2))   # strains times functions of time
warming.strain(time)                                # e, the same in all directions, (b,)
constitution = ThermoElasticity(operators, warming)

Stresses are of what strain is left, σ = C (ε − e 1), so that a stone that is free to expand has none. Heat
works by −σ : 1 ė on the stone; this is neither work of forces nor lost, but a term of its own.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Self, override

import numpy as np

from masonry_fem.fem.assemble import ShapeOperators
from masonry_fem.fem.constitution import Confined, FloatArray, LinearElasticity, Strained, dot, times
from masonry_fem.fem.material_law import UNIT
from masonry_fem.fem.strains import Strains
from masonry_fem.solid.mesh import IntArray

Change = tuple[float, Callable[[float], float]]  # a strain, and the factor that it has in time


@dataclass(frozen=True, slots=True)
class Warming:
    """Strains by temperature of b blocks.

    Attributes
    ----------
    strains : By change and block, shape (k, b). factors : Of the k changes, as functions of time [s].
    """

    strains: FloatArray
    factors: tuple[Callable[[float], float], ...]

    @classmethod
    def of(cls, changes: Mapping[int, Sequence[Change]], blocks: IntArray) -> Self | None:
        """Of the changes of some blocks, by number; None where there are none.

        Parameters
        ----------
        changes : By block. blocks : Whose they are, ascending, shape (b,).
        """
        changed = np.intersect1d(blocks, np.array(list(changes), dtype=np.int64)).tolist()
        factors = {id(factor): factor for block in changed for _, factor in changes[block]}
        if not factors:
            return None
        row = {key: place for place, key in enumerate(factors)}
        strains = np.zeros((len(factors), len(blocks)))
        for body, block in zip(np.searchsorted(blocks, changed).tolist(), changed, strict=True):
            for strain, factor in changes[block]:
                strains[row[id(factor)], body] += strain
        return cls(strains, tuple(factors.values()))

    def strain(self, time: float) -> FloatArray:
        """The strain e of each block at a time [s], shape (b,)."""
        total: FloatArray = np.array([factor(time) for factor in self.factors]) @ self.strains
        return total

    def change(self, before: Strained, after: Strained) -> FloatArray:
        """How much further blocks expand from one state to another, shape (b,)."""
        return self.strain(after.time) - self.strain(before.time)

    def confined(self, before: Strained, after: Strained, unit: Confined) -> Confined:
        """What it would take to hold the larger of the strains of two states.

        Parameters
        ----------
        before, after : The states. unit : What a unit strain takes.
        """
        largest = np.maximum(np.abs(self.strain(before.time)), np.abs(self.strain(after.time)))
        return Confined(largest**2 * unit.energy, largest * unit.force)


class ThermoElasticity(LinearElasticity):
    """Stresses that are linear in the strains that temperature does not give.

    Parameters
    ----------
    operators : Mesh, stiffness and mass. warming : Strains of the blocks by temperature.
    """

    def __init__(self, operators: ShapeOperators, warming: Warming) -> None:
        super().__init__(operators)
        self.warming: Warming = warming
        self._moduli = operators.material.moduli(operators.plane)
        self._mesh = operators.mesh

    @cached_property
    def strains(self) -> Strains:
        """Gradients of the mesh."""
        return Strains.of(self._mesh)

    @cached_property
    def push(self) -> FloatArray:
        """Nodal forces ∫ Bᵀ C 1 of a unit strain, shape (n,) [N]."""
        return pushing(self.strains, self._moduli)

    @cached_property
    def _held(self) -> float:
        """∫ 1 : C : 1, twice the energy of a unit strain that is held [J]."""
        return float(UNIT @ self._moduli @ UNIT * self.strains.weight.sum())

    @cached_property
    def _unit(self) -> Confined:
        return held_unit(self.strains, self._moduli)

    @override
    def forces(
        self, before: Strained, after: Strained, theta: float, rate: FloatArray | None = None
    ) -> FloatArray:
        grown = self._mean(before, after, theta)
        return super().forces(before, after, theta, rate) - grown[:, None] * self.push

    @override
    def expanding(self, state: Strained, step: float, *, tangent: bool = False) -> FloatArray:
        change = self.warming.strain(state.time + step) - self.warming.strain(state.time)
        return change[:, None] * self.push

    @override
    def lost(self, before: Strained, after: Strained, theta: float) -> tuple[FloatArray, FloatArray]:
        change, stretch = self.warming.change(before, after), after.displacement - before.displacement
        square = dot(times(stretch, self._stiffness), stretch) - 2 * change * (stretch @ self.push)
        return (theta - 0.5) * (square + change**2 * self._held), np.zeros(len(stretch))

    @override
    def heat(self, before: Strained, after: Strained, theta: float) -> FloatArray:
        reached = (1 - theta) * before.displacement + theta * after.displacement
        pressure = self._mean(before, after, theta) * self._held - reached @ self.push
        return pressure * self.warming.change(before, after)

    @override
    def confined(self, before: Strained, after: Strained) -> Confined:
        return self.warming.confined(before, after, self._unit)

    @override
    def stored(self, state: Strained) -> FloatArray:
        """½ ∫ (ε − e 1) : C : (ε − e 1)."""
        grown, bent = self.warming.strain(state.time), state.displacement
        return super().stored(state) - grown * (bent @ self.push) + 0.5 * grown**2 * self._held

    @override
    def stress(self, state: Strained) -> FloatArray:
        strain = self.strains.at_points(state.displacement)
        return less(strain, self.warming.strain(state.time)) @ self._moduli

    def _mean(self, before: Strained, after: Strained, theta: float) -> FloatArray:
        grown = self.warming.strain(before.time)
        return grown if after is before else (1 - theta) * grown + theta * self.warming.strain(after.time)


def held_unit(strains: Strains, moduli: FloatArray) -> Confined:
    """What it takes to hold a unit strain in one block.

    Parameters
    ----------
    strains : Of the mesh. moduli : C, shape (6, 6) [Pa].
    """
    push = pushing(strains, moduli).reshape(-1, strains.mesh.dimension)
    energy = 0.5 * float(UNIT @ moduli @ UNIT * strains.weight.sum())
    return Confined(energy, float(np.linalg.norm(push, axis=1).sum()))


def pushing(strains: Strains, moduli: FloatArray) -> FloatArray:
    """Nodal forces ∫ Bᵀ C 1 that hold a unit strain, shape (n,) [N].

    Parameters
    ----------
    strains : Of the mesh. moduli : C, shape (6, 6) [Pa].
    """
    stress = np.broadcast_to(moduli @ UNIT, (1, *strains.weight.shape, 6))
    force: FloatArray = strains.forces(stress)[0]
    return force


def less(strain: FloatArray, grown: FloatArray) -> FloatArray:
    """Strains without what temperature gives, shape (b, m, p, 6).

    Parameters
    ----------
    strain : At Gauss points, shape (b, m, p, 6). grown : Strain e of each block by temperature, shape (b,).
    """
    return strain - grown[:, None, None, None] * UNIT
