"""Response spectra against closed forms of linear oscillators."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from masonry_fem.output.spectrum import of_accelerations, of_displacements

RATIOS = np.array([0.1, 0.2, 0.37, 0.5001, 0.8, 1.3, 2.0, 4.0, 9.0])  # duration of the pulse over the period


def half_sine(ratios):
    """Greatest way of an oscillator under half a sine, over that under its peak at rest: Chopra, 4.8."""
    found = []
    for ratio in ratios:
        beta = 0.5 / ratio  # angular frequency of the force over that of the oscillator
        after = abs(2 * beta * np.cos(0.5 * np.pi / beta) / (1 - beta**2))
        phase = np.linspace(0, np.pi, 400001)
        within = np.abs((np.sin(phase) - beta * np.sin(phase / beta)) / (1 - beta**2)).max()
        found.append(max(after, within))
    return np.array(found)


@pytest.mark.parametrize("step", [0.001, 0.0025])
def test_half_a_sine(step):
    """Within and after the pulse, for short and long ones, to 1e-4 beside what sampling takes of the sine."""
    time = step * np.arange(round(0.5 / step) + 1)
    told = of_accelerations(time, 3.0 * np.sin(2 * np.pi * time), 0.5 / RATIOS, 0.0)
    np.testing.assert_allclose(told.accelerations, 3.0 * half_sine(RATIOS), rtol=1e-4)


def test_steady_harmonic():
    """After many cycles oscillators go as far as the closed form of the steady state says."""
    damping, period = 0.05, np.array([0.11, 0.3, 0.5, 0.83])
    time = 0.001 * np.arange(60001)
    swell = np.sin(np.pi / 2 * np.interp(time, [0, 24, 36, 60], [0, 1, 1, 0])) ** 2
    told = of_accelerations(time, swell * np.sin(4 * np.pi * time), period, damping)
    ratio = period / 0.5
    exact = 1 / np.hypot(1 - ratio**2, 2 * damping * ratio)
    np.testing.assert_allclose(told.accelerations, exact, rtol=1e-3)


def test_resonance_from_rest():
    """An undamped oscillator in resonance goes as far as sin(ωt) − ωt cos(ωt), half of it, over ω²."""
    time = 0.002 * np.arange(1001)
    told = of_accelerations(time, np.sin(4 * np.pi * time), np.array([0.5]), 0.0)
    phase = np.linspace(0, 8 * np.pi, 200001)
    exact = np.abs(np.sin(phase) - phase * np.cos(phase)).max() / 2
    np.testing.assert_allclose(told.accelerations, exact, rtol=2e-4)


def test_samples_at_any_instants_and_slower_than_the_oscillator():
    """A polygon is followed exactly: against an integration with steps much finer than its sides."""
    time, values = np.array([0.0, 0.1, 0.3, 0.4, 0.8]), np.array([0.0, 2.0, -1.0, 0.5, 0.0])
    period = np.array([0.05, 0.3, 1.5])
    told = of_accelerations(time, values, period, 0.05)
    for k, one in enumerate(period):
        turn = 2 * np.pi / one

        def moves(at, state, turn=turn):
            felt = np.interp(at, time, values, right=0.0)
            return [state[1], -felt - 0.1 * turn * state[1] - turn**2 * state[0]]

        exact = solve_ivp(moves, (0, 2.3), [0, 0], max_step=5e-4, rtol=1e-9, atol=1e-12).y[0]
        np.testing.assert_allclose(told.displacements[k], np.abs(exact).max(), rtol=1e-3)


def test_a_motion_that_jumps():
    """A ground that goes off with a velocity v: an undamped oscillator goes v/ω."""
    time = 0.01 * np.arange(401)
    period = np.array([0.05, 0.1, 0.5, 2.0])
    told = of_displacements(time, 0.3 * time, period, 0.0)
    assert np.isnan(told.displacements[0])  # faster than ten steps
    np.testing.assert_allclose(told.displacements[1:], 0.3 * period[1:] / (2 * np.pi), rtol=1e-5)


def test_a_motion_is_its_acceleration():
    """Way and acceleration of the same smooth motion have the same spectrum, but for the steps."""
    time = 0.001 * np.arange(3001)
    bump = np.where(time < 2, np.sin(np.pi * time / 2) ** 4, 0.0)
    phase = np.pi * time / 2
    felt = np.where(
        time < 2,
        (np.pi / 2) ** 2 * (12 * np.sin(phase) ** 2 * np.cos(phase) ** 2 - 4 * np.sin(phase) ** 4), 0.0,
    )  # fmt: skip
    period = np.array([0.3, 0.7, 1.5])
    first = of_displacements(time, bump, period, 0.05)
    second = of_accelerations(time, felt, period, 0.05)
    np.testing.assert_allclose(first.displacements, second.displacements, rtol=1e-3)
