"""Rest: admissible impulses are the solution of rigid statics."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from masonry_fem.nscd import Outcome, SolverSettings, assess, solve
from masonry_fem.nscd.iterate import iterate
from masonry_fem.nscd.rest import Rest, brought_to_rest
from tests.nscd.plane import plane_wall
from tests.nscd.walls import rigid_wall

EXACT = SolverSettings(tolerance=1e-9)


@settings(max_examples=10, deadline=None)
@given(columns=st.integers(2, 4), courses=st.integers(1, 6), pull=st.floats(0.0, 0.15), space=st.booleans())
def test_a_wall_that_stands_is_at_rest(columns, courses, pull, space):
    make = rigid_wall if space else plane_wall
    mass = {"inertia": 0.0, "step": 0.01} if space else {"mass": 0.0}
    problem = make(columns, courses, horizontal=pull, **mass)
    solution = iterate(problem, Rest(), EXACT)
    assert solution.outcome is Outcome.CONVERGED
    assert not solution.rigid_velocity.any()


def test_open_contacts_bear_nothing():
    problem = plane_wall(3, 3, horizontal=0.05, mass=0.0)
    bearing = iterate(problem, Rest(), EXACT).impulse[:, 0]
    open_gap = problem.free_velocity.copy()
    open_gap[bearing.argmin(), 0] = 1e-3
    solution = iterate(replace(problem, free_velocity=open_gap), Rest(), EXACT)
    assert not solution.impulse[bearing.argmin()].any()
    assert solution.outcome is Outcome.CONVERGED


def test_a_support_that_moves_is_no_rest():
    problem = plane_wall(3, 3, horizontal=0.05, mass=0.0)
    moved = problem.free_velocity.copy()
    moved[0, 1] = 1e-3
    solution = iterate(replace(problem, free_velocity=moved), Rest(), EXACT)
    assert solution.outcome is Outcome.STALLED
    assert not solution.impulse.any()


@pytest.mark.parametrize("pull", [0.36, 0.37])
def test_close_to_the_limit_of_a_slender_wall(pull):
    """Two bricks of 2 × 1 wide, ten courses, μ = 0.65: it falls at 0.37114 (A4.6)."""
    problem = plane_wall(2, 10, horizontal=pull, mass=0.0, friction=0.65)
    assert solve(problem, EXACT).outcome is Outcome.CONVERGED


@pytest.mark.parametrize("method", ["newton", "auto"])
def test_what_a_last_step_leaves_of_velocities_is_taken_out(method):
    """Of a wall not far from tipping."""
    problem = plane_wall(2, 10, horizontal=0.3, mass=0.0, friction=0.65)
    loose = SolverSettings(method=method, tolerance=1e-6)
    solution = solve(problem, loose)
    assert solution.outcome is Outcome.CONVERGED
    assert not solution.rigid_velocity.any()
    assert not solution.velocity.any()
    assert solution.quality == assess(problem, solution.impulse, solution.rigid_velocity)


def test_blocks_that_must_follow_a_support_are_not_brought_to_rest():
    problem = plane_wall(3, 3, horizontal=0.05, mass=0.0)
    lifted = problem.free_velocity.copy()
    grounded = (problem.bodies < 0).any(axis=1)
    lifted[grounded, 0] = -1e-3
    solution = solve(replace(problem, free_velocity=lifted), EXACT)
    assert solution.outcome is Outcome.CONVERGED
    assert abs(solution.rigid_velocity).max() > 1e-4


@pytest.mark.parametrize("friction", [1e8, 1e10])
def test_blocks_with_inertia_are_at_rest_where_they_move_by_rounding_alone(friction):
    problem = rigid_wall(2, 2, horizontal=0.3, step=0.01, friction=friction)
    still = solve(problem, SolverSettings(tolerance=1e-10))
    assert still.outcome is Outcome.CONVERGED
    speed = 1e-16 * abs(problem.rigid_impulse).max()
    for moved, rests in ((speed, True), (1e4 * speed, False)):
        velocity = np.full_like(still.rigid_velocity, moved)
        quality = assess(problem, still.impulse, velocity)
        made = replace(still, outcome=Outcome.STALLED, rigid_velocity=velocity, quality=quality)
        assert bool(brought_to_rest(problem, made, EXACT).rigid_velocity.any()) is not rests
