"""A9.6: friction from none to a million and to "no slip", in 2D and 3D, of rigid and elastic blocks."""

from __future__ import annotations

import numpy as np
import pytest

from masonry_fem.analyses.run import solve_scene
from masonry_fem.scene.specs import Dynamics, Equilibrium, Joint, Probe, Statics
from masonry_fem.structures.stack import StackStructure
from tests.extremes.scenes import (
    LARGE_STEP,
    arch,
    arch_error,
    block_on_slope,
    certificate,
    finite,
    pushed_wall,
    slope_error,
    wall_error,
)
from tests.extremes.scenes import joint_forces as carried
from tests.validation.scenes import G, cube_on_slope, rigid_arch, solved

ONE_STEP = Equilibrium(strategy="large_step", step=0.01, max_steps=3, tolerance=1e-9)
DYNAMICS = Dynamics(step=0.01, duration=0.03, theta=1.0)
ROUGH = [1.0, 1e2, 1e4, 1e6, 1e8, "no slip"]
EXACT = 2e-10  # twice the tolerance that scenes have by default


@pytest.mark.parametrize("friction", [0.0, 1e-8, 0.3, 0.36])
@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("fidelity", ["rigid", "elastic"])
@pytest.mark.parametrize("analysis", [Statics(), LARGE_STEP], ids=["statics", "large step"])
def test_a9_6_too_smooth_a_slope_holds_nothing(analysis, fidelity, dimension: int, friction: float) -> None:
    """tan 20° = 0.364: the outcome names the block and that it slides."""
    result = solve_scene(block_on_slope(friction, 20.0, fidelity, dimension, analysis))
    assert result.outcome == "no_equilibrium"
    assert "cube.b1 slides" in result.message


@pytest.mark.parametrize("friction", [0.37, 0.6, *ROUGH])
@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("fidelity", ["rigid", "elastic"])
@pytest.mark.parametrize("analysis", [Statics(), LARGE_STEP], ids=["statics", "large step"])
def test_a9_6_a_rough_slope_holds_the_cube(analysis, fidelity, dimension: int, friction) -> None:
    result = solve_scene(block_on_slope(friction, 20.0, fidelity, dimension, analysis))
    assert result.outcome == "equilibrium"
    assert slope_error(result) < (1e-9 if isinstance(analysis, Statics) else analysis.tolerance)
    assert max(certificate(result).values()) < EXACT


@pytest.mark.parametrize("edge", np.geomspace(0.3, 3.0, 8))
@pytest.mark.parametrize("friction", [1e6, 1e8, 1e10])
def test_a9_6_a_rough_slope_holds_rigid_cubes_of_any_size(friction: float, edge: float) -> None:
    """Velocities that are rounding, times μ, are a larger error than the tolerance."""
    angle = 15.0 + 5.0 * edge  # of as many roundings
    result = solve_scene(block_on_slope(friction, angle, analysis=LARGE_STEP, edge=edge))
    assert result.outcome == "equilibrium"
    assert max(certificate(result).values()) < EXACT
    assert result.summary.certificate.max_penetration < 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("friction", ROUGH)
@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("fidelity", ["rigid", "elastic"])
@pytest.mark.parametrize("build", [arch, pushed_wall])
def test_a9_6_rough_structures_rest(build, fidelity, dimension: int, friction) -> None:
    """Of 9 voussoirs and of 14 bricks, some of whose joints open: up to 1e8 μ costs no accuracy."""
    result = solve_scene(build(friction=friction, fidelity=fidelity, dimension=dimension))
    assert result.outcome == "equilibrium"
    assert (arch_error if build is arch else wall_error)(result) < 1e-9
    assert max(certificate(result).values()) < 1e-9


@pytest.mark.parametrize("friction", ROUGH)
@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("fidelity", ["rigid", "elastic"])
def test_a9_6_rough_walls_march(fidelity, dimension: int, friction, caplog: pytest.LogCaptureFixture) -> None:
    """No step misses the tolerance."""
    scene = pushed_wall(friction, fidelity=fidelity, dimension=dimension, analysis=DYNAMICS)
    result = solve_scene(scene)
    assert result.outcome == "finished"
    assert not [record for record in caplog.records if "missed" in record.getMessage()]
    assert finite(result)
    assert max(certificate(result).values()) < EXACT


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("fidelity", ["rigid", "elastic"])
@pytest.mark.parametrize("friction", [0.0, 1e-6, 0.09])
def test_a9_6_walls_that_are_too_smooth_slide(friction: float, fidelity, dimension: int) -> None:
    result = solve_scene(pushed_wall(friction, fidelity=fidelity, dimension=dimension))
    assert result.outcome == "no_equilibrium"
    assert "slide" in result.message


def test_a9_6_slope_of_a_thousandth_of_a_degree_without_friction() -> None:
    result = cube_on_slope(
        0.001, 0.0, analysis=Dynamics(step=0.01, duration=1.0, theta=0.5),
        probes=(Probe(name="cube", block="cube.b1", point=(0.5, 0.5, 0.5)),),
    )  # fmt: skip
    a = G * np.sin(np.radians(0.001))
    assert result.summary.probes["cube"][0] == pytest.approx(a / 2, rel=1e-8)


def test_a9_6_frictionless_stack_stands() -> None:
    smooth = solved(
        fidelity="rigid",
        structures=(StackStructure(name="stack", material="stone", size=(1, 1, 1), count=5),),
        joints=(Joint(friction=0.0),),
        analysis=ONE_STEP,
    )
    assert smooth.outcome == "equilibrium"
    assert carried(smooth) == pytest.approx(np.arange(5, 0, -1) * 2400 * G, rel=1e-8)


@pytest.mark.parametrize("analysis", [Dynamics(step=0.1, duration=0.5, theta=1.0), Statics()])
@pytest.mark.parametrize("angle", [1.0, 30.0, 44.0, 44.99])
def test_a9_6_what_is_rough_sticks_until_it_tips(angle: float, analysis: Dynamics | Statics) -> None:
    """µ = 1e6; a cube tips from 45° on."""
    rough = cube_on_slope(angle, 1e6, analysis=analysis)
    assert rough.march.report.speed < 1e-9
    a, weight = np.radians(angle), 2400 * G
    force = rough.summary.supports["cube.ground"].force
    assert force == pytest.approx([-weight * np.sin(a), 0, weight * np.cos(a)], abs=1e-8 * weight)


def test_a9_6_beyond_that_angle_it_tips() -> None:
    assert cube_on_slope(45.01, 1e6, analysis=Statics()).outcome == "no_equilibrium"


@pytest.mark.parametrize("thickness", [0.11, 0.5, 1.0, 1.9])
def test_a9_6_frictionless_arch_falls_however_thick(thickness: float) -> None:
    result = rigid_arch(thickness=thickness, voussoirs=9, friction=0.0, analysis=ONE_STEP)
    assert result.outcome == "no_equilibrium"
