"""The contact solver against an oracle: plane problems solved to rounding by Lemke's method."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from masonry_fem.nscd import ContactProblem, SolverSettings, assess, load_problem, solve
from tests.nscd.families import low_rank
from tests.nscd.lemke import Lemke
from tests.nscd.pivoting import pivoted
from tests.nscd.plane import plane_problem, plane_wall, soft

EXACT = 1e-12


def lemke(M, q):
    tableau = Lemke(np.asarray(M, float), np.asarray(q, float))
    while tableau.verdict is None:
        tableau.pivot()
        assert tableau.pivots < 1000
    return tableau


def exact(problem, tolerance=EXACT):
    """The oracle's solution, which is one by the measures."""
    impulse, rigid_velocity = pivoted(problem)
    assert assess(problem, impulse, rigid_velocity).error <= tolerance
    return impulse, rigid_velocity


def made(problem, tolerance=1e-10):
    """The solver's solution."""
    solution = solve(problem, SolverSettings(tolerance=tolerance))
    assert solution.converged
    return solution


# --- the oracle -----------------------------------------------------------------------------------


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


def test_a_block_on_two_feet_stands_slides_and_tips():
    feet = plane_problem(
        [[-1.0, -0.5], [1.0, -0.5]], [[0.0, 1], [0, 1]], [[0, -1], [0, -1]], 0.5, [[0.49, -1.0, 0]], mass=1.0
    )
    impulse, motion = exact(feet)
    np.testing.assert_allclose(impulse[:, 0], [0.5 - 0.49 / 4, 0.5 + 0.49 / 4])
    assert np.abs(motion).max() < 1e-14
    _, motion = exact(replace(feet, rigid_impulse=np.array([[0.51, -1.0, 0]])))
    np.testing.assert_allclose(motion, [[0.01, 0, 0]], atol=1e-14)
    tips = replace(feet, friction=np.full(2, 4.0), rigid_impulse=np.array([[2.5, -1.0, 0]]))
    # a moment of 1/4 about the right foot, where the moment of inertia is 1 + 1² + 0.5²
    np.testing.assert_allclose(exact(tips)[1], np.array([[0.5, 1.0, -1.0]]) / 9, atol=1e-14)


def test_bodies_wedged_by_prescribed_motions_have_no_solution():
    """Two fixed points close in on a block from both sides: no impulse stops that, and none is claimed."""
    vice = ContactProblem.plain(
        np.kron([[1.0, -1.0], [-1.0, 1.0]], np.diag([1.0, 1.0])), [[-1.0, 0], [-1.0, 0]], 0.5
    )
    assert pivoted(vice) is None
    assert not solve(vice, SolverSettings()).solved


# --- the solver beside it -------------------------------------------------------------------------


@given(st.lists(st.floats(-1, 1), min_size=2, max_size=2), st.floats(0, 2), st.integers(0, 1000))
@settings(max_examples=60, deadline=None)
def test_one_contact(q, friction, seed):
    root = np.random.default_rng(seed).normal(size=(2, 2))
    W = root @ root.T + 0.1 * np.eye(2)
    problem = ContactProblem.plain(W, np.array([q]), friction)
    impulse, _ = exact(problem, 1e-10)
    if friction * abs(W[0, 1]) < W[0, 0]:  # else there may be several
        np.testing.assert_allclose(made(problem).impulse, impulse, atol=1e-9)


def test_weight_between_two_walls():
    """Held by friction alone any thrust of W/µ or more does, but Lemke's way from rest meets none: a ray."""
    points = [[-0.5, -0.5], [-0.5, 0.5], [0.5, -0.5], [0.5, 0.5]]
    normals = [[1.0, 0], [1, 0], [-1, 0], [-1, 0]]
    problem = plane_problem(points, normals, [[0, -1]] * 4, 0.5, [[0, -1.0, 0]])
    assert pivoted(problem) is None
    made(problem, EXACT)


@pytest.mark.parametrize(("horizontal", "friction"), [(0.1, 0.2), (0.1, 0.6), (0.3, 0.6), (0.6, 0.6)])
def test_walls_that_stand_do_not_move(horizontal, friction):
    """Where they slide the motion is not unique: two exact solutions may differ by 10 % in their speeds."""
    problem = plane_wall(4, 4, friction=friction, horizontal=horizontal)
    assert np.abs(exact(problem)[1]).max() < 1e-12  # a step of free fall gives 1
    assert np.abs(made(problem, 1e-10).rigid_velocity).max() < 1e-9


@pytest.mark.parametrize(("horizontal", "friction"), [(0.3, 0.2), (0.6, 0.2)])
def test_walls_that_slide_are_solved_by_both(horizontal, friction):
    problem = plane_wall(4, 4, friction=friction, horizontal=horizontal)
    exact(problem)
    made(problem)


@pytest.mark.parametrize("mass", [0.0, 1.0])
@pytest.mark.parametrize(("horizontal", "friction"), [(0.1, 0.6), (0.6, 0.7)])
def test_soft_walls(horizontal, friction, mass):
    """With compliance the solution is unique where all sticks or opens."""
    problem = soft(plane_wall(3, 2, friction=friction, horizontal=horizontal, mass=mass))
    impulse, _ = exact(problem)
    np.testing.assert_allclose(made(problem).impulse, impulse, atol=1e-6 * np.abs(impulse).max())


def test_soft_walls_that_slide_fast():
    """Sliding speeds lie far above elastic ones: as exact as those leave it."""
    problem = soft(plane_wall(3, 3, friction=0.2, horizontal=0.3))
    exact(problem, 1e-9)
    made(problem, 1e-9)


@given(st.integers(0, 10_000), st.floats(0, 1.5), st.booleans())
@settings(max_examples=30, deadline=None)
def test_random_hyperstatic_problems(seed, friction, prescribed):
    """Always solved."""
    problem = low_rank(np.random.default_rng(seed), friction, prescribed)
    exact(problem, 1e-8)
    made(problem, 1e-8)


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
    impulse, rigid_velocity = exact(problem, tolerance)
    velocity = problem.velocity(impulse, rigid_velocity)
    if np.abs(problem.plain_velocity()).max() > 1e-2:
        np.testing.assert_allclose(made(problem).velocity, velocity, atol=1e-6 * np.abs(velocity).max())
