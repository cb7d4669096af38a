"""Constitution: stresses of b blocks of one mesh and material, what they store and lose, and their tangents.

    constitution = LinearElasticity(operators)          # or Inelasticity: a law with memory
    memory = constitution.fresh(b)
    memory = constitution.followed(state, displacement, time)     # the step from a state to new displacements
    constitution.forces(before, after, theta)           # ∫ Bᵀ [(1 − θ) σ + θ σ⁺]

How blocks turn is none of its concern: displacements are elastic parts, in the axes of the shape or of the
frame that turns with the block. Groups of either kinematics have one.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol, override

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

if TYPE_CHECKING:
    from masonry_fem.fem.assemble import ShapeOperators
    from masonry_fem.fem.expansion import Warming

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Memory:
    """What the material of b blocks remembers, and its stresses: m cells of p points.

    Attributes
    ----------
    internal : Internal variables of the law, k a point, shape (b, m, p, k).
    stress : Axes of the shape or frame, shape (b, m, p, 6) [Pa].
    stored : Energy that the blocks can give back, shape (b,) [J].
    dissipated, excess : Of the step that led here: what was lost, and what stresses of its end work more
        than they would have on the way (``Response``), shape (b,) [J].
    yielding : Blocks of which some point yields in that step, shape (y,).
    moduli : Their tangents, shape (y, m, p, 6, 6) [Pa].
    held : The same where damage stays as it is; None: the law has none.
    """

    internal: FloatArray
    stress: FloatArray
    stored: FloatArray
    dissipated: FloatArray
    excess: FloatArray
    yielding: IntArray
    moduli: FloatArray
    held: FloatArray | None


@dataclass(frozen=True, slots=True)
class Confined:
    """What it would take to hold strains by temperature at zero, in b blocks.

    Where blocks are free to expand, forces and energies of this size cancel but for rounding.

    Attributes
    ----------
    energy : That the blocks would store, shape (b,) [J]; or 0. force : On nodes, summed up, (b,) [N]; or 0.
    """

    energy: FloatArray | float = 0.0
    force: FloatArray | float = 0.0


class Strained(Protocol):
    """A state of b blocks as their material sees it: time [s], elastic displacements (b, n) [m], memory."""

    @property
    def time(self) -> float: ...  # noqa: D102

    @property
    def displacement(self) -> FloatArray: ...  # noqa: D102

    @property
    def memory(self) -> Memory | None: ...  # noqa: D102


class Constitution(ABC):
    """What stones are made of, as the groups see it.

    Attributes
    ----------
    nonlinear : Whether forces are not linear in displacements, so that steps take rounds.
    law : Name of the law of its material, for reports. softens : Whether it loses strength.
    warming : Strains that temperature gives the blocks; None: none.
    """

    nonlinear: bool
    law: str
    softens: bool = False
    warming: Warming | None = None

    @abstractmethod
    def fresh(self, count: int) -> Memory | None:
        """The memory of ``count`` blocks that nothing has strained."""

    @abstractmethod
    def followed(self, before: Strained, displacement: FloatArray, time: float) -> Memory | None:
        """The memory after a step from a state to displacements (b, n) [m] at a time [s]."""

    def joined(self, before: Strained, after: Strained, lost: FloatArray | float) -> Memory | None:
        """The memory after a step that was reached by several, which lost so much, (b,) [J]."""
        return after.memory

    @abstractmethod
    def forces(
        self, before: Strained, after: Strained, theta: float, rate: FloatArray | None = None
    ) -> FloatArray:
        """Nodal forces of stresses (1 − θ) σ + θ σ⁺, shape (b, n) [N].

        ``rate`` (b, n) [m] adds K times itself, as viscous stresses do.
        """

    @abstractmethod
    def lost(self, before: Strained, after: Strained, theta: float) -> tuple[FloatArray, FloatArray]:
        """Energy that the θ-scheme and the material took in a step, each of shape (b,) [J]."""

    def expanding(self, state: Strained, step: float, *, tangent: bool = False) -> FloatArray | float:
        """Nodal forces that hold what temperature makes stones grow in a step, (b, n) [N]; or 0.

        By the elastic stiffness, or by the ``tangent`` of the state, which stones that yield have.
        """
        return 0.0

    def heat(self, before: Strained, after: Strained, theta: float) -> FloatArray | float:
        """Work of heat in a step, −∫ σ_θ : 1 Δe of strains e by temperature, shape (b,) [J]; or 0."""
        return 0.0

    def confined(self, before: Strained, after: Strained) -> Confined:
        """What it would take to hold the strains that temperature gives to stones."""
        return Confined()

    @abstractmethod
    def stored(self, state: Strained) -> FloatArray:
        """Energy that the blocks can give back, shape (b,) [J]."""

    def stress(self, state: Strained) -> FloatArray | None:
        """At Gauss points, shape (b, m, p, 6) [Pa]; None: that of linear elasticity."""
        return None if state.memory is None else state.memory.stress

    def shown(self, state: Strained) -> Mapping[str, FloatArray]:
        """What field files show of the memory: by name, shape (b, m, p); {} where there is none."""
        return {}

    def promoted(self, state: Strained) -> FloatArray | None:
        """Time from which each stone has not been elastic any more, ∞ while it is, shape (b,) [s].

        None where stones are elastic, or are not, from the start on.
        """
        return None

    def tangents(self, guess: Strained) -> Iterator[tuple[int, sparse.csr_array]]:
        """The blocks whose tangent is not the elastic stiffness, with K_t, shape (n, n) [N/m]; none here."""
        return iter(())


class LinearElasticity(Constitution):
    """Stresses that are linear in strains: no memory, nothing lost.

    Parameters
    ----------
    operators : Mesh, stiffness and mass.
    """

    nonlinear = False
    law = "elastic"

    def __init__(self, operators: ShapeOperators) -> None:
        self._stiffness = operators.stiffness

    @override
    def fresh(self, count: int) -> None:
        return None

    @override
    def followed(self, before: Strained, displacement: FloatArray, time: float) -> None:
        return None

    @override
    def forces(
        self, before: Strained, after: Strained, theta: float, rate: FloatArray | None = None
    ) -> FloatArray:
        stretch = before.displacement
        if after is not before:
            stretch = (1 - theta) * stretch + theta * after.displacement
        if rate is not None:
            stretch = stretch + rate
        return times(stretch, self._stiffness)

    @override
    def lost(self, before: Strained, after: Strained, theta: float) -> tuple[FloatArray, FloatArray]:
        stretch = after.displacement - before.displacement
        return (theta - 0.5) * dot(times(stretch, self._stiffness), stretch), np.zeros(len(stretch))

    @override
    def stored(self, state: Strained) -> FloatArray:
        """½ qᵀ K q."""
        return 0.5 * dot(times(state.displacement, self._stiffness), state.displacement)


def dot(a: FloatArray, b: FloatArray) -> FloatArray:
    """Scalar products block by block, shape (b,).

    Parameters
    ----------
    a, b : One vector per block, shape (b, n).
    """
    product: FloatArray = np.einsum("bn,bn->b", a, b)
    return product


def times(vectors: FloatArray, matrix: sparse.csr_array) -> FloatArray:
    """Products with a symmetric matrix block by block: ``vectors @ matrix`` would transpose it each time.

    Parameters
    ----------
    vectors : One per block, shape (b, n).
    matrix : Symmetric, shape (n, n).

    Returns
    -------
    Products, shape (b, n).
    """
    product: FloatArray = (matrix @ vectors.T).T
    return product
