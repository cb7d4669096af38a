"""The choice of "auto": who has a turn, from where, and how the limits are shared."""

from dataclasses import replace

import numpy as np
import pytest

from masonry_fem.nscd import Outcome, SolverSettings, Start, assess, solve
from masonry_fem.nscd.admissible import admissible_impulses
from masonry_fem.nscd.methods.interior_point import InteriorPoint
from masonry_fem.nscd.turns import Case, turns
from tests.nscd import plane, walls


def names(problem, settings=None, start=None):
    def loads():
        return admissible_impulses(problem)

    case = Case(problem, settings or SolverSettings(), start, loads)
    return [turn.make(case).name for turn in turns(case)]


def test_a_cold_wall_that_sticks_needs_the_interior_point_only():
    solution = solve(walls.rigid_wall(8, 6, friction=0.6, horizontal=0.1), SolverSettings(tolerance=1e-8))
    assert solution.converged
    assert solution.method == "interior_point"
    assert solution.linear_solves <= 12


@pytest.mark.parametrize("horizontal", [0.3, 0.6])
def test_small_walls_that_slide_reach_the_default_tolerance(horizontal):
    problem = walls.rigid_wall(6, 5, friction=0.2, horizontal=horizontal)
    solution = solve(problem)
    assert solution.converged
    assert assess(problem, solution.impulse, solution.rigid_velocity).error <= 1e-10


def test_many_sliding_contacts_are_polished_patiently():
    """Sweeps bring them on slowly, and Newton's method with a fixed path of its weight goes round."""
    problem = walls.rigid_wall(16, 16, friction=0.4, horizontal=0.5)
    solution = solve(problem, SolverSettings(tolerance=1e-8))
    assert solution.converged
    assert solution.iterations <= 500  # 1525 with up to 1500 sweeps


def test_a_wall_that_tips_and_slides():
    problem = walls.rigid_wall(10, 8, friction=0.6, horizontal=0.6)
    solution = solve(problem, SolverSettings(tolerance=1e-8))
    assert solution.converged
    assert solution.rigid_velocity[:, 0].max() > 0.1  # it falls
    assert solution.quality.max_penetration < 1e-6


def test_who_has_a_turn():
    wall = walls.rigid_wall(8, 6)
    assert wall.count > 500
    assert names(wall)[0] == "interior_point"
    warm = Start(impulse=np.zeros_like(wall.free_velocity))
    assert names(wall, start=warm)[:2] == ["newton", "interior_point"]
    assert names(walls.rigid_wall(3, 3))[:3] == ["newton", "interior_point", "nsgs"]


def test_nothing_but_the_motion_is_sought_where_no_impulses_can_balance_the_loads():
    stands = plane.plane_wall(4, 4, friction=0.6, horizontal=0.1, mass=0.0)
    falls = plane.plane_wall(4, 4, friction=0.2, horizontal=0.3, mass=0.0)
    assert "interior_point" in names(stands)
    assert names(falls) == ["newton", "newton"]
    assert names(plane.soft(falls)) == ["newton", "newton", "newton"]


def test_the_rigid_twin_shows_what_moves():
    rigid = plane.plane_wall(4, 4, friction=0.2, horizontal=0.3, mass=0.0)
    soft = plane.soft(rigid)
    solution = solve(soft)
    assert solution.outcome is Outcome.NO_EQUILIBRIUM
    # the loads push along x, and do positive work on the motion
    assert (solution.rigid_velocity * soft.rigid_impulse).sum() > 0
    assert solution.velocity == pytest.approx(soft.velocity(solution.impulse, solution.rigid_velocity))
    assert solution.quality == assess(soft, solution.impulse, solution.rigid_velocity)


def test_iterations_are_counted_over_all_turns():
    problem = walls.rigid_wall(8, 6, friction=0.2, horizontal=0.3)
    solution = solve(problem, SolverSettings(max_iterations=100))
    assert solution.outcome is Outcome.MAX_ITERATIONS
    assert solution.method == "interior_point+nsgs"
    assert 100 <= solution.iterations < 150  # sweeps come in batches
    assert np.isfinite(solution.quality.error)


def test_a_time_limit_returns_the_best_state():
    problem = walls.rigid_wall(12, 10, friction=0.6, horizontal=0.6)
    solution = solve(problem, SolverSettings(time_limit=1e-3))
    assert solution.outcome is Outcome.TIME_LIMIT
    assert solution.quality.error == assess(problem, solution.impulse, solution.rigid_velocity).error
    assert solution.quality.error < 2


def pushed(wall, share):
    """The wall's static problem with a horizontal acceleration that is so large a share of its weight's."""
    problem = wall.problem(friction=0.3)
    turned = np.zeros_like(problem.rigid_impulse)
    weight = problem.rigid_impulse[:, :3]
    turned[:, :3] = weight
    turned[:, 0] += share * np.abs(weight[:, 2])
    return replace(problem, rigid_impulse=turned)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("share", "outcome"),
    [(0.29, Outcome.CONVERGED), (0.3, Outcome.AT_LIMIT), (0.31, Outcome.NO_EQUILIBRIUM)],
)
def test_elastic_walls_at_and_about_the_limit_of_friction(share, outcome):
    """At the limit itself impulses balance the loads, but bulging blocks that slide find no rest."""
    problem = pushed(walls.wall(), share)
    assert problem.count > 500
    solution = solve(problem, SolverSettings(tolerance=1e-9))
    assert solution.outcome is outcome
    if outcome is not Outcome.CONVERGED:
        assert solution.linear_solves < 150
        moving = solution.rigid_velocity[:, 0]
        assert moving.max() > 10 * np.abs(solution.rigid_velocity[:, 1]).max()  # along the push


@pytest.mark.slow
def test_a_wall_at_the_limit_of_friction_that_tips_is_followed_round_its_folds():
    """Without the path it ends at an error of 1.6e-6."""
    problem = walls.rigid_wall(24, 24, friction=0.7, horizontal=0.7)
    solution = solve(problem, SolverSettings(tolerance=1e-8))
    assert solution.converged
    assert solution.method.endswith("+path")
    assert assess(problem, solution.impulse, solution.rigid_velocity).error <= 1e-8


def test_large_walls_are_solved_in_their_plane(monkeypatch):
    seen = []
    whole = InteriorPoint.init

    def init(self, problem, start):
        seen.append(problem)
        return whole(self, problem, start)

    monkeypatch.setattr(InteriorPoint, "init", init)
    wall = walls.rigid_wall(8, 6)
    solution = solve(wall, SolverSettings(tolerance=1e-8))
    assert solution.converged
    assert [problem.dimension for problem in seen] == [2]
    assert 2 * seen[0].count == wall.count
    sideways = wall.rigid_impulse.copy()
    sideways[5, 1] = 0.01 * np.abs(sideways).max()
    assert solve(replace(wall, rigid_impulse=sideways), SolverSettings(tolerance=1e-8)).converged
    assert seen[-1].dimension == 3


def test_a_linear_solver_asked_for_is_taken_in_the_plane_too(monkeypatch):
    asked = []
    whole = InteriorPoint.init

    def init(self, problem, start):
        asked.append(self.library)
        return whole(self, problem, start)

    monkeypatch.setattr(InteriorPoint, "init", init)
    solve(walls.rigid_wall(8, 6), SolverSettings(tolerance=1e-8, linear="direct"))
    assert asked == ["direct"]
