"""Elastic blocks: closed forms, clamps fixed and moving, and the independent reference A10.1."""

from dataclasses import replace

import numpy as np
import pytest

from masonry_fem.bodies.base import Scheme, Sides, by_block
from masonry_fem.bodies.rotation import exponential
from masonry_fem.bodies.support import Clamp, Motion
from masonry_fem.errors import GeometryError
from masonry_fem.fem.groups import elastic_groups
from masonry_fem.fem.material import ElasticMaterial
from masonry_fem.output.strength import von_mises
from masonry_fem.solid.assembly import Assembly, Block, Shape
from masonry_fem.solid.pose import Pose
from tests.fem.meshes import box, box_mesh

STONE = ElasticMaterial(10e9, 0.2, 2400.0)
STATIC = Scheme(1.0, 1.0, 0.0)
LEFT, RIGHT, FRONT, BACK, BOTTOM, TOP = range(6)


def one(cell, counts, high, poses=None):
    d = len(counts)
    low = (0.0,) * d
    shape = Shape("block", box(low, high), box_mesh(cell, counts, low, high))
    poses = poses or [Pose.identity(d)]
    return Assembly(d, (shape,), tuple(Block(f"b{i}", 0, pose) for i, pose in enumerate(poses)))


def statics(group, force):
    """One static step without contact."""
    state = group.rest()
    free = group.free(state, state, force, STATIC)
    after = group.advance(state, free, np.zeros_like(free.rigid_velocity), None, STATIC)
    impulse = np.zeros_like(free.rigid_velocity)
    # forces in K q cancel to the rounding of its terms
    rounding = 1e-15 * np.abs(group.operators.stiffness.data).max() * np.linalg.norm(after.displacement)
    assert group.imbalance(state, after, after, force, impulse, None, STATIC).max() <= 4 * rounding
    return after


def test_reference_a10_1_where_the_joint_sticks():
    """validation.md A10.1, t = 0.1 MPa: the closed joint is as bonded; 8³ cells a cube."""
    assembly = one("hexahedron", (8, 8, 16), (1.0, 1.0, 2.0))
    (group,) = elastic_groups(assembly, {0: STONE}, {0: [Clamp(BOTTOM)]})
    force = group.traction_force(0, TOP, np.array([0.1e6, 0.0, -1e6]))
    force += group.acceleration_force(np.array([0.0, 0.0, -9.81]))
    state = statics(group, force)
    top_edge = 1e6 * group.displacement(state, 0, np.array([1.0, 0.5, 2.0]))
    np.testing.assert_allclose(top_edge[[0, 2]], [380.726, -324.486], atol=0.0006)  # digits printed there
    assert von_mises(group.stress(state).gauss).max() / 1e6 == pytest.approx(2.384, abs=0.0006)
    reaction = group.clamp_reactions(group.rest(), state, force, None, STATIC)["b0/bottom"]
    np.testing.assert_allclose(reaction[:3], [-1e5, 0.0, 1_047_088.0], rtol=1e-9, atol=1e-9 * 1_047_088)


@pytest.mark.parametrize("cell", ["hexahedron", "tetra", "hexahedron27", "tetra10"])
def test_bar_settles_by_rho_g_l_squared_over_two_e(cell):
    """Own weight, ν = 0: uz(L) = −ρ g L²/(2E), σzz(0) = −ρ g L; nodal values of order 1 are exact too."""
    material = replace(STONE, poisson=0.0)
    assembly = one(cell, (1, 1, 4), (0.5, 0.5, 2.0))
    (group,) = elastic_groups(assembly, {0: material}, {0: [Clamp(BOTTOM)]})
    state = statics(group, group.acceleration_force(np.array([0.0, 0.0, -9.81])))
    exact = -2400 * 9.81 * 2.0**2 / (2 * 10e9)
    tolerance = 1e-9 if "hex" in cell else 1e-2  # simplices couple the sides with the axis
    assert group.displacement(state, 0, np.array([0.25, 0.25, 2.0]))[2] == pytest.approx(exact, rel=tolerance)
    if cell == "hexahedron27":
        bottom = group.stress(state).nodal[0][group.nodes(0)[:, 2] == 0]
        np.testing.assert_allclose(bottom[:, 2], -2400 * 9.81 * 2.0, rtol=1e-9)


