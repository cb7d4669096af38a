"""A2.4, A2.5: sudden gravity on an elastic column, Signorini's bar, against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from masonry_fem.analyses.run import RunResult
from masonry_fem.scene.specs import (
    Acceleration,
    Contact,
    Dynamics,
    Equilibrium,
    Joint,
    Loads,
    Material,
    MeshSettings,
    Probe,
    Statics,
    Support,
    Traction,
)
from masonry_fem.structures.block import BlockStructure
from masonry_fem.structures.stack import StackStructure
from tests.validation.scenes import G, solved
from tests.validation.tape import Tape, taped

# --- A2.4: sudden gravity on a column --------------------------------------------------------------

COLUMN = Material(density=2000.0, young=1e9, poisson=0.0)
WAVE = np.sqrt(1e9 / 2000.0)  # m/s
WEIGHT = 2000.0 * G * 3.0  # N per metre of depth and width


def column(analysis, n: int = 60) -> tuple[Tape, RunResult]:
    return taped(
        dimension=2,
        materials={"stone": COLUMN},
        structures=(StackStructure(name="column", material="stone", size=(1.0, 3.0), count=1),),
        mesh=MeshSettings(divisions=(1, n)),
        joints=(Joint(friction=0.0),),
        loads=Loads(gravity=(0.0, -G)),
        analysis=analysis,
        probes=(Probe(name="top", block="column.b1", point=(0.5, 3.0)),),
    )[:2]


@pytest.mark.slow
def test_a2_4_ground_resultant_is_a_triangular_wave() -> None:
    """From 0 to 2W and back with period 4L/c; θ = ½ does not damp it."""
    h = 3.0 / 60 / WAVE / 2
    tape, made = column(Dynamics(step=h, duration=8 * 3.0 / WAVE, theta=0.5))
    phase = (tape.time - h / 2) * WAVE / 3.0 % 4  # the resultant is the mean over a step
    wave = np.where(phase < 2, phase, 4 - phase)
    force = tape.reaction("column.ground", 1) / WEIGHT
    assert np.sqrt(np.mean((force - wave) ** 2)) < 0.01
    assert np.abs(force - wave).max() < 0.05  # the kinks ring
    assert made.ledger.imbalance < 1e-10
    second = tape.time > 4 * 3.0 / WAVE
    assert force[second].max() == pytest.approx(2.0, rel=0.03)


@pytest.mark.parametrize("strategy", ["brutal_damping", "large_step"])
def test_a2_4_velocity_zeroing_ends_at_the_weight(strategy: str) -> None:
    step = 1e-3 if strategy == "brutal_damping" else 10.0
    tape, made = column(Equilibrium(strategy=strategy, step=step, max_steps=300, tolerance=1e-6))
    assert made.outcome == "equilibrium"
    assert tape.reaction("column.ground", 1)[-1] == pytest.approx(WEIGHT, rel=1e-3)
    assert tape.probe("top", 1)[-1] == pytest.approx(-8.829e-5, rel=1e-3)
    if strategy == "large_step":  # A9.8: h ≫ L/c is statics in one step
        assert made.report.step == 1


# --- A2.5: Signorini in one dimension ------------------------------------------------------------


@pytest.mark.parametrize(
    ("force", "body", "displacement", "reaction"),
    [(5e4, 0.0, 5e-5, 0.0), (1e5, 0.0, 1e-4, 0.0), (2e5, 0.0, 1e-4, 1e5), (0.0, 4e5, 1e-4, 1e5)],
)
def test_a2_5_bar_with_a_gap(force: float, body: float, displacement: float, reaction: float) -> None:
    """L = 1, EA = 1e9, gap 1e-4; end force F or body force f: R = F − EA g/L, R = fL/2 − EA g/L."""
    gap = 1e-4
    result = solved(
        dimension=2,
        materials={"bar": Material(density=1000.0, young=1e9, poisson=0.0)},
        structures=(
            BlockStructure(name="bar", material="bar", size=(1.0, 1.0)),
            BlockStructure(
                name="wall", material="bar", size=(1.0, 3.0), position=(1.0 + gap, -1.0), support=True
            ),
        ),
        mesh=MeshSettings(divisions=(10, 1)),
        supports=(Support(on="bar/left"),),
        joints=(Joint(friction=0.0),),
        contact=Contact(reach=2 * gap),
        loads=Loads(
            tractions=(Traction(on="bar/right", vector=(force, 0.0)),),
            accelerations=(Acceleration(vector=(body / 1000.0, 0.0)),),
        ),
        probes=(Probe(name="end", block="bar", point=(1.0, 0.5)),),
        analysis=Statics(),
    )
    assert result.outcome == "equilibrium"
    assert result.summary.probes["end"][0] == pytest.approx(displacement, rel=1e-10)
    # the gap of two coordinates near 1 m is known to 1e-16 m, that is 1e-7 N here
    assert -result.summary.supports["wall"].force[0] == pytest.approx(reaction, rel=1e-10, abs=5e-7)
