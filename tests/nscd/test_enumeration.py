"""Enumeration: how many solutions there are, where that is known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from masonry_fem.errors import ProblemError
from masonry_fem.nscd import ContactProblem, SolverSettings, assess, solve
from tests.nscd import walls
from tests.nscd.enumeration import enumerate_solutions
from tests.nscd.plane import plane_problem, plane_wall, soft


def rod(normal, tangential, friction=2.0, slope=2.0):
    """Painlevé's rod (A9.5): unit mass, tan θ = ``slope``, with the free velocity of its lower end."""
    cosine = 1 / np.hypot(1, slope)
    sine = slope * cosine
    W = [[1 + 3 * cosine**2, 3 * sine * cosine], [3 * sine * cosine, 1 + 3 * sine**2]]
    return ContactProblem.plain(W, [[normal, tangential]], friction)


def test_a_rod_that_may_leave_slide_or_stop():
    found = enumerate_solutions(rod(0.1, 10.0))
    assert sorted(solution.status[0] for solution in found) == ["open", "slip_down", "stick"]
    sliding = next(solution for solution in found if solution.status == ("slip_down",))
    np.testing.assert_allclose(sliding.impulse, [[0.125, -0.25]])  # 0.1 / 0.8
    assert all(solution.freedom == 0 for solution in found)


def test_a_rod_that_must_stop():
    """Sliding on would pull it into the ground: the only solution is an impulse that stops it."""
    problem = rod(-0.1, 10.0)
    (found,) = enumerate_solutions(problem)
    assert found.status == ("stick",)
    np.testing.assert_allclose(found.impulse, [[3.085, -4.03]])
    for method in ("newton", "nsgs"):
        made = solve(problem, SolverSettings(method=method, tolerance=1e-10))
        np.testing.assert_allclose(made.impulse, found.impulse, rtol=1e-6)


@pytest.mark.parametrize("normal", [-0.1, 0.1])
def test_below_the_critical_friction_there_is_one(normal):
    """µ < 4/3: no paradox at any slope."""
    for slope in (0.5, 1.0, 2.0, 4.0):
        assert len(enumerate_solutions(rod(normal, 10.0, friction=1.2, slope=slope))) == 1


def test_a_closing_vice_has_none():
    W = np.kron([[1.0, -1.0], [-1.0, 1.0]], np.eye(2))
    assert enumerate_solutions(ContactProblem.plain(W, [[-1.0, 0], [-1.0, 0]], 0.5)) == []


@pytest.mark.parametrize("mass", [0.0, 1.0])
def test_a_block_on_three_feet_rests_in_many_ways(mass):
    """Six impulses, three balances."""
    points = [[-1.0, 0.0], [0.0, 0.0], [1.0, 0.0]]
    problem = plane_problem(
        points, [[0, 1.0]] * 3, [[0, -1]] * 3, 0.5, [[0.1, -1.0, 0]], mass=mass, centres=[[0, 0.5]]
    )
    (found,) = enumerate_solutions(problem)
    assert found.status == ("stick",) * 3
    assert found.freedom == 3
    assert assess(problem, found.impulse, found.rigid_velocity).error < 1e-12


def test_static_sliding_has_none():
    feet = plane_problem(
        [[-1.0, 0], [1.0, 0]], [[0, 1.0]] * 2, [[0, -1]] * 2, 0.5, [[0.6, -1.0, 0]], centres=[[0, 0.5]]
    )
    assert enumerate_solutions(feet) == []
    limit = replace(feet, rigid_impulse=np.array([[0.5, -1.0, 0]]))
    assert enumerate_solutions(limit)


@given(st.integers(1, 3), st.integers(0, 10_000), st.floats(0.0, 0.3))
@settings(max_examples=25, deadline=None)
def test_little_friction_on_regular_problems_is_unique_and_found(count, seed, friction):
    """For W near a diagonal and small µ, Coulomb's problem has one solution."""
    generator = np.random.default_rng(seed)
    root = generator.normal(size=(2 * count, 2 * count)) * 0.1
    problem = ContactProblem.plain(
        np.eye(2 * count) + root @ root.T, generator.normal(size=(count, 2)), friction
    )
    (found,) = enumerate_solutions(problem)
    made = solve(problem, SolverSettings(tolerance=1e-10))
    np.testing.assert_allclose(made.impulse, found.impulse, atol=1e-8)


def test_every_solution_is_one_by_the_measures():
    problem = soft(plane_wall(2, 1, friction=0.3, horizontal=0.2), size=1e-2)
    assert problem.count <= 6
    found = enumerate_solutions(problem)
    assert found
    for solution in found:
        assert assess(problem, solution.impulse, solution.rigid_velocity).error < 1e-9


def test_what_is_too_large_is_told():
    with pytest.raises(ProblemError, match="18 contacts in 2D, expected at most 6"):
        enumerate_solutions(plane_wall(2, 2))
    with pytest.raises(ProblemError, match="in 3D"):
        enumerate_solutions(walls.rigid_wall(1, 1))
