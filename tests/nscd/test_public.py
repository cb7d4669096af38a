"""Public contact problems (Siconos Numerics' collection, converted; see the data's README)."""

import numpy as np
import pytest

from masonry_fem.nscd import SolverSettings, load_problem, solve


@pytest.fixture(scope="module")
def problems(shared_data):
    return {path.stem: load_problem(path) for path in sorted((shared_data / "fc").glob("*.npz"))}


def natural_map_by_definition(problem, impulse):
    """err_rho of one contact after the other, from the README's formula."""
    W = problem.compliance.toarray()
    d, residual = problem.dimension, []
    v = (W @ impulse.ravel()).reshape(-1, d) + problem.free_velocity
    for i, mu in enumerate(problem.friction):
        block = W[i * d : i * d + d, i * d : i * d + d]
        hat = v[i] + mu * np.linalg.norm(v[i, 1:]) * np.eye(d)[0]
        x = impulse[i] - hat / np.linalg.norm(block, 2)
        size = np.linalg.norm(x[1:])
        if size <= mu * x[0]:
            y = x
        elif mu * size <= -x[0]:
            y = np.zeros(d)
        else:
            y = (x[0] + mu * size) / (1 + mu**2) * np.concatenate([[1.0], mu * x[1:] / size])
        residual.append(impulse[i] - y)
    return np.linalg.norm(residual) / max(np.linalg.norm(impulse), 1e-300)


def test_sweeps_reach_engineering_accuracy(problems):
    assert problems
    missed = {}
    for name, problem in problems.items():
        solution = solve(problem, SolverSettings(method="nsgs", tolerance=1e-4))
        if not solution.converged:
            missed[name] = solution.quality.natural_map
        elif problem.count < 400 and solution.impulse.any():
            assert natural_map_by_definition(problem, solution.impulse) <= 1e-4
        assert (solution.impulse[:, 0] >= 0).all()
    assert not missed