@pytest.mark.parametrize("plane", ["strain", "stress"])
def test_cantilever_deflects_as_a_timoshenko_beam(plane):
    """P L³/3EI + P L/(κ G A), with E/(1 − ν²) in plane strain; Q2, slender: within 0.5 %."""
    length, height, load = 4.0, 0.25, 1e4
    assembly = one("quad9", (24, 2), (length, height))
    (group,) = elastic_groups(assembly, {0: STONE}, {0: [Clamp(0)]}, plane)
    state = statics(group, group.traction_force(0, 1, np.array([0.0, -load / height])))
    young = STONE.young / (1 - STONE.poisson**2) if plane == "strain" else STONE.young
    shear = STONE.young / (2 * (1 + STONE.poisson))
    exact = load * length**3 / (3 * young * height**3 / 12) + load * length / (5 / 6 * shear * height)
    tip = group.displacement(state, 0, np.array([length, height / 2]))
    assert -tip[1] == pytest.approx(exact, rel=5e-3)


def test_turned_blocks_of_one_shape_share_a_group_and_do_the_same():
    poses = [Pose.identity(3), Pose(exponential(np.array([0.4, -0.3, 1.1])), np.array([3.0, 1.0, -2.0]))]
    assembly = one("hexahedron", (2, 2, 3), (0.4, 0.5, 0.9), poses)
    clamps = {0: [Clamp(BOTTOM)], 1: [Clamp(BOTTOM)]}
    (group,) = elastic_groups(assembly, {0: STONE, 1: STONE}, clamps)
    turn, load = poses[1].rotation, np.array([2e5, -1e5, -3e5])
    force = group.traction_force(0, TOP, load) + group.traction_force(1, TOP, turn @ load)
    state = statics(group, force)
    straight, turned = by_block(group, group.displacements(state))
    np.testing.assert_allclose(turned, straight @ turn.T, atol=1e-12 * np.abs(straight).max())
    np.testing.assert_allclose(group.strain_energy(state)[1], group.strain_energy(state)[0], rtol=1e-11)
    stress = group.stress(state)
    np.testing.assert_allclose(von_mises(stress.gauss[1]), von_mises(stress.gauss[0]), rtol=1e-9)
    world = group.clamp_reactions(group.rest(), state, force, None, STATIC)["b1/bottom"]
    np.testing.assert_allclose(world[:3], -(turn @ load) * 0.2, rtol=1e-9)


def test_partial_clamps_hold_world_axes_of_a_turned_block():
    """A turned block on rollers in world x: it spreads freely along the others under σxx."""
    turn = exponential(np.array([0.0, 0.0, 0.7]))
    assembly = one("hexahedron", (2, 1, 1), (0.4, 0.2, 0.2), [Pose(turn, np.array([1.0, 0.0, 0.0]))])
    (group,) = elastic_groups(assembly, {0: STONE}, {0: [Clamp(LEFT, (0,))]})
    state = group.rest()
    free = group.free(state, state, group.acceleration_force(np.array([3.0, 5.0, -9.81])), Scheme(1e-3, 0.5))
    after = group.advance(state, free, free.rigid_velocity + free.rigid_impulse, None, Scheme(1e-3, 0.5))
    on_face = np.abs((group.nodes(0) - [1.0, 0.0, 0.0]) @ turn[:, 0]) < 1e-9
    assert on_face.sum() == 4
    velocity = group.velocities(after)
    assert np.abs(velocity[on_face, 0]).max() <= 1e-15
    np.testing.assert_allclose(velocity[:, 1:], np.tile([5e-3, -9.81e-3], (len(velocity), 1)), rtol=0.2)
    np.testing.assert_allclose(group.modes.count, 3)


def test_reactions_of_a_face_clamped_twice_add_up():
    assembly = one("hexahedron", (2, 2, 2), (0.4, 0.4, 0.4))
    clamps = [Clamp(BOTTOM, (2,)), Clamp(BOTTOM, (0, 1))]
    (group,) = elastic_groups(assembly, {0: STONE}, {0: clamps})
    force = group.acceleration_force(np.array([1.0, 2.0, -9.81]))
    state = statics(group, force)
    reactions = group.clamp_reactions(group.rest(), state, force, None, STATIC)
    assert list(reactions) == ["b0/bottom"]
    np.testing.assert_allclose(reactions["b0/bottom"], -group.resultant(force)[0], rtol=1e-9, atol=1e-7)


