"""Contacts doubled and tripled: the same points many times over, and more and more points on a face.

What a contact carries its copies share, as they like; what they add up to, and every motion, stay.
"""

from __future__ import annotations

from dataclasses import replace

import msgspec
import numpy as np
import pytest
from scipy import sparse

from masonry_fem.analyses.run import RunResult, solve_scene
from masonry_fem.nscd import ContactProblem, SolverSettings, solve
from masonry_fem.nscd.outcome import Outcome
from masonry_fem.scene.specs import Joint, Scene
from tests.extremes.scenes import arch, certificate, pushed_wall, standing_wall, wall_error

SCENES: dict[str, Scene] = {
    "rigid arch": arch(),
    "elastic arch": arch(fidelity="elastic"),
    "rigid wall": pushed_wall(dimension=3),
    "elastic wall": pushed_wall(fidelity="elastic", dimension=3),
    "wall that slips": pushed_wall(0.3, 0.2, "elastic"),
    "rigid wall in time": standing_wall(0.01),
    "elastic wall in time": standing_wall(0.01, fidelity="elastic"),
}


def repeated(problem: ContactProblem, times: int) -> ContactProblem:
    """Each contact so many times."""
    rows, d = np.tile(np.arange(problem.count), times), problem.dimension
    dofs = (rows[:, None] * d + np.arange(d)).ravel()
    return replace(
        problem,
        friction=problem.friction[rows],
        free_velocity=problem.free_velocity[rows],
        compliance=sparse.bsr_array(problem.compliance.tocsr()[dofs][:, dofs], blocksize=(d, d)),
        bodies=problem.bodies[rows],
        rigid_map=problem.rigid_map[rows],
    )


@pytest.mark.parametrize("times", [2, 3])
@pytest.mark.parametrize("name", SCENES)
def test_copies_share_what_one_contact_carries(name: str, times: int) -> None:
    problem = solve_scene(SCENES[name]).march.last.problem
    one, many = solve(problem, SolverSettings()), solve(repeated(problem, times), SolverSettings())
    assert many.converged
    given = problem.body_impulse(one.impulse)
    summed = problem.body_impulse(many.impulse.reshape(times, *one.impulse.shape).sum(axis=0))
    assert np.abs(summed - given).max() < 1e-8 * np.abs(given).max()
    if not problem.rigid:  # rigid blocks at rest move by rounding
        moved = np.abs(one.velocity).max()
        assert np.abs(many.velocity[: problem.count] - one.velocity).max() < 1e-8 * moved


@pytest.mark.parametrize("method", ["nsgs", "newton", "interior_point"])
@pytest.mark.parametrize("name", ["rigid wall in time", "elastic wall in time"])
def test_every_method_bears_copies(name: str, method: str) -> None:
    problem = repeated(solve_scene(SCENES[name]).march.last.problem, 2)
    settings = SolverSettings(method=method, tolerance=1e-8)
    made = solve(problem, settings)
    assert np.isfinite(made.impulse).all()
    if name == "elastic wall in time" and method == "nsgs":  # it crawls there without copies, too
        assert made.outcome is Outcome.MAX_ITERATIONS
        assert made.outcome.advice(settings)
    elif name == "elastic wall in time" and method == "interior_point":  # as near as it comes by itself
        assert made.quality.error < 2e-8
        assert solve(problem, SolverSettings(tolerance=1e-8)).converged
    else:
        assert made.converged


@pytest.mark.parametrize("density", [1, 2, 3, pytest.param(10, marks=pytest.mark.slow)])
def test_more_points_on_a_face_change_no_sum(density: int) -> None:
    """From 4 to 400 points a joint of rigid bricks."""
    result = _placed("rigid", Joint(friction=0.6, placement="gauss", density=density))
    assert result.outcome == "equilibrium"
    assert result.summary.contacts == 124 * density**2
    assert wall_error(result) < 1e-10
    assert max(certificate(result).values()) < 1e-9


@pytest.mark.parametrize("placement", ["corners", "gauss", "nodes"])
def test_elastic_walls_rest_on_any_points(placement) -> None:
    result = _placed("elastic", Joint(friction=0.6, placement=placement))
    assert result.outcome == "equilibrium"
    assert wall_error(result) < 1e-10
    assert max(certificate(result).values()) < 1e-9


def _placed(fidelity, joint: Joint) -> RunResult:
    scene = pushed_wall(fidelity=fidelity, dimension=3)
    return solve_scene(msgspec.structs.replace(scene, joints=(joint,)))
