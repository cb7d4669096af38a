"""Conjugate gradients from a guess."""

import numpy as np
import pytest

from masonry_fem.nscd.solvers.conjugate import conjugate


def system(size=20):
    rng = np.random.default_rng(1)
    factor = rng.normal(size=(size, size))
    return factor @ factor.T + np.eye(size), rng.normal(size=size)


def same(x):
    return x.copy()


def test_it_solves():
    A, b = system()
    x, products = conjugate(lambda v: A @ v, same, b, np.zeros(20), 1e-13)
    np.testing.assert_allclose(A @ x, b, atol=1e-10)
    assert products <= 40


def test_a_good_guess_costs_one_product():
    A, b = system()
    exact = np.linalg.solve(A, b)
    x, products = conjugate(lambda v: A @ v, same, A @ exact, exact, 1e-2)
    assert products == 1
    np.testing.assert_array_equal(x, exact)


@pytest.mark.parametrize("accuracy", [1e-1, 1e-4])
def test_accuracy_is_relative_to_the_guess(accuracy):
    A, b = system()
    guess = np.linalg.solve(A, b) + 1e-3
    x, _ = conjugate(lambda v: A @ v, same, b, guess, accuracy)
    assert np.linalg.norm(b - A @ x) <= accuracy * np.linalg.norm(b - A @ guess)


def test_the_exact_inverse_needs_one_step():
    A, b = system()
    inverse = np.linalg.inv(A)
    x, products = conjugate(lambda v: A @ v, lambda v: inverse @ v, b, np.zeros(20), 1e-8)
    assert products == 2
    np.testing.assert_allclose(A @ x, b, atol=1e-10)


def test_zero_is_solved_by_zero():
    A, _ = system()
    x, products = conjugate(lambda v: A @ v, same, np.zeros(20), np.zeros(20), 1e-2)
    assert products == 1
    assert not x.any()
