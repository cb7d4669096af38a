"""Quality measures: what they see, and in which units."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import sparse

from masonry_fem.nscd import ContactProblem, SolverSettings, assess, rounding, solve
from masonry_fem.nscd.residuals import balance_rounding
from tests.nscd.walls import rigid_wall

NONE = np.zeros((0, 6))


def single(q=(-1.0, 0.3, 0.0), mu=0.5):
    return ContactProblem.plain(np.diag([2.0, 4.0, 4.0]), np.array([q]), mu)


def test_the_answer_has_none():
    quality = assess(single(), np.array([[0.5, -0.075, 0.0]]), NONE)
    assert quality.error <= 1e-15
    assert (quality.max_penetration, quality.cone_violation) == (0, 0)


def test_each_fault_is_seen():
    penetrating = assess(single(), np.array([[0.25, -0.075, 0.0]]), NONE)
    assert penetrating.max_penetration == pytest.approx(0.5)
    pulling = assess(single(), np.array([[-0.1, 0.0, 0.0]]), NONE)
    assert pulling.min_normal == pytest.approx(-0.1)
    outside = assess(single(), np.array([[0.5, -0.3, 0.0]]), NONE)
    assert outside.cone_violation == pytest.approx(0.05)
    flying = assess(single(), np.array([[1.0, -0.075, 0.0]]), NONE)
    assert flying.complementarity == pytest.approx(1.0)
    assert min(q.error for q in (penetrating, pulling, outside, flying)) > 0.1


def test_friction_that_drives_is_a_fault():
    slipping = single(q=(-1.0, 4.0, 0.0))
    assert assess(slipping, np.array([[0.5, -0.25, 0.0]]), NONE).error <= 1e-15
    assert assess(slipping, np.array([[0.5, 0.25, 0.0]]), NONE).natural_map > 0.5


def test_free_of_units():
    rng = np.random.default_rng(0)
    factor = rng.normal(size=(9, 9))
    W, q, p = factor @ factor.T, rng.normal(size=(3, 3)), rng.normal(size=(3, 3))
    one = assess(ContactProblem.plain(W, q, 0.4), p, NONE)
    other = assess(ContactProblem.plain(W / 1e6, q * 1e3, 0.4), p * 1e9, NONE)
    assert other.natural_map == pytest.approx(one.natural_map)
    assert other.natural_map_velocity == pytest.approx(one.natural_map_velocity)
    assert other.max_penetration == pytest.approx(1e3 * one.max_penetration)
    assert other.complementarity == pytest.approx(1e12 * one.complementarity)


@pytest.mark.parametrize("speed", [1.0, 1e-17])
def test_without_impulses_velocities_decide(speed):
    apart = single(q=(speed, speed, 0.0))
    assert assess(apart, np.zeros((1, 3)), NONE).error == 0
    falling = single(q=(-speed, 0.0, 0.0))
    assert assess(falling, np.zeros((1, 3)), NONE).error == pytest.approx(1.0)
    assert assess(single(q=(0, 0, 0)), np.zeros((1, 3)), NONE).error == 0


@pytest.mark.parametrize("friction", [0.5, 1e10])
def test_without_impulses_sliding_hides_no_penetration(friction):
    """v̂ = v + μ‖v_T‖ n is within the dual cone, or nearly so, however fast blocks go into each other."""
    through = single(q=(-1.0, 0.3, 0.0), mu=friction)
    assert assess(through, np.zeros((1, 3)), NONE).error > 0.8
    assert assess(through, np.zeros((1, 3)), NONE, least_impulse=1.0).error > 0.2


def test_speeds_whose_squares_are_zero_are_no_error():
    assert assess(single(q=(-1e-170, 1e-170, 0.0)), np.zeros((1, 3)), NONE).error == 0


def test_an_unbalanced_body_is_seen():
    problem = rigid_wall(3, 2, step=0.01)
    p = np.full((problem.count, 3), [1.0, 0.1, 0.0])
    U = problem.balanced_velocity(p)
    assert assess(problem, p, U).block_balance <= 1e-15
    assert assess(problem, p, 1.1 * U).block_balance == pytest.approx(0.1, rel=0.5)
    assert assess(problem, p, np.nan * U).error == np.inf
    assert assess(problem, 0.0 * p, np.nan * U).error == np.inf


def test_the_rigid_scale_does_not_hide_elastic_errors():
    """A body of mass 1 on a compliance 1e-8 times softer than its inertia: 1 % off is 1 % off."""
    maps = np.zeros((1, 2, 3, 6))
    maps[0, 0, :, :3] = np.eye(3)
    problem = ContactProblem(
        friction=np.array([0.5]),
        free_velocity=np.zeros((1, 3)),
        compliance=sparse.bsr_array(1e-8 * np.eye(3), blocksize=(3, 3)),
        bodies=np.array([[0, -1]]),
        rigid_map=maps,
        rigid_mass=np.ones((1, 6)),
        rigid_impulse=np.array([[-1.0, 0, 0, 0, 0, 0]]),
        rigid_velocity=np.zeros((1, 6)),
    )
    exact = 1 / (1 + 1e-8)
    right = np.array([[exact, 0.0, 0.0]])
    assert assess(problem, right, problem.balanced_velocity(right)).error <= 1e-8
    off = right.copy()
    U = problem.balanced_velocity(right)
    U[0, 0] *= 1.01  # 1 % of the elastic indentation
    quality = assess(problem, off, U)
    assert quality.natural_map_velocity == pytest.approx(0.01, rel=0.01)
    static = replace(problem, rigid_mass=np.zeros((1, 6)))
    assert solve(static, SolverSettings(tolerance=1e-10)).velocity[0, 0] == pytest.approx(0, abs=1e-16)


def test_a_huge_impulse_that_nothing_feels_is_a_fault():
    """Both points are led along the normal and part: p − v/w is p to rounding, yet p must be 0."""
    W = np.diag([0.0, 4e-9, 4e-9, 2e-9, 4e-9, 4e-9])
    led = ContactProblem.plain(W, np.array([[1e-3, 0.0, 0.0], [-1e-4, 0.0, 0.0]]), 0.5)
    pressed = np.array([[0.0, 0.0, 0.0], [5e4, 0.0, 0.0]])
    assert assess(led, pressed, NONE).error <= 1e-15
    pressed[0, 0] = 1e23
    assert assess(led, pressed, NONE).error > 0.1


@pytest.mark.parametrize("friction", [1e2, 1e6, 1e8])
def test_very_rough_contacts_blow_up_slip_and_the_rounding_that_is_told(friction):
    """A pressed point under rest: μ‖v_T‖ of a slip of 1e-12 counts μ-fold, and of 1e-16 is rounding."""
    stuck = ContactProblem.plain(np.diag([2.0, 4.0, 4.0]), np.array([[-1.0, 0.3, 0.0]]), friction)
    exact = np.array([[0.5, -0.075, 0.0]])
    for shift in (0.0, 3e-17, 1e-12):
        moved = exact + np.array([[0.0, shift, 0.0]])
        error, known = assess(stuck, moved, NONE).error, rounding(stuck, moved, NONE).error
        assert known <= 1e-14 * friction
        assert error <= known if shift < 1e-16 else error >= max(0.1 * friction * shift, 10 * known)


@pytest.mark.parametrize("pressed", [(0.5, -0.075, 0.0), (0.3, 0.2, -0.1)])
def test_rounding_of_one_contact_is_what_its_formula_says(pressed):
    """p̃ is known to γ₂ |p|, v̂ to (1 + μ) γ (|W| |p| + |q|): both count, however the other turns out."""
    problem, p = single(mu=0.5), np.array([pressed])
    told = rounding(problem, p, NONE, scale=np.array([4.0]))
    unit = np.finfo(float).eps / 2
    # three products with W, two rigid maps of six columns, and q
    sizes = np.array([2.0, 4.0, 4.0]) * np.abs(p[0]) + np.abs(problem.free_velocity[0])
    of_velocity = np.sqrt(3 + 2 * 6 + 1) * unit * sizes
    part, augmented = np.sqrt(2) * unit * np.linalg.norm(p), 1.5 * np.linalg.norm(of_velocity)
    assert told.natural_map == pytest.approx((part + augmented / 4.0) / np.linalg.norm(p), rel=1e-12, abs=0.0)
    assert told.max_penetration == pytest.approx(of_velocity[0], rel=1e-12, abs=0.0)


@pytest.mark.parametrize("touching", [1, 2])
def test_rounding_of_a_balance_grows_with_the_root_of_its_terms(touching):
    """Three components of each contact on the body, its load, and its momentum before and after."""
    maps = np.zeros((touching, 2, 3, 6))
    maps[:, 0, :, :3] = np.eye(3)
    problem = ContactProblem(
        friction=np.full(touching, 0.5),
        free_velocity=np.zeros((touching, 3)),
        compliance=sparse.bsr_array((3 * touching, 3 * touching), blocksize=(3, 3)),
        bodies=np.tile([0, -1], (touching, 1)),
        rigid_map=maps,
        rigid_mass=np.full((1, 6), 2.0),
        rigid_impulse=np.array([[-5.0, 0, 0, 0, 0, 0]]),
        rigid_velocity=np.array([[1.0, 0, 0, 0, 0, 0]]),
    )
    p, U = np.tile([7.0 / touching, 0.0, 0.0], (touching, 1)), np.array([[-3.0, 0, 0, 0, 0, 0]])
    sizes = 7.0 + 5.0 + 2.0 * (3.0 + 1.0)
    bound = np.sqrt(3 * touching + 3) * np.finfo(float).eps / 2 * sizes
    assert balance_rounding(problem, p, U) == pytest.approx([bound], rel=1e-12, abs=0.0)
    assert rounding(problem, p, U).block_balance == pytest.approx(bound / 8.0, rel=1e-12, abs=0.0)