def test_clamp_turns_about_the_middle_of_its_face():
    """A base that turns by 1 µrad carries the block along rigidly."""
    motion = Motion(rotation=lambda t: np.array([0.0, 1e-6 * t, 0.0]))
    assembly = one("hexahedron", (2, 2, 2), (0.4, 0.4, 0.8))
    (group,) = elastic_groups(assembly, {0: STONE}, {0: [Clamp(BOTTOM, None, motion)]})
    state = statics(group, group.no_force())
    arms = group.nodes(0) - [0.2, 0.2, 0.0]
    expected = np.cross([0.0, 1e-6, 0.0], arms)
    np.testing.assert_allclose(group.displacements(state), expected, atol=1e-12)


def test_moving_clamp_carries_a_static_block_along():
    """Statics: base lifted by 1 mm and pushed by 2 mm: the whole block follows, without stress."""
    motion = Motion(displacement=lambda t: np.array([2e-3, 0.0, 1e-3]) * t)
    assembly = one("hexahedron", (2, 2, 2), (0.4, 0.4, 0.4))
    (group,) = elastic_groups(assembly, {0: STONE}, {0: [Clamp(BOTTOM, None, motion)]})
    state = statics(group, group.no_force())
    field = group.displacements(state)
    np.testing.assert_allclose(field, np.tile([2e-3, 0.0, 1e-3], (len(field), 1)), atol=1e-14)
    assert np.abs(group.stress(state).gauss).max() <= 1e-4  # of E · 2e-3/0.4 = 5e7 Pa: rounding


@pytest.mark.parametrize("theta", [0.5, 1.0])
def test_shaken_base_balances_energy_and_momentum(theta):
    """A clamp that oscillates: reaction = change of momentum, work of the clamp = gain + loss."""
    motion = Motion(displacement=lambda t: np.array([1e-3 * np.sin(200 * t), 0.0, 0.0]))
    assembly = one("hexahedron", (2, 1, 3), (0.4, 0.3, 0.9))
    damped = replace(STONE, young=1e8, mass_damping=0.3, stiffness_damping=1e-4)
    (group,) = elastic_groups(assembly, {0: damped}, {0: [Clamp(BOTTOM, None, motion)]})
    scheme, state, force = Scheme(5e-4, theta), group.rest(), group.no_force()
    for _ in range(30):
        free = group.free(state, state, force, scheme)
        after = group.advance(state, free, free.rigid_velocity, None, scheme)
        spent = group.step_energy(state, after, force, None, scheme)
        gain = (group.kinetic_energy(after) + group.strain_energy(after)) - (
            group.kinetic_energy(state) + group.strain_energy(state)
        )
        total = spent.external + spent.support - spent.damping - spent.numerical
        scale = group.kinetic_energy(after) + group.strain_energy(after)
        np.testing.assert_allclose(gain, total, atol=1e-10 * scale.max())
        residual = group.imbalance(state, after, after, force, np.zeros((1, 6)), None, scheme)
        assert residual.max() <= 1e-10 * np.sqrt(2 * scale * group.mass).max()
        state = after
    base = group.nodes(0)[:, 2] == 0
    reached = group.displacements(state)[base, 0]
    np.testing.assert_allclose(reached, 1e-3 * np.sin(200 * state.time), atol=1e-12 if theta == 1 else 2e-5)


def test_partial_moving_clamp_pushes_the_rigid_modes():
    """Rollers that push in x: in free dynamics momentum along x is the rollers' impulse, no other."""
    motion = Motion(displacement=lambda t: np.array([0.05 * t**2, 0.0, 0.0]))
    assembly = one("hexahedron", (2, 1, 1), (0.4, 0.2, 0.2))
    (group,) = elastic_groups(assembly, {0: replace(STONE, young=1e7)}, {0: [Clamp(LEFT, (0,), motion)]})
    scheme, state = Scheme(1e-3, 1.0), group.rest()
    force = group.acceleration_force(np.array([0.0, 0.0, -9.81]))
    for _ in range(20):
        free = group.free(state, state, force, scheme)
        velocity = free.rigid_velocity + free.rigid_impulse / free.rigid_mass
        after = group.advance(state, free, velocity, None, scheme)
        residual = group.nodal_residual(state, after, force, None, scheme)[0].reshape(-1, 3)
        total = residual.sum(axis=0)
        np.testing.assert_allclose(total[1:], 0.0, atol=1e-12 * group.mass[0])
        spent = group.step_energy(state, after, force, None, scheme)
        before = group.kinetic_energy(state) + group.strain_energy(state)
        gain = group.kinetic_energy(after) + group.strain_energy(after) - before
        np.testing.assert_allclose(
            gain, spent.external + spent.support - spent.numerical, atol=1e-9 * abs(gain).max()
        )
        state = after
    fall = group.velocities(state)[:, 2].mean()
    assert fall == pytest.approx(-9.81 * state.time, rel=1e-3)


