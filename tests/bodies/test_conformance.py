"""What every free body group owes the solver, whatever it is made of (architecture: Body)."""

import numpy as np
import pytest

from masonry_fem.bodies.base import Scheme, by_block
from tests.bodies.groups import DENSITY, FREE_GROUPS, bricks, sides_of

CASES = [(name, dimension) for name in FREE_GROUPS for dimension in (2, 3)]
SCHEMES = [Scheme(0.02, 0.5), Scheme(0.5, 1.0), Scheme(1e-3, 0.7)]


@pytest.fixture(params=CASES, ids=lambda case: f"{case[0]}-{case[1]}d")
def made(request):
    name, dimension = request.param
    assembly = bricks(dimension)
    group = FREE_GROUPS[name](assembly)
    sides = sides_of(group, assembly)
    return group, assembly, sides, group.attach(sides)


def volumes(assembly):
    return np.array([assembly.solid(i).mass_properties().volume for i in range(len(assembly.blocks))])


def rigid_map(group, state, sides, attachment):
    """B over all sides, shape (k d, b m)."""
    local = attachment.rigid_map(state, sides.point + attachment.displacements(state), sides.frame)
    k, d, m = local.shape
    full = np.zeros((k, d, len(group.blocks), m))
    full[np.arange(k), :, sides.body] = local
    return full.reshape(k * d, -1)


def delassus(group, state, sides, attachment, scheme):
    """W of the sides, as the split form puts it together, shape (k d, k d)."""
    free = group.free(state, state, group.acceleration_force(np.zeros(sides.point.shape[1])), scheme)
    rigid = rigid_map(group, state, sides, attachment)
    total = rigid / free.rigid_mass.ravel() @ rigid.T
    d = sides.point.shape[1]
    for members, matrix in attachment.compliance(scheme, sides.frame):
        dofs = (np.asarray(members)[:, None] * d + np.arange(d)).ravel()
        total[np.ix_(dofs, dofs)] += matrix
    return total


def step(group, state, sides, attachment, scheme, force, impulses):
    """One step under given side impulses (k, d) in the frames; returns state and Bᵀp, Gᵀp."""
    free = group.free(state, state, force, scheme)
    turned = (rigid_map(group, state, sides, attachment).T @ impulses.ravel()).reshape(
        free.rigid_velocity.shape
    )
    velocity = free.rigid_velocity + (free.rigid_impulse + turned) / free.rigid_mass
    nodal = attachment.spread(impulses, sides.frame)
    return group.advance(state, free, velocity, nodal, scheme), turned, nodal


def side_velocity(group, before, after, sides, attachment):
    """Velocities of the sides at the end of a step, in the frames, by the map of its start."""
    rigid, elastic = group.velocity_parts(after)
    velocity = (rigid_map(group, before, sides, attachment) @ rigid.ravel()).reshape(sides.point.shape)
    return velocity if elastic is None else velocity + attachment.elastic_velocity(elastic, sides.frame)


@pytest.mark.parametrize("scheme", SCHEMES, ids=str)
def test_delassus_is_symmetric_positive_semidefinite(made, scheme):
    group, _, sides, attachment = made
    matrix = delassus(group, group.rest(), sides, attachment, scheme)
    size = np.abs(matrix).max()
    assert np.abs(matrix - matrix.T).max() <= 1e-12 * size
    assert np.linalg.eigvalsh(0.5 * (matrix + matrix.T)).min() >= -1e-10 * size


@pytest.mark.parametrize("scheme", SCHEMES, ids=str)
def test_delassus_columns_are_answers_to_unit_impulses(made, scheme):
    group, _, sides, attachment = made
    state, nothing = group.rest(), group.acceleration_force(np.zeros(sides.point.shape[1]))
    matrix = delassus(group, state, sides, attachment, scheme)
    for column in range(0, len(matrix), 5):
        impulses = np.zeros(sides.point.shape)
        impulses.ravel()[column] = 1.0
        after, _, _ = step(group, state, sides, attachment, scheme, nothing, impulses)
        answer = side_velocity(group, state, after, sides, attachment).ravel()
        np.testing.assert_allclose(answer, matrix[:, column], atol=1e-10 * np.abs(matrix).max())


def test_masses(made):
    group, assembly, _, _ = made
    np.testing.assert_allclose(group.mass, DENSITY * volumes(assembly), rtol=1e-12)


def test_rigid_modes_are_mass_orthonormal(made):
    """The U of a unit translation has the block's mass as its square, along any two axes 0."""
    group, _, sides, attachment = made
    state, d = group.rest(), sides.point.shape[1]
    local = attachment.rigid_map(state, sides.point, sides.frame)
    for body, mass in enumerate(group.mass):
        mine = sides.body == body
        modes = local[mine].reshape(-1, local.shape[2])
        translations = sides.frame[mine].reshape(-1, d)  # unit translations, seen in the frames
        U, *_ = np.linalg.lstsq(modes, translations, rcond=None)
        np.testing.assert_allclose(modes @ U, translations, atol=1e-12)
        np.testing.assert_allclose(U.T @ U, mass * np.eye(d), atol=1e-9 * mass)


