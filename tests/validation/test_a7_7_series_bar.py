"""A7.7: an elastic bar and a Frémond-Cangémi joint in series, stretched at its end.

The bar takes r L/E of the end's displacement U and the joint the rest: u + r(u) L/E = U with r = c u up to
u0 = √(w/c) and r = w²/(c u³) beyond. From the peak the joint falls at 3 c at most, so that a bar longer
than L = E/(3 c) has no state next to the peak: it snaps back.
"""

from __future__ import annotations

import logging
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

from masonry_fem.analyses.run import RunResult, solve_scene
from masonry_fem.scene.specs import (
    Joint,
    Material,
    MeshSettings,
    Motion,
    Scene,
    Solver,
    Statics,
    Support,
    Table,
    law_record,
)
from masonry_fem.structures.block import BlockStructure

YOUNG, STIFFNESS, ENERGY = 10e9, 1e10, 50.0
U0 = np.sqrt(ENERGY / STIFFNESS)
PEAK = np.sqrt(ENERGY * STIFFNESS)
LIMIT = YOUNG / (3 * STIFFNESS)  # length from which the bar snaps back [m]
WIDTH = 0.05
# U/U_peak, u_N/u0, r [MPa] for L = 0.1 m
TABLE = [
    (0.5, 0.5, 0.353553),
    (1.0, 1.0, 0.707107),
    (1.1, 1.143040, 0.473479),
    (1.5, 1.626772, 0.164250),
    (2.0, 2.190486, 0.067277),
    (4.0, 4.398825, 0.008308),
]


class _Tape:
    """Stress [Pa], jump [m] and dissipated energy [J/m²] of each step."""

    def __init__(self) -> None:
        self.stress: list[float] = []
        self.jump: list[float] = []
        self.dissipated: list[float] = []

    def record(self, model: Any, state: Any, report: Any) -> None:
        self.stress.append(-report.support_resultants["base"][1] / WIDTH)
        assert np.ptp(state.jump[:, 0]) <= 1e-12 * U0 + 1e-9 * state.jump[0, 0]
        self.jump.append(float(state.jump[:, 0].mean()))
        self.dissipated.append(float(state.joints.dissipated.sum()) / WIDTH)


def peak_at(length: float) -> float:
    """U at the peak of the joint [m]."""
    return float(U0 * (1 + STIFFNESS * length / YOUNG))


def stretched(length: float, ends: list[float]) -> tuple[RunResult, _Tape]:
    """A bar of ``length`` glued to a support; its other end is taken to ``ends`` [m], one a step."""
    count = len(ends)
    path = Table(points=((0.0, 0.0), *(((i + 1) / count, end) for i, end in enumerate(ends))))
    scene = Scene(
        dimension=2,
        plane="stress",
        materials={"stone": Material(density=2000.0, young=YOUNG, poisson=0.0)},
        structures=(
            BlockStructure(name="base", material="stone", size=(WIDTH, 0.1), support=True),
            BlockStructure(name="bar", material="stone", size=(WIDTH, length), position=(0.0, 0.1)),
        ),
        mesh=MeshSettings(divisions=(1, 4)),
        joints=(
            Joint(
                law=law_record(
                    "fremond_cangemi",
                    normal_stiffness=STIFFNESS,
                    tangential_stiffness=STIFFNESS,
                    energy=ENERGY,
                )
            ),
        ),
        supports=(Support(on="bar/top", motion=Motion(displacement=(0.0, 1.0), time=path)),),
        analysis=Statics(load_steps=count),
        solver=Solver(tolerance=1e-12),
    )
    tape = _Tape()
    return solve_scene(scene, observers=[tape]), tape


def test_a7_7_table() -> None:
    result, tape = stretched(0.1, [ratio * peak_at(0.1) for ratio, _, _ in TABLE])
    assert result.outcome == "equilibrium"
    for jump, stress, (ratio, opening, strength) in zip(tape.jump, tape.stress, TABLE, strict=True):
        assert jump / U0 == pytest.approx(opening, rel=1e-6), ratio
        assert stress / 1e6 == pytest.approx(strength, abs=1e-6), ratio


@pytest.mark.parametrize("share", [0.3, 0.9, 0.99])
def test_a7_7_shorter_bars_follow_the_curve(share: float, caplog: pytest.LogCaptureFixture) -> None:
    """Close to the limit the curve drops steeply after the peak, yet every state is exact."""
    length = share * LIMIT
    ends = [ratio * peak_at(length) for ratio in (0.5, 0.999, 1.001, 1.01, 1.1, 1.5)]
    with caplog.at_level(logging.WARNING):
        result, tape = stretched(length, ends)
    assert result.outcome == "equilibrium"
    for end, jump, stress in zip(ends, tape.jump, tape.stress, strict=True):
        exact = opening_for(end, length)
        assert jump == pytest.approx(exact, rel=1e-6)
        assert stress == pytest.approx(traction(exact), rel=1e-6)
    assert not [record for record in caplog.records if "snap" in record.getMessage()]


LONG = 3 * LIMIT
JUMPING = [ratio * peak_at(LONG) for ratio in (0.5, 0.99, 1.01, 1.5)]


def test_a7_7_longer_bars_are_exact_before_the_peak_and_after_the_fall() -> None:
    result, tape = stretched(LONG, JUMPING)
    assert result.outcome == "equilibrium"
    sound = [end / (1 + STIFFNESS * LONG / YOUNG) for end in JUMPING[:2]]
    assert tape.jump[:2] == pytest.approx(sound, rel=1e-9)
    for end, jump, stress in zip(JUMPING[2:], tape.jump[2:], tape.stress[2:], strict=True):
        assert stress == pytest.approx(traction(jump), rel=1e-6)
        assert jump + stress * LONG / YOUNG == pytest.approx(end, rel=1e-9)
        assert jump > 1.8 * U0


def test_a7_7_longer_bars_dissipate_what_no_smaller_step_could_save() -> None:
    """The fall gives away more than damage takes: what the bar had stored is lost at once."""
    result, tape = stretched(LONG, JUMPING)
    damage = np.diff(tape.dissipated)[1] * WIDTH
    lost = damage + result.march.ledger.numerical_dissipation
    assert lost > 1.5 * damage


def test_a7_7_longer_bars_say_that_they_snap_back(caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.WARNING):
        result, _ = stretched(LONG, JUMPING)
    told = [record.getMessage() for record in caplog.records] + [result.message]
    assert any("snap" in text for text in told)


def traction(opening: float) -> float:
    """r(u) of a joint that only opened [Pa]."""
    return STIFFNESS * opening if opening <= U0 else float(ENERGY**2 / (STIFFNESS * opening**3))


def opening_for(end: float, length: float) -> float:
    """u of a bar that is not too long [m]."""
    return float(brentq(lambda u: u + traction(u) * length / YOUNG - end, 0.0, end, xtol=1e-18, rtol=1e-14))
