"""Inelasticity: stresses by a material law at each Gauss point, with memory.

    constitution = Inelasticity(operators)              # of a material with a law
    made = constitution.followed(state, displacement, time)   # from the committed state on, in every round

A step is Newton-Raphson on the blocks. The first round goes on from the start of the step with the tangents
of the step before, where there is inertia with the elastic ones. Each further one is linearised at the end
that the round before came to, its guess, whose stresses σ(q⁺) and tangents are those of the law in a step
from the committed state:

    u_el⁺ = u_el,guess + (M̂_t⁻¹)_el [Gᵀ p − ℛ(u_guess)],       M̂_t = M̂ + h²θ² (K_t − K)

Rigid motions strain nothing, so that they are as of elastic blocks. Only blocks that yield in the guess have
factors of their own (``tangent``); the others share the elastic one.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import cached_property
from typing import override

import numpy as np
from scipy import sparse

from masonry_fem.fem.assemble import ShapeOperators
from masonry_fem.fem.constitution import Confined, Constitution, FloatArray, Memory, Strained, dot
from masonry_fem.fem.expansion import Warming, held_unit, less, pushing
from masonry_fem.fem.material_law import UNIT, Isotropic
from masonry_fem.fem.strains import Strains


class Inelasticity(Constitution):
    """Stresses by the law of a material.

    Parameters
    ----------
    operators : Mesh, stiffness and mass, of a material with a law.
    warming : Strains of the blocks by temperature; None: there are none.

    Raises
    ------
    LawError : The law does not go with its stone or its elements.
    """

    nonlinear = True

    def __init__(self, operators: ShapeOperators, warming: Warming | None = None) -> None:
        material = operators.material
        assert material.law is not None  # the fidelity sees to it
        self._operators, self._law = operators, material.law
        self.law, self.softens, self.warming = material.law.name, material.law.softens, warming
        self._elastic = Isotropic.of(material.young, material.poisson)
        self._law.refuse(self._elastic, self.strains.band.ravel())

    @cached_property
    def strains(self) -> Strains:
        """Gradients of the mesh."""
        return Strains.of(self._operators.mesh)

    @override
    def fresh(self, count: int) -> Memory:
        m, p = self.strains.weight.shape
        internal = self._law.initial(count * m * p).reshape(count, m, p, -1)
        none = np.zeros(count)
        nobody = np.zeros(0, dtype=np.int64)
        stress, stored = np.zeros((count, m, p, 6)), none
        if self.warming is not None:
            strain = less(stress, self.warming.strain(0.0))
            stress = strain @ self._moduli
            stored = 0.5 * self.strains.integral((stress * strain).sum(axis=-1))
        return Memory(internal, stress, stored, none, none, nobody, np.zeros((0, m, p, 6, 6)), None)

    @override
    def followed(self, before: Strained, displacement: FloatArray, time: float) -> Memory:
        start = self._strain(before.displacement, before.time)
        return self._yielded(start, self._strain(displacement, time), remembered(before).internal)

    def _yielded(self, start: FloatArray, end: FloatArray, internal: FloatArray) -> Memory:
        """The memory after a step between strains (b, m, p, 6) with internal variables (b, m, p, k)."""
        b, m, p = internal.shape[:3]
        committed, band = internal.reshape(b * m * p, -1), np.tile(self.strains.band.ravel(), b)
        made = self._law.update(self._elastic, start.reshape(-1, 6), end.reshape(-1, 6), committed, band)

        def summed(density: FloatArray) -> FloatArray:
            return self.strains.integral(density.reshape(b, m, p))

        yielding = np.flatnonzero(made.changed.reshape(b, -1).any(axis=1))
        return Memory(
            made.internal.reshape(b, m, p, -1),
            made.stress.reshape(b, m, p, 6),
            summed(made.stored),
            summed(made.dissipation),
            summed(made.excess),
            yielding,
            made.tangent.reshape(b, m, p, 6, 6)[yielding],
            None if made.held is None else made.held.reshape(b, m, p, 6, 6)[yielding],
        )

    @override
    def forces(
        self, before: Strained, after: Strained, theta: float, rate: FloatArray | None = None
    ) -> FloatArray:
        stress = remembered(before).stress
        if after is not before:
            stress = (1 - theta) * stress + theta * remembered(after).stress
        force = self.strains.forces(stress)
        if rate is not None:
            force += rate @ self._operators.stiffness
        return force

    @override
    def lost(self, before: Strained, after: Strained, theta: float) -> tuple[FloatArray, FloatArray]:
        """Stresses of the end work ``excess`` more than is stored and lost, σ_θ (1 − θ) Δσ : Δε less."""
        own, stretch = remembered(after), after.displacement - before.displacement
        change = own.stress - remembered(before).stress
        grown = dot(self.strains.forces(change), stretch)
        if self.warming is not None:
            grown -= self._pressed(change) * self.warming.change(before, after)
        return own.excess - (1 - theta) * grown, own.dissipated

    @override
    def joined(self, before: Strained, after: Strained, lost: FloatArray | float) -> Memory:
        own, stretch = remembered(after), after.displacement - before.displacement
        work = dot(self.strains.forces(own.stress), stretch)
        if self.warming is not None:
            work -= self._pressed(own.stress) * self.warming.change(before, after)
        dissipated = np.zeros_like(work) + lost
        return replace(
            own, dissipated=dissipated, excess=work - (own.stored - remembered(before).stored) - dissipated
        )

    @override
    def expanding(self, state: Strained, step: float, *, tangent: bool = False) -> FloatArray | float:
        if self.warming is None:
            return 0.0
        change = self.warming.strain(state.time + step) - self.warming.strain(state.time)
        force = change[:, None] * pushing(self.strains, self._moduli)
        if tangent:
            own = remembered(state)
            force[own.yielding] = change[own.yielding, None] * self.strains.forces(own.moduli @ UNIT)
        return force

    @override
    def heat(self, before: Strained, after: Strained, theta: float) -> FloatArray | float:
        if self.warming is None:
            return 0.0
        mean = (1 - theta) * remembered(before).stress + theta * remembered(after).stress
        return -self._pressed(mean) * self.warming.change(before, after)

    @cached_property
    def _unit(self) -> Confined:
        return held_unit(self.strains, self._moduli)

    @override
    def confined(self, before: Strained, after: Strained) -> Confined:
        if self.warming is None:
            return Confined()
        return self.warming.confined(before, after, self._unit)

    def _pressed(self, stress: FloatArray) -> FloatArray:
        """∫ σ : 1 of stresses (b, m, p, 6), shape (b,) [J]."""
        return self.strains.integral(stress[..., :3].sum(axis=-1))

    def _strain(self, displacement: FloatArray, time: float) -> FloatArray:
        """Strains that make stress, of displacements (b, n) at a time [s], shape (b, m, p, 6)."""
        strain = self.strains.at_points(displacement)
        return strain if self.warming is None else less(strain, self.warming.strain(time))

    @property
    def _moduli(self) -> FloatArray:
        """Stress of a strain in the elastic stone, as its stiffness has it, shape (6, 6) [Pa]."""
        return self._operators.material.moduli(self._operators.plane)

    @override
    def stored(self, state: Strained) -> FloatArray:
        return remembered(state).stored

    @override
    def shown(self, state: Strained) -> Mapping[str, FloatArray]:
        internal = remembered(state).internal
        shape = internal.shape[:-1]
        flat = internal.reshape(math.prod(shape), internal.shape[-1])  # which may be 0
        return {name: values.reshape(shape) for name, values in self._law.measures(flat).items()}

    @override
    def tangents(self, guess: Strained) -> Iterator[tuple[int, sparse.csr_array]]:
        own = remembered(guess)
        for body, moduli in zip(own.yielding.tolist(), own.moduli, strict=True):
            yield body, self.strains.stiffness(moduli)


def remembered(state: Strained) -> Memory:
    """The memory of a state whose material has one."""
    assert state.memory is not None
    return state.memory