def test_gravity_has_the_weight_as_resultant(made):
    group, assembly, _, _ = made
    d = assembly.dimension
    gravity = np.array([0.3, -9.81, 1.0])[:d]
    total = group.resultant(group.acceleration_force(gravity))
    centres = np.array([assembly.solid(i).mass_properties().centroid for i in range(len(group.blocks))])
    force = group.mass[:, None] * gravity
    np.testing.assert_allclose(total[:, :d], force, rtol=1e-10, atol=1e-10)
    cross = (
        np.cross(centres, force) if d == 3 else centres[:, :1] * force[:, 1:] - centres[:, 1:] * force[:, :1]
    )
    np.testing.assert_allclose(total[:, d:], cross, rtol=1e-9, atol=1e-8)


def test_point_force_has_its_own_resultant(made):
    group, assembly, _, _ = made
    d = assembly.dimension
    corner, force = assembly.solid(1).vertices[2], np.array([3.0, -5.0, 2.0])[:d]
    total = group.resultant(group.point_force(1, corner, force))
    cross = np.cross(corner, force) if d == 3 else [corner[0] * force[1] - corner[1] * force[0]]
    np.testing.assert_allclose(total[1], [*force, *cross], atol=1e-10)
    assert not total[[0, 2]].any()


@pytest.mark.parametrize("scheme", SCHEMES, ids=str)
def test_inertia_takes_what_loads_and_contacts_give(made, scheme):
    """Newton's second law of each block, by resultants."""
    group, _, sides, attachment = made
    d, random = sides.point.shape[1], np.random.default_rng(3)
    force = group.acceleration_force(np.array([0.3, -9.81, 1.0])[:d])
    impulses = random.normal(size=sides.point.shape) * group.mass.mean() * scheme.step
    state = group.with_velocity(group.rest(), 1, np.ones(d), np.zeros(1 if d == 2 else 3))
    after, _, nodal = step(group, state, sides, attachment, scheme, force, impulses)
    given = group.resultant(force)[:, :d]
    np.add.at(given, sides.body, np.einsum("kai,ka->ki", sides.frame, impulses) / scheme.step)
    taken = group.actions(state, after, force, nodal, scheme).inertia[:, :d]
    assert np.abs(taken - given).max() <= 1e-9 * np.abs(given).max()


def test_closed_surface_under_uniform_pressure_has_no_resultant(made):
    group, assembly, _, _ = made
    solid = assembly.solid(2)
    total = sum(group.traction_force(2, face, -1e5 * solid.normal(face)) for face in range(len(solid.faces)))
    np.testing.assert_allclose(group.resultant(total), 0.0, atol=1e-9 * 1e5)


def test_traction_has_area_times_traction_as_resultant(made):
    group, assembly, _, _ = made
    d, solid = assembly.dimension, assembly.solid(1)
    traction = np.array([2e3, -1e3, 5e2])[:d]
    total = group.resultant(group.traction_force(1, 1, traction))[1]
    force = np.linalg.norm(solid.area_vector(1)) * traction
    middle = solid.face_points(1).mean(axis=0)  # a box's faces have their centroid there
    cross = np.cross(middle, force) if d == 3 else [middle[0] * force[1] - middle[1] * force[0]]
    np.testing.assert_allclose(total, [*force, *cross], rtol=1e-10, atol=1e-8)


@pytest.mark.parametrize("scheme", SCHEMES, ids=str)
def test_momentum_balance_holds_and_sees_a_missing_impulse(made, scheme):
    group, _, sides, attachment = made
    random, d = np.random.default_rng(3), sides.point.shape[1]
    state = group.rest()
    for body in range(len(group.blocks)):
        spin = random.normal(size=1 if d == 2 else 3)
        state = group.with_velocity(state, body, random.normal(size=d), spin)
    force = group.acceleration_force(np.array([0.0, -9.81, 0.0])[:d])
    impulses = random.normal(size=sides.point.shape) * group.mass.mean() * 9.81 * scheme.step
    after, turned, nodal = step(group, state, sides, attachment, scheme, force, impulses)
    weight = group.mass * 9.81 * scheme.step
    residual = group.imbalance(state, state, after, force, turned, nodal, scheme)
    assert (residual <= 1e-9 * weight).all()
    absent = None if nodal is None else np.zeros_like(nodal)
    missing = group.imbalance(state, state, after, force, np.zeros_like(turned), absent, scheme)
    assert (missing > 1e-2 * weight).all()


