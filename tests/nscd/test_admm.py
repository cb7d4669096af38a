"""ADMM: pencil answers, walls that stick and slide, and the velocities of Newton's method."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import sparse

from masonry_fem.nscd import ContactProblem, Outcome, SolverSettings, Start, solve
from masonry_fem.nscd.iterate import iterate
from masonry_fem.nscd.methods.admm import ADMM
from tests.nscd import walls

G = 9.81


def admm(problem, tolerance=1e-10, start=None, **more):
    return solve(problem, SolverSettings(method="admm", tolerance=tolerance, **more), start)


def block_on_floor(friction, horizontal, *, inertia=1.0):
    box = [((0.0, 0.0, 0.0), (1.0, 1.0, 1.0))]
    return walls.rigid_boxes(
        box, walls.touching(box), friction=friction, acceleration=[horizontal * G, 0, -G], inertia=inertia,
        density=1.0,
    )  # fmt: skip


@pytest.mark.parametrize(("friction", "horizontal"), [(0.6, 0.3), (0.3, 0.6), (0.0, 0.2)])
def test_a_block_sticks_or_slides(friction, horizontal):
    solution = admm(block_on_floor(friction, horizontal))
    assert solution.converged
    normal, along, across = solution.impulse.sum(axis=0)
    assert normal == pytest.approx(G, rel=1e-8)
    assert along == pytest.approx(-min(friction, horizontal) * G, rel=1e-8, abs=1e-8)
    assert across == pytest.approx(0, abs=1e-8)
    slid = max(horizontal - friction, 0.0) * G
    assert solution.rigid_velocity[0] == pytest.approx([slid, 0, 0, 0, 0, 0], abs=1e-8)


def test_a_static_block_is_balanced():
    solution = admm(block_on_floor(0.6, 0.3, inertia=0.0))
    assert solution.converged
    assert solution.impulse.sum(axis=0) == pytest.approx([G, -0.3 * G, 0], abs=1e-7)


@pytest.mark.parametrize(
    ("horizontal", "friction"), [(0.1, 0.2), (0.1, 0.6), (0.1, 1.2), (0.3, 0.2), (0.3, 1.2), (0.6, 1.2)]
)
def test_walls_have_the_velocities_of_newton(horizontal, friction):
    problem = walls.rigid_wall(6, 5, friction=friction, horizontal=horizontal)
    solution = admm(problem, 1e-9)
    exact = solve(problem, SolverSettings(method="newton", tolerance=1e-9))
    assert solution.converged
    assert exact.converged
    np.testing.assert_allclose(solution.rigid_velocity, exact.rigid_velocity, atol=1e-6 * G * 12)


@pytest.mark.parametrize("inertia", [0.0, 1.0])
def test_elastic_blocks(inertia):
    problem = walls.wall(3, 1.0, (2, 2, 1), inertia=inertia).problem(friction=0.6, inertia=inertia)
    solution = admm(problem, 1e-8)
    exact = solve(problem, SolverSettings(tolerance=1e-10))
    assert solution.converged
    np.testing.assert_allclose(solution.velocity, exact.velocity, atol=1e-6 * np.abs(exact.velocity).max())


def test_plane_contact_without_friction():
    problem = ContactProblem.plain(np.diag([2.0, 1.0, 4.0, 1.0]), [[-1.0, 0.5], [1.0, 0.0]], 0.0)
    solution = admm(problem, 1e-12)
    assert solution.impulse == pytest.approx(np.array([[0.5, 0.0], [0.0, 0.0]]), abs=1e-10)
    assert solution.velocity == pytest.approx(np.array([[0.0, 0.5], [1.0, 0.0]]), abs=1e-10)


def test_no_contacts():
    solution = admm(ContactProblem.plain(np.zeros((0, 0)), np.zeros((0, 3)), np.zeros(0)))
    assert solution.converged


def with_a_loose_body(problem, inertia):
    """The problem, and a body that nothing touches."""
    c, _, d, m = problem.rigid_map.shape
    push = np.full((1, m), 2.0 * inertia)
    return replace(
        problem,
        rigid_mass=np.vstack([problem.rigid_mass, np.full((1, m), inertia)]),
        rigid_impulse=np.vstack([problem.rigid_impulse, push]),
        rigid_velocity=np.vstack([problem.rigid_velocity, np.full((1, m), 3.0)]),
        compliance=sparse.bsr_array((c * d, c * d), blocksize=(d, d)),
    )


@pytest.mark.parametrize("inertia", [0.0, 1.0])
def test_a_body_without_contacts_flies_on(inertia):
    problem = with_a_loose_body(block_on_floor(0.6, 0.3, inertia=inertia), inertia)
    solution = admm(problem)
    assert solution.converged
    assert solution.rigid_velocity[1] == pytest.approx(3.0 + 2.0 * inertia)
    assert solution.impulse[:, 0].sum() == pytest.approx(G, rel=1e-7)


def test_no_load_needs_no_impulse():
    problem = walls.rigid_wall(4, 3, step=0.0)
    solution = admm(problem)
    assert solution.converged
    assert not solution.impulse.any()


@pytest.mark.parametrize("step", [1e-9, 1e6])
def test_units_change_nothing(step):
    problem = walls.rigid_wall(5, 4, horizontal=0.3, friction=0.2)
    unit = admm(problem, 1e-8)
    other = admm(replace(problem, rigid_impulse=step * problem.rigid_impulse), 1e-8)
    assert unit.converged
    assert other.converged
    np.testing.assert_allclose(other.rigid_velocity / step, unit.rigid_velocity, atol=1e-5 * G * 12)


def test_a_load_that_vanishes_leaves_no_impulse():
    """A warm start from the load before, which must go altogether."""
    loaded = walls.rigid_wall(4, 3)
    before = admm(loaded, 1e-9)
    problem = replace(loaded, rigid_impulse=np.zeros_like(loaded.rigid_impulse))
    least = float(np.linalg.norm(before.impulse)) * 1e-6
    settings = SolverSettings(method="admm", tolerance=1e-6, least_impulse=least)
    after = solve(problem, settings, Start(before.impulse, before.rigid_velocity))
    assert after.converged
    assert np.abs(after.rigid_velocity).max() < 1e-6 * np.abs(loaded.rigid_impulse).max()


def test_a_wall_that_neither_tips_nor_slides_although_it_might():
    """With a friction term that is updated in each iteration this one never ends."""
    problem = walls.rigid_wall(10, 8, horizontal=0.6, friction=1.2)
    assert admm(problem, 1e-8, max_iterations=500).converged


def test_two_runs_agree_bit_for_bit():
    problem = walls.rigid_wall(6, 5, horizontal=0.3, friction=0.2)
    one, two = (admm(problem, 1e-8) for _ in range(2))
    assert one.converged
    assert (one.impulse == two.impulse).all()


def test_a_time_limit_returns_the_best_state():
    problem = walls.rigid_wall(6, 5, horizontal=0.3, friction=0.2)
    solution = admm(problem, 1e-15, time_limit=0.02)
    assert solution.outcome is Outcome.TIME_LIMIT
    assert solution.quality.error == solution.history[:, 1].min()


def test_a_first_guess_that_holds_is_kept():
    problem = walls.rigid_wall(6, 5)
    done = solve(problem, SolverSettings(tolerance=1e-10))
    again = admm(problem, 1e-8, Start(done.impulse, done.rigid_velocity))
    assert again.iterations == 0
    assert again.converged


def test_it_owns_no_verdict_without_equilibrium():
    problem = walls.rigid_wall(5, 4, horizontal=0.9, friction=0.2, inertia=0.0)
    solution = iterate(problem, ADMM(patience=500), SolverSettings(tolerance=1e-8))
    assert solution.outcome is Outcome.STALLED
    assert np.isfinite(solution.impulse).all()
