"""Krylov: the same answers as a factor gives, in few products; failures are said and factorised."""

import logging

import numpy as np
import pytest
from scipy import sparse

from masonry_fem.errors import ProblemError
from masonry_fem.nscd import SolverSettings, krylov, solve
from masonry_fem.nscd.linear_cost import LinearCost, widest_level
from masonry_fem.nscd.solvers import body_solver
from masonry_fem.nscd.solvers.body_matrix import BodyMatrix, BodyPattern
from masonry_fem.nscd.solvers.body_solver import BodySolver
from masonry_fem.nscd.solvers.common_motion import common_motions
from masonry_fem.nscd.solvers.newton_system import NewtonSystem

from .masses import bonded_boxes, rigid_mass, touching_boxes
from .walls import rigid_wall


def slopes(problem, seed, *, sliding=False):
    """Stiffnesses of contacts over four decades; of sliding ones K (n − μ t) nᵀ and a little more."""
    rng = np.random.default_rng(seed)
    base = rng.normal(size=(problem.count, 3, 3))
    slope = base @ base.transpose(0, 2, 1) + 0.1 * np.eye(3)
    slope *= 10.0 ** rng.uniform(-2, 2, (problem.count, 1, 1))
    if sliding:
        some = rng.random(problem.count) < 0.1
        slope[some] = 0.01 * np.eye(3)
        slope[some, 0, 0], slope[some, 1, 0] = 1.0, -0.4
    return slope


def solver_of(problem, slope, library):
    """Solver of the bodies' matrix, and that matrix."""
    system = NewtonSystem(problem, np.ones(problem.count), library)
    every, diagonal = np.arange(problem.count), np.ones_like(problem.rigid_mass)
    matrix = -system.body_matrix.assemble(slope, every, diagonal)
    solve = system.body_solver.solver(slope, every, diagonal, system._bodies_factorised)
    return solve, matrix


@pytest.mark.parametrize("sliding", [False, True])
@pytest.mark.parametrize("make", [lambda: rigid_mass(4, 4, 4), lambda: rigid_wall(12, 10)])
def test_iteration_answers_as_the_factor(make, sliding, caplog):
    problem = make()
    slope = slopes(problem, 1, sliding=sliding)
    rhs = np.random.default_rng(2).normal(size=problem.rigid_mass.size)
    with caplog.at_level(logging.INFO, logger=body_solver.__name__):
        found, matrix = solver_of(problem, slope, "krylov")
        answer = found(rhs)
    assert not caplog.records  # it was the iteration
    expected = solver_of(problem, slope, "direct")[0](rhs)
    np.testing.assert_allclose(matrix @ answer, rhs, atol=1e-8 * np.abs(rhs).max())
    np.testing.assert_allclose(answer, expected, rtol=1e-6, atol=1e-6 * np.abs(expected).max())


def test_products_hardly_grow_with_the_mass(monkeypatch):
    products = []
    conjugate = krylov.cg

    def counted(*given, **options):
        products.append(0)

        def one(_):
            products[-1] += 1

        return conjugate(*given, callback=one, **options)

    monkeypatch.setattr(krylov, "cg", counted)
    for size in (5, 10):
        problem = rigid_mass(size, size, size)
        found, _ = solver_of(problem, np.tile(1e4 * np.eye(3), (problem.count, 1, 1)), "krylov")
        found(problem.rigid_impulse.ravel())
    assert products[1] <= 2 * products[0] + 5
    assert products[1] <= 30


def test_iteration_gives_the_same_bits_whatever_the_random_state():
    problem = rigid_mass(4, 4, 4)
    slope, answers = slopes(problem, 3, sliding=True), []
    for seed in (1, 2):
        np.random.seed(seed)  # noqa: NPY002 - the state that pyamg would draw from
        before = np.random.get_state()[1].copy()  # noqa: NPY002
        found, _ = solver_of(problem, slope, "krylov")
        answers.append(found(problem.rigid_impulse.ravel()))
        np.testing.assert_array_equal(np.random.get_state()[1], before)  # noqa: NPY002
    np.testing.assert_array_equal(*answers)


@pytest.mark.parametrize("horizontal", [0.1, 0.35])
@pytest.mark.parametrize(("method", "inertia"), [("interior_point", 1.0), ("newton", 0.0), ("auto", 1.0)])
def test_a_mass_is_solved_as_by_factors(method, inertia, horizontal):
    problem = rigid_mass(3, 3, 4, horizontal=horizontal, inertia=inertia)
    direct, iterated = (
        solve(problem, SolverSettings(method=method, tolerance=1e-8, linear=name))
        for name in ("direct", "krylov")
    )
    assert iterated.converged
    assert iterated.quality.error <= 1e-8
    size = np.abs(direct.velocity).max()
    np.testing.assert_allclose(iterated.velocity, direct.velocity, atol=1e-5 * max(size, 1e-6))


def test_what_fails_is_factorised_and_said_and_given_up_after_two(monkeypatch, caplog):
    problem = rigid_mass(5, 5, 4)
    monkeypatch.setattr(krylov, "ITERATIONS", 1)
    system = NewtonSystem(problem, np.ones(problem.count), "krylov")
    every, diagonal = np.arange(problem.count), np.ones_like(problem.rigid_mass)
    rhs = problem.rigid_impulse.ravel()
    with caplog.at_level(logging.INFO, logger=body_solver.__name__):
        for _ in range(3):
            slope = slopes(problem, 4)
            found = system.body_solver.solver(slope, every, diagonal, system._bodies_factorised)
            answer = found(rhs)
            matrix = -system.body_matrix.assemble(slope, every, diagonal)
            np.testing.assert_allclose(matrix @ answer, rhs, atol=1e-10 * np.abs(rhs).max())
    assert len(caplog.records) == 2
    assert "all further ones" in caplog.text


