"""Meshes: one element beside hundreds, all kinds of elements, elements of aspect 1e4."""

from __future__ import annotations

import pytest

from masonry_fem.analyses.run import solve_scene
from tests.extremes.scenes import certificate
from tests.extremes.solids import column, column_error, patch, patch_error


@pytest.mark.parametrize(("lower", "upper"), [
    ((1, 1), (1, 1)), ((1, 1), (50, 50)), ((50, 50), (1, 1)), ((1, 2), (100, 2)), ((2, 2), (3, 50)),
    pytest.param((1, 1), (300, 1), marks=pytest.mark.slow),
])  # fmt: skip
def test_patch_of_very_different_meshes(lower: tuple[int, int], upper: tuple[int, int]) -> None:
    """One element beside 50, 100, 300 of the other side, at Gauss points of the common segments."""
    result = solve_scene(patch(divisions=(lower, upper)))
    assert result.outcome == "equilibrium"
    assert patch_error(result) < 1e-8
    assert max(certificate(result).values()) < 1e-9


@pytest.mark.parametrize("one", ["P1", "Q1", "P2", "Q2"])
@pytest.mark.parametrize("two", ["P1", "Q1", "P2", "Q2"])
def test_patch_of_any_elements(one: str, two: str) -> None:
    """1:20. A quadratic element that 20 linear ones push errs by 200 times the tolerance."""
    result = solve_scene(patch(elements=(one, two), divisions=((1, 1), (20, 4))))
    assert result.outcome == "equilibrium"
    assert patch_error(result) < 1e-7
    assert max(certificate(result).values()) < 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("element", ["P1", "Q1", "P2", "Q2"])
def test_patch_in_space(element: str) -> None:
    one, many = (1, 1, 1), (4, 4, 2)
    scene = patch(size=(1.0, 1.0, 1.0), elements=(element, element), divisions=(one, many))
    assert patch_error(solve_scene(scene)) < 1e-8


@pytest.mark.parametrize("aspect", [1e2, 1e3, 1e4])
@pytest.mark.parametrize("lying", [True, False], ids=["plates", "needles"])
def test_patch_of_slivers(aspect: float, lying: bool) -> None:
    """Blocks of aspect 1e4, their elements likewise, at the default tolerance (A9.10 has a tighter one).

    The stress errs by some aspect times the tolerance, 1e-6 at 1e4, whatever the path of the solver.
    """
    size = (1.0, 1.0 / aspect) if lying else (1.0 / aspect, 1.0)
    result = solve_scene(patch(size=size))
    assert result.outcome == "equilibrium"
    assert patch_error(result) < 3 * aspect * 1e-10
    assert max(certificate(result).values()) < max(1e-9, 1e-11 * aspect)


@pytest.mark.parametrize("divisions", [(1, 1), (1, 200), (200, 1)])
def test_column_of_one_element_or_very_many(divisions: tuple[int, int]) -> None:
    from masonry_fem.scene.specs import MeshSettings

    scene = column([1e10] * 3, mesh=MeshSettings(divisions=divisions))
    result = solve_scene(scene)
    assert column_error(result) < 1e-8
    assert max(certificate(result).values()) < 1e-8
