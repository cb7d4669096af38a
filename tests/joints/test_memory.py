"""A law that remembers more than all others: ties that yield in shear and keep their plastic slide."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import pytest

from masonry_fem.joints import Assignment, Bed, Dry, JointState, Law, Reduction, pull, rub
from masonry_fem.joints.laws.parts.adhesive import held

K, TAU = 1e9, 0.2e6


@dataclass(frozen=True, slots=True, eq=False)
class Ties(Law):
    """Shear springs K that yield at τ; the plastic slide is two numbers of the law's own."""

    name: ClassVar[str] = "ties"
    memory: ClassVar[int] = 2

    def _plastic(self, state):
        return state.own[:, : state.dimension - 1]

    def _force(self, state, end):
        """Yielded stress and plastic slide at a jump."""
        trial = K * (end[:, 1:] - self._plastic(state))
        size = np.linalg.norm(trial, axis=1)
        stress = trial * np.minimum(1.0, TAU / np.maximum(size, 1e-300))[:, None]
        return stress, end[:, 1:] - stress / K

    def reduce(self, state, jump, area, step):
        reduction = Reduction.dry(np.full(state.count, 0.5), state.dimension)
        reduction.offset[:, 1:] = area[:, None] * K * (held(state, jump)[:, 1:] - self._plastic(state))
        for axis in range(1, state.dimension):
            reduction.stiffness[:, axis, axis] = step * area * K
        return reduction

    def update(self, state, trial, jump, reaction, velocity, area, step):
        end = held(state, jump) + step * velocity
        stress, plastic = self._force(state, end)
        lost = area * (stress * (plastic - self._plastic(state))).sum(axis=1)
        after = replace(
            state.remember(*plastic.T), jump=end, dissipated=state.dissipated + np.maximum(lost, 0.0)
        )
        return rub(self, state, after, np.full(state.count, 0.5), reaction, velocity, area, step)

    def adhesive_reaction(self, state, area):
        force = np.zeros_like(state.jump)
        force[:, 1:] = area[:, None] * K * (state.jump[:, 1:] - self._plastic(state))
        return force

    def stored(self, state, area):
        return 0.5 * (self.adhesive_reaction(state, area) ** 2).sum(axis=1) / (area * K)


def test_ties_yield_in_loops():
    """Elastic to τ, then flat; unloading is elastic: area of a loop 4 τ (A − τ/K)."""
    amplitude, stiff = 1e-3, 1e12
    path = np.concatenate([np.linspace(0, 1, 50), np.linspace(1, -1, 100), np.linspace(-1, 1, 100)])
    history = pull(Ties(), np.stack([0 * path, amplitude * path], axis=1), stiffness=stiff)
    assert history.settled.all()
    assert np.abs(history.stress[:, 1]).max() == pytest.approx(TAU, rel=1e-9)
    slide, stress = history.jump[49:, 1], history.stress[49:, 1]
    loop = np.trapezoid(stress, slide)
    assert loop == pytest.approx(4 * TAU * (slide.max() - TAU / K), rel=1e-2)
    assert history.state.own[0, 0] == pytest.approx(slide[-1] - TAU / K)


@pytest.mark.parametrize("bedded", [False, True])
def test_memory_stands_beside_laws_without(bedded):
    ties = Bed(Ties(), 1e11, 1e11) if bedded else Ties()
    joints = Assignment(((Dry(0.3), np.array([1])), (ties, np.array([0, 2]))))
    state = joints.initial(3, 3)
    assert state.own.shape == (3, 2)
    area, step = np.ones(3), 1.0
    velocity = np.array([[0.0, 1e-3, 0.0], [0.0, 1e-3, 0.0], [0.0, 0.0, -2e-3]])
    after = joints.update(state, state, np.zeros((3, 3)), np.zeros((3, 3)), velocity, area, step)
    assert after.own[0] == pytest.approx([1e-3 - TAU / K, 0.0])
    assert after.own[2] == pytest.approx([0.0, -2e-3 + TAU / K])
    assert not after.own[1].any()
    assert after.distance(state) == pytest.approx(1.0)
    kept = JointState(**after.arrays())
    np.testing.assert_array_equal(kept.own, after.own)


def test_states_of_one_width_have_no_memory_unless_a_law_asks():
    assert JointState.intact(3, 2).own.shape == (3, 0)
    assert Assignment(((Dry(0.3), np.arange(3)),)).initial(3, 2).own.shape == (3, 0)
