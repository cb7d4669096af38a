"""A5.4: what domes do whose meridian joints have a strength, or none.

A thin bonded dome on a base without friction pulls along the parallels by γ R = 100 kPa at most: joints that
bear more stay whole, others crack from the base up. On a base that holds it a dome stands cracked, with at
least the thrust of limit analysis, .019469 γ R³ per radian for t/R = 0.1. The cracks end near 51.8° from the
crown, where the parallels begin to press; the stones of a ring are 4.9° high.
"""

from __future__ import annotations

import numpy as np
import pytest

from masonry_fem.analyses.run import RunResult
from tests.validation.domes import (
    BONDED,
    GAMMA,
    PLANE,
    RADIUS,
    SWEEP,
    brittle,
    lune,
    meridian_points,
    thrust,
)

THIN, THICK = 0.1, 0.5
LEAST = 0.019469 * GAMMA * RADIUS**3  # thrust of the thick dome [N per radian]
HELD = 0.8  # friction of a base that holds


def cracked(result: RunResult) -> tuple[np.ndarray, np.ndarray]:
    """Angles from the crown of the broken and of the sound points of meridian joints [deg]."""
    mine, angle = meridian_points(result)
    state = result.march.state
    broken = state.joints.broken[mine]
    return angle[broken], angle[~broken]


def pull(result: RunResult) -> tuple[np.ndarray, np.ndarray]:
    """Stress that opens each point of the meridian joints [Pa], and its angle."""
    mine, angle = meridian_points(result)
    return -result.march.state.reaction[mine, 0] / result.built.model.contacts.area[mine], angle


@pytest.mark.parametrize("thickness", [THIN, THICK])
def test_a5_4_strong_joints_stay_whole_on_rollers(thickness: float) -> None:
    result = lune(thickness=thickness, meridian=brittle(130e3), beds=BONDED)
    assert result.outcome == "equilibrium"
    broken, _ = cracked(result)
    assert len(broken) == 0
    stress, angle = pull(result)
    assert stress.max() == pytest.approx(GAMMA * RADIUS, rel=0.25)  # and what bending at the base adds
    assert angle[stress.argmax()] > 80


@pytest.mark.slow
def test_a5_4_weak_joints_crack_from_the_base_and_the_dome_falls() -> None:
    """Half the strength is reached at about half the load, lowest first; nothing ties the cracked dome."""
    whole = lune(thickness=THICK, meridian=PLANE, beds=BONDED)
    stress, _ = pull(whole)
    assert stress.max() > 50e3
    result = lune(thickness=THICK, meridian=brittle(0.5 * stress.max()), beds=BONDED)
    assert result.outcome == "no_equilibrium"
    broken, _ = cracked(result)
    assert broken.max() == pytest.approx(90.0, abs=0.5)


@pytest.mark.slow
@pytest.mark.parametrize("thickness", [THIN, THICK])
def test_a5_4_without_cohesion_and_ties_it_falls(thickness: float) -> None:
    assert lune(thickness=thickness, meridian=None).outcome == "no_equilibrium"


def test_a5_4_without_cohesion_it_stands_on_a_base_that_holds() -> None:
    result = lune(thickness=THICK, meridian=None, base_friction=HELD)
    assert result.outcome == "equilibrium"
    horizontal, weight = thrust(result)
    assert weight == pytest.approx(GAMMA * (5.25**3 - 4.75**3) / 3, rel=0.01)  # chords for arcs
    assert LEAST < horizontal < HELD * weight
    mine, angle = meridian_points(result)
    gap = result.march.state.gap[mine]
    assert (gap[(angle > 55) & (angle < 84)] > 0).sum() > 20  # cracked, though not at the held base
    assert gap[angle < 35].max() < 1e-9


@pytest.mark.slow
@pytest.mark.parametrize(("strength", "highest", "lowest"), [(100e3, 60, 72), (50e3, 41, 56), (20e3, 31, 52)])
def test_a5_4_cracks_end_where_the_parallels_press(strength: float, highest: float, lowest: float) -> None:
    """The base spreads by 0.1 mm: cracks run up from it, the further the weaker the joints."""
    result = lune(thickness=THICK, meridian=brittle(strength), base_friction=HELD, spread=1e-4, steps=4)
    assert result.outcome == "equilibrium"
    broken, sound = cracked(result)
    assert broken.max() == pytest.approx(90.0, abs=0.1)
    assert highest < broken.min() < lowest
    assert sound.max() < broken.min() + 6  # one crack, no islands
    mine, angle = meridian_points(result)
    gap = result.march.state.gap[mine]
    assert gap[(angle > broken.min() + 1) & (angle < 88)].min() >= 0
    assert gap[np.abs(angle - 90) < 1].max() == pytest.approx(1e-4 * np.radians(SWEEP / 2), rel=0.01)
