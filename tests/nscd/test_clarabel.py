"""Cross-check by a general conic solver: with the friction term s = ‖v_T‖ frozen at its value in our
solution, the contact problem is the optimality system of a convex one, whose velocities are unique."""

import numpy as np
import pytest
from scipy import sparse

from masonry_fem.nscd import ContactProblem, SolverSettings, solve
from masonry_fem.nscd.graphs import tangential_norm
from tests.nscd import walls
from tests.nscd.plain_form import condensed

clarabel = pytest.importorskip("clarabel")

TIGHT = 1e-11
# A gap of 1e-10 of the objective, which clarabel ends at, is this much in velocities.
SPEED = 1e-5


def minimise(quadratic, linear, cone, offset, dimension):
    """Minimise ½ xᵀ P x + cᵀ x with ``cone`` x + ``offset`` in second-order cones; x."""
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.equilibrate_enable = False  # our units are good; its own cost it four digits
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = TIGHT
    cones = [clarabel.SecondOrderConeT(dimension)] * (len(offset) // dimension)
    upper = sparse.csc_matrix(sparse.triu(quadratic))
    found = clarabel.DefaultSolver(
        upper, linear, sparse.csc_matrix(-cone), offset, cones, settings
    ).solve()  # fmt: skip
    assert str(found.status) in {"Solved", "AlmostSolved"}
    return np.array(found.x)


def shifted(problem, velocity):
    """μ s n of a solution, shape (c, d)."""
    shift = np.zeros_like(velocity)
    shift[:, 0] = problem.friction * tangential_norm(velocity)
    return shift


def conic_motion(problem, shift):
    """Velocities U of min ½ ‖U − U_free‖²_M under B U + q + μ s n in the dual cone, (b, m)."""
    weight = np.ones_like(problem.free_velocity)
    weight[:, 0] = 1 / problem.friction  # the dual cone is v_N ≥ μ ‖v_T‖
    B = sparse.diags_array(weight.ravel()) @ problem.rigid_matrix().tocsr()
    mass = problem.rigid_mass.ravel()
    linear = -(mass * problem.rigid_velocity.ravel() + problem.rigid_impulse.ravel())
    offset = (weight * (problem.free_velocity + shift)).ravel()
    motion = minimise(sparse.diags_array(mass), linear, B, offset, problem.dimension)
    return motion.reshape(problem.rigid_mass.shape)


def conic_impulse(problem, shift):
    """Impulses of min ½ pᵀ W p + (q + μ s n)ᵀ p in the cones, shape (c, d)."""
    weight = np.ones_like(problem.free_velocity)
    weight[:, 0] = problem.friction
    linear = (problem.free_velocity + shift).ravel()
    found = minimise(
        problem.compliance.tocsr(), linear, sparse.diags_array(weight.ravel()), np.zeros(linear.size),
        problem.dimension,
    )  # fmt: skip
    return found.reshape(weight.shape)


@pytest.mark.parametrize("method", ["auto", "newton"])
@pytest.mark.parametrize(
    ("horizontal", "friction"), [(0.1, 0.6), (0.3, 0.2), (0.3, 1.2), (0.6, 0.2), (0.6, 0.6), (0.6, 1.2)]
)
def test_rigid_walls(method, horizontal, friction):
    problem = walls.rigid_wall(6, 5, friction=friction, horizontal=horizontal)
    ours = solve(problem, SolverSettings(method=method, tolerance=1e-9))
    assert ours.converged
    motion = conic_motion(problem, shifted(problem, ours.velocity))
    free = problem.free_rigid_velocity()
    scale = np.abs(free).max()
    np.testing.assert_allclose(ours.rigid_velocity, motion, atol=SPEED * scale)

    def objective(rigid_velocity):
        return 0.5 * (problem.rigid_mass * (rigid_velocity - free) ** 2).sum()

    assert objective(ours.rigid_velocity) == pytest.approx(objective(motion), rel=1e-8)


def elastic_wall():
    return walls.wall(3, 1.0, (2, 2, 1), inertia=1.0).problem(friction=0.3, inertia=1.0)


def random_plane():
    rng = np.random.default_rng(4)
    factor = rng.normal(size=(24, 10))  # rank 10 of 24: impulses are not unique, velocities are
    return ContactProblem.plain(factor @ factor.T, factor @ rng.normal(size=10), 0.5, dimension=2)


@pytest.mark.parametrize("make", [elastic_wall, random_plane])
def test_plain_problems(make):
    problem = make()
    ours = solve(problem, SolverSettings(tolerance=1e-9))
    assert ours.converged
    plain = condensed(problem)
    shift = shifted(plain, ours.velocity)
    theirs = conic_impulse(plain, shift)
    velocity = plain.velocity(theirs, plain.rigid_velocity)
    scale = np.abs(plain.free_velocity).max()
    np.testing.assert_allclose(ours.velocity, velocity, atol=SPEED * scale)

    def objective(impulse):
        own = 0.5 * plain.elastic_velocity(impulse) + plain.free_velocity + shift
        return (own * impulse).sum()

    assert objective(ours.impulse) == pytest.approx(objective(theirs), rel=1e-8)
