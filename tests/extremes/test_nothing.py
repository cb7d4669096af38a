"""Almost nothing: no gravity, no contact, one block, no free one, no time: none may end in nonsense."""

from __future__ import annotations

import msgspec
import numpy as np
import pytest

from masonry_fem.analyses.run import solve_scene
from masonry_fem.errors import SceneError
from masonry_fem.scene.specs import Analysis, Dynamics, Equilibrium, Statics, Support
from masonry_fem.structures.block import BlockStructure
from tests.extremes.scenes import (
    LARGE_STEP,
    WEIGHT,
    G,
    base_force,
    block_on_slope,
    certificate,
    finite,
    lonely,
    scattered,
    slope_error,
    stack,
    stack_error,
    weightless,
)

FIDELITIES = ["rigid", "elastic"]
ANALYSES: dict[str, Analysis] = {
    "statics": Statics(),
    "three load steps": Statics(load_steps=3),
    "dynamics": Dynamics(step=0.01, duration=0.05),
    "numerical viscosity": Equilibrium(strategy="numerical_viscosity", step=0.01, max_steps=5),
    "brutal damping": Equilibrium(strategy="brutal_damping", step=0.01, max_steps=5),
    "linear damping": Equilibrium(strategy="linear_damping", step=0.01, max_steps=5),
    "large step": Equilibrium(strategy="large_step", step=1.0, max_steps=1),
}
SEEKING = [name for name in ANALYSES if name != "dynamics"]


@pytest.mark.parametrize("fidelity", FIDELITIES)
@pytest.mark.parametrize("name", ANALYSES)
def test_without_gravity_nothing_happens(name: str, fidelity, caplog: pytest.LogCaptureFixture) -> None:
    """No force, no motion, an equilibrium; and a word that nothing acts."""
    result = solve_scene(weightless(fidelity, ANALYSES[name]))
    assert result.outcome == ("finished" if name == "dynamics" else "equilibrium")
    assert not result.march.state.reaction.any()
    assert not result.march.state.velocity.any()
    assert max(certificate(result).values()) == 0
    assert any("nothing acts on the blocks" in record.getMessage() for record in caplog.records)


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("fidelity", FIDELITIES)
@pytest.mark.parametrize("name", ANALYSES)
def test_a_single_block_that_is_held(name: str, fidelity, dimension: int) -> None:
    """No free block and no contact: at rest from the start."""
    result = solve_scene(lonely("held", fidelity, ANALYSES[name], dimension))
    assert result.outcome == ("finished" if name == "dynamics" else "equilibrium")
    assert finite(result)
    assert result.summary.contacts == 0


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("fidelity", FIDELITIES)
@pytest.mark.parametrize("name", SEEKING)
def test_a_single_block_that_nothing_holds_falls(name: str, fidelity, dimension: int) -> None:
    """In statics, too, the outcome names it and says that it falls."""
    result = solve_scene(lonely("free", fidelity, ANALYSES[name], dimension))
    assert result.outcome == "no_equilibrium"
    assert "cube falls" in result.message
    assert finite(result)


