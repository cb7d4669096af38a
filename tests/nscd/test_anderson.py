"""Anderson's acceleration on linear maps, where it is GMRES, and on one that leaps."""

import numpy as np
import pytest

from masonry_fem.nscd.solvers.anderson import Anderson


def iterations(map_, size, memory, limit=2000):
    anderson, state = Anderson(memory, size), np.zeros(size)
    for made in range(limit):
        image = map_(state)
        if np.linalg.norm(image - state) < 1e-10:
            return made, state
        state = anderson.next(state, image)
    return limit, state


def linear(size=12, slowest=0.99):
    rng = np.random.default_rng(0)
    basis = np.linalg.qr(rng.normal(size=(size, size)))[0]
    matrix = basis @ np.diag(np.linspace(0, slowest, size)) @ basis.T
    offset = rng.normal(size=size)
    return (lambda x: matrix @ x + offset), np.linalg.solve(np.eye(size) - matrix, offset)


def test_a_linear_map_ends_within_its_size():
    map_, fixed = linear()
    plain, _ = iterations(map_, 12, 0)
    made, state = iterations(map_, 12, 14)
    assert plain > 1000
    assert made < 40
    np.testing.assert_allclose(state, fixed, rtol=1e-6)


def test_a_short_memory_still_helps():
    map_, fixed = linear()
    made, state = iterations(map_, 12, 4)
    assert made < 300
    np.testing.assert_allclose(state, fixed, rtol=1e-6)


def test_no_memory_is_the_plain_iteration():
    anderson = Anderson(0, 2)
    image = np.array([1.0, 2.0])
    assert anderson.next(np.zeros(2), image) is image


def test_a_longer_step_forgets_the_past():
    anderson = Anderson(3, 1)
    anderson.next(np.array([0.0]), np.array([1.0]))
    anderson.next(np.array([1.0]), np.array([1.5]))
    assert anderson.count == 1
    leap = np.array([9.0])
    assert anderson.next(np.array([2.0]), leap) == pytest.approx(leap)
    assert anderson.count == 0


def test_no_difference_is_taken_over_a_shift():
    anderson = Anderson(3, 1)
    anderson.next(np.array([0.0]), np.array([1.0]))
    anderson.skip()
    anderson.next(np.array([1.0]), np.array([1.5]))
    assert anderson.count == 0
    anderson.next(np.array([1.5]), np.array([1.7]))
    assert anderson.count == 1
