"""Newton's method with a law's tangent against turns with its secant."""

import numpy as np
import pytest

from masonry_fem.joints import Bed, Bilinear, Dry, Elastic, FremondCangemi, linearise, pull
from tests.joints.samples import FRACTURE, SAMPLES, label, wander

C, ENERGY = 1e10, 50.0
U0 = np.sqrt(ENERGY / C)


def bar(law, stretches, newton, length):
    """Bar of E = 10 GPa and a length [m] in series; displacement of its end over U at the peak."""
    k = 10e9 / length
    peak = U0 * (1 + C / k)
    return pull(law, [[x * peak, 0.0] for x in stretches], stiffness=k, newton=newton)


@pytest.fixture
def joint():
    return FremondCangemi(normal_stiffness=C, tangential_stiffness=C, energy=ENERGY)


def test_tangent_of_a_softening_spring(joint):
    """r = w²/(c u³): slope −3 w²/(c u⁴)."""
    state, area, step, u = joint.initial(1, 2), np.ones(1), 0.1, 2 * U0
    jump, velocity, reaction = np.zeros((1, 2)), np.array([[u / 0.1, 0.0]]), np.zeros((1, 2))
    trial = joint.update(state, state, jump, reaction, velocity, area, step)
    tangent = linearise(joint, state, trial, jump, reaction, velocity, area, step)
    r, slope = ENERGY**2 / (C * u**3), -3 * ENERGY**2 / (C * u**4)
    assert tangent.stiffness[0, 0, 0] == pytest.approx(step * slope, rel=1e-8)
    assert tangent.adhesive_reaction(velocity)[0] == pytest.approx([r, 0], rel=1e-12)


def test_newton_is_quick_near_the_snap_back(joint):
    """Bars of 0.1 m and, just short of the snap-back's 1/3 m, 0.32 m: the secant crawls."""
    for length, most in ((0.1, 8), (0.32, 25)):
        stretches = np.linspace(0.9, 1.5, 13)
        slow, quick = (bar(joint, stretches, newton, length) for newton in (False, True))
        assert quick.settled.all()
        assert quick.turns.max() <= most
        assert slow.turns.max() > 3 * quick.turns.max()
        assert slow.jump[:, 0] == pytest.approx(quick.jump[:, 0], rel=1e-6 if slow.settled.all() else 1e-2)


@pytest.mark.parametrize(("length", "snaps"), [(0.32, False), (0.35, True)])
def test_a_long_bar_snaps_back(joint, length, snaps):
    """A7.7: det(I + h w B) ≤ 0 iff the bar is longer than E/3c = 1/3 m, just past the peak."""
    state, area, step, u = joint.initial(1, 2), np.full(1, 0.2), 0.1, 1.0001 * U0
    jump, velocity, reaction = np.zeros((1, 2)), np.array([[u / step, 0.0]]), np.zeros((1, 2))
    trial = joint.update(state, state, jump, reaction, velocity, area, step)
    tangent = linearise(joint, state, trial, jump, reaction, velocity, area, step)
    w = np.eye(2)[None] / (step**2 * area * 10e9 / length)
    secant = joint.reduce(trial, jump, area, step)
    steep, flat = (np.linalg.det(np.eye(2) + step * w @ one.stiffness)[0] for one in (tangent, secant))
    assert (steep <= 0) == snaps
    assert flat > 0


def test_bar_in_series_by_newton(joint):
    """A7.7."""
    table = {1.1: 1.143040, 1.5: 1.626772, 2: 2.190486, 4: 4.398825}
    history = bar(joint, list(table), True, 0.1)
    assert history.jump[:, 0] / U0 == pytest.approx(list(table.values()), rel=1e-6)


def test_joint_beyond_the_snap_back_jumps(joint):
    """A bar longer than E/3c lets go at once: the end state is on the far branch all the same."""
    history = bar(joint, [0.99, 1.01], False, 1.0)
    k = 10e9
    assert history.settled.all()
    assert history.jump[0, 0] == pytest.approx(0.99 * U0)
    u, end = history.jump[1, 0], 1.01 * U0 * (1 + C / k)
    assert u > 1.5 * U0
    assert k * (end - u) == pytest.approx(ENERGY**2 / (C * u**3), rel=1e-9)


@pytest.mark.parametrize("law", SAMPLES, ids=label)
def test_tangent_passes_through_the_state(law):
    """Whatever the law, the linearised cohesion is the law's own where it was taken."""
    path = wander(5, 3, steps=1, points=6)[0]
    state, area, step = law.initial(6, 3), np.full(6, 0.2), 0.5
    jump, reaction = np.zeros((6, 3)), np.full((6, 3), [3e4, 1e3, -2e3])
    trial = law.update(state, state, jump, reaction, path / step, area, step)
    tangent = linearise(law, state, trial, jump, reaction, path / step, area, step)
    again = law.update(state, trial, jump, reaction, path / step, area, step)
    own = tangent.own_velocity(path / step, reaction, step)
    assert tangent.adhesive_reaction(own) == pytest.approx(
        law.adhesive_reaction(again, area), rel=1e-9, abs=1e-6
    )


def test_tangent_of_linear_springs_is_the_secant():
    law = Bed(Elastic(normal_stiffness=C, tangential_stiffness=2 * C), 1e11, 1e11)
    state, area = law.initial(2, 3), np.array([0.1, 0.2])
    jump, velocity = np.full((2, 3), 1e-5), np.full((2, 3), 3e-5)
    secant = law.reduce(state, jump, area, 1.0)
    tangent = linearise(law, state, state, jump, np.zeros((2, 3)), velocity, area, 1.0)
    assert tangent.stiffness == pytest.approx(secant.stiffness, rel=1e-8, abs=1e-3)
    assert tangent.offset == pytest.approx(secant.offset, rel=1e-6, abs=1e-3)
    assert (tangent.compliance == secant.compliance).all()


def test_mixed_mode_couples_the_directions():
    law = Bilinear(**FRACTURE)
    state, jump, velocity = law.initial(1, 2), np.zeros((1, 2)), np.array([[4e-5, 4e-5]])
    args = (jump, np.zeros((1, 2)), velocity, np.ones(1), 1.0)
    tangent = linearise(law, state, law.update(state, state, *args), *args)
    assert (tangent.stiffness[0] != 0).all()
    assert np.linalg.eigvalsh(tangent.stiffness[0] + tangent.stiffness[0].T).min() < 0
    dry = Dry()
    assert not linearise(dry, dry.initial(1, 2), dry.initial(1, 2), *args).stiffness.any()
