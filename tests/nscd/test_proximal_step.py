"""The linear half of ADMM, by its two laws."""

import numpy as np
import pytest

from masonry_fem.nscd.scaling import contact_scale
from masonry_fem.nscd.solvers.proximal_step import ProximalStep
from tests.nscd import walls


def elastic():
    return walls.wall(2, 1.0, (2, 1, 1), inertia=1.0).problem(friction=0.6, inertia=1.0)


CASES = {
    "rigid": lambda: walls.rigid_wall(3, 2),
    "elastic": elastic,
    "mixed": lambda: walls.wall(2, 1.0, (2, 1, 1), inertia=1.0).problem(inertia=1.0, rigid=(0,)),
    "plain": lambda: walls.rigid_wall(3, 2).condensed(),
}


@pytest.mark.parametrize("make", CASES.values(), ids=CASES.keys())
def test_both_laws_hold(make):
    problem = make()
    scale = contact_scale(problem)
    weight = 0.3 * scale
    step = ProximalStep(problem, scale)
    step.weigh(weight)
    force = np.random.default_rng(0).normal(size=problem.free_velocity.shape) * scale[:, None]
    x, U = step.solve(force)
    moved = problem.elastic_velocity(x) + problem.contact_velocity(U) + weight[:, None] * x
    np.testing.assert_allclose(moved, force, atol=1e-8 * np.abs(moved).max())
    gained = problem.rigid_mass * (U - problem.rigid_velocity)
    left = problem.body_impulse(x) + problem.rigid_impulse - gained
    assert np.abs(left).max(initial=0.0) <= 1e-8 * np.abs(problem.rigid_impulse).max(initial=1.0)


def test_bodies_without_inertia_come_to_balance():
    """Their proximal mass is gone once the step is at rest."""
    problem = walls.rigid_wall(3, 2, inertia=0.0)
    scale = contact_scale(problem)
    step = ProximalStep(problem, scale)
    step.weigh(0.3 * scale)
    for _ in range(4):
        x, _ = step.solve(np.zeros_like(problem.free_velocity))
    left = problem.body_impulse(x) + problem.rigid_impulse
    assert np.abs(left).max() <= 1e-9 * np.abs(problem.rigid_impulse).max()
