"""JointLaws: which cohesive law holds at which contact points, seen as one law of them all.

    laws = JointLaws((MohrCoulomb(cohesion=0.35e6, friction=0.75),), (bed_joints,))
    state = laws.initial(contacts.count, 3)
    reduction = laws.reduce(state, friction, jump, area, step)

Contacts of no law are dry. Within a step law and contact solver take turns until the trial state stays
(formulation 5); the committed one is left as it was.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from masonry_fem.nscd.laws.law import Law
from masonry_fem.nscd.laws.reduction import Reduction
from masonry_fem.nscd.laws.state import JointState

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class JointLaws:
    """Laws and the numbers of the contacts each holds at.

    Attributes
    ----------
    laws : One for each joint record with cohesion.
    members : Its contacts, no contact twice, each of shape (k,).
    """

    laws: tuple[Law, ...]
    members: tuple[IntArray, ...]

    def _pairs(self) -> Iterator[tuple[Law, IntArray]]:
        return zip(self.laws, self.members, strict=True)

    def initial(self, count: int, dimension: int) -> JointState:
        """Fresh joints, and dry ones in between."""
        state = JointState.dry(count, dimension)
        for law, members in self._pairs():
            state = state.put(members, law.initial(len(members), dimension))
        return state

    def reduce(
        self, state: JointState, friction: FloatArray, jump: FloatArray, area: FloatArray, step: float
    ) -> Reduction:
        """The laws as the contact solver sees them; ``friction`` is that of dry contacts."""
        whole = Reduction.dry(friction.copy(), state.dimension)
        for law, members in self._pairs():
            part = law.reduce(state.take(members), jump[members], area[members], step)
            for name in ("offset", "stiffness", "friction", "compliance", "shift", "closure"):
                getattr(whole, name)[members] = getattr(part, name)
        return whole

    def update(
        self,
        state: JointState,
        trial: JointState,
        jump: FloatArray,
        reaction: FloatArray,
        velocity: FloatArray,
        area: FloatArray,
        step: float,
    ) -> JointState:
        """Next trial state, from physical reactions and the relative velocity without gap term."""
        for law, members in self._pairs():
            part = law.update(
                state.take(members), trial.take(members), jump[members], reaction[members],
                velocity[members], area[members], step,
            )  # fmt: skip
            trial = trial.put(members, part)
        return trial

    def stored(self, state: JointState, area: FloatArray) -> FloatArray:
        """Energy that each joint can give back [J], shape (c,)."""
        energy = np.zeros(state.count)
        for law, members in self._pairs():
            energy[members] = law.stored(state.take(members), area[members])
        return energy

    @property
    def contacts(self) -> IntArray:
        """All contacts with a law."""
        return np.concatenate([*self.members, np.zeros(0, dtype=np.int64)])
