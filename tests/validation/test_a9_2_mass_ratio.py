"""A9.2: a heavy body on a light one and a light on a heavy one, a million to one."""

from __future__ import annotations

import msgspec
import numpy as np
import pytest

from masonry_fem.nscd import ContactProblem, SolverSettings, solve
from masonry_fem.scene.specs import Equilibrium, Material, Override, Solver, StackStructure, Statics
from tests.validation.scenes import G, solved
from tests.validation.test_a9_extremes import ONE_STEP, carried

# Under a million times the weight a block takes seconds to settle.
LONG_STEP = msgspec.structs.replace(ONE_STEP, step=1e3)
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
    solution = solve(particles(lower, upper), SolverSettings(tolerance=1e-12))
    assert solution.converged
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
@pytest.mark.parametrize("heavy", ["pair.b1", "pair.b2"])
def test_a9_2_blocks(heavy: str, analysis: Equilibrium | Statics, fidelity: str) -> None:
    light = Material(density=1.0, young=10e9, poisson=0.2)
    result = solved(
        fidelity=fidelity,
        materials={"light": light, "heavy": Material(density=RATIO, young=10e9, poisson=0.2)},
        structures=(StackStructure(name="pair", material="light", size=(1, 1, 1), count=2),),
        overrides=(Override(blocks=heavy, material="heavy"),),
        analysis=analysis,
        solver=Solver(tolerance=1e-12),
    )
    assert result.outcome == "equilibrium"
    upper = RATIO if heavy == "pair.b2" else 1.0
    assert carried(result) == pytest.approx([(RATIO + 1) * G, upper * G], rel=1e-6)
