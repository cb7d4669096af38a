"""A9.1: stacks of 10, 100 and 1000 blocks, rigid and elastic: n W at the base, ρ g L²/2E at the top."""

from __future__ import annotations

import pytest

from masonry_fem.analyses.run import solve_scene
from masonry_fem.scene.specs import Equilibrium, Statics
from tests.extremes.scenes import WEIGHT, base_force, certificate, stack, stack_error

ONE_STEP = Equilibrium(strategy="large_step", step=0.01, max_steps=3, tolerance=1e-9)


@pytest.mark.parametrize("analysis", [ONE_STEP, Statics()], ids=["large step", "statics"])
@pytest.mark.parametrize("count", [10, 100, pytest.param(1000, marks=pytest.mark.slow)])
def test_a9_1_stack_presses_with_its_whole_weight(count: int, analysis: Equilibrium | Statics) -> None:
    """Base force nW to 1e-6: what a test on the change of r gets wrong on tall stacks."""
    result = solve_scene(stack(count, "rigid", analysis, tolerance=1e-12))
    assert result.outcome == "equilibrium"
    assert base_force(result)[2] == pytest.approx(count * WEIGHT, rel=1e-6)
    assert stack_error(result) < 1e-6


@pytest.mark.parametrize("fidelity", ["rigid", "elastic"])
@pytest.mark.parametrize("count", [1, 10, 100, pytest.param(1000, marks=pytest.mark.slow)])
def test_a9_1_the_tolerance_that_scenes_have_does(count: int, fidelity) -> None:
    """1e-10 of the whole: of a block's own weight, which is 1/n of it, n times as much; A9.1 asks for 1e-6.

    The certificate, which is relative to single blocks, says so.
    """
    result = solve_scene(stack(count, fidelity))
    of_a_block = 1e-10 * max(count, 10)
    assert result.outcome == "equilibrium"
    assert base_force(result)[2] == pytest.approx(count * WEIGHT, rel=of_a_block)
    assert stack_error(result) < of_a_block
    assert max(certificate(result).values()) < of_a_block
    assert stack_error(result) < 3 * max(certificate(result).values()) + 1e-12


def test_a9_1_unsolved_steps_say_nothing_of_what_exists() -> None:
    """Cut short, sweeps leave two thirds of the weight uncarried; that is no proof of a fall.

    By impulses alone their error is below 1e-3.
    """
    result = solve_scene(stack(100, "rigid", ONE_STEP, tolerance=1e-12, method="nsgs", max_iterations=1000))
    assert result.march.report.natural_map < 1e-3
    assert result.outcome == "no_convergence"
    assert "max_iterations" in result.message


@pytest.mark.parametrize(
    ("count", "divisions"),
    [(10, 1), (10, 2), (100, 1), (100, 2), pytest.param(1000, 1, marks=pytest.mark.slow)],
)
def test_a9_1_elastic_stack_settles_by_its_weight(count: int, divisions: int) -> None:
    """ρ g L²/2E with ν = 0 and no friction; linear elements meet end displacements exactly."""
    # its error grows with the height
    tolerance = 1e-12 if count == 1000 else 1e-10
    result = solve_scene(stack(count, "elastic", divisions=divisions, tolerance=tolerance, friction=0.0))
    assert result.outcome == "equilibrium"
    assert stack_error(result) < 1e-8
    assert base_force(result)[2] == pytest.approx(count * WEIGHT, rel=1e-8)
