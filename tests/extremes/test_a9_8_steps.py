"""A9.8: time steps that must not matter, from 1e-12 s to far beyond the waves."""

from __future__ import annotations

import numpy as np
import pytest

from masonry_fem.analyses.run import RunResult, solve_scene
from masonry_fem.scene.specs import Dynamics, Equilibrium, Joint, Material, MeshSettings, Probe
from masonry_fem.structures.stack import StackStructure
from tests.extremes.scenes import (
    base_force,
    bouncing,
    bouncing_gain,
    certificate,
    finite,
    sliding_block,
    sliding_error,
    stack,
    standing_wall,
    wall_error,
)
from tests.validation.scenes import G, attempted, solved


@pytest.mark.slow
@pytest.mark.parametrize(
    ("step", "outcome"),
    [(1e-12, "no_convergence"), (1e-6, "no_convergence"), (1e-3, "no_convergence"),
     (1.0, "equilibrium"), (1e3, "equilibrium")],
)  # fmt: skip
def test_a9_8_any_step_gives_numbers(step: float, outcome: str) -> None:
    """From h → 0 to h ≫ L/c: no NaN; a long step with θ = 1 is statics (R = W), short ones rest later."""
    result = attempted(
        structures=(StackStructure(name="stack", material="stone", size=(1, 1, 1), count=2),),
        mesh=MeshSettings(divisions=(2, 2, 2)),
        analysis=Equilibrium(strategy="large_step", step=step, max_steps=2, tolerance=1e-6),
    )
    reaction = result.march.state.reaction
    assert result.outcome == outcome
    assert np.isfinite(reaction).all()
    assert result.march.report.natural_map < 1e-8
    if step >= 1.0:
        base = result.summary.supports["stack.ground"].force[2]
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
    base = result.summary.supports["column.ground"].force[1]
    assert base == pytest.approx(weight, rel=bound)
    assert result.summary.probes["top"][1] == pytest.approx(-8.829e-5, rel=max(bound, 1e-6))


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
    assert result.summary.probes["top"][1] == pytest.approx(-fallen, rel=1e-6)
    assert result.march.ledger.imbalance < 1e-10


@pytest.mark.slow
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
    base = result.summary.supports["stack.ground"].force
    assert base == pytest.approx([0, 0, 3 * 2400 * G], rel=1e-9, abs=1e-6)
    assert result.march.report.speed <= 1e-10 * G * h


STEPS = [1e-12, 1e-9, 1e-6, 1e-3, 1.0, 1e3]
THETAS = [0.5, 0.75, 1.0]


@pytest.mark.slow
@pytest.mark.parametrize("theta", THETAS)
@pytest.mark.parametrize("step", STEPS)
def test_a9_8_rigid_wall_rests_at_any_step(step: float, theta: float) -> None:
    """h from 1e-12 to 1e3 s: the ground gives weight and push from the first step on, and nothing moves."""
    result = solve_scene(standing_wall(step, theta=theta))
    assert finite(result)
    assert wall_error(result) < 1e-9
    assert max(certificate(result).values()) < 1e-9
    assert result.march.report.inertial_share(step) < 1e-8


@pytest.mark.parametrize("theta", THETAS)
@pytest.mark.parametrize("step", STEPS)
def test_a9_8_elastic_wall_at_any_step(step: float, theta: float) -> None:
    """From far below the waves to far beyond: balances and contact hold; θ = 1 and 1 s or more is statics."""
    result = solve_scene(standing_wall(step, theta=theta, fidelity="elastic"))
    assert finite(result)
    assert max(certificate(result).values()) < 1e-9
    if theta == 1 and step >= 1:
        assert wall_error(result) < 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("theta", THETAS)
@pytest.mark.parametrize("step", [1e-4, 1e-2, 1.0, 1e2, 1e3])
def test_a9_8_sliding_goes_as_far_as_algebra_says(step: float, theta: float) -> None:
    """A1.2: at most 1e-16 of the block's place is lost, which is all of the way below a step of 1e-7 s."""
    assert sliding_error(solve_scene(sliding_block(step, theta=theta)), step, theta=theta) < 1e-7


@pytest.mark.slow
@pytest.mark.parametrize("step", STEPS)
def test_a9_8_bounces_keep_their_energy(step: float) -> None:
    """e = 1 and θ = ½, whatever the step; where it is too long to meet the contact in time, it is told."""
    result = solve_scene(bouncing(step))
    assert finite(result)
    largest = max(1.0, (9.81 * step) ** 2 / (2 * 9.81 * 0.01))  # what falls through the ground is faster
    assert abs(bouncing_gain(result)) < 1e-9 * largest


def test_a9_8_blocks_that_fall_into_each_other_are_told(caplog: pytest.LogCaptureFixture) -> None:
    solve_scene(bouncing(1.0))
    told = [record.getMessage() for record in caplog.records]
    assert any("blocks went into each other by up to 4.9 m" in text for text in told)


@pytest.mark.slow
@pytest.mark.parametrize("analysis", ["large_step", "dynamics"])
def test_a9_8_rest_that_is_none_is_told(analysis: str, caplog: pytest.LogCaptureFixture) -> None:
    """A step of 1e5 s: a speed of 1e-11 of what the weight gives in it goes a metre."""
    h = 1e5
    plan = Equilibrium(strategy="large_step", step=h, max_steps=2)
    result = solve_scene(
        stack(2, "rigid", plan if analysis == "large_step" else Dynamics(step=h, duration=h))
    )
    assert base_force(result)[2] == pytest.approx(2 * 2400 * G, rel=1e-9)
    assert any("places are not" in record.getMessage() for record in caplog.records)