def test_free_vibration_has_the_frequency_of_a_bar():
    """Fixed-free bar, ν = 0: f₁ = √(E/ρ)/(4L); θ = ½ keeps its energy."""
    material = replace(STONE, poisson=0.0)
    length = 2.0
    assembly = one("hexahedron27", (1, 1, 4), (0.2, 0.2, length))
    (group,) = elastic_groups(assembly, {0: material}, {0: [Clamp(BOTTOM)]})
    period = 4 * length / np.sqrt(material.young / material.density)
    shape = np.sin(np.pi * group.nodes(0)[:, 2] / (2 * length))
    start = np.zeros((1, group.mesh.points.size))
    start[0, 2::3] = 1e-5 * shape
    state, steps = replace(group.rest(), displacement=start), 200
    energy, scheme = group.strain_energy(state)[0], Scheme(period / steps, 0.5)
    for _ in range(steps):
        free = group.free(state, state, group.no_force(), scheme)
        state = group.advance(state, free, free.rigid_velocity, None, scheme)
    assert group.kinetic_energy(state)[0] + group.strain_energy(state)[0] == pytest.approx(energy, rel=1e-9)
    np.testing.assert_allclose(state.displacement, start, atol=1e-3 * 1e-5)


def test_static_contact_answer_is_the_springs_own():
    """A free bar pressed at both ends by p/h: it shortens by F L/(E A), from W_el alone."""
    material = replace(STONE, poisson=0.0)
    assembly = one("hexahedron", (1, 1, 4), (0.5, 0.5, 2.0))
    (group,) = elastic_groups(assembly, {0: material})
    ends = [(x, y, z) for z in (0.0, 2.0) for x in (0.0, 0.5) for y in (0.0, 0.5)]
    frame = np.array([[[0, 0, 1.0], [1, 0, 0], [0, 1, 0]]] * 4 + [[[0, 0, -1.0], [0, 1, 0], [1, 0, 0]]] * 4)
    facets = np.array([np.flatnonzero(group.mesh.facet_face == face)[0] for face in (BOTTOM, TOP)])
    sides = Sides(np.arange(8), np.zeros(8, int), np.zeros(8, int), np.array(ends), facets.repeat(4), frame)
    attachment = group.attach(sides)
    ((rows, compliance),) = attachment.compliance(Scheme(0.5, 1.0, 0.0), frame)
    impulse = np.zeros((8, 3))
    impulse[:, 0] = 0.5 * 1e5 / 4  # 1e5 N at each end over h = 0.5 s
    velocity = (compliance @ impulse[rows].ravel()).reshape(8, 3)
    approach = 0.5 * (velocity[0, 0] + velocity[4, 0])
    assert approach == pytest.approx(1e5 * 2.0 / (10e9 * 0.25), rel=1e-10)


def test_points_outside_and_blocks_without_mesh_are_refused():
    assembly = one("hexahedron", (1, 1, 1), (1.0, 1.0, 1.0))
    (group,) = elastic_groups(assembly, {0: STONE})
    with pytest.raises(GeometryError, match="block 'b0', point"):
        group.displacement(group.rest(), 0, np.array([0.5, 0.5, 3.0]))
    bare = Assembly(3, (Shape("bare", box((0, 0, 0), (1, 1, 1))),), (Block("k", 0, Pose.identity(3)),))
    with pytest.raises(GeometryError, match="block 'k' is elastic but its shape 'bare' has no mesh"):
        elastic_groups(bare, {0: STONE})


def test_groups_follow_mesh_material_and_clamps():
    assembly = one("hexahedron", (1, 1, 1), (1.0, 1.0, 1.0), [Pose.at(2.0 * i, 0.0, 0.0) for i in range(5)])
    soft = replace(STONE, young=1e6)
    groups = elastic_groups(assembly, {0: STONE, 1: soft, 2: STONE, 4: STONE}, {4: [Clamp(BOTTOM)]})
    assert [group.blocks.tolist() for group in groups] == [[0, 2], [1], [4]]
    assert groups[0].operators is groups[2].operators
