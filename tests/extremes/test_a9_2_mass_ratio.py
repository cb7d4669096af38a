"""A9.2: a heavy body on a light one and a light on a heavy one, up to 1e8 to one."""

from __future__ import annotations

import numpy as np
import pytest

from masonry_fem.analyses.run import solve_scene
from masonry_fem.nscd import ContactProblem, SolverSettings, rounding, solve
from masonry_fem.scene.specs import Equilibrium, Statics
from tests.extremes.scenes import certificate, mass_ratio, mass_ratio_error
from tests.validation.scenes import G

ONE_STEP = Equilibrium(strategy="large_step", step=0.01, max_steps=3, tolerance=1e-9)
# Under a million times the weight a block takes seconds to settle.
LONG_STEP = Equilibrium(strategy="large_step", step=1e3, max_steps=3, tolerance=1e-9)
RATIO = 1e6
STEP = 0.01


def particles(lower: float, upper: float) -> ContactProblem:
    """Two masses above each other on the ground: W = [[1/l, −1/l], [−1/l, 1/l + 1/u]]."""
    W = np.kron([[1 / lower, -1 / lower], [-1 / lower, 1 / lower + 1 / upper]], np.eye(2))
    return ContactProblem.plain(W, [[-G * STEP, 0.0], [0.0, 0.0]], 0.0)


@pytest.mark.parametrize("masses", [(1.0, RATIO), (RATIO, 1.0)], ids=["heavy on light", "light on heavy"])
def test_a9_2_two_particles(masses: tuple[float, float]) -> None:
    """R = (10⁶ + 1, 10⁶) g, or (10⁶ + 1, 1) g."""
    lower, upper = masses
    problem = particles(lower, upper)
    solution = solve(problem, SolverSettings(tolerance=1e-12))
    known = rounding(problem, solution.impulse, solution.rigid_velocity).error
    assert solution.quality.error <= max(1e-12, known)
    assert known < 1e-8  # 1/l times the rounding of what is upon it
    reaction = solution.impulse[:, 0] / STEP
    assert reaction == pytest.approx([(lower + upper) * G, upper * G], rel=1e-8)


@pytest.mark.parametrize(("masses", "radius"), [((1.0, RATIO), 0.999999), ((RATIO, 1.0), 1e-6)])
def test_a9_2_what_a_sweep_leaves(masses: tuple[float, float], radius: float) -> None:
    """Gauss–Seidel on both normals: a sweep leaves W_12²/(W_11 W_22) of the error."""
    W = particles(*masses).compliance.toarray()[::2, ::2]
    assert W[0, 1] * W[1, 0] / (W[0, 0] * W[1, 1]) == pytest.approx(radius, rel=2e-6)


@pytest.mark.parametrize(
    ("fidelity", "analysis"),
    [("rigid", ONE_STEP), ("rigid", Statics()), ("elastic", LONG_STEP), ("elastic", Statics())],
    ids=["rigid, large step", "rigid, statics", "elastic, large step", "elastic, statics"],
)
@pytest.mark.parametrize("ratio", [1 / RATIO, 1.0, RATIO])
def test_a9_2_blocks(ratio: float, analysis: Equilibrium | Statics, fidelity: str) -> None:
    result = solve_scene(mass_ratio(ratio, fidelity, analysis, tolerance=1e-12))
    assert result.outcome == "equilibrium"
    assert mass_ratio_error(result, ratio) < 1e-6


@pytest.mark.parametrize("fidelity", ["rigid", "elastic"])
@pytest.mark.parametrize("power", [-8, -6, -3, 3, 6, 8])
def test_a9_2_at_the_tolerance_that_scenes_have(power: int, fidelity: str) -> None:
    """Statics to 1e-10: both joints to 1e-6 of what each carries, from 1e-8 to 1e8."""
    result = solve_scene(mass_ratio(10.0**power, fidelity))
    assert result.outcome == "equilibrium"
    assert mass_ratio_error(result, 10.0**power) < 1e-6
    assert max(certificate(result).values()) < 1e-8
