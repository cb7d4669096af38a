"""Proximal Newton: independent references of validation A10, verdicts, limits of the split form."""

import numpy as np
import pytest

from masonry_fem.nscd.iterate import iterate
from masonry_fem.nscd.outcome import Outcome
from masonry_fem.nscd.settings import SolverSettings
from masonry_fem.nscd.solvers.newton import ProximalNewton
from tests.nscd import walls

TIGHT = SolverSettings(tolerance=1e-11)


def newton(problem, settings=TIGHT, start=None):
    return iterate(problem, ProximalNewton(), settings, start)


@pytest.mark.parametrize(
    ("horizontal", "expected", "counts"),
    [(0.1e6, (380.726, -324.486), (0, 81, 0)), (0.3e6, (1280.876, -600.115), (36, 27, 18))],
)
def test_two_cubes_reach_the_independent_reference(horizontal, expected, counts):
    """A10.1, A10.2: displacements [µm] to the printed digits; open, stick and slip counts."""
    structure = walls.cubes(8, horizontal)
    problem = structure.problem()
    found = newton(problem)
    top = structure.displacement(problem, found.impulse, found.rigid_velocity, 1, np.array([1, 0.5, 2]))
    assert found.outcome is Outcome.CONVERGED
    assert found.linear_solves <= 12
    np.testing.assert_allclose(1e6 * top[[0, 2]], expected, atol=5.1e-4)
    assert status_counts(problem, found) == counts


def status_counts(problem, solution):
    """Open, sticking and slipping contacts."""
    p, v = solution.impulse, solution.velocity
    closed = p[:, 0] > 1e-9 * np.abs(p).max()
    caused = np.abs(problem.elastic_velocity(p)).max()
    slips = closed & (np.linalg.norm(v[:, 1:], axis=1) > 1e-9 * caused)
    return int((~closed).sum()), int((closed & ~slips).sum()), int(slips.sum())
