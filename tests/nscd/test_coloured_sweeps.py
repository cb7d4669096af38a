"""Coloured sweeps: the laws' solution, no bit that depends on threads, and ω that changes no answer."""

import os
from dataclasses import replace

import numba
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from masonry_fem.errors import ProblemError
from masonry_fem.nscd import Outcome, SolverSettings, Start, assess, load_problem, solve, threads
from masonry_fem.nscd.solvers.sweep_form import SweepForm
from tests.nscd.families import FAMILIES
from tests.nscd.plain_form import condensed
from tests.nscd.plane import plane_wall
from tests.nscd.walls import rigid_wall

# where sweeps end in reasonable time
SWEPT = ["plain", "hyperstatic", "rigid dynamics"]


def nsgs(problem, tolerance=1e-9, start=None, **more):
    return solve(problem, SolverSettings(method="nsgs", tolerance=tolerance, **more), start)


def walls():
    """Walls with colours of enough groups for threads to share, some joints open and some slide."""
    space, plane = (
        rigid_wall(12, 8, horizontal=0.5, friction=0.3),
        plane_wall(12, 16, horizontal=0.3, mass=1.0),
    )
    dry = {"3D": space, "plain 3D": condensed(space), "2D": plane, "plain 2D": condensed(plane)}
    return dry | {"cohesive 3D": with_cohesion(space), "cohesive 2D": with_cohesion(plane)}


def with_cohesion(problem):
    """The same with some stiffness of cohesion at every contact."""
    root = np.random.default_rng(1).normal(size=(problem.count, problem.dimension, problem.dimension))
    return replace(problem, cohesion_stiffness=0.1 * root @ root.swapaxes(1, 2))


@pytest.mark.slow
@pytest.mark.parametrize("name", walls())
@pytest.mark.parametrize("relaxation", [1.0, 1.4])
def test_threads_change_no_bit(name, relaxation):
    """Twice the same kernel with one and two threads, and once its twin that has none."""
    problem = walls()[name]
    form = SweepForm(problem, relaxation, 2)
    assert form.threads == 2
    assert form.colouring.count > 3
    made = []
    for parallel, count in ((False, 1), (True, 1), (True, min(2, numba.config.NUMBA_NUM_THREADS))):
        before = numba.get_num_threads()
        form = SweepForm(problem, relaxation, 1)
        impulse = np.zeros_like(problem.free_velocity)
        numba.set_num_threads(count)
        try:
            result = form.swept(impulse, 13, 1e-12, parallel=parallel)
        finally:
            numba.set_num_threads(before)
        made.append((result, impulse))
    for result, impulse in made[1:]:
        assert result == made[0][0]
        assert np.array_equal(impulse, made[0][1])
    assert made[0][1].any()


@pytest.mark.slow
def test_any_number_of_threads_gives_the_same_solution():
    problem = rigid_wall(12, 8, horizontal=0.3, friction=0.6)
    one, two, many = (nsgs(problem, threads=count, max_iterations=12) for count in (1, 2, 64))
    for other in (two, many):
        assert np.array_equal(other.impulse, one.impulse)
        assert np.array_equal(other.velocity, one.velocity)
        assert other.iterations == one.iterations
        assert other.quality == one.quality
    assert numba.get_num_threads() == numba.config.NUMBA_NUM_THREADS  # as it was


@pytest.mark.parametrize("name", SWEPT)
@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize(("relaxation", "count"), [(1.0, 1), (0.7, None), (1.3, None), (1.3, 2)])
def test_the_solution_is_that_of_plain_sweeps(name, dimension, relaxation, count):
    rng = np.random.default_rng(3)
    problem = FAMILIES[name](rng, dimension)
    plain = nsgs(problem, 1e-8)
    other = nsgs(problem, 1e-8, relaxation=relaxation, threads=count)
    assert plain.converged
    assert other.converged
    assert other.quality == assess(problem, other.impulse, other.rigid_velocity)
    size = max(np.abs(plain.velocity).max(), np.abs(problem.plain_velocity()).max())
    assert other.velocity == pytest.approx(plain.velocity, abs=1e-6 * size)


