"""A9.3: more contact points than freedoms: reactions are not unique, what they add up to is."""

from __future__ import annotations

import numpy as np
import pytest

from masonry_fem.analyses.run import solve_scene
from tests.extremes.scenes import LARGE_STEP, block_on_slope, slope_error
from tests.validation.scenes import G, cube_on_slope


def test_a9_3_a_cube_on_four_corners_has_rank_six() -> None:
    """Delassus' 12 × 12 matrix of a unit cube of 1 kg: W_nn = 4, beside it 1, 1 and −2; σ1/σ6 = 8.5497."""
    result = solve_scene(block_on_slope(0.6, 0.0, analysis=LARGE_STEP))
    W = 2400.0 * result.march.last.problem.delassus().toarray()
    values = np.linalg.svd(W, compute_uv=False)
    assert (values > 1e-10 * values[0]).sum() == 6
    assert values[0] / values[5] == pytest.approx(8.5497, rel=1e-5)
    normal = W[::3, ::3]
    assert np.diag(normal) == pytest.approx(np.full(4, 4.0), rel=1e-12)
    for row in range(4):
        assert sorted(np.delete(normal[row], row)) == pytest.approx([-2.0, 1.0, 1.0], rel=1e-12)


@pytest.mark.parametrize("friction", [0.0, 1e-6, 0.6, 1e2, 1e6])
@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("fidelity", ["rigid", "elastic"])
def test_a9_3_friction_does_not_matter_on_level_ground(fidelity, dimension: int, friction: float) -> None:
    """μ = 0 or 1e6: v = 0 and the weight is carried."""
    result = solve_scene(block_on_slope(friction, 0.0, fidelity, dimension))
    assert result.outcome == "equilibrium"
    assert slope_error(result, 0.0) < 1e-10


@pytest.mark.parametrize("friction", [0.0, 0.6, 1e6])
def test_a9_3_four_corners_share_the_weight(friction: float) -> None:
    """Reactions of the four corners are not unique; their force and moment are."""
    result = cube_on_slope(0.0, friction, analysis=LARGE_STEP)
    ground = result.summary.supports["cube.ground"]
    weight = 2400 * G
    assert ground.force == pytest.approx([0, 0, weight], abs=1e-8 * weight)
    assert ground.moment == pytest.approx([0.5 * weight, -0.5 * weight, 0], abs=1e-8 * weight)
    assert result.march.report.speed < 1e-12
