"""Macroblocks: rigid motions are found again under what shakes and what strays."""

import numpy as np
import pytest

from masonry_fem.bodies.rotation import lever, spin_count
from masonry_fem.march.macroblocks import ALIKE, MOST, macroblocks


def shaken(dimension, sizes, noise, strays, seed):
    """Cubes (squares) of groups of some ``sizes`` with a random rigid motion each, all a little shaken."""
    random = np.random.default_rng(seed)
    truth = np.concatenate([np.repeat(np.arange(len(sizes)), sizes), np.full(strays, -1)])
    count = len(truth)
    centre = random.uniform(-10, 10, (count, dimension))
    corner = 0.2 * (np.indices((2,) * dimension).reshape(dimension, -1).T - 0.5)
    points = (centre[:, None] + corner).reshape(-1, dimension)
    owner = np.repeat(np.arange(count), len(corner))
    shift = 5 * random.normal(size=(len(sizes) + strays, dimension))
    spin = 0.5 * random.normal(size=(len(sizes) + strays, spin_count(dimension)))
    group = np.where(truth < 0, len(sizes) + np.cumsum(truth < 0) - 1, truth)
    velocity = shift[group[owner]] + np.einsum("nij,nj->ni", lever(points), spin[group[owner]])
    fastest = np.linalg.norm(velocity, axis=1).max()
    velocity += noise * fastest * random.uniform(-1, 1, velocity.shape) / np.sqrt(dimension)
    return points, velocity, owner, truth, shift, spin


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("seed", range(4))
def test_groups_are_found_again(dimension, seed):
    sizes = [120, 60, 40]
    points, velocity, owner, truth, shift, spin = shaken(dimension, sizes, 0.03, 0, seed)
    found = macroblocks(points, velocity, owner)
    fastest = np.linalg.norm(velocity, axis=1).max()
    for group in range(len(sizes)):
        numbers, counts = np.unique(found.member[truth == group], return_counts=True)
        assert counts.max() >= 0.9 * sizes[group]  # some lie where two motions are alike
        own = int(numbers[counts.argmax()])
        assert np.abs(found.spin[own] - spin[group]).max() < 0.03 * fastest / 10
        assert np.abs(found.velocity[own] - shift[group]).max() < 0.05 * fastest
    size = np.bincount(found.member[found.member >= 0])
    assert (np.diff(size) <= 0).all()


def test_what_belongs_to_none_is_by_itself():
    points, velocity, owner, truth, *_ = shaken(2, [100, 50], 0.0, 5, 3)
    found = macroblocks(points, velocity, owner)
    assert (found.member[truth >= 0] >= 0).all()
    flat = np.linalg.norm(velocity, axis=1).max()
    for block in np.flatnonzero(found.member >= 0):
        own = owner == block
        motion = found.velocity[found.member[block]] + lever(points[own]) @ found.spin[found.member[block]]
        assert np.linalg.norm(velocity[own] - motion, axis=1).max() <= ALIKE * flat * (1 + 1e-9)


def test_there_are_never_more_than_one_can_keep_in_mind():
    points, velocity, owner, *_ = shaken(3, [10] * 12, 0.0, 0, 5)
    found = macroblocks(points, velocity, owner)
    assert 1 <= len(found.velocity) <= MOST
    assert found.member.max() == len(found.velocity) - 1


def test_units_and_the_origin_do_not_matter():
    points, velocity, owner, *_ = shaken(2, [40, 30], 0.02, 0, 7)
    one = macroblocks(points, velocity, owner)
    other = macroblocks(1e3 * points, 1e-6 * velocity, owner)
    assert np.array_equal(one.member, other.member)
    assert other.spin == pytest.approx(1e-9 * one.spin, rel=1e-6)
