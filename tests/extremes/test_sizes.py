"""Structures from a micrometre to 1e5 km, far from the origin, and blocks of very different sizes."""

from __future__ import annotations

from typing import Any

import pytest

from masonry_fem.analyses.run import solve_scene
from masonry_fem.scene.specs import Solver
from tests.extremes.scenes import arrived, certificate
from tests.extremes.solids import (
    DYNAMICS,
    LINEAR,
    ONE_STEP,
    arch,
    carried_error,
    column,
    column_error,
    patch,
    patch_error,
    sizes_apart,
    thrust,
    wall,
    wall_error,
)

RADII = [1e-6, 1e-3, 1e-2, 1e2, 1e4, 1e8]
PLACES = [1e2, 1e4, 1e6, 1e8]


@pytest.mark.parametrize("radius", RADII)
@pytest.mark.parametrize("fidelity", ["rigid", "elastic"])
def test_arch_of_any_size_thrusts_alike(fidelity: str, radius: float) -> None:
    """H/γR² of the 1 m arch, with E/(ρgR) kept; A3.3's interval holds it."""
    one = thrust(solve_scene(arch(fidelity=fidelity, stiffness=1e6)))
    result = solve_scene(arch(radius=radius, fidelity=fidelity, stiffness=1e6))
    assert result.outcome == "equilibrium"
    assert thrust(result, radius) == pytest.approx(one, rel=1e-9)
    assert 0.094247 <= one <= 0.160027
    assert max(certificate(result).values()) < 1e-9


@pytest.mark.parametrize("edge", [1e-6, 1e-3, 1.0, 1e3])
def test_column_of_one_stone_settles_with_the_square_of_its_size(edge: float) -> None:
    """E is not scaled: n² ρ g L² / 2E, physical sizes."""
    assert column_error(solve_scene(column([1e10] * 3, edge=edge))) < 1e-11


@pytest.mark.parametrize("scale", [1e-6, 1e-3, 1e3, 1e6])
@pytest.mark.parametrize("fidelity", ["rigid", "elastic"])
def test_wall_of_any_size(fidelity: str, scale: float) -> None:
    """An elastic wall 1000 km high would flow: with fixed contacts it balances in the reference."""
    for analysis in (None, ONE_STEP, DYNAMICS) if fidelity == "rigid" else (None,):
        keys: dict[str, Any] = {} if analysis is None else {"analysis": analysis}
        if fidelity == "elastic":
            keys["contact"] = LINEAR
        scene = wall(scale=scale, fidelity=fidelity, **keys)
        result = solve_scene(scene)
        assert result.outcome == arrived(scene)
        assert wall_error(result) < 1e-8
        assert max(certificate(result).values()) < 1e-9


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("fidelity", ["rigid", "elastic"])
def test_arch_far_from_the_origin(fidelity: str, place: float) -> None:
    """Digits that places lose are lost to the thrust, too: 1e-16 of the distance over R."""
    one = thrust(solve_scene(arch(fidelity=fidelity)))
    result = solve_scene(arch(fidelity=fidelity, at=(place, -place)))
    assert result.outcome == "equilibrium"
    assert thrust(result) == pytest.approx(one, rel=max(1e-11, 1e-15 * place))
    assert max(certificate(result).values()) < 1e-9


@pytest.mark.parametrize("place", PLACES)
def test_patch_and_wall_far_from_the_origin(place: float) -> None:
    assert patch_error(solve_scene(patch(at=(place, place)))) < 1e-8
    result = solve_scene(wall(at=(place, place)))
    assert wall_error(result) < 1e-9
    assert max(certificate(result).values()) < 1e-9


@pytest.mark.parametrize("ratio", [1e2, 1e4])
@pytest.mark.parametrize(
    ("dimension", "fidelity"), [(2, "rigid"), (2, "elastic"), (3, "rigid"), (3, "elastic")]
)
def test_faces_far_apart_in_size(dimension: int, fidelity: str, ratio: float) -> None:
    """A cube on one of 1e4 times its edge: faces 1e8 apart in area, masses 1e12.

    The tolerance is of the whole: 1e-10 of the large cube's weight may be all of the small one's.
    """
    for analysis in (None, ONE_STEP) if fidelity == "rigid" else (None,):
        keys = {"solver": Solver(tolerance=1e-12)} | ({} if analysis is None else {"analysis": analysis})
        result = solve_scene(sizes_apart(ratio, dimension=dimension, fidelity=fidelity, **keys))
        assert result.outcome == "equilibrium"
        assert carried_error(result) < 1e-5
        assert max(certificate(result).values()) < 1e-9