def test_broken_matrices_go_to_the_factor(caplog):
    problem = rigid_mass(3, 3, 3)
    slope = slopes(problem, 5)
    slope[7] = np.nan
    with caplog.at_level(logging.INFO, logger=body_solver.__name__), np.errstate(all="ignore"):
        solver_of(problem, slope, "krylov")
    assert "not finite" in caplog.text


def test_polar_factor_is_the_slope_or_the_contact_without_friction():
    problem = rigid_mass(3, 3, 3)
    definite = slopes(problem, 6)
    partner, symmetric = krylov.nearest_definite(definite)
    assert symmetric
    assert partner is definite
    normal, reaction = np.array([1.0, 0, 0]), np.array([1.0, -0.5, 0])
    partner, symmetric = krylov.nearest_definite(np.outer(reaction, normal)[None])
    assert not symmetric
    np.testing.assert_allclose(partner[0], np.sqrt(1.25) * np.outer(normal, normal), atol=1e-14)


def test_common_motions_move_no_contact():
    problem = rigid_mass(4, 3, 3)
    motions = common_motions(problem.bodies, problem.rigid_map, problem.body_count)
    inner = (problem.bodies >= 0).all(axis=1)
    moved = problem.rigid_map[inner] @ motions[problem.bodies[inner]]
    size = np.abs(problem.rigid_map[inner] @ np.abs(motions[problem.bodies[inner]])).max()
    np.testing.assert_allclose(moved.sum(axis=1), 0.0, atol=1e-10 * size)


def test_bodies_apart_and_hinged_have_motions_of_their_own():
    """Two bodies on one contact point, one alone: nothing to pass on, or only what the point passes."""
    maps = np.zeros((1, 2, 3, 6))
    maps[0, 0, :, :3], maps[0, 1, :, :3] = np.eye(3), -np.eye(3)
    motions = common_motions(np.array([[0, 1]]), maps, 3)
    np.testing.assert_array_equal(motions[[0, 2]], [np.eye(6), np.eye(6)])
    np.testing.assert_allclose(motions[1], np.diag([1.0, 1, 1, 0, 0, 0]), atol=1e-14)


def chain(length):
    """Indices and pointer of a chain of bodies."""
    matrix = sparse.csr_array(sparse.diags_array([1.0, 1.0, 1.0], offsets=[-1, 0, 1], shape=(length, length)))
    return matrix.indices, matrix.indptr


def lattice(side):
    """Indices and pointer of side³ bodies."""
    line = sparse.diags_array([1.0, 1.0], offsets=[-1, 1], shape=(side, side))
    one = sparse.eye_array(side)
    cube = sparse.kron(sparse.kron(line, one) + sparse.kron(one, line), one)
    matrix = sparse.csr_array(cube + sparse.kron(sparse.kron(one, one), line) + sparse.eye_array(side**3))
    return matrix.indices, matrix.indptr


def test_iteration_is_chosen_where_factors_fill():
    assert widest_level(*chain(5000)) == 1
    assert not LinearCost.foreseen(*chain(20000), 6).iteration_pays(symmetric=True)
    small, large = (LinearCost.foreseen(*lattice(side), 6) for side in (6, 20))
    assert not small.fills
    assert not small.iteration_pays(symmetric=True)
    assert large.fills
    assert large.iteration_pays(symmetric=True)
    assert large.sliding > large.symmetric
    assert not LinearCost.foreseen(np.zeros(0, int), np.zeros(1, int), 6).iteration_pays(symmetric=True)


def test_settings_choose():
    problem = rigid_mass(3, 3, 3)
    pattern = BodyPattern(problem.bodies, problem.body_count)
    matrix = BodyMatrix(pattern, problem.rigid_map, np.ones_like(problem.rigid_mass))
    chosen = {
        name: BodySolver(matrix, name).iterates(symmetric=True)
        for name in ("auto", "direct", "krylov", "superlu")
    }
    assert chosen == {"auto": False, "direct": False, "krylov": True, "superlu": False}
    with pytest.raises(ProblemError, match="linear is 'magic', expected one of 'auto', 'direct', 'krylov'"):
        SolverSettings(linear="magic")


def test_masses_are_bonded():
    boxes = bonded_boxes(3, 3, 2)
    pairs = touching_boxes(boxes)
    volume = sum(np.prod(size) for _, size in boxes)
    assert volume == pytest.approx(3 * 3 * 2 * 0.4 * 0.2 * 0.2)
    # a whole brick in the middle of the upper course lies on three
    middle = [
        i
        for i, (low, size) in enumerate(boxes)
        if low[2] > 0.1
        and np.allclose(size, (0.4, 0.2, 0.2))
        and 0.05 < low[1] < 0.35
        and 0.15 < low[0] < 0.65
    ]
    assert middle
    for brick in middle:
        assert ((pairs[:, 0] == brick) & (pairs[:, 2] == 2)).sum() == 3
