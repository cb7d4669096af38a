"""The compiled measures of contacts give what the formulas of ``graphs`` and NumPy's norms give."""

import numpy as np
import pytest

from masonry_fem.nscd import graphs
from masonry_fem.nscd.contact_measures import measured, spectral_norms
from masonry_fem.nscd.solvers.linearisation import linearise
from masonry_fem.nscd.transfer import column_squares, largest_side, longest, side_size


def contacts(dimension, count=300):
    """Impulses, velocities, friction and scales of contacts, some of them free of impulse or at rest."""
    rng = np.random.default_rng(dimension)
    pressed, velocity = rng.normal(size=(2, count, dimension))
    pressed[:40], velocity[20:60] = 0.0, 0.0
    return pressed, velocity, rng.uniform(0.0, 1.0, count), rng.uniform(0.1, 3.0, count)


@pytest.mark.parametrize("dimension", [2, 3])
def test_the_compiled_natural_map_is_the_one_of_the_graphs(dimension):
    pressed, velocity, friction, scale = contacts(dimension)
    natural, penetration, tension, violation, work = measured(pressed, velocity, friction, scale)
    expected = graphs.lengths(graphs.natural_map(pressed, velocity, friction, scale))
    np.testing.assert_allclose(natural, expected, rtol=1e-14, atol=1e-15)
    assert penetration == -velocity[:, 0].min()
    assert tension == -pressed[:, 0].min()
    beyond = graphs.tangential_norm(pressed) - friction * pressed[:, 0]
    assert violation == pytest.approx(beyond.max(), rel=1e-15)
    done = (pressed * graphs.augmented_velocity(velocity, friction)).sum(axis=1)
    assert work == pytest.approx(np.abs(done).max(), rel=1e-14)


def test_what_is_no_number_is_not_taken_for_small():
    pressed, velocity, friction, scale = contacts(3)
    velocity[7, 1] = np.nan
    natural, *_, work = measured(pressed, velocity, friction, scale)
    assert np.flatnonzero(np.isnan(natural)).tolist() == [7]
    assert np.isnan(work)
    assert np.isnan(longest(velocity))


@pytest.mark.parametrize("size", [1e-170, 1.0, 1e160])
@pytest.mark.parametrize("dimension", [2, 3])
def test_what_is_within_the_cone_for_certain_is_found_as_by_square_roots(dimension, size):
    """Contacts whose trial point is a rounding within the cone, on it and beyond, at any size."""
    rng = np.random.default_rng(3)
    friction, rho = rng.uniform(0.0, 1.0, 1000), rng.uniform(0.5, 2.0, 1000)
    direction = rng.normal(size=(1000, dimension))
    direction[:, 0] = np.abs(direction[:, 0])
    share = 1.0 + rng.integers(-2, 3, 1000) * 10.0 ** rng.integers(-16, 0, 1000)
    radius = share * friction * direction[:, 0] / graphs.tangential_norm(direction)
    direction[:, 1:] *= radius[:, None]
    pressed, still = size * direction, np.zeros((1000, dimension))
    tangent = graphs.tangential_norm(pressed)
    line = linearise(pressed, still, friction, rho)
    assert np.array_equal(line.plain, tangent <= friction * pressed[:, 0])
    _, _, _, violation, _ = measured(pressed, still, friction, rho)
    assert violation == (tangent - friction * pressed[:, 0]).max()
    beyond = graphs.natural_map(pressed, still, friction, rho).any(axis=1)
    assert np.array_equal(beyond, tangent > friction * pressed[:, 0])


@pytest.mark.parametrize("dimension", [2, 3])
def test_spectral_norms_are_largest_singular_values(dimension):
    blocks = np.random.default_rng(0).normal(size=(200, dimension, dimension))
    blocks[::3] = blocks[::3] @ blocks[::3].transpose(0, 2, 1)
    blocks[0], blocks[1], blocks[2], blocks[3] = 0.0, np.eye(dimension), 1.0, 1e-170 * np.eye(dimension)
    expected = np.linalg.norm(blocks, 2, axis=(1, 2))
    np.testing.assert_allclose(spectral_norms(blocks), expected, rtol=1e-13)


def test_impulses_on_sides_and_the_longest_row():
    rng = np.random.default_rng(1)
    maps, impulse = rng.normal(size=(50, 2, 3, 6)), rng.normal(size=(50, 3))
    sides = np.einsum("csdm,cd->csm", maps, impulse)
    assert largest_side(maps, impulse) == pytest.approx(np.linalg.norm(sides, axis=2).max(), rel=1e-14)
    assert side_size(maps, impulse) == pytest.approx(np.linalg.norm(sides), rel=1e-14)
    assert longest(impulse) == pytest.approx(np.linalg.norm(impulse, axis=1).max(), rel=1e-15)
    assert longest(np.zeros((0, 3))) == 0.0


@pytest.mark.parametrize("dimension", [2, 3])
def test_columns_of_the_rigid_map_are_as_long_as_those_of_its_matrix(dimension):
    rng = np.random.default_rng(2)
    maps = rng.normal(size=(40, 2, dimension, 3 * dimension - 3))
    bodies = rng.integers(-1, 7, size=(40, 2))
    bodies[bodies[:, 0] == bodies[:, 1], 1] = -1
    whole = np.zeros((40, dimension, 7, maps.shape[3]))
    for contact, side in np.argwhere(bodies >= 0):
        whole[contact, :, bodies[contact, side]] += maps[contact, side]
    np.testing.assert_allclose(column_squares(bodies, maps, 7), (whole**2).sum(axis=(0, 1)), rtol=1e-14)
