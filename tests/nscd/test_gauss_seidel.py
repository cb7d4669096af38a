"""NSGS on problems with pencil answers, and its two forms against each other."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from masonry_fem.errors import ProblemError
from masonry_fem.nscd import ContactProblem, Outcome, SolverSettings, Start, assess, solve
from masonry_fem.nscd.iterate import iterate
from masonry_fem.nscd.methods.nsgs import GaussSeidel
from tests.nscd.plain_form import condensed
from tests.nscd.walls import rigid_boxes, rigid_wall, touching

G, STEP = 9.81, 0.01


def nsgs(problem, tolerance=1e-10, **more):
    return solve(problem, SolverSettings(method="nsgs", tolerance=tolerance, **more))


def boxes_on_floor(boxes, **more):
    return rigid_boxes(boxes, touching(boxes), step=STEP, **more)


def resultant(solution, count=4):
    return solution.impulse[:count].sum(axis=0)


UNIT = [((0.0, 0.0, 0.0), (1.0, 1.0, 1.0))]


@pytest.mark.parametrize("angle", [0.1, 0.5])
def test_block_on_a_slope(angle):
    mu = 0.3
    pull = G * np.array([np.sin(angle), 0.0, -np.cos(angle)])
    problem = boxes_on_floor(UNIT, friction=mu, acceleration=pull)
    solution = nsgs(problem)
    mass = 2000.0
    normal, first, _ = resultant(solution)  # frame (z, x, y)
    assert solution.converged
    assert normal == pytest.approx(mass * G * STEP * np.cos(angle), rel=1e-9)
    slides = np.tan(angle) > mu
    expected = G * (np.sin(angle) - mu * np.cos(angle)) if slides else 0.0
    assert solution.rigid_velocity[0, 0] / np.sqrt(mass) == pytest.approx(
        expected * STEP, abs=1e-9 * G * STEP
    )
    assert -first == pytest.approx(min(mu, np.tan(angle)) * normal, rel=1e-8)


def test_a_pushed_cube_slides_or_tips():
    """Pushed at its centre, a cube with μ < 1 slides, with μ > 1 tips."""
    for mu in (0.5, 1.5):
        pull = np.array([1.2 * G, 0.0, -G])
        solution = nsgs(boxes_on_floor(UNIT, friction=mu, acceleration=pull))
        spin = solution.rigid_velocity[0, 3:]
        assert solution.converged
        if mu < 1:
            assert spin == pytest.approx(0, abs=1e-8)
            slid = 0.7 * G * STEP
            assert solution.rigid_velocity[0, 0] / np.sqrt(2000) == pytest.approx(slid, rel=1e-8)
        else:
            assert spin[1] > 0  # about y: over the edge ahead
            assert (solution.impulse[:2] == 0).all()  # the corners behind lift
            # turns about the edge: ω = h (1.2 − 1) g ½ / (2/3)
            assert spin[1] / np.sqrt(2000 / 6) == pytest.approx(STEP * 0.2 * G * 0.5 / (2 / 3), rel=1e-8)


def test_rank_of_a_cube_on_four_corners():
    """A9.3: rank 6 of 12; only the resultant is determined."""
    problem = rigid_boxes(UNIT, touching(UNIT), friction=0.6, acceleration=[0, 0, -G], step=STEP, density=1.0)
    W = problem.delassus().toarray()
    values = np.linalg.svd(W, compute_uv=False)
    assert (values > 1e-10 * values[0]).sum() == 6
    assert values[0] / values[5] == pytest.approx(8.5497, rel=1e-4)
    normal = W[::3, ::3]
    assert np.diag(normal) == pytest.approx(4.0)
    assert sorted(normal[0, 1:]) == pytest.approx([-2, 1, 1])
    for mu in (0.0, 0.6, 1e6):
        solution = nsgs(replace(problem, friction=np.full(4, mu)))
        assert solution.converged
        assert resultant(solution) == pytest.approx([G * STEP, 0, 0], abs=1e-9 * G * STEP)
        assert problem.velocity(solution.impulse, solution.rigid_velocity) == pytest.approx(0, abs=1e-10)
        corners = solution.impulse[:, 0]
        assert corners[0] + corners[1] == pytest.approx(G * STEP / 2)  # no moment
        assert corners[0] + corners[2] == pytest.approx(G * STEP / 2)


def two_masses(lower, upper):
    """Particles above each other, 2D, without friction."""
    W = np.kron([[1 / lower, -1 / lower], [-1 / lower, 1 / lower + 1 / upper]], np.eye(2))
    return ContactProblem.plain(W, np.array([[-G * STEP, 0.0], [0.0, 0.0]]), 0.0)


def test_mass_ratios():
    """A9.2: light on heavy is quick, heavy on light hopeless by sweeps, and said to be so."""
    quick = nsgs(two_masses(1e6, 1.0))
    assert quick.converged
    assert quick.iterations <= 10
    assert quick.impulse[:, 0] == pytest.approx([(1e6 + 1) * G * STEP, G * STEP], rel=1e-9)
    slow = nsgs(two_masses(1.0, 1e6))
    assert slow.outcome is Outcome.MAX_ITERATIONS
    assert slow.impulse[0, 0] < 0.1 * 1e6 * G * STEP  # far off, and the measures see it:
    assert slow.quality.error > 0.1
    auto = solve(two_masses(1.0, 1e4), SolverSettings(tolerance=1e-9))
    assert auto.converged
    assert auto.impulse[:, 0] == pytest.approx([(1e4 + 1) * G * STEP, 1e4 * G * STEP], rel=1e-8)


def stack(count):
    return boxes_on_floor([((0.0, 0.0, float(k)), (1.0, 1.0, 1.0)) for k in range(count)], friction=0.6,
                          acceleration=[0, 0, -G])  # fmt: skip


@pytest.mark.parametrize(
    ("count", "method", "tolerance"), [(10, "nsgs", 1e-7), (10, "auto", 1e-10), (100, "auto", 1e-10)]
)
def test_stack_carries_its_weight(count, method, tolerance):
    """A9.1: sweeps that stop at small changes would leave the base short of load."""
    problem = stack(count)
    solution = solve(problem, SolverSettings(method=method, tolerance=tolerance))
    assert solution.converged
    floor = (problem.bodies == -1).any(axis=1)
    weight = 2000 * G * STEP
    assert solution.impulse[floor, 0].sum() == pytest.approx(count * weight, rel=1e-6)


def test_bodies_and_plain_form_sweep_alike():
    problem = rigid_wall(4, 3, horizontal=0.5, friction=0.3, step=STEP)
    kept = iterate(problem, GaussSeidel(), SolverSettings(tolerance=1e-8, max_iterations=40))
    formed = iterate(condensed(problem), GaussSeidel(), SolverSettings(tolerance=1e-8, max_iterations=40))
    assert formed.impulse == pytest.approx(kept.impulse, abs=1e-9 * np.abs(kept.impulse).max())


def in_the_plane():
    """Two squares on the ground and one on top of both, 2D, pushed sideways: 8 contacts."""
    corner = {0: (0.0, 0.0), 1: (1.2, 0.0), 2: (0.6, 1.0)}
    touch = [(0, -1, 0.0), (0, -1, 1.0), (1, -1, 1.2), (1, -1, 2.2)]
    touch += [(2, 0, 0.6), (2, 0, 1.0), (2, 1, 1.2), (2, 1, 1.6)]
    maps, bodies = np.zeros((8, 2, 2, 3)), []
    for i, (upper, lower, x) in enumerate(touch):
        bodies.append((upper, lower))
        for side, (body, sign) in enumerate(((upper, 1.0), (lower, -1.0))):
            if body >= 0:
                arm = np.array([x, corner[upper][1]]) - corner[body] - 0.5
                maps[i, side] = sign * np.array([[0, 1, arm[0] * 6**0.5], [-1, 0, arm[1] * 6**0.5]])
    return ContactProblem(
        friction=np.full(8, 0.4),
        free_velocity=np.zeros((8, 2)),
        compliance=ContactProblem.plain(np.zeros((16, 16)), np.zeros((8, 2)), 0.0).compliance,
        bodies=np.array(bodies),
        rigid_map=maps,
        rigid_mass=np.ones((3, 3)),
        rigid_impulse=np.tile([0.3 * G * STEP, -G * STEP, 0.0], (3, 1)),
        rigid_velocity=np.zeros((3, 3)),
    )


def test_plane_problems_in_both_forms():
    problem = in_the_plane()
    kept, formed = nsgs(problem, 1e-9), nsgs(condensed(problem), 1e-9)
    assert kept.converged
    assert formed.converged
    assert kept.impulse[:4, 0].sum() == pytest.approx(3 * G * STEP, rel=1e-8)
    assert formed.velocity == pytest.approx(kept.velocity, abs=1e-8 * G * STEP)


def test_a_warm_start_saves_sweeps():
    problem = rigid_wall(4, 3, step=STEP)
    cold = nsgs(problem, 1e-6)
    nudged = replace(problem, rigid_impulse=problem.rigid_impulse * 1.001)
    settings = SolverSettings(method="nsgs", tolerance=1e-6)
    warm = solve(nudged, settings, Start(impulse=cold.impulse))
    assert warm.converged
    assert warm.iterations < 0.8 * nsgs(nudged, 1e-6).iterations


def test_two_runs_agree_to_the_last_bit():
    problem = rigid_wall(4, 3, horizontal=0.4, friction=0.3, step=STEP)
    one, other = nsgs(problem, 1e-6), nsgs(problem, 1e-6)
    assert np.array_equal(one.impulse, other.impulse)
    assert one.iterations == other.iterations
    assert np.array_equal(one.history[:, :2], other.history[:, :2])


def test_statics_is_refused():
    with pytest.raises(ProblemError, match=r"without inertia \(statics\).* use method 'auto' or 'newton'"):
        nsgs(rigid_wall(3, 2, inertia=0.0))


@st.composite
def random_problems(draw):
    d = draw(st.sampled_from([2, 3]))
    c = draw(st.integers(1, 4))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    factor = rng.normal(size=(c * d, c * d))
    W = factor @ factor.T + 0.5 * c * d * np.eye(c * d)
    return ContactProblem.plain(W, rng.normal(size=(c, d)), rng.uniform(0, 0.8, c))


@given(random_problems())
def test_answers_satisfy_the_laws(problem):
    solution = nsgs(problem, 1e-9)
    p, v = solution.impulse, problem.velocity(solution.impulse, solution.rigid_velocity)
    speed, size = np.abs(problem.free_velocity).max(), np.abs(p).max()
    assert solution.converged
    assert (v[:, 0] >= -1e-7 * speed).all()
    assert (p[:, 0] >= 0).all()
    assert (np.linalg.norm(p[:, 1:], axis=1) <= problem.friction * p[:, 0] * (1 + 1e-12)).all()
    assert np.abs(p[:, 0] * v[:, 0]).max() <= 1e-7 * speed * max(size, 1e-300)
    # friction takes energy: against the motion where it slips
    assert ((p[:, 1:] * v[:, 1:]).sum(axis=1) <= 1e-7 * speed * size).all()


@given(random_problems(), st.floats(0, 6.28), st.floats(-6, 6), st.floats(-3, 3))
def test_frames_and_units_change_nothing(problem, angle, mass, speed):
    c, d = problem.count, problem.dimension
    Q = np.eye(d)
    if d == 3:
        Q[1:, 1:] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    else:
        Q[1, 1] = -1
    turn = np.kron(np.eye(c), Q)
    W = turn @ problem.compliance.toarray() @ turn.T / 10**mass
    other = ContactProblem.plain(W, 10**speed * problem.free_velocity @ Q.T, problem.friction)
    expected = 10 ** (mass + speed) * nsgs(problem, 1e-11).impulse @ Q.T
    tolerance = 1e-8 * max(np.abs(expected).max(), 1e-300)
    assert nsgs(other, 1e-11).impulse == pytest.approx(expected, abs=tolerance)


def test_quality_is_not_the_solvers_own():
    problem = rigid_wall(3, 2, step=STEP)
    solution = nsgs(problem, 1e-6)
    assert solution.quality == assess(problem, solution.impulse, solution.rigid_velocity)
