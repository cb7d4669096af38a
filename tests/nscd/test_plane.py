"""PlaneForm: what moves in a plane only is found, and solved there, whatever its axes and frames."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from masonry_fem.nscd import SolverSettings, assess, solve
from masonry_fem.nscd.plane import plane_form
from tests.nscd import walls
from tests.nscd.plain_form import condensed

SLIDES = {"friction": 0.4, "horizontal": 0.45}


def turned(problem, rotation):
    """The same problem in other axes: translations by the rotation, each block's spins by one of its own."""
    b = problem.body_count
    change = np.zeros((b + 1, 6, 6))
    change[:, :3, :3] = rotation.as_matrix()
    change[:, 3:, 3:] = Rotation.random(b + 1, random_state=1).as_matrix()
    twist = np.zeros((problem.count, 3, 3))  # the tangents' own turn about the normal
    angle = np.random.default_rng(2).uniform(0, 2 * np.pi, problem.count)
    twist[:, 0, 0] = 1.0
    twist[:, 1, 1] = twist[:, 2, 2] = np.cos(angle)
    twist[:, 1, 2], twist[:, 2, 1] = np.sin(angle), -np.sin(angle)
    return replace(
        problem,
        rigid_map=twist[:, None] @ problem.rigid_map @ change[problem.bodies].transpose(0, 1, 3, 2),
        rigid_impulse=np.einsum("bij,bj->bi", change[:b], problem.rigid_impulse),
        rigid_velocity=np.einsum("bij,bj->bi", change[:b], problem.rigid_velocity),
        free_velocity=np.einsum("cij,cj->ci", twist, problem.free_velocity),
    )


@pytest.mark.parametrize("seed", [None, 3, 4])
def test_a_solution_in_the_plane_is_one_in_space(seed):
    wall = walls.rigid_wall(6, 5, **SLIDES)
    if seed is not None:
        wall = turned(wall, Rotation.random(random_state=seed))
    form = plane_form(wall)
    assert form is not None
    assert form.problem.dimension == 2
    assert 2 * form.problem.count == wall.count  # front and back
    made = solve(form.problem, SolverSettings(tolerance=1e-10))
    assert made.converged
    impulse = form.impulse(made.impulse)
    assert assess(wall, impulse, wall.balanced_velocity(impulse)).error < 1e-9
    assert form.flat_impulse(impulse) == pytest.approx(made.impulse, rel=1e-12, abs=1e-12)


def test_velocities_are_those_of_the_solution_in_space():
    wall = turned(walls.rigid_wall(5, 4, **SLIDES), Rotation.random(random_state=7))
    form = plane_form(wall)
    exact = SolverSettings(tolerance=1e-11)
    impulse = form.impulse(solve(form.problem, exact).impulse)
    inside, space = wall.balanced_velocity(impulse), solve(wall, exact).rigid_velocity
    assert inside == pytest.approx(space, abs=1e-8 * np.abs(space).max())


def test_what_leads_out_of_the_plane_has_no_plane_form():
    wall = walls.rigid_wall(5, 4)
    assert plane_form(wall) is not None
    sideways = wall.rigid_impulse.copy()
    sideways[7, 1] = 1e-3 * np.abs(sideways).max()
    assert plane_form(replace(wall, rigid_impulse=sideways)) is None
    spin = wall.rigid_velocity.copy()
    spin[3, 5] = 1.0
    assert plane_form(replace(wall, rigid_velocity=spin)) is None
    shove = wall.free_velocity.copy()
    shove[4] = [0.0, 0.1, 0.1]
    assert plane_form(replace(wall, free_velocity=shove)) is None


def test_rounding_does_not_lead_out_of_the_plane():
    """Velocities and gaps of a wall that stands are rounding, and that of one point is not another's."""
    wall = walls.rigid_wall(5, 4)
    random = np.random.default_rng(0)
    speed = np.abs(wall.rigid_impulse).max()
    noisy = replace(
        wall,
        rigid_velocity=1e-14 * speed * random.standard_normal(wall.rigid_velocity.shape),
        free_velocity=1e-14 * speed * random.standard_normal(wall.free_velocity.shape),
    )
    form = plane_form(noisy)
    assert form is not None
    assert 2 * form.problem.count == wall.count


@pytest.mark.parametrize(("size", "tolerance"), [(9e-10, 1e-6), (9e-10, 1e-10), (1e-11, 1e-10)])
def test_what_is_left_out_does_not_show(size, tolerance):
    wall = walls.rigid_wall(8, 6)
    noise = np.random.default_rng(0).standard_normal(wall.rigid_impulse.shape)
    sideways = wall.rigid_impulse.copy()
    sideways[:, 1] += size * np.abs(sideways).max() * np.sign(noise[:, 1])
    loaded = replace(wall, rigid_impulse=sideways)
    assert (plane_form(loaded, tolerance) is None) == (size > 0.01 * tolerance)
    assert solve(loaded, SolverSettings(tolerance=tolerance)).converged


def test_contacts_that_are_not_alike_turn_blocks_out_of_the_plane():
    wall = walls.rigid_wall(5, 4)
    gap = wall.free_velocity.copy()
    gap[10, 0] = 0.01  # open in front, closed at the back
    assert plane_form(replace(wall, free_velocity=gap)) is None
    rough = wall.friction.copy()
    rough[10] = 0.9
    assert plane_form(replace(wall, friction=rough)) is None


def test_only_rigid_dry_blocks_with_inertia():
    wall = walls.rigid_wall(4, 3)
    assert plane_form(replace(wall, rigid_mass=0 * wall.rigid_mass)) is None
    assert plane_form(replace(wall, cohesion_offset=np.full_like(wall.free_velocity, 1.0))) is None
    assert plane_form(walls.wall(2, 2).problem()) is None
    assert plane_form(condensed(wall)) is None


def test_three_points_through_the_thickness_share_alike():
    wall = walls.rigid_wall(4, 3, **SLIDES)
    form = plane_form(wall)
    middle = wall.rigid_map.copy()
    pair = np.argsort(form.member, kind="stable").reshape(-1, 2)
    between = 0.5 * (middle[pair[:, 0]] + middle[pair[:, 1]])
    more = replace(
        wall,
        friction=np.concatenate([wall.friction, wall.friction[pair[:, 0]]]),
        free_velocity=np.concatenate([wall.free_velocity, wall.free_velocity[pair[:, 0]]]),
        compliance=type(wall.compliance)((3 * (wall.count + len(pair)),) * 2, blocksize=(3, 3)),
        bodies=np.concatenate([wall.bodies, wall.bodies[pair[:, 0]]]),
        rigid_map=np.concatenate([middle, between]),
    )
    thick = plane_form(more)
    assert thick.problem.count == form.problem.count
    assert thick.share == pytest.approx(1 / 3)
