"""Compiled motions of undeformed blocks: what they keep, and what they give for known turns."""

import numpy as np
import pytest

from masonry_fem.bodies.motions import (
    add_signed,
    by_block,
    put_maps,
    side_maps,
    spun,
    turned_frames,
    turned_moments,
    turns,
    wrenches,
)
from masonry_fem.bodies.rotation import IDENTITY, exponential


def test_a_block_in_free_flight_keeps_its_angular_momentum():
    rng = np.random.default_rng(0)
    axes = exponential(rng.normal(size=(20, 3)))
    scale, start = rng.uniform(0.5, 2.0, (20, 3)), rng.normal(size=(20, 3))
    h, theta = 0.05, 0.5
    end = spun(axes, scale, start, h, theta, 60, 1e-15)
    turn = h * np.einsum("bri,bi->br", axes, ((1 - theta) * start + theta * end) / scale)
    before, after = (
        np.einsum("bri,bi->br", frame, scale * spin)
        for frame, spin in ((axes, start), (exponential(turn) @ axes, end))
    )
    np.testing.assert_allclose(after, before, rtol=0, atol=1e-13)
    assert np.abs(end - start).max() > 1e-3  # the axes do turn


def test_turns_are_those_of_rodrigues():
    quarter = np.array([[0.0, 0.0, np.pi / 2], [0.0, 0.0, 0.0], [1e-9, 0.0, 0.0]])
    changed = turns(quarter)
    np.testing.assert_allclose(changed[0], [[-1, -1, 0], [1, -1, 0], [0, 0, 0]], atol=1e-15)
    assert not changed[1].any()
    assert changed[2, 2, 1] == 1e-9
    assert changed[2, 1, 1] == pytest.approx(-5e-19, rel=1e-12)  # nothing cancels


@pytest.mark.parametrize("dimension", [2, 3])
def test_side_maps_give_the_velocity_of_a_turning_block(dimension):
    rng = np.random.default_rng(dimension)
    spins = dimension * (dimension - 1) // 2
    arms, velocity = rng.normal(size=(2, 1, dimension))
    spin, scale = rng.normal(size=(1, spins)), rng.uniform(0.5, 2.0, (1, dimension + spins))
    axes = exponential(rng.normal(size=(1, 3)))
    frames = IDENTITY[dimension][None, ::-1].copy()
    unit = np.concatenate([velocity, spin], axis=1)
    maps = side_maps(frames, arms, axes, scale, np.zeros(1, dtype=np.int64))
    world = np.concatenate([np.zeros(2), spin[0]]) if dimension == 2 else axes[0] @ spin[0]
    arm = np.append(arms[0], [0.0] * (3 - dimension))
    expected = velocity[0] + np.cross(world, arm)[:dimension]
    np.testing.assert_allclose(maps[0] @ (scale * unit)[0], frames[0] @ expected, rtol=1e-12)


@pytest.mark.parametrize("dimension", [2, 3])
def test_moments_of_forces_on_turned_arms_and_at_contacts(dimension):
    rng = np.random.default_rng(dimension)
    arm, force = rng.normal(size=(2, dimension))
    turn = exponential(rng.normal(size=(1, 1 if dimension == 2 else 3)))
    forces = np.concatenate([force, np.outer(arm, force).ravel()])[None]

    def moment(a):
        full = (np.append(v, [0.0] * (3 - dimension)) for v in (a, force))
        return np.cross(*full)[3 - (1 if dimension == 2 else 3) :]

    np.testing.assert_allclose(turned_moments(forces, turn)[0], moment(turn[0] @ arm), rtol=1e-13)
    both = wrenches(np.array([[1, 0]]), np.array([[arm, 2 * arm]]), force[None], 2)
    np.testing.assert_allclose(both[1], np.concatenate([force, moment(arm)]), rtol=1e-14)
    np.testing.assert_allclose(both[0], -np.concatenate([force, moment(2 * arm)]), rtol=1e-14)


@pytest.mark.parametrize("dimension", [2, 3])
def test_products_by_block_and_by_side_are_those_of_numpy(dimension):
    rng = np.random.default_rng(dimension)
    matrices, blocks = rng.normal(size=(5, dimension, dimension)), rng.integers(0, 5, 30)
    vectors, frames = rng.normal(size=(30, dimension)), rng.normal(size=(30, dimension, dimension))
    expected = (matrices[blocks] @ vectors[:, :, None])[:, :, 0]
    np.testing.assert_allclose(by_block(matrices, blocks, vectors), expected, rtol=0, atol=1e-14)
    turned = turned_frames(frames, matrices, blocks)
    np.testing.assert_allclose(turned, frames @ matrices[blocks], rtol=0, atol=1e-14)
    contact, side = np.arange(30) // 2, np.arange(30) % 2
    maps, velocity = np.zeros((15, 2, dimension, dimension)), np.ones((15, dimension))
    put_maps(maps, contact, side, frames)
    add_signed(velocity, contact, side, vectors)
    np.testing.assert_array_equal(maps[:, 0], frames[::2])
    np.testing.assert_array_equal(maps[:, 1], -frames[1::2])
    np.testing.assert_allclose(velocity, 1.0 + vectors[::2] - vectors[1::2], rtol=0, atol=1e-15)