@pytest.mark.parametrize("theta", [0.5, 0.75, 1.0])
def test_drop_follows_the_theta_rule(theta):
    """s_n = a h² n (n − 1 + 2θ)/2 for a body released from rest (algebra of section 3)."""
    for name, dimension in CASES:
        if name.startswith("damped"):
            continue
        assembly = bricks(dimension)
        group = FREE_GROUPS[name](assembly)
        sides = sides_of(group, assembly)
        attachment = group.attach(sides)
        gravity, h, n = np.array([1.0, -9.81, 0.5])[:dimension], 0.01, 25
        scheme, state = Scheme(h, theta), group.rest()
        force = group.acceleration_force(gravity)
        for _ in range(n):
            state, _, _ = step(group, state, sides, attachment, scheme, force, np.zeros(sides.point.shape))
        fallen = gravity * h**2 * n * (n - 1 + 2 * theta) / 2
        field, velocity = group.displacements(state), group.velocities(state)
        np.testing.assert_allclose(field, np.broadcast_to(fallen, field.shape), atol=1e-10)
        np.testing.assert_allclose(velocity, np.broadcast_to(n * h * gravity, velocity.shape), atol=1e-9)


@pytest.mark.parametrize("scheme", SCHEMES, ids=str)
def test_energy_ledger_of_a_step_is_exact(made, scheme):
    group, _, sides, attachment = made
    random, d = np.random.default_rng(5), sides.point.shape[1]
    state = group.rest()
    for body in range(len(group.blocks)):
        spin = random.normal(size=1 if d == 2 else 3)
        state = group.with_velocity(state, body, random.normal(size=d), spin)
    force = group.acceleration_force(np.array([0.5, -9.81, 0.0])[:d]) + group.point_force(
        0, sides.point[0], np.array([200.0, 100.0, -50.0])[:d]
    )
    impulses = 10 * random.normal(size=sides.point.shape)
    after, _, _ = step(group, state, sides, attachment, scheme, force, impulses)
    start = side_velocity(group, state, state, sides, attachment)
    end = side_velocity(group, state, after, sides, attachment)
    contact = float((impulses * ((1 - scheme.theta) * start + scheme.theta * end)).sum())
    gained = sum(
        float((energy(after) - energy(state)).sum()) for energy in (group.kinetic_energy, group.strain_energy)
    )
    spent = group.step_energy(state, after, force, None, scheme)
    given = contact + float((spent.external - spent.damping - spent.numerical).sum())
    scale = max(abs(gained), abs(contact), float(np.abs(spent.external).sum()))
    assert abs(gained - given) <= 1e-9 * scale
    assert (spent.damping >= -1e-12 * scale).all()


def test_static_step_leaves_mass_out(made):
    """Inertia 0: no rigid mass, and loads in balance with the impulses leave no residual."""
    group, assembly, _, _ = made
    d, scheme, state = assembly.dimension, Scheme(0.25, 1.0, 0.0), group.rest()
    force = group.acceleration_force(np.array([0.0, -9.81, 2.0])[:d])
    free = group.free(state, state, force, scheme)
    assert not free.rigid_mass.any()
    velocity = np.full_like(free.rigid_velocity, 0.01)
    nodal = None if free.elastic is None else np.zeros_like(free.elastic)
    after = group.advance(state, free, velocity, nodal, scheme)
    assert not group.actions(state, after, force, nodal, scheme).inertia.any()
    unbalanced = group.imbalance(state, state, after, force, np.zeros_like(velocity), nodal, scheme)
    np.testing.assert_allclose(
        unbalanced, scheme.step * group.mass * np.linalg.norm([9.81, *[2.0] * (d - 2)])
    )
    if nodal is None:
        held = group.imbalance(state, state, after, force, -free.rigid_impulse, nodal, scheme)
        assert (held <= 1e-12 * unbalanced).all()


def test_with_velocity_moves_one_block(made):
    group, assembly, _, _ = made
    d = assembly.dimension
    velocity, spin = np.array([1.0, -2.0, 0.5])[:d], np.array([0.2, 0.4, -0.7])[: 1 if d == 2 else 3]
    state = group.with_velocity(group.rest(), 2, velocity, spin)
    arms = group.nodes(2) - assembly.solid(2).mass_properties().centroid
    turning = np.cross(spin, arms) if d == 3 else spin * np.column_stack([-arms[:, 1], arms[:, 0]])
    still, _, moving = by_block(group, group.velocities(state))
    np.testing.assert_allclose(moving, velocity + turning, atol=1e-10)
    assert not still.any()
    inertia = DENSITY * assembly.solid(2).mass_properties().inertia
    energy = 0.5 * group.mass[2] * velocity @ velocity + 0.5 * spin @ inertia @ spin
    np.testing.assert_allclose(group.kinetic_energy(state), [0, 0, energy], atol=1e-9 * energy)
    halved = group.kinetic_energy(group.scale_velocity(state, 0.5))
    np.testing.assert_allclose(halved, [0, 0, energy / 4], atol=1e-9 * energy)
