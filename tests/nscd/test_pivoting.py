"""Pivoting: plane problems to rounding, against closed forms and the other methods."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from masonry_fem.errors import ProblemError
from masonry_fem.nscd import ContactProblem, Outcome, SolverSettings, Start, assess, load_problem, solve
from masonry_fem.nscd.lemke import Lemke
from masonry_fem.nscd.local import solve_contact
from tests.nscd import walls
from tests.nscd.plane import plane_problem, plane_wall, soft

EXACT = 1e-12


def pivoted(problem, tolerance=EXACT):
    return solve(problem, SolverSettings(method="pivoting", tolerance=tolerance))


def lemke(M, q):
    tableau = Lemke(np.asarray(M, float), np.asarray(q, float))
    while tableau.verdict is None:
        tableau.pivot()
        assert tableau.pivots < 1000
    return tableau


# --- Lemke's method -------------------------------------------------------------------------------


def test_known_complementarity_problems():
    np.testing.assert_allclose(lemke([[2, 1], [0, 2]], [-1, -2]).solution(), [0, 1])
    assert lemke([[2, -1], [0, -2]], [-1, -2]).verdict == "ray"
    assert lemke(np.eye(2), [1, 0]).pivots == 0


def test_no_cycling_where_everything_ties():
    """q = −1 and equal rows: any order of pivots is degenerate."""
    n = 12
    found = lemke(np.ones((n, n)), -np.ones(n))
    z = found.solution()
    assert found.verdict == "solved"
    assert z.sum() == pytest.approx(1)
    assert (z >= 0).all()


@given(st.integers(1, 12), st.integers(0, 10_000))
@settings(max_examples=60, deadline=None)
def test_semidefinite_problems_are_solved(n, seed):
    """M of any rank with q in its range plus something positive: feasible, so solvable."""
    generator = np.random.default_rng(seed)
    root = generator.normal(size=(n, generator.integers(1, n + 1)))
    M = root @ root.T / n
    q = -M @ np.abs(generator.normal(size=n)) + np.abs(generator.normal(size=n)) * generator.integers(0, 2, n)
    found = lemke(M, q)
    assert found.verdict == "solved"
    z = found.solution()
    w = M @ z + q
    assert min(z.min(), w.min()) > -1e-8
    assert np.abs(z * w).max() < 1e-8


# --- one contact and one block --------------------------------------------------------------------


@given(st.lists(st.floats(-1, 1), min_size=2, max_size=2), st.floats(0, 2), st.integers(0, 1000))
@settings(max_examples=60, deadline=None)
def test_one_contact(q, friction, seed):
    root = np.random.default_rng(seed).normal(size=(2, 2))
    W = root @ root.T + 0.1 * np.eye(2)
    problem = ContactProblem.plain(W, np.array([q]), friction)
    solution = pivoted(problem, 1e-10)
    assert solution.converged
    if friction * abs(W[0, 1]) < W[0, 0]:  # else there may be several
        np.testing.assert_allclose(solution.impulse[0], solve_contact(W, q, friction), atol=1e-9)


@pytest.mark.parametrize("mass", [0.0, 1.0])
def test_a_block_on_two_feet_stands_slides_and_tips(mass):
    feet = {
        "points": [[-1.0, -0.5], [1.0, -0.5]],
        "normals": [[0.0, 1], [0, 1]],
        "owners": [[0, -1], [0, -1]],
    }
    stands = plane_problem(**feet, friction=0.5, load=[[0.49, -1.0, 0]], mass=mass)
    solution = pivoted(stands)
    assert solution.converged
    np.testing.assert_allclose(solution.impulse[:, 0], [0.5 - 0.49 / 4, 0.5 + 0.49 / 4])
    assert np.abs(solution.velocity).max() < 1e-14
    moves = Outcome.CONVERGED if mass else Outcome.NO_EQUILIBRIUM  # without inertia, as with masses of 1
    slides = pivoted(replace(stands, rigid_impulse=np.array([[0.51, -1.0, 0]])))
    assert slides.outcome is moves
    np.testing.assert_allclose(slides.rigid_velocity, [[0.01, 0, 0]], atol=1e-14)
    tips = pivoted(replace(stands, friction=np.full(2, 4.0), rigid_impulse=np.array([[2.5, -1.0, 0]])))
    assert tips.outcome is moves
    # a moment of 1/4 about the right foot, where the moment of inertia is 1 + 1² + 0.5²
    np.testing.assert_allclose(tips.rigid_velocity, np.array([[0.5, 1.0, -1.0]]) / 9, atol=1e-14)


def test_weight_between_two_walls():
    """Held by friction alone any thrust of W/µ or more does, but Lemke's way from rest meets none.

    The verdict of no equilibrium, which a ray suggests, must not stand then: impulses that balance exist.
    """
    points = [[-0.5, -0.5], [-0.5, 0.5], [0.5, -0.5], [0.5, 0.5]]
    normals = [[1.0, 0], [1, 0], [-1, 0], [-1, 0]]
    problem = plane_problem(points, normals, [[0, -1]] * 4, 0.5, [[0, -1.0, 0]])
    assert pivoted(problem).outcome is Outcome.UNDECIDED
    assert solve(problem, SolverSettings(tolerance=EXACT)).converged
    smooth = replace(problem, friction=np.zeros(4))
    assert pivoted(smooth).outcome is Outcome.NO_EQUILIBRIUM


def test_bodies_wedged_by_prescribed_motions_have_no_solution():
    """Two fixed points close in on a block from both sides: no impulse stops that, and none is claimed."""
    problem = ContactProblem.plain(
        np.kron([[1.0, -1.0], [-1.0, 1.0]], np.diag([1.0, 1.0])), [[-1.0, 0], [-1.0, 0]], 0.5
    )
    solution = pivoted(problem)
    assert solution.outcome is Outcome.STALLED
    assert solution.quality.error > 0.1


# --- walls ----------------------------------------------------------------------------------------

WALLS = [(horizontal, friction) for horizontal in (0.1, 0.3, 0.6) for friction in (0.2, 0.6)]


@pytest.mark.parametrize(("horizontal", "friction"), WALLS)
def test_rigid_walls_are_solved_to_rounding(horizontal, friction):
    problem = plane_wall(4, 4, friction=friction, horizontal=horizontal)
    solution = pivoted(problem)
    assert solution.converged
    assert assess(problem, solution.impulse, solution.rigid_velocity).error <= EXACT


@pytest.mark.parametrize(("horizontal", "friction"), [(0.1, 0.2), (0.1, 0.6), (0.3, 0.6), (0.6, 0.6)])
def test_walls_that_stand_do_not_move(horizontal, friction):
    """Where they slide the motion is not unique: two exact solutions may differ by 10 % in their speeds."""
    solution = pivoted(plane_wall(4, 4, friction=friction, horizontal=horizontal))
    assert np.abs(solution.rigid_velocity).max() < 1e-12  # a step of free fall gives 1


@pytest.mark.parametrize(("horizontal", "friction"), WALLS)
def test_static_walls_get_their_verdict(horizontal, friction):
    """A pull above µ slides the wall off its floor."""
    problem = plane_wall(3, 3, friction=friction, horizontal=horizontal, mass=0.0)
    solution = pivoted(problem)
    expected = Outcome.CONVERGED if horizontal <= friction else Outcome.NO_EQUILIBRIUM
    assert solution.outcome is expected
    if expected is Outcome.NO_EQUILIBRIUM:
        driven = replace(problem, rigid_mass=np.ones_like(problem.rigid_mass))
        np.testing.assert_allclose(
            solution.rigid_velocity, pivoted(driven).rigid_velocity, rtol=1e-9, atol=1e-12
        )


@pytest.mark.parametrize("mass", [0.0, 1.0])
@pytest.mark.parametrize(("horizontal", "friction"), [(0.1, 0.6), (0.6, 0.7)])
def test_soft_walls(horizontal, friction, mass):
    """With compliance the solution is unique where all sticks or opens."""
    problem = soft(plane_wall(3, 2, friction=friction, horizontal=horizontal, mass=mass))
    solution = pivoted(problem)
    assert solution.converged
    other = solve(problem, SolverSettings(tolerance=1e-10))
    assert other.converged
    np.testing.assert_allclose(solution.impulse, other.impulse, atol=1e-6 * np.abs(other.impulse).max())


def test_soft_walls_that_slide_fast():
    """Sliding speeds lie far above elastic ones: as exact as those leave it."""
    problem = soft(plane_wall(3, 3, friction=0.2, horizontal=0.3))
    assert pivoted(problem, 1e-9).converged


@given(st.integers(0, 10_000), st.floats(0, 1.5), st.booleans())
@settings(max_examples=30, deadline=None)
def test_random_hyperstatic_problems(seed, friction, prescribed):
    """W of low rank with velocities that impulses can stop: always solved."""
    generator = np.random.default_rng(seed)
    c = int(generator.integers(1, 12))
    H = generator.normal(size=(2 * c, int(generator.integers(1, 2 * c + 1))))
    q = (H @ generator.normal(size=H.shape[1])).reshape(c, 2)
    if prescribed:
        q[:, 0] += np.abs(generator.normal(size=c))  # open gaps
    problem = ContactProblem.plain(H @ H.T, q, friction)
    solution = pivoted(problem, 1e-8)
    assert solution.converged
    assert solution.quality.error == assess(problem, solution.impulse, solution.rigid_velocity).error


# --- public problems ------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "tolerance"),
    [
        ("FC2D_SliderCrankLagrangian00000", 1e-12),
        ("FrictionContactProblem00031", 1e-12),
        ("FrictionContactProblem00071", 1e-12),
        ("gfc2d_granularflowonwall_00069_00350", 1e-12),
        ("FrictionContactProblem00237", 1e-10),  # a condition of 2e8
    ],
)
def test_public_problems(shared_data, name, tolerance):
    problem = load_problem(shared_data / "fc" / f"{name}.npz")
    solution = pivoted(problem, tolerance)
    assert solution.converged
    if np.abs(problem.plain_velocity()).max() > 1e-2:
        other = solve(problem, SolverSettings(method="newton", tolerance=1e-10))
        np.testing.assert_allclose(
            solution.velocity, other.velocity, atol=1e-6 * np.abs(other.velocity).max()
        )


# --- edges ----------------------------------------------------------------------------------------


def test_units_do_not_matter():
    problem = plane_wall(3, 3, friction=0.2, horizontal=0.3)
    scaled = replace(
        problem,
        rigid_map=1e-3 * problem.rigid_map,
        rigid_impulse=1e3 * problem.rigid_impulse,
        rigid_mass=1e-3 * problem.rigid_mass,
    )
    first, second = pivoted(problem), pivoted(scaled)
    assert first.iterations == second.iterations
    np.testing.assert_allclose(second.impulse, 1e6 * first.impulse, atol=1e-3)


def test_a_solution_to_start_from_is_kept():
    problem = plane_wall(2, 2)
    first = pivoted(problem)
    again = solve(problem, SolverSettings(method="pivoting", tolerance=EXACT), Start(impulse=first.impulse))
    assert again.iterations == 0


def test_a_limit_ends_it():
    """Pivots come in batches of 50."""
    problem = plane_wall(4, 4)
    solution = solve(problem, SolverSettings(method="pivoting", max_iterations=10))
    assert solution.outcome is Outcome.MAX_ITERATIONS
    assert solution.iterations == 50
    assert pivoted(problem).iterations > 50


def test_what_is_wrong_is_told():
    with pytest.raises(ProblemError, match="3D"):
        pivoted(walls.rigid_wall(2, 2))
    with pytest.raises(ProblemError, match="500 contacts, expected at most 400"):
        pivoted(ContactProblem.plain(np.eye(1000), -np.ones((500, 2)), 0.5))