@pytest.mark.parametrize("theta", [0.5, 1.0])
@pytest.mark.parametrize("fidelity", FIDELITIES)
def test_free_flight_is_met_by_algebra(fidelity, theta: float) -> None:
    march = Dynamics(step=0.01, duration=0.1, theta=theta)
    fallen = G * 0.01**2 * 10 * (10 - 1 + 2 * theta) / 2
    result = solve_scene(lonely("free", fidelity, march))
    assert result.outcome == "finished"
    assert result.summary.probes["cube"] == pytest.approx([0, 0, -fallen], abs=1e-12)
    assert max(certificate(result).values()) < 1e-12
    several = solve_scene(scattered(fidelity=fidelity, analysis=march))
    for name in ("c0", "c1"):
        assert several.summary.probes[name] == pytest.approx([0, 0, -fallen], abs=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("fidelity", FIDELITIES)
@pytest.mark.parametrize("analysis", [Statics(), LARGE_STEP], ids=["statics", "large step"])
def test_only_what_flies_is_named(analysis, fidelity) -> None:
    """A stack that stands, and a block in the air beside it."""
    scene = stack(2, fidelity, analysis)
    flying = BlockStructure(name="bird", material="stone", size=(1, 1, 1), position=(0, 0, 5))
    result = solve_scene(msgspec.structs.replace(scene, structures=(*scene.structures, flying)))
    assert result.outcome == "no_equilibrium"
    assert "bird falls" in result.message
    assert "stack" not in result.message


@pytest.mark.parametrize("fidelity", FIDELITIES)
@pytest.mark.parametrize("name", ANALYSES)
def test_all_blocks_held(name: str, fidelity) -> None:
    """Joints of blocks none of which can move are no joints."""
    scene = msgspec.structs.replace(stack(3, fidelity, ANALYSES[name]), supports=(Support(on="stack.*"),))
    result = solve_scene(scene)
    assert result.outcome == ("finished" if name == "dynamics" else "equilibrium")
    assert result.summary.contacts == 0
    assert finite(result)


@pytest.mark.parametrize("name", ANALYSES)
def test_a_clamped_block_without_joints(name: str) -> None:
    """Its base gives the weight, in statics exactly; waves are left in dynamics."""
    result = solve_scene(lonely("clamped", "elastic", ANALYSES[name]))
    assert finite(result)
    if name in ("statics", "three load steps", "large step"):
        assert result.outcome == "equilibrium"
        assert base_force(result) == pytest.approx([0, 0, WEIGHT], abs=1e-6 * WEIGHT)


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("fidelity", FIDELITIES)
def test_one_block_on_the_ground(fidelity, dimension: int) -> None:
    result = solve_scene(block_on_slope(0.6, 0.0, fidelity, dimension))
    assert result.outcome == "equilibrium"
    assert slope_error(result, 0.0) < 1e-10


@pytest.mark.parametrize("duration", [1e-300, 1e-9, 0.0099])
@pytest.mark.parametrize("fidelity", FIDELITIES)
def test_a_run_shorter_than_its_step_is_refused(fidelity, duration: float) -> None:
    with pytest.raises(SceneError, match=r"analysis\.duration .* not shorter than the step"):
        solve_scene(stack(2, fidelity, Dynamics(step=0.01, duration=duration)))


@pytest.mark.parametrize("step", [1e-100, 1e-15, 1e-6, 0.01])
@pytest.mark.parametrize("fidelity", FIDELITIES)
def test_a_run_of_one_step(fidelity, step: float) -> None:
    result = solve_scene(stack(2, fidelity, Dynamics(step=step, duration=step, theta=1.0)))
    assert result.outcome == "finished"
    assert result.summary.steps == 1
    assert finite(result)
    if fidelity == "rigid":
        assert stack_error(result) < 1e-8


@pytest.mark.parametrize(
    "strategy", ["numerical_viscosity", "brutal_damping", "linear_damping", "large_step"]
)
@pytest.mark.parametrize("step", [1e-6, 1e-3])
def test_a_march_that_is_too_short_says_so(strategy, step: float) -> None:
    """Elastic cubes settle for longer than a step: that is no proof that they fall."""
    result = solve_scene(stack(3, "elastic", Equilibrium(strategy=strategy, step=step, max_steps=1)))
    assert result.outcome == "no_convergence"
    assert "Not at rest after 1 step" in result.message
    assert "max_steps" in result.message
    assert np.isfinite(list(certificate(result).values())).all()


@pytest.mark.parametrize("step", [1e-300, 1e31, 1e100])
def test_steps_beyond_what_numbers_can_hold_are_refused(step: float) -> None:
    with pytest.raises(SceneError, match=r"analysis\.step .* expected a time from 1e-100 to 1e\+30 s"):
        solve_scene(stack(2, "rigid", Dynamics(step=step, duration=step)))
