"""Corotational blocks: spin without end, and forces that balance where blocks are."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from masonry_fem.bodies.base import Scheme
from masonry_fem.bodies.rotation import change, exponential
from masonry_fem.fem.groups import elastic_groups
from masonry_fem.fem.material import ElasticMaterial
from masonry_fem.solid.assembly import Assembly, Block, Shape
from masonry_fem.solid.pose import Pose
from tests.fem.meshes import box, box_mesh

STONE = ElasticMaterial(young=1e9, poisson=0.2, density=2400.0)


def brick(dimension: int):
    """One brick of 0.5 × 0.2 × 0.3 m, turned in space."""
    low, high = (0.0, 0.0, 0.0)[:dimension], (0.5, 0.2, 0.3)[:dimension]
    cell = "quad" if dimension == 2 else "hexahedron"
    shape = Shape("brick", box(low, high), box_mesh(cell, (3, 2, 2)[:dimension], low, high, 0.0))
    turn = np.array([0.3, -0.5, 0.8])[-(2 * dimension - 3) :]
    assembly = Assembly(dimension, (shape,), (Block("b", 0, Pose(exponential(turn), np.ones(dimension))),))
    (group,) = elastic_groups(assembly, {0: STONE}, turns=True)
    return group


@pytest.mark.slow
@pytest.mark.parametrize("dimension", [2, 3])
def test_four_turns_of_a_free_stone(dimension: int) -> None:
    """Momentum and energy of a stone that tumbles; it starts bent, and vibrates on."""
    group, h = brick(dimension), 1e-3
    spin = np.array([1.0, 9.0, 3.0]) if dimension == 3 else np.array([9.0])
    velocity = np.array([0.3, -0.2, 0.5])[:dimension]
    state = group.with_velocity(group.rest(), 0, velocity, spin)
    bent = group.factor(Scheme(1.0, 1.0, 0.0)).apply(np.sin(np.arange(group.mesh.points.size))[None]) * 1e3
    state = replace(state, displacement=bent)
    start, scheme = state, Scheme(h, 0.5)
    energy = group.kinetic_energy(state) + group.strain_energy(state)
    assert group.strain_energy(state) > 1e-6 * energy
    for _ in range(int(4 * 2 * np.pi / np.linalg.norm(spin) / h)):
        free = group.free(state, state, group.no_force(), scheme)
        impulse = free.rigid_impulse / free.rigid_mass
        state = group.advance(state, free, free.rigid_velocity + impulse, None, scheme)
    np.testing.assert_allclose(group._momentum(state), group._momentum(start), rtol=1e-12, atol=1e-12)
    after = group.kinetic_energy(state) + group.strain_energy(state)
    np.testing.assert_allclose(after, energy, rtol=1e-4 if dimension == 3 else 1e-12)
    gone = group.positions(state).mean(axis=0) - group.positions(start).mean(axis=0)
    np.testing.assert_allclose(gone, velocity * state.time, atol=2 * np.abs(bent).max())


@pytest.mark.parametrize("dimension", [2, 3])
def test_internal_forces_balance_where_the_block_is(dimension: int) -> None:
    """Loads that balance on the deformed block leave nothing of its equations, whatever its turn."""
    group, rng = brick(dimension), np.random.default_rng(3)
    turned = change(np.array([[0.9, -1.2, 2.0]])[:, -(2 * dimension - 3) :])
    state = replace(group.rest(), turned=turned, displacement=1e-3 * rng.normal(size=group.no_force().shape))
    force = group.no_force()
    nodes = force.reshape(1, -1, dimension)
    along = (group._moved(state) + group.mesh.points)[0, [0, -1]]
    nodes[0, 0] = 1e6 * (along[1] - along[0])  # two corners pulled apart along the line that joins them
    nodes[0, -1] = -nodes[0, 0]
    statics = Scheme(0.5, 1.0, 0.0)
    free = group.free(state, state, force, statics)
    largest = np.abs(statics.step * np.abs(group.generalised(state, np.abs(force)))).max()
    np.testing.assert_allclose(free.rigid_impulse, 0.0, atol=1e-13 * largest)


@pytest.mark.parametrize("dimension", [2, 3])
def test_stress_turns_with_the_block(dimension: int) -> None:
    group, rng = brick(dimension), np.random.default_rng(5)
    bent = replace(group.rest(), displacement=1e-4 * rng.normal(size=group.no_force().shape))
    turned = change(np.array([[0.9, -1.2, 2.0]])[:, -(2 * dimension - 3) :])
    there = replace(bent, turned=turned)
    here = group.stress(bent).gauss[0, 0, 0]
    now = group.stress(there).gauss[0, 0, 0]
    np.testing.assert_allclose(_invariants(now), _invariants(here), rtol=1e-10)
    np.testing.assert_allclose(group.strain_energy(there), group.strain_energy(bent), rtol=1e-15)


def _invariants(stress: np.ndarray) -> np.ndarray:
    xx, yy, zz, xy, yz, xz = stress
    return np.linalg.eigvalsh([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
