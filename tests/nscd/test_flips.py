"""Flips: who swings between open and sticking, and what a step makes of it."""

import numpy as np
import pytest

from masonry_fem.nscd import ContactProblem, SolverSettings, solve
from masonry_fem.nscd.solvers.flips import Flips
from masonry_fem.nscd.solvers.linearisation import linearise, slipping

RHO = np.array([2.0, 2.0, 2.0])
STUCK, OPEN = np.array([1.0, 0.1, 0.0]), np.array([-1.0, 0.1, 0.0])
SLIDES = np.array([1.0, 0.0, 5e4])


def line(trials, friction):
    """The contact function where p − ρ v = ``trials``, at rest."""
    return linearise(np.array(trials), np.zeros((len(trials), 3)), friction, RHO[: len(trials)])


def test_who_goes_there_and_back_is_found():
    friction = np.array([1e3, 1e3, 0.5])
    flips = Flips(friction)
    states = [[STUCK, STUCK, STUCK], [OPEN, SLIDES, OPEN], [STUCK, STUCK, STUCK]]
    found = [flips.swinging(line(state, friction), settled=True) for state in states]
    assert not found[0].any()
    assert not found[1].any()
    assert found[2].tolist() == [True, False, False]  # the second slid, the third is not rough
    assert not flips.swinging(line(states[1], friction), settled=True).any()  # it begins anew


def test_who_comes_to_stay_is_left_alone():
    friction = np.full(1, 1e3)
    flips = Flips(friction)
    for state in (OPEN, STUCK, STUCK, STUCK):
        assert not flips.swinging(line([state], friction), settled=True).any()
    flips.forget()
    assert not any(
        flips.swinging(line([state], friction), settled=False).any() for state in (OPEN, STUCK, OPEN)
    )


def test_where_a_contact_slips_the_slipping_function_is_the_usual_one():
    rng = np.random.default_rng(0)
    impulse, velocity = rng.normal(size=(3, 3)), rng.normal(size=(3, 3))
    impulse[:, 0] = 3 + RHO * velocity[:, 0]
    friction = np.full(3, 0.1)
    usual = linearise(impulse, velocity, friction, RHO)
    made = slipping(usual, np.array([True, False, True]), impulse, velocity, friction)
    for name in ("residual", "by_impulse", "by_velocity"):
        assert getattr(made, name) == pytest.approx(getattr(usual, name), rel=1e-12, abs=1e-15)


@pytest.mark.parametrize("friction", [10.0, 1e3, 1e6])
@pytest.mark.parametrize("d", [2, 3])
def test_a_contact_that_can_neither_open_nor_stick(d, friction):
    """W_NT = ½: open, v_N = −0.1; stuck, p_N < 0. It slides with v_N = 0: p_N (1 + μ/2) = 0.1."""
    W, q = np.eye(d), np.zeros((1, d))
    W[0, 1] = W[1, 0] = 0.5
    q[0, :2] = -0.1, -1.0
    solution = solve(ContactProblem.plain(W, q, friction), SolverSettings(method="newton", tolerance=1e-9))
    assert solution.converged
    assert solution.linear_solves < 20
    normal = 0.1 / (1 + friction / 2)
    assert solution.impulse[0, :2] == pytest.approx([normal, friction * normal], rel=1e-6)
