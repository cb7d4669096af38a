"""Young's moduli of neighbours up to 1e±12 apart, from 1e3 to 1e18 Pa, and rigid beside elastic blocks."""

from __future__ import annotations

import logging

import pytest

from masonry_fem.analyses.run import solve_scene
from masonry_fem.scene import check
from masonry_fem.scene.material_doubts import MAGNIFIED
from masonry_fem.scene.specs import Solver
from tests.extremes.scenes import certificate
from tests.extremes.solids import (
    DENSITY,
    LINEAR,
    YOUNG,
    column,
    column_error,
    patch,
    stress_errors,
    wall,
    wall_error,
)

RATIOS = [1e-12, 1e-8, 1e-4, 1e4, 1e8, 1e12]


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("dimension", [2, 3])
def test_column_of_soft_and_stiff_cubes(dimension: int, ratio: float) -> None:
    """What joints carry and how far the top sinks, to rounding, whatever the contrast."""
    young, exact = [YOUNG, YOUNG * ratio], Solver(tolerance=1e-12)
    result = solve_scene(column(young, (DENSITY,) * 4, dimension=dimension, contact=LINEAR, solver=exact))
    assert result.outcome == "equilibrium"
    assert max(certificate(result).values()) < 1e-12
    assert column_error(result) < 1e-11


@pytest.mark.parametrize("young", [1e3, 1e6, 1e9, 1e12, 1e15, 1e18])
@pytest.mark.parametrize("edge", [1e-3, 1.0, 1e3])
def test_column_of_any_stiffness(edge: float, young: float) -> None:
    result = solve_scene(column([young] * 4, edge=edge, contact=LINEAR))
    assert result.outcome == "equilibrium"
    assert column_error(result) < 1e-11


@pytest.mark.slow
@pytest.mark.parametrize("pair", [[None, YOUNG], [YOUNG, None]])
@pytest.mark.parametrize(("young", "error"), [(1e3, 1e-11), (1e10, 1e-10), (1e14, 1e-6), (1e18, 1e-2)])
def test_column_of_rigid_and_elastic_cubes(pair: list[float | None], young: float, error: float) -> None:
    """Between rigid cubes some m high, settlements are exact to the rounding of places, some 1e-15 m.

    The softest ones are strained by 110: where stones turn, such a column without friction buckles.
    """
    fixed = {"contact": LINEAR} if young < 1e6 else {}
    result = solve_scene(column([None if e is None else young for e in pair] * 3, **fixed))
    assert result.outcome == "equilibrium"
    assert column_error(result) < error
    assert max(certificate(result).values()) < 1e-9


@pytest.mark.parametrize("ratio", [1e-6, 1e-4, 1e4, 1e6])
@pytest.mark.parametrize("alternate", ["courses", "columns"])
def test_wall_of_soft_and_stiff_bricks(alternate: str, ratio: float) -> None:
    result = solve_scene(wall(ratio=ratio, alternate=alternate, contact=LINEAR))
    assert result.outcome == "equilibrium"
    assert wall_error(result) < 1e-10
    assert max(certificate(result).values()) < 1e-9


@pytest.mark.parametrize("ratio", [1e-8, 1e8])
@pytest.mark.parametrize("alternate", ["courses", "columns"])
def test_wall_at_the_end_of_the_range(alternate: str, ratio: float, caplog: pytest.LogCaptureFixture) -> None:
    """At 1e8 the law of contact holds to 1e-8; where that misses what is aimed at, the run says so."""
    with caplog.at_level(logging.WARNING):
        result = solve_scene(wall(ratio=ratio, alternate=alternate, contact=LINEAR))
    told = certificate(result)
    assert result.outcome == "equilibrium"
    assert ("ended at an error of up to" in caplog.text) == (result.summary.certificate.natural_map > 1e-10)
    assert max(told.values()) < 1e-7
    assert wall_error(result) < 1e-9


def test_rigid_courses_among_elastic_ones() -> None:
    result = solve_scene(wall(alternate="rigid courses"))
    assert result.outcome == "equilibrium"
    assert wall_error(result) < 1e-12


@pytest.mark.parametrize("ratio", [1e-8, 1e-6, 1e-4, 1e-2, 1e2, 1e4, 1e6, 1e8])
def test_patch_keeps_the_stress_of_the_softer_block(ratio: float) -> None:
    """2:3 elements. The stiffer block's stress errs by up to 50 times the contrast times the tolerance."""
    result = solve_scene(patch(ratio=ratio))
    assert result.outcome == "equilibrium"
    errors = stress_errors(result)
    soft, stiff = ("lower", "upper") if ratio > 1 else ("upper", "lower")
    contrast = max(ratio, 1 / ratio)
    assert errors[soft] < 1e-8
    assert errors[stiff] < max(1e-8, MAGNIFIED * contrast * 1e-10)


@pytest.mark.parametrize(("ratio", "tolerance", "told"), [
    (1e4, 1e-10, []), (1e8, 1e-10, ["make 'upper' rigid"]), (1e-8, 1e-10, ["make 'lower' rigid"]),
    (1e6, 1e-10, ["solver.tolerance at most 2e-11"]), (1e6, 1e-11, []),
])  # fmt: skip
def test_contrast_that_the_tolerance_does_not_bound_is_told(
    ratio: float, tolerance: float, told: list[str], caplog: pytest.LogCaptureFixture
) -> None:
    with caplog.at_level(logging.WARNING):
        check(patch(ratio=ratio, solver=Solver(tolerance=tolerance)))
    found = [record.getMessage() for record in caplog.records if "bound the stress" in record.getMessage()]
    assert [words in message for words, message in zip(told, found, strict=True)] == [True] * len(told)


@pytest.mark.parametrize("ratio", [1e-8, 1e8])
def test_matching_meshes_keep_both_stresses(ratio: float) -> None:
    result = solve_scene(patch(ratio=ratio, divisions=((3, 3), (3, 3)), placement="nodes"))
    assert max(stress_errors(result).values()) < 1e-6
