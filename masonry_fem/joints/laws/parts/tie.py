"""Tie: a bar, cable or chain between two points that bears tension only.

    ε = (L − L_0)/L_0 = T/(E A) + ε_p,    T ≥ 0,    0 ≤ T ≤ A (f_y + H ε_p)

As a contact its normal points from its candidate to its antagonist: what pushes the candidate along the
normal pulls the two together, the gap L_0 − L is open where the tie is slack, and there is no friction. An
elastic tie is a compliance L_0/(E A) on the diagonal of the Delassus operator. One that yields adds that of
its hardening, as a bed that crushes does. One that has snapped takes no part in the contact problem any more.

    Tie(modulus=np.array([200e9]), length=np.array([4.0]), prestress=np.array([50e6]), ...)

The gap that the march has is that of the points where they are. So the force follows from the length of the
tie, whichever way its points have gone, and no error of steps adds up.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar, override

import numpy as np

from masonry_fem.joints.law import Law, Pull
from masonry_fem.joints.parameters import FloatArray
from masonry_fem.joints.reduction import Reduction
from masonry_fem.joints.state import JointState

ROUNDING = 1e-12  # of a strength


@dataclass(frozen=True, slots=True, eq=False)
class Tie(Law):
    """k ties, each a contact of its own; its area is the section of the tie.

    Attributes
    ----------
    modulus : Young's modulus E, shape (k,) [Pa].
    length : L_0 of the tie that bears nothing, shape (k,) [m].
    prestress : T_0/A at the start, shape (k,) [Pa].
    strength : f_y at which it begins to yield, infinite where it never does, shape (k,) [Pa].
    hardening : H > 0, slope of the stress over the plastic strain, shape (k,) [Pa].
    rupture : Strain at which it snaps, infinite where it never does, shape (k,).
    """

    modulus: FloatArray
    length: FloatArray
    prestress: FloatArray
    strength: FloatArray
    hardening: FloatArray
    rupture: FloatArray

    name: ClassVar[str] = "tie"
    memory: ClassVar[int] = 1  # 1 where it has snapped

    @property
    @override
    def pull(self) -> Pull:
        return self

    @override
    def initial(self, count: int, dimension: int) -> JointState:
        state = JointState.dry(count, dimension)
        elastic = np.zeros((count, dimension))
        elastic[:, 0] = -self.length * self.prestress / self.modulus
        return replace(state, own=np.zeros((count, self.memory)), elastic=elastic, bedded=elastic)

    def snapped(self, state: JointState) -> np.ndarray:
        """Which of the ties have snapped, shape (k,)."""
        return state.own[:, 0] > 0

    def force(self, state: JointState, area: FloatArray) -> FloatArray:
        """T of a state, shape (k,) [N].

        Parameters
        ----------
        state : Of the k ties. area : Their sections, shape (k,) [m²].
        """
        pulled: FloatArray = -self._stiffness(area) * state.elastic[:, 0]
        return np.maximum(pulled, 0.0)

    def capacity(self, state: JointState, area: FloatArray) -> FloatArray:
        """The force at which it yields, infinite where it never does, shape (k,) [N].

        Parameters
        ----------
        state : Of the k ties. area : Their sections, shape (k,) [m²].
        """
        return area * self._limit(state)

    def _stiffness(self, area: FloatArray) -> FloatArray:
        """E A/L_0, shape (k,) [N/m]."""
        stiffness: FloatArray = self.modulus * area / self.length
        return stiffness

    def _limit(self, state: JointState) -> FloatArray:
        """Stress at which a tie yields further, shape (k,) [Pa]."""
        limit: FloatArray = self.strength - self.hardening * state.crushed / self.length
        return limit

    @override
    def reduce(self, state: JointState, jump: FloatArray, area: FloatArray, step: float) -> Reduction:
        dry = Reduction.dry(np.zeros(state.count), state.dimension)
        compliance, kept = 1.0 / (step**2 * self._stiffness(area)), state.crushed.copy()
        flows = state.crushing
        slope = self.length / (self.hardening * area)
        compliance[flows] += slope[flows] / step**2
        kept[flows] = (self.strength * self.length / self.hardening)[flows]
        shift = np.zeros_like(state.bedded)
        shift[:, 0] = (state.bedded[:, 0] - kept) / step
        return replace(
            dry,
            compliance=np.repeat(compliance[:, None], state.dimension, axis=1),
            shift=shift,
            closure=state.bedded[:, 0],
        )

    @override
    def update(
        self, state: JointState, trial: JointState, jump: FloatArray, reaction: FloatArray,
        velocity: FloatArray, area: FloatArray, step: float,
    ) -> JointState:  # fmt: skip
        stress = np.maximum(reaction[:, 0], 0.0) / area
        limit = self._limit(state)
        flown = (self.strength - stress) * np.divide(self.length, self.hardening)
        flown = np.where(np.isfinite(self.strength), flown, np.inf)
        least = np.where(trial.crushing, 0.0, ROUNDING * self.length * limit / self.hardening)
        crushing = np.isfinite(limit) & (flown < state.crushed - np.where(np.isfinite(least), least, 0.0))
        crushed = np.where(crushing, flown, state.crushed)
        elastic = np.zeros_like(state.elastic)
        elastic[:, 0] = -stress * self.length / self.modulus
        # as the contact was solved: what yields from the next turn on is not yet so long
        stretched = -elastic[:, 0] - np.where(trial.crushing, flown, state.crushed)
        snapped = self.snapped(trial) | (stretched > self.rupture * self.length)
        # what it was stretched by stays as it is: nothing springs back on the stones
        elastic[snapped] = 0.0
        crushed = np.where(snapped, state.crushed + state.elastic[:, 0], crushed)
        crushing &= ~snapped
        after = replace(
            state, elastic=elastic, crushed=crushed, crushing=crushing, bedded=state.bed,
            jump=jump + step * velocity,
        ).remember(snapped.astype(float))  # fmt: skip
        flow = np.where(crushing, state.crushed - crushed, 0.0)
        yielded = area * np.where(crushing, 0.5 * (limit + self._limit(after)), 0.0) * flow
        freed = np.where(snapped, self.stored(state, area), 0.0)
        return replace(after, dissipated=state.dissipated + yielded + freed)

    @override
    def adhesive_reaction(self, state: JointState, area: FloatArray) -> FloatArray:
        return np.zeros(state.jump.shape)

    @override
    def work_at_start(self, before: JointState, after: JointState, area: FloatArray) -> FloatArray:
        work: FloatArray = self.force(before, area) * (after.bed - before.bed)[:, 0]
        return work

    @override
    def stored(self, state: JointState, area: FloatArray) -> FloatArray:
        energy: FloatArray = 0.5 * self._stiffness(area) * state.elastic[:, 0] ** 2
        return energy
