"""Inelastic groups: elastic where nothing yields; in balance, all energy accounted for, where it does."""

from dataclasses import replace

import numpy as np
import pytest

from masonry_fem.bodies.base import Scheme
from masonry_fem.bodies.rotation import change
from masonry_fem.bodies.support import Clamp
from masonry_fem.fem.groups import elastic_groups
from masonry_fem.fem.material import ElasticMaterial
from masonry_fem.fem.materials.drucker_prager import DruckerPrager
from masonry_fem.fem.plane_stress import PlaneStress
from masonry_fem.fem.strains import Strains
from masonry_fem.solid.assembly import Assembly, Block, Shape
from masonry_fem.solid.pose import Pose
from tests.fem.meshes import CELLS, box, box_mesh, dimension_of

WEAK = DruckerPrager(1e4, 30.0, 5.0, hardening=2e6)
SCHEMES = [Scheme(0.02, 0.5), Scheme(0.05, 0.8), Scheme(0.25, 1.0, 0.0)]


def stones(cell, law=WEAK, turns=False, plane="strain", **damping):
    """Two bricks of one shape, the second turned, held by their left faces; or free, in frames that turn."""
    d = dimension_of(cell)
    low, high = (0.0, 0.0, 0.0)[:d], (0.5, 0.2, 0.3)[:d]
    shape = Shape("brick", box(low, high), box_mesh(cell, (2, 1, 1)[:d], low, high, 0.2))
    turn = (
        np.array([[0.6, -0.8], [0.8, 0.6]])
        if d == 2
        else np.array([[0.6, -0.8, 0], [0.8, 0.6, 0], [0, 0, 1.0]])
    )
    poses = [Pose(np.eye(d), np.zeros(d)), Pose(turn, np.ones(d))]
    assembly = Assembly(d, (shape,), tuple(Block(f"b{i}", 0, pose) for i, pose in enumerate(poses)))
    law = PlaneStress(law) if plane == "stress" else law
    material = ElasticMaterial(1e7, 0.2, 2400.0, law=law, **damping)
    clamps = None if turns else {0: [Clamp(0)], 1: [Clamp(0)]}
    plane = plane if d == 2 else None
    (group,) = elastic_groups(assembly, {0: material, 1: material}, clamps, plane, turns=turns)
    return group


def settled(group, state, force, scheme, rounds=30):
    """A step without contact, by Newton's rounds; the state and the residuals of the rounds."""
    made, left = None, []
    for _ in range(rounds):
        free = group.free(state, state, force, scheme, made)
        mass = np.where(free.rigid_mass > 0, free.rigid_mass, 1.0)
        made = group.advance(state, free, free.rigid_velocity + free.rigid_impulse / mass, None, scheme)
        impulse = np.zeros_like(free.rigid_velocity)
        residual = group.imbalance(state, made, made, force, impulse, None, scheme)
        left.append(float((residual / group.effort(made, scheme)).max()))
        if left[-1] <= 1e-13:
            break
    return made, left


@pytest.mark.parametrize("cell", CELLS)
def test_stiffness_of_elastic_moduli_is_that_of_the_elastic_stone(cell):
    group = stones(cell)
    strains = Strains.of(group.mesh)
    moduli = np.broadcast_to(group.constitution._elastic.matrix, (*strains.weight.shape, 6, 6))
    elastic = group.operators.stiffness
    assert abs(strains.stiffness(moduli) - elastic).max() <= 1e-13 * abs(elastic).max()


@pytest.mark.parametrize("cell", CELLS)
def test_strains_and_forces_of_an_affine_field(cell):
    """Strains of x → A x are the symmetric part of A, and forces of a uniform stress do its work."""
    group, random = stones(cell), np.random.default_rng(1)
    d, strains = group.dimension, group.constitution.strains
    A = random.normal(size=(d, d))
    field = (group.mesh.points @ A.T).ravel()[None]
    strain = strains.at_points(np.repeat(field, 2, axis=0))
    full = np.zeros((3, 3))
    full[:d, :d] = A + A.T
    expected = [full[0, 0] / 2, full[1, 1] / 2, full[2, 2] / 2, full[0, 1], full[1, 2], full[0, 2]]
    np.testing.assert_allclose(strain, np.broadcast_to(expected, strain.shape), atol=1e-12)
    stress = random.normal(size=6)
    forces = strains.forces(np.broadcast_to(stress, strain.shape))
    volume = group.mass[0] / group.operators.material.density
    np.testing.assert_allclose(forces @ field[0], volume * (stress @ expected), rtol=1e-11)


def push(group):
    """More than the weak stones bear elastically, on all nodes."""
    d = group.dimension
    force = group.acceleration_force(np.array([4.0, -9.81, 3.0])[:d])
    return 4.0 * force


