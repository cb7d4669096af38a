"""Interior point: walls that stick, slide, tip, or all at once; and what "auto" makes of it."""

from dataclasses import replace

import numpy as np
import pytest

from masonry_fem.nscd import ContactProblem, Outcome, SolverSettings, Start, solve
from masonry_fem.nscd.iterate import iterate
from masonry_fem.nscd.methods.interior_point import InteriorPoint
from tests.nscd import families, walls
from tests.nscd.plane import plane_wall, soft

WALLS = [(horizontal, friction) for horizontal in (0.1, 0.3, 0.6) for friction in (0.2, 0.6, 1.2)]


def misses(problem, solution):
    """Worst violation of each law, by its definition; speeds relative to the largest free one."""
    p, mu = solution.impulse, problem.friction
    v = problem.velocity(p, solution.rigid_velocity)
    size = np.linalg.norm(p[:, 1:], axis=1)
    slip = np.linalg.norm(v[:, 1:], axis=1)
    largest, speed = np.abs(p).max(), 9.81
    slides = (slip > 1e-5 * speed) & (p[:, 0] > 1e-5 * largest)
    against = (p[:, 1:] * v[:, 1:]).sum(axis=1) + mu * p[:, 0] * slip  # 0 where friction opposes slip
    balance = problem.body_impulse(p) + problem.rigid_impulse - problem.rigid_mass * solution.rigid_velocity
    return {
        "penetration": -v[:, 0].min() / speed,
        "tension": -p[:, 0].min() / largest,
        "cone": (size - mu * p[:, 0]).max() / largest,
        "normal work": np.abs(p[:, 0] * v[:, 0]).max() / (largest * speed),
        "friction work": against[slides].max(initial=0.0) / (largest * speed),
        "balance": np.abs(balance).max() / np.abs(problem.rigid_impulse).max(),
    }


@pytest.mark.parametrize(("horizontal", "friction"), WALLS)
def test_it_comes_close_to_the_solution_of_every_wall(horizontal, friction):
    """Close enough for Newton: where statuses are ambiguous, rounding ends it at some 1e-6."""
    problem = walls.rigid_wall(10, 8, friction=friction, horizontal=horizontal)
    solution = iterate(problem, InteriorPoint(), SolverSettings(tolerance=1e-8))
    assert solution.quality.error < 2e-5
    assert solution.linear_solves <= 50
    assert max(misses(problem, solution).values()) < 1e-4


@pytest.mark.parametrize(("horizontal", "friction"), WALLS)
def test_auto_solves_every_wall(horizontal, friction):
    problem = walls.rigid_wall(10, 8, friction=friction, horizontal=horizontal)
    solution = solve(problem, SolverSettings(tolerance=1e-8))
    assert solution.converged
    missed = misses(problem, solution)
    assert max(missed.values()) < 1e-6, missed


def test_velocities_are_those_of_newton_and_sweeps():
    """Sweeps, another method altogether, crawl to 1e-6 on this wall that tips and slides."""
    problem = walls.rigid_wall(5, 4, friction=0.6, horizontal=0.8)
    exact = solve(problem, SolverSettings(method="newton", tolerance=1e-11)).rigid_velocity
    swept = solve(problem, SolverSettings(method="nsgs", tolerance=2e-6)).rigid_velocity
    found = iterate(problem, InteriorPoint(), SolverSettings(tolerance=1e-9)).rigid_velocity
    scale = np.abs(exact).max()
    np.testing.assert_allclose(swept, exact, atol=1e-3 * scale)
    np.testing.assert_allclose(found, exact, atol=1e-4 * scale)


@pytest.mark.parametrize("friction", [0.0, 1e-3, 1e3, 1e6])
def test_extremes_of_friction(friction):
    problem = walls.rigid_wall(5, 4, friction=friction)
    solution = iterate(problem, InteriorPoint(), SolverSettings(tolerance=1e-8))
    assert solution.quality.error < 2e-5


