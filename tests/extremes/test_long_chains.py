"""Chains of voussoirs (A3.8): 401 of them, close to the least thickness, each step of which is 0.45°."""

from __future__ import annotations

import pytest

from masonry_fem.analyses.run import solve_scene
from masonry_fem.scene.specs import Dynamics, Equilibrium
from tests.extremes.scenes import arch, arch_error, certificate, finite, thrust

LEAST = 0.10748  # of many voussoirs (A3.1)
ONE_STEP = Equilibrium(strategy="large_step", step=0.01, max_steps=3)


@pytest.mark.parametrize("count", [5, 21, 101, pytest.param(401, marks=pytest.mark.slow)])
@pytest.mark.parametrize("friction", [0.6, 5.0])
def test_arches_rest_however_many_voussoirs(count: int, friction: float) -> None:
    """t = 0.2: the springings carry the weight, with a thrust within A3.3's interval."""
    result = solve_scene(arch(count, 0.2, friction))
    assert result.outcome == "equilibrium"
    assert arch_error(result) < 1e-8
    assert max(certificate(result).values()) < 1e-9
    if count > 5:
        assert 0.094 < thrust(result) < 0.161


@pytest.mark.slow
@pytest.mark.parametrize("thickness", [0.2, 0.11, 1.01 * LEAST, 1.001 * LEAST])
def test_a3_8_four_hundred_voussoirs_stand(thickness: float) -> None:
    """Down to a thousandth above the least thickness; with H = 0.0621 … there (A3.1: 0.62088 γ t R)."""
    result = solve_scene(arch(401, thickness, 0.6))
    assert result.outcome == "equilibrium"
    assert arch_error(result) < 1e-8
    assert max(certificate(result).values()) < 1e-9
    if thickness < 1.02 * LEAST:
        assert thrust(result) == pytest.approx(0.62088 * thickness, rel=0.01)


@pytest.mark.slow
@pytest.mark.parametrize("thickness", [0.99 * LEAST, 0.8 * LEAST, 0.05])
def test_a3_8_four_hundred_voussoirs_fall(thickness: float) -> None:
    result = solve_scene(arch(401, thickness, 0.6))
    assert result.outcome == "no_equilibrium"
    assert finite(result)


@pytest.mark.slow
@pytest.mark.parametrize("thickness", [0.2, 0.11])
def test_a3_8_four_hundred_voussoirs_march_to_rest(thickness: float) -> None:
    result = solve_scene(arch(401, thickness, 5.0, analysis=ONE_STEP))
    assert result.outcome == "equilibrium"
    assert arch_error(result) < 1e-6


@pytest.mark.slow
def test_a3_8_four_hundred_voussoirs_in_time() -> None:
    result = solve_scene(arch(401, 0.2, 0.6, analysis=Dynamics(step=0.01, duration=0.03, theta=1.0)))
    assert result.outcome == "finished"
    assert arch_error(result) < 1e-6
    assert max(certificate(result).values()) < 1e-8


@pytest.mark.slow
@pytest.mark.parametrize(("thickness", "interval"), [(0.2, (0.0956, 0.1616)), (0.11, (0.0668, 0.0695))])
def test_a3_8_four_hundred_elastic_voussoirs(thickness: float, interval: tuple[float, float]) -> None:
    """One thrust, within the interval of the rigid ones (A3.3)."""
    result = solve_scene(arch(401, thickness, 0.6, "elastic"))
    assert result.outcome == "equilibrium"
    assert arch_error(result) < 1e-6
    assert interval[0] < thrust(result) < interval[1]
