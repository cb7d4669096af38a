"""Loose bodies: what only sliding contacts hold goes as far as friction lets it."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from scipy import sparse

from masonry_fem.nscd import SolverSettings, Start
from masonry_fem.nscd.iterate import iterate
from masonry_fem.nscd.methods.newton import NewtonRun, ProximalNewton
from masonry_fem.nscd.problem import ContactProblem
from masonry_fem.nscd.solvers.linearisation import linearise
from masonry_fem.nscd.solvers.loose import Loose, loose_clusters

FRICTION = 0.5


def board(under: np.ndarray, bearing: np.ndarray, *, mass: float = 0.0) -> ContactProblem:
    """A body on supports, each of which moves at a speed of its own, in the plane.

    Parameters
    ----------
    under : Speed of each support, shape (c,). bearing : Normal impulse on each, which is the weight, (c,).
    """
    c = len(under)
    free = np.zeros((c, 2))
    free[:, 1] = -under
    maps = np.zeros((c, 2, 2, 3))
    maps[:, 0, 0, 1] = maps[:, 0, 1, 0] = 1.0  # normal velocity is U_y, slip U_x; the body does not turn
    return ContactProblem(
        friction=np.full(c, FRICTION),
        free_velocity=free,
        compliance=sparse.bsr_array((2 * c, 2 * c), blocksize=(2, 2)),
        bodies=np.stack([np.zeros(c, dtype=np.int64), np.full(c, -1)], axis=1),
        rigid_map=maps,
        rigid_mass=np.full((1, 3), mass),
        rigid_impulse=np.array([[0.0, -bearing.sum(), 0.0]]),
        rigid_velocity=np.zeros((1, 3)),
    )


def sliding(problem: ContactProblem, bearing: np.ndarray) -> tuple[Loose | None, np.ndarray, np.ndarray]:
    """The board where it rests: all supports slide under it, with the friction that belongs to that."""
    velocity = problem.velocity(np.zeros_like(problem.free_velocity), np.zeros((1, 3)))
    impulse = np.stack([bearing, -FRICTION * bearing * np.sign(velocity[:, 1])], axis=1)
    line = linearise(impulse, velocity, problem.friction, np.ones(problem.count))
    return loose_clusters(problem, line, impulse, velocity), impulse, velocity


def went(loose: Loose, impulse: np.ndarray, velocity: np.ndarray, step: float, load: float = 0.0) -> float:
    """How far the board goes if its drift is a ``step`` in x [m/s]."""
    slip, motion = np.zeros_like(velocity), np.array([[step, 0.0, 0.0]])
    slip[:, 1] = step
    given = loose.problem.rigid_impulse + np.array([[load, 0.0, 0.0]])
    lengths = loose.lengths(impulse, velocity, given, np.zeros((1, 3)), (np.zeros_like(slip), slip, motion))
    of_contacts, of_bodies = loose.along(lengths)
    assert np.all(of_contacts == of_bodies[0])
    return float(of_bodies[0] * step)


@pytest.mark.parametrize("seed", range(20))
def test_it_goes_to_the_weighted_median_of_what_drags_it(seed: int) -> None:
    """Friction alone on supports that move: it ends where those to either side of it bear half the weight."""
    random = np.random.default_rng(seed)
    under, bearing = random.uniform(0.1, 1.0, 7), random.uniform(0.5, 2.0, 7)
    loose, impulse, velocity = sliding(board(under, bearing), bearing)
    assert loose is not None
    order = np.argsort(under)
    median = under[order][np.searchsorted(np.cumsum(bearing[order]), 0.5 * bearing.sum())]
    assert went(loose, impulse, velocity, 0.05) == pytest.approx(median, rel=1e-9)


def test_loads_shift_where_it_goes() -> None:
    under, bearing = np.array([1.0, 2.0, 3.0]), np.ones(3)
    loose, impulse, velocity = sliding(board(under, bearing), bearing)
    assert loose is not None
    # all drag it with 1.5; each that it overtakes holds it back instead, which takes away 1
    assert went(loose, impulse, velocity, 0.1, load=0.0) == pytest.approx(2.0)
    assert went(loose, impulse, velocity, 0.1, load=0.75) == pytest.approx(3.0)


def test_it_does_not_go_against_what_drags_it() -> None:
    under, bearing = np.array([1.0, 2.0, 3.0]), np.ones(3)
    loose, impulse, velocity = sliding(board(under, bearing), bearing)
    assert loose is not None
    assert went(loose, impulse, velocity, -0.1) == 0.0


def test_far_is_bounded() -> None:
    under, bearing = np.full(3, 1e6), np.ones(3)
    loose, impulse, velocity = sliding(board(under, bearing), bearing)
    assert loose is not None
    assert went(loose, impulse, velocity, 1.0) == 64.0


def test_bodies_with_inertia_are_held_by_it() -> None:
    bearing = np.ones(3)
    loose, _, _ = sliding(board(np.array([1.0, 2.0, 3.0]), bearing, mass=1.0), bearing)
    assert loose is None


def test_one_point_that_sticks_is_enough() -> None:
    problem = board(np.array([0.0, 2.0, 3.0]), np.ones(3))
    velocity = problem.velocity(np.zeros((3, 2)), np.zeros((1, 3)))
    impulse = np.stack([np.ones(3), [0.1, 0.5, 0.5]], axis=1)
    line = linearise(impulse, velocity, problem.friction, np.ones(3))
    assert line.plain.tolist() == [True, False, False]
    assert loose_clusters(problem, line, impulse, velocity) is None


def test_the_slope_is_a_share_of_the_secant_in_the_direction_of_slip() -> None:
    under, bearing = np.array([1.0, 2.0, 3.0]), np.ones(3)
    loose, impulse, velocity = sliding(board(under, bearing), bearing)
    assert loose is not None
    plain = linearise(impulse, velocity, np.full(3, FRICTION), np.ones(3))
    added = loose.line.by_velocity - plain.by_velocity
    np.testing.assert_array_equal(added[:, 0, :], 0.0)
    # ‖x_T‖ = μ + ‖v_T‖ and p_N = 1
    np.testing.assert_allclose(added[:, 1, 1], 0.03 * FRICTION / (FRICTION + under))
    np.testing.assert_allclose(loose.line.by_impulse - plain.by_impulse, -added)
    step = np.array([[0.0, 0.2], [0.0, 0.0], [0.0, 0.0]])
    np.testing.assert_allclose(loose.withheld(step, 0 * step)[0, 1], added[0, 1, 1] * 0.2)


@dataclass(frozen=True, slots=True, kw_only=True)
class Drifting(ProximalNewton):
    """Newton's method that has met a short step already."""

    def init(self, problem: ContactProblem, start: Start | None) -> NewtonRun:
        run = NewtonRun(problem, self, start)
        run.jams, run.settled = True, np.inf
        return run


def test_newton_finds_where_a_board_rests() -> None:
    """Within 60 steps Newton's method alone finds five of these boards, with the drift twenty."""
    found = []
    for seed in range(24):
        under, bearing = np.random.default_rng(seed).uniform(0.1, 1.0, 31), np.ones(31)
        soft = sparse.diags_array(np.full(62, 1e-3)).tobsr((2, 2))
        problem = replace(board(under, bearing), compliance=soft)
        start = Start(np.stack([bearing, FRICTION * bearing], axis=1), np.array([[0.0, -1e-3, 0.0]]), None)
        settings = SolverSettings(tolerance=1e-8, max_iterations=60)
        end = iterate(problem, Drifting(full_steps=0), settings, start)
        if end.converged:
            found.append(float(end.rigid_velocity[0, 0]) - np.median(under))
    assert len(found) >= 15
    # where the median sticks, it does so with what it gives way under its friction
    np.testing.assert_allclose(found, 0.0, atol=1e-3 * FRICTION)