@pytest.mark.parametrize("inertia", [0.0, 1.0])
def test_without_friction_it_ends_near_the_least_that_its_cones_need(inertia):
    """What contacts rub with μ = 1e-6 is left; it is told, and "auto" goes on."""
    problem = walls.rigid_wall(10, 8, friction=0.0, horizontal=0.1 * inertia, inertia=inertia)
    alone = solve(problem, SolverSettings(method="interior_point", tolerance=1e-8))
    assert alone.outcome is Outcome.STALLED
    assert 1e-7 < alone.quality.error < 2e-5
    assert alone.quality.natural_map < 1e-6
    assert solve(problem, SolverSettings(tolerance=1e-8)).converged


@pytest.mark.parametrize("step", [1e-9, 1.0, 1e6])
def test_the_step_changes_nothing_but_units(step):
    problem = walls.rigid_wall(5, 4, friction=0.6, horizontal=0.6, step=step)
    assert iterate(problem, InteriorPoint(), SolverSettings(tolerance=1e-8)).quality.error < 2e-5


@pytest.mark.parametrize("make", [walls.wall, lambda: walls.rigid_wall(10, 8, inertia=0.0)])
def test_static_structures(make):
    problem = make() if make is not walls.wall else make().problem()
    solution = iterate(problem, InteriorPoint(), SolverSettings(tolerance=1e-7))
    assert solution.converged


def test_where_there_is_no_equilibrium_it_says_that_it_stalled():
    problem = walls.rigid_wall(10, 8, horizontal=0.7, inertia=0.0)
    solution = iterate(problem, InteriorPoint(), SolverSettings(tolerance=1e-8))
    assert solution.outcome is Outcome.STALLED
    assert np.isfinite(solution.impulse).all()


def test_wide_gaps_between_elastic_blocks_do_not_hold_it_up():
    """A gap closes within a step at a speed far above those at which stones deform."""
    wall = soft(plane_wall())
    upper = wall.bodies >= wall.body_count - 3
    free = wall.free_velocity.copy()
    free[upper.any(axis=1) & ~upper.all(axis=1), 0] = 100.0
    solution = iterate(replace(wall, free_velocity=free), InteriorPoint(), SolverSettings(tolerance=1e-8))
    assert solution.converged


def test_a_first_guess_that_holds_is_kept():
    problem = walls.rigid_wall(5, 4)
    done = solve(problem, SolverSettings(tolerance=1e-10))
    again = iterate(problem, InteriorPoint(), SolverSettings(tolerance=1e-8), Start(done.impulse))
    assert again.iterations == 0
    assert again.converged


def test_two_runs_agree_bit_for_bit():
    problem = walls.rigid_wall(10, 8, friction=0.6, horizontal=0.6)
    one, two = (solve(problem, SolverSettings(tolerance=1e-8)) for _ in range(2))
    assert (one.impulse == two.impulse).all()


@pytest.mark.parametrize("d", [2, 3])
def test_a_sliding_contact_is_solved_to_rounding(d):
    """Without products of the scaling, whose eigenvalues grow τ⁻² apart: they ended it at 1e-8."""
    q = np.zeros((1, d))
    q[0, :2] = -1.0, 3.0
    problem = ContactProblem.plain(2 * np.eye(d), q, 0.5)
    solution = iterate(problem, InteriorPoint(), SolverSettings(tolerance=1e-12))
    assert solution.converged
    assert solution.impulse[0, :2] == pytest.approx([0.5, -0.25], abs=1e-12)


def test_friction_in_space_is_aligned_with_sliding():
    """Steps that let τ fall leave the angle between them at √τ."""
    errors = np.zeros((4, 2))
    for seed in range(4):
        problem = families.full_rank(np.random.default_rng(seed), 3)
        for column, align in enumerate((1e-2, 0.0)):
            found = iterate(problem, InteriorPoint(align=align), SolverSettings(tolerance=3e-9))
            errors[seed, column] = found.quality.error
    aligned, usual = errors.max(axis=0)
    assert aligned <= 3e-9
    assert usual > 1e-8
