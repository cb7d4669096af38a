"""A9.8: time steps that must not matter, from 1e-12 s to far beyond the waves."""

from __future__ import annotations

import numpy as np
import pytest

from masonry_fem.run import RunResult
from masonry_fem.scene.specs import (
    Dynamics,
    Equilibrium,
    Joint,
    Material,
    MeshSettings,
    Probe,
    StackStructure,
)
from tests.validation.scenes import G, solved


@pytest.mark.parametrize("step", [1e-12, 1e-6, 1e-3, 1.0, 1e3])
def test_a9_8_any_step_gives_numbers(step: float) -> None:
    """From h → 0 to h ≫ L/c: no NaN; a long step with θ = 1 is statics (R = W)."""
    result = solved(
        structures=(StackStructure(name="stack", material="stone", size=(1, 1, 1), count=2),),
        mesh=MeshSettings(divisions=(2, 2, 2)),
        analysis=Equilibrium(strategy="large_step", step=step, max_steps=2, tolerance=1e-6),
    )
    reaction = result.march.state.reaction
    assert np.isfinite(reaction).all()
    assert result.march.report.natural_map < 1e-8
    if step >= 1.0:
        base = result.summary["supports"]["stack.ground"]["force"][2]
        assert base == pytest.approx(2 * 2400 * G, rel=1e-6)


COLUMN = Material(density=2000.0, young=1e9, poisson=0.0)
PERIOD = 4 * 3.0 / np.sqrt(1e9 / 2000.0)  # of the column's first wave [s]


def column(step: float, theta: float, count: int = 1) -> RunResult:
    """A2.4: gravity at once on a 3 m column at rest."""
    return solved(
        dimension=2,
        materials={"stone": COLUMN},
        structures=(StackStructure(name="column", material="stone", size=(1.0, 3.0), count=1),),
        mesh=MeshSettings(divisions=(1, 12)),
        joints=(Joint(friction=0.0),),
        analysis=Dynamics(step=step, duration=count * step, theta=theta),
        probes=(Probe(name="top", block="column.b1", point=(0.5, 3.0)),),
    )


@pytest.mark.parametrize("ratio", [1e2, 1e3, 1e5, 1e8])
def test_a9_8_one_step_far_beyond_the_waves_is_statics(ratio: float) -> None:
    """θ = 1, h ≫ L/c: R = W and the settlement ρ g L²/2E after one step, up to (L/ch)²."""
    result = column(ratio * PERIOD, 1.0)
    weight = 2000.0 * G * 3.0
    bound = max(0.1 / ratio**2, 1e-8)
    assert result.march.report.step == 1
    base = result.summary["supports"]["column.ground"]["force"][1]
    assert base == pytest.approx(weight, rel=bound)
    assert result.summary["probes"]["top"][1] == pytest.approx(-8.829e-5, rel=max(bound, 1e-6))


@pytest.mark.parametrize("theta", [0.5, 1.0])
def test_a9_8_steps_of_a_picosecond(theta: float) -> None:
    """h = 1e-12: the top falls freely, the base presses what is left of the weight's momentum."""
    h, steps = 1e-12, 5
    result = column(h, theta, steps)
    state = result.march.state
    assert np.isfinite(state.reaction).all()
    assert np.isfinite(state.velocity).all()
    # θ-scheme at constant acceleration: s_n = a h² n (n − 1 + 2θ)/2
    fallen = G * h**2 * steps * (steps - 1 + 2 * theta) / 2
    assert result.summary["probes"]["top"][1] == pytest.approx(-fallen, rel=1e-6)
    assert result.march.ledger.imbalance < 1e-10


@pytest.mark.parametrize(("h", "steps"), [(1e-12, 3), (1e-6, 3), (1.0, 3), (1e6, 1)])
def test_a9_8_rigid_stack_at_any_step(h: float, steps: int) -> None:
    """Rigid blocks press with their weight from the first step on, however short or long it is.

    After 1e6 s rounding of the free fall, 1e7 m/s, has moved the blocks by metres: one step only.
    """
    result = solved(
        fidelity="rigid",
        structures=(StackStructure(name="stack", material="stone", size=(1, 1, 1), count=3),),
        analysis=Dynamics(step=h, duration=steps * h, theta=1.0),
    )
    base = result.summary["supports"]["stack.ground"]["force"]
    assert base == pytest.approx([0, 0, 3 * 2400 * G], rel=1e-9, abs=1e-6)
    assert result.march.report.speed <= 1e-10 * G * h
