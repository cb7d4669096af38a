"""Properties of the whole chain: same bits, same physics in any frame, replay, exact energy."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from masonry_fem.analyses.run import RunResult
from masonry_fem.nscd import SolverSettings, load_problem, save_problem, solve
from masonry_fem.scene.specs import Dynamics, Joint, Loads, Material, MeshSettings, Statics
from masonry_fem.structures.block import BlockStructure
from tests.validation.scenes import G, low_wall, solved
from tests.validation.tape import taped


def two_on_a_base(turn: Rotation, **keys) -> RunResult:
    """A base and two stones on it, all turned about the origin, gravity and a push with them."""
    rotvec = turn.as_rotvec(degrees=True)
    angle = float(np.linalg.norm(rotvec))
    axis = tuple(rotvec / angle) if angle else (0.0, 0.0, 1.0)

    def block(name: str, size, low, **more) -> BlockStructure:
        return BlockStructure(
            name=name,
            material="stone",
            size=size,
            position=tuple(turn.apply(low)),
            rotation=angle,
            axis=axis,
            **more,
        )

    return solved(
        structures=(
            block("base", (3.0, 1.0, 0.5), (-1.0, 0.0, -0.5), support=True),
            block("lower", (1.0, 1.0, 0.5), (0.0, 0.0, 0.0)),
            block("upper", (0.8, 1.0, 0.5), (0.1, 0.0, 0.5)),
        ),
        mesh=MeshSettings(divisions=(2, 2, 2)),
        loads=Loads(gravity=tuple(turn.apply((0.2 * G, 0.1 * G, -G)))),
        **({"analysis": Statics(), "joints": (Joint(friction=0.5, placement="gauss"),)} | keys),
    )


@pytest.mark.parametrize("vector", [(0.0, 30.0, 0.0), (25.0, -40.0, 70.0)])
def test_results_turn_with_the_frame(vector) -> None:
    turn = Rotation.from_rotvec(vector, degrees=True)
    still, turned = two_on_a_base(Rotation.identity()), two_on_a_base(turn)
    assert still.outcome == turned.outcome == "equilibrium"
    force = still.summary.supports["base"].force
    assert turned.summary.supports["base"].force == pytest.approx(turn.apply(force), rel=1e-8, abs=1e-6)
    assert turned.summary.energy.strain == pytest.approx(still.summary.energy.strain, rel=1e-8)
    for key in ("max_von_mises", "min_principal"):
        one, other = (getattr(result.summary.stress, key).value for result in (still, turned))
        assert other == pytest.approx(one, rel=1e-7)


def test_same_scene_same_bits() -> None:
    one, two = (low_wall(0.25) for _ in range(2))
    assert np.array_equal(one.march.state.reaction, two.march.state.reaction)
    for a, b in zip(one.march.state.bodies, two.march.state.bodies, strict=True):
        if hasattr(a, "displacement"):
            assert np.array_equal(a.displacement, b.displacement)


def test_saved_contact_problem_replays(tmp_path: Path) -> None:
    """The condensed operators of a step, saved and solved again, give its velocities."""
    result = low_wall(0.25)
    save_problem(result.march.last.problem, tmp_path / "step.npz")
    again = solve(load_problem(tmp_path / "step.npz"), SolverSettings(tolerance=1e-10))
    assert again.converged
    expected = result.march.last.solution.velocity
    assert again.velocity == pytest.approx(expected, abs=1e-9 * np.abs(expected).max())


@pytest.mark.parametrize("theta", [0.5, 0.75, 1.0])
@pytest.mark.parametrize("fidelity", ["rigid", "elastic"])
def test_energy_of_a_sliding_stack_is_accounted_for(theta: float, fidelity: str) -> None:
    """Work, friction, Rayleigh damping and the scheme's own loss: nothing is missing to rounding."""
    stone = Material(density=2400.0, young=1e8, poisson=0.2)
    _, made, _ = taped(
        fidelity=fidelity,
        materials={"stone": stone},
        structures=(
            BlockStructure(
                name="base", material="stone", size=(4, 1, 0.5), position=(0, 0, -0.5), support=True
            ),
            BlockStructure(name="lower", material="stone", size=(1, 1, 0.5)),
            BlockStructure(name="upper", material="stone", size=(1, 1, 0.5), position=(0, 0, 0.5)),
        ),
        mesh=MeshSettings(divisions=(2, 2, 1)),
        joints=(Joint(friction=0.2),),
        loads=Loads(gravity=(0.5 * G, 0, -G)),
        analysis=Dynamics(step=2e-3, duration=0.1, theta=theta),
    )
    assert made.outcome == "finished"
    assert made.ledger.friction_dissipation > 0
    assert made.ledger.imbalance < 1e-10
    assert made.report.block_balance < 1e-8
