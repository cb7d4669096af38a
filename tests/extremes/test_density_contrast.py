"""Densities of neighbours up to 1e±8 apart, rigid and elastic, in statics, in a march and in dynamics."""

from __future__ import annotations

import pytest

from masonry_fem.analyses.run import solve_scene
from tests.extremes.scenes import arrived, certificate
from tests.extremes.solids import (
    DENSITY,
    DYNAMICS,
    ONE_STEP,
    carried_error,
    column,
    wall,
    wall_error,
)

RATIOS = [1e-8, 1e-4, 1e4, 1e8]
STIFF = 1e18  # Pa: else stones of 1e11 kg/m³ are pressed flat


@pytest.mark.slow
@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("count", [1, 2])
@pytest.mark.parametrize("young", [None, STIFF], ids=["rigid", "elastic"])
@pytest.mark.parametrize("analysis", [None, ONE_STEP], ids=["statics", "large step"])
def test_column_of_light_and_heavy_cubes(analysis, young, count: int, ratio: float) -> None:
    """Each joint carries what lies above it, to 1e-6 of that: of a light stone on a heavy one, too."""
    densities = [DENSITY, DENSITY * ratio] * count
    result = solve_scene(column([young], densities, analysis=analysis))
    assert result.outcome == "equilibrium"
    assert carried_error(result) < 1e-6
    assert max(certificate(result).values()) < 1e-9


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("count", [1, 2])
def test_column_stays_in_dynamics(count: int, ratio: float) -> None:
    result = solve_scene(column([None], [DENSITY, DENSITY * ratio] * count, analysis=DYNAMICS))
    assert result.outcome == "finished"
    assert carried_error(result) < 1e-6
    assert result.march.report.speed < 1e-7
    assert max(certificate(result).values()) < 1e-9


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("alternate", ["courses", "columns"])
def test_rigid_wall_of_light_and_heavy_bricks(alternate: str, ratio: float) -> None:
    for analysis in (None, ONE_STEP, DYNAMICS):
        keys = {} if analysis is None else {"analysis": analysis}
        scene = wall(density_ratio=ratio, fidelity="rigid", alternate=alternate, **keys)
        result = solve_scene(scene)
        assert result.outcome == arrived(scene)
        assert wall_error(result) < 1e-7
        assert max(certificate(result).values()) < 1e-9


@pytest.mark.slow
@pytest.mark.parametrize(
    ("alternate", "ratio"),
    [("courses", 1e-3), ("courses", 1e4), ("courses", 1e8)]
    + [("columns", ratio) for ratio in (1e-8, 1e-4, 1e4, 1e8)],
)
def test_elastic_wall_of_light_and_heavy_bricks(alternate: str, ratio: float) -> None:
    result = solve_scene(wall(density_ratio=ratio, alternate=alternate, young=STIFF))
    assert result.outcome == "equilibrium"
    assert wall_error(result) < 1e-9
    assert max(certificate(result).values()) < 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("ratio", [1e-4, 1e-5])
def test_elastic_wall_under_bricks_without_weight(ratio: float) -> None:
    """Half bricks of 0.2 kg/m³ at the ends of a course ride on others that bulge."""
    result = solve_scene(wall(density_ratio=ratio, alternate="courses"))
    assert result.outcome == "equilibrium"
    assert result.summary.certificate.natural_map <= 1e-10
    assert wall_error(result) < 1e-7
