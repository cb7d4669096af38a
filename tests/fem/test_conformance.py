"""Stones that deform pass the tests of every free body group; those tests are imported by name."""

import numpy as np
import pytest

from masonry_fem.bodies.base import Scheme
from masonry_fem.bodies.rotation import exponential
from masonry_fem.fidelities import deforms, fidelities
from masonry_fem.scene.specs import Damping, Material
from masonry_fem.solid.assembly import Assembly, Block, Shape
from masonry_fem.solid.pose import Pose
from tests.bodies import groups
from tests.bodies.groups import DENSITY, LAW, STONE, sides_of
from tests.bodies.test_conformance import step as advance
from tests.bodies.test_conformance import (  # noqa: F401 - collected here with this file's fixture
    test_closed_surface_under_uniform_pressure_has_no_resultant,
    test_delassus_columns_are_answers_to_unit_impulses,
    test_delassus_is_symmetric_positive_semidefinite,
    test_energy_ledger_of_a_step_is_exact,
    test_gravity_has_the_weight_as_resultant,
    test_inertia_takes_what_loads_and_contacts_give,
    test_masses,
    test_momentum_balance_holds_and_sees_a_missing_impulse,
    test_point_force_has_its_own_resultant,
    test_rigid_modes_are_mass_orthonormal,
    test_static_step_leaves_mass_out,
    test_traction_has_area_times_traction_as_resultant,
)
from tests.bodies.test_conformance import test_with_velocity_moves_one_block as moves_one_block
from tests.fem.meshes import box, box_mesh

DAMPED = Material(
    density=DENSITY, young=1e7, poisson=0.2, damping=Damping(mass=0.7, stiffness=1e-3), inelastic=LAW
)
KINDS = [name for name in fidelities() if deforms(name)]
CASES = [
    ("hexahedron", STONE, False), ("hexahedron", DAMPED, True), ("tetra", STONE, False),
    ("hexahedron27", STONE, False), ("tetra10", DAMPED, True), ("quad", STONE, False),
    ("triangle", DAMPED, False), ("quad9", STONE, True), ("triangle6", STONE, False),
]  # fmt: skip


def bricks(cell):
    """Three bricks of one shape, turned in space."""
    d = 2 if cell.startswith(("quad", "tri")) else 3
    low, high = (0.0, 0.0, 0.0)[:d], (0.5, 0.2, 0.3)[:d]
    shape = Shape("brick", box(low, high), box_mesh(cell, (2, 1, 1)[:d], low, high, 0.2))
    turns = np.array([[0.0, 0.0, 0.0], [0.3, -0.5, 0.8], [-0.2, 0.9, 0.1]])
    turns = turns if d == 3 else turns[:, 2:]
    shifts = np.array([[0.0, 0.0, 0.0], [1.0, 2.0, -0.5], [-3.0, 0.4, 1.0]])[:, :d]
    poses = [Pose(exponential(turn), shift) for turn, shift in zip(turns, shifts, strict=True)]
    return Assembly(d, (shape,), tuple(Block(f"b{i}", 0, pose) for i, pose in enumerate(poses)))


@pytest.fixture(
    scope="module",
    params=[(kind, turns, *case) for kind in KINDS for turns in (True, False) for case in CASES],
    ids=lambda case: "-".join(map(str, (case[0], "turns" if case[1] else "small", case[2], case[4]))),
)
def made(request):
    kind, turns, cell, material, lumped = request.param
    assembly = bricks(cell)
    group = groups.made(kind, assembly, material, lumped=lumped, turns=turns)
    sides = sides_of(group, assembly)
    return group, assembly, sides, group.attach(sides)


def test_with_velocity_moves_one_block(made, request):
    if request.node.callspec.params["made"][4]:
        pytest.skip("a lumped mass has not the solid's exact inertia")
    moves_one_block(made)


@pytest.mark.parametrize("theta", [0.5, 0.75, 1.0])
def test_drop_follows_the_theta_rule(made, theta):
    group, _, sides, attachment = made
    if group.operators.material.mass_damping:
        pytest.skip("a damped body falls more slowly")
    d, h, n = group.dimension, 0.01, 25
    gravity, scheme, state = np.array([1.0, -9.81, 0.5])[:d], Scheme(h, theta), group.rest()
    force = group.acceleration_force(gravity)
    for _ in range(n):
        state, _, _ = advance(group, state, sides, attachment, scheme, force, np.zeros(sides.point.shape))
    fallen = gravity * h**2 * n * (n - 1 + 2 * theta) / 2
    field, velocity = group.displacements(state), group.velocities(state)
    np.testing.assert_allclose(field, np.broadcast_to(fallen, field.shape), atol=1e-10)
    np.testing.assert_allclose(velocity, np.broadcast_to(n * h * gravity, velocity.shape), atol=1e-9)
    assert group.strain_energy(state).max() <= 1e-20 * group.kinetic_energy(state).min()
