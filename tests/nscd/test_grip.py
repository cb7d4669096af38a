"""Slip held back: a body that only sliding contacts hold comes to where friction lets it rest."""

import numpy as np
import pytest
from scipy import sparse

from masonry_fem.nscd import SolverSettings, Start
from masonry_fem.nscd.iterate import iterate
from masonry_fem.nscd.methods.newton import ProximalNewton
from masonry_fem.nscd.problem import ContactProblem
from masonry_fem.nscd.solvers.linearisation import held_back, linearise

FRICTION = 0.5


def board(under: np.ndarray) -> ContactProblem:
    """A body without inertia on supports, each of which moves at a speed of its own, in the plane.

    Parameters
    ----------
    under : Speed of each support, which bears 1 N s, shape (c,).
    """
    c = len(under)
    free = np.zeros((c, 2))
    free[:, 1] = -under
    maps = np.zeros((c, 2, 2, 3))
    maps[:, 0, 0, 1] = maps[:, 0, 1, 0] = 1.0  # normal velocity is U_y, slip U_x; the body does not turn
    return ContactProblem(
        friction=np.full(c, FRICTION),
        free_velocity=free,
        compliance=sparse.diags_array(np.full(2 * c, 1e-3)).tobsr((2, 2)),
        bodies=np.stack([np.zeros(c, dtype=np.int64), np.full(c, -1)], axis=1),
        rigid_map=maps,
        rigid_mass=np.zeros((1, 3)),
        rigid_impulse=np.array([[0.0, -float(c), 0.0]]),
        rigid_velocity=np.zeros((1, 3)),
    )


def ends(method: ProximalNewton, *, steps: int = 100) -> list[float]:
    """How far from the median of its supports' speeds each of 24 boards comes to rest, of those that do."""
    found = []
    for seed in range(24):
        under = np.random.default_rng(seed).uniform(0.1, 1.0, 31)
        start = Start(np.tile([1.0, FRICTION], (31, 1)), np.array([[0.0, -1e-3, 0.0]]), None)
        settings = SolverSettings(tolerance=1e-8, max_iterations=steps)
        end = iterate(board(under), method, settings, start)
        if end.converged:
            found.append(float(end.rigid_velocity[0, 0]) - float(np.median(under)))
    return found


def test_newton_finds_where_a_board_rests() -> None:
    """Half of the supports drag it one way and half the other: it rests on the one in the middle."""
    found = ends(ProximalNewton(grip=0.03))
    assert len(found) >= 22
    # which sticks, with what it gives way under its friction
    np.testing.assert_allclose(found, 0.0, atol=1e-3 * FRICTION)


def test_without_it_most_boards_are_missed() -> None:
    assert len(ends(ProximalNewton(full_steps=0))) < 12


def test_the_spring_acts_on_contacts_that_slide_alone() -> None:
    velocity = np.array([[0.0, 0.5], [0.0, 0.0], [1.0, 0.5]])  # slides, sticks, is open
    impulse = np.array([[1.0, -FRICTION], [1.0, 0.0], [0.0, 0.0]])
    line = linearise(impulse, velocity, np.full(3, FRICTION), np.full(3, 2.0))
    held = held_back(line, np.full((3, 2), 0.25), 0.1)
    more = held.by_velocity - line.by_velocity
    np.testing.assert_allclose(more[0], np.diag([0.0, 0.1]))
    np.testing.assert_allclose(held.residual[0] - line.residual[0], [0.0, 0.1 * 2.0 * 0.25])
    for same in (1, 2):
        np.testing.assert_array_equal(more[same], 0.0)
        np.testing.assert_array_equal(held.residual[same], line.residual[same])
    assert held.plain is line.plain


@pytest.mark.parametrize("share", [0.0, 1e-3, 1.0])
def test_it_vanishes_where_slip_is_what_it_was(share: float) -> None:
    velocity, impulse = np.array([[0.0, 0.5]]), np.array([[1.0, -FRICTION]])
    line = linearise(impulse, velocity, np.full(1, FRICTION), np.ones(1))
    np.testing.assert_array_equal(held_back(line, 0 * velocity, share).residual, line.residual)
