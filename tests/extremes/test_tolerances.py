"""Tolerances from 1e-2 to 1e-15: the certificate tells what is not exact; what cannot be had, the outcome."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from masonry_fem.analyses.run import RunResult, solve_scene
from masonry_fem.errors import SceneError
from masonry_fem.scene.specs import Scene
from tests.extremes.scenes import (
    LARGE_STEP,
    WEIGHT,
    arch,
    arch_error,
    arrived,
    base_force,
    certificate,
    finite,
    pushed_wall,
    stack,
    standing_wall,
    wall_error,
)

SCENES: dict[str, tuple[Callable[..., Scene], Callable[[RunResult], float]]] = {
    "rigid stack": (lambda **own: stack(100, **own), lambda r: abs(base_force(r)[2] / (100 * WEIGHT) - 1)),
    "elastic stack": (
        lambda **own: stack(100, "elastic", **own), lambda r: abs(base_force(r)[2] / (100 * WEIGHT) - 1),
    ),
    "rigid arch": (arch, arch_error),
    "elastic arch": (lambda **own: arch(fidelity="elastic", **own), arch_error),
    "rigid wall": (lambda **own: pushed_wall(dimension=3, **own), wall_error),
    "elastic wall": (lambda **own: pushed_wall(dimension=3, fidelity="elastic", **own), wall_error),
    "wall that slips": (
        lambda **own: pushed_wall(0.3, 0.2, "elastic", **own), lambda r: wall_error(r, 0.2),
    ),
    "wall in time": (lambda **own: standing_wall(0.01, **own), wall_error),
}  # fmt: skip
REACHED = [10.0**-power for power in (2, 3, 4, 6, 8, 10, 12)]


@pytest.mark.slow
@pytest.mark.parametrize("tolerance", REACHED)
@pytest.mark.parametrize("name", SCENES)
def test_what_a_tolerance_leaves_is_in_the_certificate(name: str, tolerance: float) -> None:
    """The error of the supports' force is at most three times what the certificate says."""
    build, error = SCENES[name]
    scene = build(tolerance=tolerance)
    result = solve_scene(scene)
    assert result.outcome == arrived(scene)
    assert finite(result)
    told = max(certificate(result).values())
    assert told <= 30 * tolerance  # balance is told by a block's load, of which a stack has a hundred
    assert error(result) <= max(3 * told, 1e-13)


@pytest.mark.slow
@pytest.mark.parametrize("tolerance", [1e-13, 1e-14, 1e-15])
@pytest.mark.parametrize("name", SCENES)
def test_below_rounding_it_is_reached_or_told(name: str, tolerance: float) -> None:
    """Elastic blocks are held to the tolerance, and the message says that rounding is all that is left; rigid
    blocks are answered as well as arithmetic can.
    """
    build, error = SCENES[name]
    scene = build(tolerance=tolerance)
    result = solve_scene(scene)
    reached = result.march.report.quality.error
    held = scene.fidelity == "rigid" or reached <= tolerance
    assert result.outcome == (arrived(scene) if held else "no_convergence")
    assert ("rounding" in result.message) == (not held)
    assert "load_steps" not in result.message  # smaller steps round no less
    assert reached < 1e-12
    assert error(result) < 1e-12


def test_sweeps_that_cannot_reach_it_say_so() -> None:
    """933 sweeps a decade for a stack of 100: 500 leave most of the weight, and no claim is made."""
    result = solve_scene(stack(100, "rigid", LARGE_STEP, tolerance=1e-10, method="nsgs", max_iterations=500))
    assert result.outcome == "no_convergence"
    assert max(certificate(result).values()) > 1e-6


def test_contacts_solved_worse_than_rest_is_asked_for_are_refused() -> None:
    with pytest.raises(SceneError, match=r"solver\.tolerance is 0\.01, expected at most"):
        solve_scene(stack(10, "rigid", LARGE_STEP, tolerance=1e-2))


def test_a_march_solved_too_loosely_does_not_claim_a_fall() -> None:
    """1e-6 leaves speeds above what counts as rest in a stack of 100: it is neither at rest nor falling."""
    result = solve_scene(stack(100, "rigid", LARGE_STEP, tolerance=1e-6))
    assert result.outcome == "no_convergence"
    assert "tighten solver.tolerance" in result.message
    assert base_force(result)[2] == pytest.approx(100 * WEIGHT, rel=1e-5)
    assert np.isfinite(list(certificate(result).values())).all()