@pytest.mark.parametrize("scheme", SCHEMES, ids=str)
@pytest.mark.parametrize(
    ("cell", "plane"), [(cell, "strain") for cell in CELLS] + [("quad", "stress"), ("triangle6", "stress")]
)
def test_rounds_settle_and_the_energy_of_the_step_is_complete(cell, plane, scheme):
    group = stones(cell, plane=plane, mass_damping=0.3, stiffness_damping=2e-3)
    force, state, yielded = push(group), group.rest(), set()
    stored = [group.strain_energy, group.kinetic_energy] if scheme.inertia else [group.strain_energy]
    for _ in range(4 if scheme.inertia else 1):
        before = state
        state, left = settled(group, before, force, scheme)
        assert left[-1] <= 1e-12, left
        yielded |= set(state.memory.yielding.tolist())
        gained = sum(energy(state) - energy(before) for energy in stored)
        spent = group.step_energy(before, state, force, None, scheme)
        given = spent.external - spent.damping - spent.numerical - spent.dissipation
        np.testing.assert_allclose(gained, given, atol=1e-10 * np.abs(spent.external).max())
        assert (spent.dissipation >= 0).all()
    assert yielded == {0, 1}
    assert (group.material_state(state)["plastic_strain"].max(axis=(1, 2)) > 0).all()


def pinched(group):
    """Forces that balance and are more than the weak stones bear: both ends pulled apart along the axis."""
    force, points = group.no_force(), group.mesh.points
    ends = points[:, 0] - points[:, 0].mean()
    force.reshape(group.count, -1, group.dimension)[..., 0] = 4e3 * np.sign(ends) * (np.abs(ends) > 0.24)
    return force


@pytest.mark.parametrize("scheme", SCHEMES, ids=str)
@pytest.mark.parametrize("cell", ["quad", "hexahedron"])
def test_stones_that_turn_yield_as_those_that_do_not(cell, scheme):
    """Loads that have turned with a frame strain it alike, and the energy of the step is complete."""
    group = stones(cell, turns=True, mass_damping=0.3, stiffness_damping=2e-3)
    d, force = group.dimension, pinched(group)
    turn = change(np.array([[0.9, -1.2, 2.0]])[:, -(2 * d - 3) :])
    state = replace(group.rest(), turned=np.concatenate([0 * turn, turn]))
    force[1] = (force[1].reshape(-1, d) @ state.rotation[1].T).ravel()
    made, left = settled(group, state, force, scheme)
    assert left[-1] <= 1e-12, left
    assert made.memory.yielding.tolist() == [0, 1]
    own, size = made.memory.stress, np.abs(made.memory.stress).max()
    np.testing.assert_allclose(own[1], own[0], atol=1e-10 * size)
    np.testing.assert_allclose(made.turned, state.turned, atol=1e-10)
    spent = group.step_energy(state, made, force, None, scheme)
    given = spent.external - spent.damping - spent.numerical - spent.dissipation
    kinetic = group.kinetic_energy(made) if scheme.inertia else 0.0
    np.testing.assert_allclose(
        group.strain_energy(made) + kinetic, given, atol=1e-10 * np.abs(spent.external).max()
    )
    assert (spent.dissipation > 0).all()


@pytest.mark.parametrize("plane", ["strain", "stress"])
def test_the_order_of_newton_is_two(plane):
    """Fitted to the residuals that are neither of the way there nor below what the tangent's share leaves."""
    for law in (WEAK, DruckerPrager(1e4, 30.0, hardening=2e6), DruckerPrager(1e4, 30.0, 0.0, hardening=2e6)):
        group = stones("quad9", law, plane=plane)
        _, left = settled(group, group.rest(), push(group), SCHEMES[2])
        used = [value for value in left if 1e-11 < value < 1e-1]
        orders = np.diff(np.log(used))
        assert len(orders) >= 2, left
        assert orders[-1] / orders[-2] >= 1.8, left


def test_only_blocks_that_yield_have_factors_of_their_own():
    group = stones("hexahedron")
    force, state = push(group), group.rest()
    force[1] *= 1e-3
    made, _ = settled(group, state, force, SCHEMES[2])
    assert made.memory.yielding.tolist() == [0]
    assert list(group.tangents(made, SCHEMES[2])) == [0]
    assert group.tangents(None, SCHEMES[2]) == {}
    count = group.factorisations
    group.tangents(made, SCHEMES[2])
    assert group.factorisations == count


def test_turned_stones_yield_alike():
    """The second stone is the first one turned; so are its loads: stresses are the same, turned."""
    group = stones("tetra10")
    force = push(group)
    force[1] = force[0]
    made, _ = settled(group, group.rest(), force, SCHEMES[2])
    np.testing.assert_allclose(
        made.memory.stress[1], made.memory.stress[0], atol=1e-10 * np.abs(made.memory.stress).max()
    )
    world = group.stress(made).gauss
    mean = np.abs(world[1] - world[0]).max()
    assert mean > 1e-2 * np.abs(world).max()  # in the world's axes they differ


def test_what_is_unloaded_keeps_its_plastic_strain():
    group = stones("quad")
    loaded, _ = settled(group, group.rest(), push(group), SCHEMES[2])
    free, left = settled(group, loaded, 0.0 * push(group), SCHEMES[2])
    assert left[-1] <= 1e-12
    first, second = (group.material_state(state)["plastic_strain"] for state in (loaded, free))
    assert (second >= first).all()
    assert np.abs(free.displacement).max() > 0
    assert np.abs(free.memory.stress).max() < np.abs(loaded.memory.stress).max()
