"""Stacks of rigid stones whose masses differ by powers of ten, as one matrix W that tells of no bodies.

So problems of other programs come. W has a rank of six a stone, far below its rows, and no scale fits all
contacts.
"""

from dataclasses import replace

import numpy as np
import pytest

from masonry_fem.nscd import ContactProblem, SolverSettings, solve
from tests.nscd.walls import rigid_boxes, running_bond, touching

BRICK = (0.5, 0.25, 0.25)
PUSH = np.array([0.5, 0.3, -9.81])  # [m/s²]


def stack(decades, seed):
    """A stack of 45 stones in six courses, 464 contacts, with masses up to so many powers of ten apart."""
    boxes = running_bond(6, 3.5, BRICK)
    problem = rigid_boxes(boxes, touching(boxes), friction=0.7, acceleration=PUSH, step=1e-2)
    random = np.random.default_rng(seed)
    root = np.sqrt(10.0 ** (decades * (random.random(problem.body_count) - 0.5)))  # of the mass ratios
    maps = problem.rigid_map / np.append(root, np.inf)[problem.bodies][:, :, None, None]
    heavy = replace(problem, rigid_map=maps, rigid_impulse=problem.rigid_impulse * root[:, None])
    return ContactProblem.plain(heavy.delassus(), heavy.plain_velocity(), heavy.friction)


@pytest.mark.parametrize(("decades", "seed"), [(0, 0), (2, 1), (3, 2), (4, 3), (4, 4)])
def test_no_stack_stalls(decades, seed):
    problem = stack(decades, seed)
    assert problem.count == 464
    solution = solve(problem, SolverSettings(tolerance=1e-8))
    assert solution.converged
    assert solution.quality.error <= 1e-8