@settings(max_examples=20)
@given(st.integers(0, 2**32 - 1), st.sampled_from([2, 3]), st.floats(0.2, 1.8))
def test_a_solution_stays_under_any_relaxation(seed, dimension, relaxation):
    """Fixed points are the same, and every iterate is in the cone."""
    problem = FAMILIES["plain"](np.random.default_rng(seed), dimension)
    solved = nsgs(problem, 1e-12)
    assert solved.converged
    kept = solved.impulse.copy()
    SweepForm(problem, relaxation, None).sweep(kept, 3, 1e-300)
    assert kept == pytest.approx(solved.impulse, abs=1e-9 * max(np.abs(solved.impulse).max(), 1e-300))
    cold = np.zeros_like(kept)
    for _ in range(5):
        SweepForm(problem, relaxation, None).sweep(cold, 1, 1e-300)
        slack = 1e-14 * np.abs(cold).max()
        assert (np.linalg.norm(cold[:, 1:], axis=1) <= problem.friction * cold[:, 0] + slack).all()
        assert (cold[:, 0] >= 0).all()


def test_relaxation_of_one_contact_by_hand():
    """p goes from 0 to ω times the solution each time: 1 − (1 − ω)^k of it after k sweeps."""
    problem = FAMILIES["plain"](np.random.default_rng(0), 2)
    alone = replace(
        problem,
        friction=np.array([0.5]),
        free_velocity=np.array([[-1.0, 0.1]]),
        compliance=type(problem.compliance)(np.eye(2), blocksize=(2, 2)),
        bodies=np.full((1, 2), -1),
        rigid_map=np.zeros((1, 2, 2, 3)),
    )
    for count in (1, 2, 3):
        impulse = np.zeros((1, 2))
        SweepForm(alone, 0.5, None).sweep(impulse, count, 1e-300)
        assert impulse[0] == pytest.approx((1 - 0.5**count) * np.array([1.0, -0.1]), rel=1e-14)


def test_it_stops_by_the_full_residual_and_says_so_where_it_does_not():
    problem = rigid_wall(4, 3, horizontal=0.5, friction=0.3, step=0.01)
    solution = nsgs(problem, 1e-6, threads=2, relaxation=1.2)
    assert solution.converged
    assert solution.quality.error <= 1e-6
    assert solution.quality == assess(problem, solution.impulse, solution.rigid_velocity)
    short = nsgs(problem, 1e-12, threads=1, max_iterations=23)
    assert short.outcome is Outcome.MAX_ITERATIONS
    assert short.iterations == 23


def test_a_warm_start_is_kept():
    problem = rigid_wall(4, 3, step=0.01)
    solved = nsgs(problem, 1e-7, threads=1)
    again = nsgs(problem, 1e-6, Start(impulse=solved.impulse), threads=1)
    assert again.iterations == 0
    assert again.impulse == pytest.approx(solved.impulse, rel=1e-12)  # projected on the cones once more


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "fork"), reason="forks are of Unix")
def test_a_fork_makes_do_without_its_parents_threads(monkeypatch):
    """GNU's OpenMP ends a process that uses the threads of the one it was forked from."""
    assert threads.available_threads(1) == 1
    monkeypatch.setattr(threads, "_awake", os.getpid() + 1)
    assert threads.available_threads(2) == 1
    problem = rigid_wall(12, 8, horizontal=0.3)
    forked = nsgs(problem, threads=2, max_iterations=12)
    monkeypatch.setattr(threads, "_awake", None)
    assert np.array_equal(nsgs(problem, threads=2, max_iterations=12).impulse, forked.impulse)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"relaxation": 2.0}, "relaxation is 2.0, expected a number between 0 and 2"),
        ({"relaxation": 0.0}, "relaxation is 0.0, expected a number between 0 and 2"),
        ({"relaxation": float("nan")}, "relaxation is nan, expected a number between 0 and 2"),
        ({"threads": 0}, "threads is 0, expected a whole number of at least 1"),
        ({"threads": 1.5}, "threads is 1.5, expected a whole number of at least 1"),
        ({"threads": 2, "method": "auto"}, "threads is 2 with method 'auto'.* choose method 'nsgs'"),
        ({"relaxation": 1.2, "method": "newton"}, "relaxation is 1.2 with method 'newton', expected 1.0"),
    ],
)
def test_settings_that_mean_nothing_are_refused(given, message):
    with pytest.raises(ProblemError, match=message):
        SolverSettings(**({"method": "nsgs"} | given))


def test_public_problems(shared_data):
    """Engineering accuracy by relaxed and coloured sweeps, as plain ones reach it."""
    found = {}
    for path in sorted((shared_data / "fc").glob("*.npz")):
        problem = load_problem(path)
        if problem.count <= 400:
            found[path.stem] = nsgs(problem, 1e-4, relaxation=1.1, threads=1).outcome
    assert found
    assert found == dict.fromkeys(found, Outcome.CONVERGED)
