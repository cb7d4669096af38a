"""One contact: the answer satisfies Signorini and Coulomb whatever the block."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from masonry_fem.nscd.graphs import natural_map
from masonry_fem.nscd.local import reduce_blocks, solve_contact

FRICTIONS = (0.0, 0.1, 0.6, 1.0, 10.0, 1e3, 1e6)


def miss(W, b, mu, p):
    """Natural map relative to the impulse, or to what stops b where there is none."""
    w = np.linalg.norm(W, 2)
    residual = natural_map(p[None], (W @ p + b)[None], np.array([mu]), np.array([w]))
    return np.linalg.norm(residual) / max(np.linalg.norm(p), np.linalg.norm(b) / w)


@st.composite
def contacts(draw):
    """(W, b, mu): positive semi-definite, near-singular or a little unsymmetric, any scale."""
    d = draw(st.sampled_from([2, 3]))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    rank = draw(st.integers(1, d + 1))
    factor = rng.normal(size=(d, rank)) * 10.0 ** rng.uniform(-4, 4, size=(1, rank))
    W = factor @ factor.T + draw(st.sampled_from([0.0, 1e-14, 1e-6, 1.0])) * np.eye(d) * np.sum(factor**2)
    skew = rng.normal(size=(d, d))
    W += draw(st.sampled_from([0.0, 0.1])) * max(np.linalg.eigvalsh(W)[0], 0.0) * (skew - skew.T)
    return W, rng.normal(size=d) * 10.0 ** rng.uniform(-6, 6), draw(st.sampled_from(FRICTIONS))


@given(contacts())
def test_solves_any_contact(contact):
    W, b, mu = contact
    p = solve_contact(W, b, mu)
    assert p[0] >= 0
    assert np.linalg.norm(p[1:]) <= mu * p[0] * (1 + 1e-14)
    # near ‖p_T‖ = μ p_N with a huge μ, p_N carries 1/μ of the digits
    assert miss(W, b, mu, p) <= 1e-12 * max(1.0, mu)


@given(contacts(), st.floats(0.0, 6.28), st.floats(-5, 5), st.floats(-5, 5))
def test_turns_with_the_frame_and_scales_with_the_units(contact, angle, first, second):
    W, b, mu = contact
    W = W + 0.1 * np.trace(W) * np.eye(len(b))  # one clear answer
    p = solve_contact(W, b, min(mu, 1.0))
    Q = np.eye(len(b))
    if len(b) == 3:
        Q[1:, 1:] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    else:
        Q[1, 1] = -1.0
    mass, speed = 10.0**first, 10.0**second
    turned = solve_contact(Q @ W @ Q.T / mass, speed * (Q @ b), min(mu, 1.0))
    assert turned == pytest.approx(
        mass * speed * (Q @ p), rel=1e-9, abs=1e-9 * mass * speed * np.linalg.norm(p)
    )


def test_open_stick_and_slip_by_hand():
    W = np.diag([2.0, 4.0])
    assert np.array_equal(solve_contact(W, [0.1, 5.0], 0.5), [0, 0])
    assert solve_contact(W, [-2.0, 1.0], 0.5) == pytest.approx([1.0, -0.25])
    assert solve_contact(W, [-2.0, 8.0], 0.5) == pytest.approx([1.0, -0.5])
    W = np.diag([2.0, 4.0, 4.0])
    assert solve_contact(W, [-2.0, 0.6, 0.8], 0.5) == pytest.approx([1.0, -0.15, -0.2])
    assert solve_contact(W, [-2.0, 6.0, 8.0], 0.5) == pytest.approx([1.0, -0.3, -0.4])
    assert solve_contact(W, [-2.0, 6.0, 8.0], 0.0) == pytest.approx([1.0, 0.0, 0.0])


def test_anisotropic_slip_opposes_the_velocity():
    W = np.array([[2.0, 0.3, -0.2], [0.3, 5.0, 1.0], [-0.2, 1.0, 1.0]])
    b, mu = np.array([-1.0, 3.0, 2.0]), 0.4
    p = solve_contact(W, b, mu)
    v = W @ p + b
    assert v[0] == pytest.approx(0, abs=1e-14)
    assert np.linalg.norm(p[1:]) == pytest.approx(mu * p[0], rel=1e-14)
    assert p[1:] / np.linalg.norm(p[1:]) == pytest.approx(-v[1:] / np.linalg.norm(v[1:]), abs=1e-13)


def test_a_contact_that_nothing_moves_takes_no_impulse():
    assert np.array_equal(solve_contact(np.zeros((3, 3)), [-1.0, 1.0, 0.0], 0.5), [0, 0, 0])
    assert np.isfinite(reduce_blocks(np.zeros((2, 2, 2)))).all()


@pytest.mark.parametrize(("normal", "coupling"), [(2.0, 7.0), (2.0, -7.0), (8.0, 6.0)])
def test_a_wedge_on_the_brink_of_jamming_is_found_though_its_pressure_is_lost_in_rounding(normal, coupling):
    """Where μ |W_NT| = W_NN, p_N of a slip is a quotient whose divisor is 0: the contact sticks."""
    friction = normal / abs(coupling)
    W = np.array([[normal, coupling], [coupling, coupling**2 / normal + 1.0]])
    for tangential in np.copysign(np.arange(1.0, 100.0) / 7.0, coupling):
        b = np.array([-1e-30, tangential])
        p = solve_contact(W, b, friction)
        assert p[0] > 0
        assert miss(W, b, friction, p) <= 1e-14


@pytest.mark.parametrize("friction", [0.3, 1.0, 1.5, 4.0, 30.0])
@pytest.mark.parametrize("angle", [0.0, 0.7, 2.5, 4.0])
def test_sliding_in_space_along_a_line_is_sliding_in_the_plane(friction, angle):
    """A wedge that couples pressure and slip along one direction; nothing moves across it."""
    plane = np.array([[2.0, -0.5], [-0.5, 1.0]])
    free = np.array([-1.0, 40.0])
    normal, along = solve_contact(plane, free, friction)
    velocity = plane @ (normal, along) + free
    assert velocity[0] == pytest.approx(0.0, abs=1e-14)
    assert velocity[1] > 1.0  # slides
    assert along == pytest.approx(-friction * normal, rel=1e-14)
    turn = np.array([np.cos(angle), np.sin(angle)])
    space = np.zeros((3, 3))
    space[0, 0] = plane[0, 0]
    space[0, 1:] = space[1:, 0] = plane[0, 1] * turn
    across = np.array([-turn[1], turn[0]])
    space[1:, 1:] = plane[1, 1] * np.outer(turn, turn) + 3.0 * np.outer(across, across)
    found = solve_contact(space, np.concatenate([free[:1], free[1] * turn]), friction)
    assert found[0] == pytest.approx(normal, rel=1e-13)
    assert found[1:] == pytest.approx(along * turn, rel=1e-12, abs=1e-12 * abs(along))
