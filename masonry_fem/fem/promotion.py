"""Promotion: stones that are elastic until their stress comes near to their strength, and yield from then on.

    constitution = Promotion(operators)                       # of a material with a law and ``promote_at``
    constitution.promoted(state)                              # since when each block has its law

Before that a stone's stresses are linear in strains and its law is asked for nothing but whether the strain,
divided by ``promote_at``, would make fresh material yield. The step in which it would is that of the law from
its start on, when the stone is fresh: the results are those of ``Inelasticity``. No stone goes back.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import override

import numpy as np

from masonry_fem.fem.constitution import FloatArray, IntArray, Memory, Strained
from masonry_fem.fem.inelastic import Inelasticity, remembered
from masonry_fem.fem.material_law import BoolArray


@dataclass(frozen=True, slots=True)
class Waiting(Memory):
    """The memory of b stones of which some are elastic still.

    Attributes
    ----------
    since : Time at the end of the step from which on a stone has its law, ∞ before, shape (b,) [s].
    """

    since: FloatArray


class Promotion(Inelasticity):
    """Stresses that are linear in strains, and by the law of the material in stones that come near to yield.

    Parameters
    ----------
    operators : Mesh, stiffness and mass, of a material with a law and the share from which on it is used.

    Raises
    ------
    LawError : The law does not go with its stone or its elements.
    """

    @override
    def fresh(self, count: int) -> Waiting:
        return _waiting(super().fresh(count), np.full(count, np.inf))

    @override
    def promoted(self, state: Strained) -> FloatArray:
        return _since(state)

    @override
    def shown(self, state: Strained) -> Mapping[str, FloatArray]:
        """What the law shows, and ``inelastic``: 1 in stones that have it by now, 0 in the others."""
        shape = remembered(state).internal.shape[:-1]
        known = np.isfinite(_since(state)).astype(float)
        return {**super().shown(state), "inelastic": np.broadcast_to(known[:, None, None], shape).copy()}

    @override
    def followed(self, before: Strained, displacement: FloatArray, time: float) -> Waiting:
        strain = self._strain(displacement, time)
        since = _since(before).copy()
        asleep = np.flatnonzero(np.isinf(since))
        since[asleep[self._near(strain[asleep])]] = time
        awake = np.flatnonzero(np.isfinite(since))
        start = self._strain(before.displacement, before.time)
        linear = self._linear(remembered(before), start, strain)
        if not len(awake):
            return _waiting(linear, since)
        own = self._yielded(start[awake], strain[awake], remembered(before).internal[awake])
        return _waiting(_merged(linear, own, awake), since)

    def _near(self, strain: FloatArray) -> BoolArray:
        """Which of b stones come near to yield, by strains (b, m, p, 6), shape (b,)."""
        b, band = len(strain), self.strains.band.ravel()
        beyond = self._law.yields(
            self._elastic, strain.reshape(-1, 6) / self._operators.material.promote_at, np.tile(band, b)
        )
        near: BoolArray = beyond.reshape(b, len(band)).any(axis=1)
        return near

    def _linear(self, old: Memory, start: FloatArray, strain: FloatArray) -> Memory:
        """The memory of elastic stones: none but stress and energy; by strains of start and end."""
        stress, stretch = strain @ self._moduli, strain - start
        work = 0.5 * np.einsum("bmpi,bmpi->bmp", stress, strain)
        excess = 0.5 * np.einsum("bmpi,bmpi->bmp", stretch @ self._moduli, stretch)
        nothing = np.zeros(len(strain))
        nobody, none = old.yielding[:0], old.moduli[:0]
        return Memory(
            old.internal,
            stress,
            self.strains.integral(work),
            nothing,
            self.strains.integral(excess),
            nobody,
            none,
            None,
        )


def _since(state: Strained) -> FloatArray:
    memory = state.memory
    assert isinstance(memory, Waiting)
    return memory.since


def _waiting(memory: Memory, since: FloatArray) -> Waiting:
    own = {field.name: getattr(memory, field.name) for field in fields(Memory)}
    return Waiting(**own, since=since)


def _merged(linear: Memory, own: Memory, blocks: IntArray) -> Memory:
    """The memory of all stones, with that of some by their law."""
    made = {}
    for name in ("internal", "stress", "stored", "dissipated", "excess"):
        made[name] = getattr(linear, name).copy()
        made[name][blocks] = getattr(own, name)
    return Memory(**made, yielding=blocks[own.yielding], moduli=own.moduli, held=own.held)
