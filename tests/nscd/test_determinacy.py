"""Determinacy: least-norm reactions and determined resultants, where both are known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy import linalg, sparse

from masonry_fem.errors import ProblemError
from masonry_fem.nscd import ContactProblem, Outcome, SolverSettings, assess, solve
from masonry_fem.nscd.determinacy import determined_resultants, least_norm_reaction
from masonry_fem.nscd.solution_set import solution_set
from tests.nscd import walls

DOWN = np.array([0.0, 0.0, -9.81])


def solved(problem, tolerance=1e-10):
    solution = solve(problem, SolverSettings(tolerance=tolerance))
    assert solution.converged
    return solution


def pairs(problem):
    return np.unique(problem.bodies, axis=0, return_inverse=True)[1].ravel()


def plane(points, normals, friction, load, bodies=1, owners=None):
    """A static plane problem: contacts at points of rigid blocks (a block's origin is the world's).

    ``owners`` are (candidate, antagonist) of each contact, −1 fixed; tangent is the normal turned by −90°.
    """
    points, normals = np.asarray(points, float), np.asarray(normals, float)
    c = len(points)
    owners = np.tile([0, -1], (c, 1)) if owners is None else np.asarray(owners)
    frames = np.stack([normals, np.stack([normals[:, 1], -normals[:, 0]], 1)], 1)
    arm = np.stack([-points[:, 1], points[:, 0]], 1)  # velocity of the point under a unit turn
    maps = np.concatenate([frames, (frames @ arm[:, :, None])], axis=2)
    sides = np.stack([maps, -maps], 1)
    sides[owners < 0] = 0.0
    return ContactProblem(
        friction=np.broadcast_to(np.asarray(friction, float), (c,)).copy(),
        free_velocity=np.zeros((c, 2)),
        compliance=sparse.bsr_array(sparse.csr_array((2 * c, 2 * c)).tobsr((2, 2))),
        bodies=owners,
        rigid_map=sides,
        rigid_mass=np.zeros((bodies, 3)),
        rigid_impulse=np.asarray(load, float).reshape(bodies, 3),
        rigid_velocity=np.zeros((bodies, 3)),
    )


def table(**options):
    """A cube on the corners of its base."""
    settings = {"friction": 0.6, "acceleration": DOWN} | options
    return walls.rigid_boxes([((0.0, 0, 0), (1.0, 1, 1))], [(0, -1, 2)], **settings)


# --- one block ------------------------------------------------------------------------------------


def test_four_legs_share_equally():
    """Three sums are determined, four forces are not (A9.3)."""
    problem = table()
    solution = solved(problem)
    weight = 2000 * 9.81
    other = solution.impulse.copy()
    other[:, 0] = weight * (0.25 + 0.1 * np.array([1, -1, -1, 1]))
    other[:, 1:] = 0
    given = replace(solution, impulse=other, quality=assess(problem, other, solution.rigid_velocity))
    assert given.quality.error < 1e-9
    least = least_norm_reaction(problem, given)
    np.testing.assert_allclose(least.impulse, np.tile([weight / 4, 0, 0], (4, 1)), atol=1e-9 * weight)
    assert least.norm == pytest.approx(weight / 2)
    assert least.attained
    assert least.given_norm > least.norm
    assert least.quality.error < 1e-9
    known = determined_resultants(problem, given, np.zeros(4))
    assert known.determined.all()
    assert not known.unique.any()
    single = determined_resultants(problem, given, np.arange(4), np.tile(np.eye(3), (4, 1, 1)))
    assert not single.determined.any()


def test_weights_move_the_shares():
    """min Σ ω r² with Σ r = W and both moments 0 on four corners: each diagonal shares equally."""
    problem = table()
    weight = np.array([1.0, 3.0, 3.0, 1.0])
    least = least_norm_reaction(problem, solved(problem), weight).impulse[:, 0] / (2000 * 9.81)
    assert least[0] == pytest.approx(least[3])
    assert least[1] == pytest.approx(least[2])
    # the free direction is (1, −1, −1, 1): stationary where Σ ± ω r = 0
    assert weight * [1, -1, -1, 1] @ least == pytest.approx(0, abs=1e-9)
    assert least.sum() == pytest.approx(1)


def test_three_legs_are_determined_without_friction_only():
    corners = [[0.0, 1.0], [1.0, 0.0], [2.0, 1.0]]
    maps = np.zeros((3, 2, 3, 6))
    for contact, (x, y) in enumerate(corners):
        maps[contact, 0, :, :3] = np.eye(3)[[2, 0, 1]]
        maps[contact, 0, 0, 3:5] = y, -x
        maps[contact, 0, 1:, 5] = -y, x
    problem = ContactProblem(
        friction=np.zeros(3), free_velocity=np.zeros((3, 3)),
        compliance=sparse.bsr_array(sparse.csr_array((9, 9)).tobsr((3, 3))),
        bodies=np.array([[0, -1]] * 3), rigid_map=maps, rigid_mass=np.ones((1, 6)),
        rigid_impulse=np.array([[0, 0, -1.0, -0.6, 1.0, 0]]), rigid_velocity=np.zeros((1, 6)),
    )  # fmt: skip
    assert determined_resultants(problem, solved(problem), np.arange(3)).unique.all()
    rough = replace(problem, friction=np.full(3, 0.5))
    known = determined_resultants(rough, solved(rough), np.arange(3), np.tile(np.eye(3), (3, 1, 1)))
    assert known.determined[:, 0].all()  # balance still tells the normal forces
    assert not known.determined[:, 1:].any()


def test_a_block_between_two_walls():
    """Held by friction alone: the shear of each wall is half the weight by moments, the thrust open."""
    points = [[-0.5, -0.5], [-0.5, 0.5], [0.5, -0.5], [0.5, 0.5]]
    normals = [[1.0, 0], [1, 0], [-1, 0], [-1, 0]]
    problem = plane(points, normals, 0.5, [0, -1.0, 0])
    solution = solved(problem)
    wrench = np.zeros((4, 3, 2))
    frames = np.array([[[nx, ny], [ny, -nx]] for nx, ny in normals])
    wrench[:, :2] = frames.transpose(0, 2, 1)
    wrench[:, 2] = (np.array(points)[:, None, 1] * -1) * wrench[:, 0] + 0  # −y fx: moment of thrusts
    known = determined_resultants(problem, solution, [0, 0, 1, 1], wrench)
    assert not known.determined[:, 0].any()
    assert not known.determined[:, 1].any()  # the moments of the thrusts may take over
    least = least_norm_reaction(problem, solution).impulse
    # every point carries W/4 by friction, at the cone's edge
    np.testing.assert_allclose(least[:, 0], 0.5, rtol=1e-8)
    np.testing.assert_allclose(np.abs(least[:, 1]), 0.25, rtol=1e-8)


@pytest.mark.parametrize(("angle", "friction"), [(30.0, 0.3), (20.0, 0.2)])
def test_a_keystone_has_its_weight_and_a_choice_of_thrusts(angle, friction):
    """A1.9: W/(2 tan(a + φ)) ≤ H ≤ W/(2 tan(a − φ)); the vertical forces are W/2 each."""
    a, phi = np.radians(angle), np.arctan(friction)
    normals = [[np.cos(a), np.sin(a)], [-np.cos(a), np.sin(a)]]
    problem = plane([[-1.0, 0.0], [1.0, 0.0]], normals, friction, [0, -1.0, 0])
    frames = np.array([[[nx, ny], [ny, -nx]] for nx, ny in normals])
    solution = solved(problem)
    known = determined_resultants(problem, solution, [0, 1], frames.transpose(0, 2, 1))
    np.testing.assert_array_equal(known.determined, [[False, True], [False, True]])
    np.testing.assert_allclose(known.resultant[:, 1], 0.5, rtol=1e-8)
    least = least_norm_reaction(problem, solution)
    force = (frames.transpose(0, 2, 1) @ least.impulse[:, :, None])[:, :, 0]
    # the least force is the flattest, at the edge of the cone
    assert force[0, 0] == pytest.approx(1 / (2 * np.tan(a + phi)), rel=1e-7)
    assert least.attained


def test_at_the_limit_nothing_is_free():
    """A block on the verge of sliding: all friction is used, so tangential forces follow normal ones."""
    problem = plane([[-1, -0.5], [1, -0.5]], [[0, 1.0], [0, 1]], 0.5, [0.5, -1.0, 0])
    solution = solved(problem, 1e-12)
    known = determined_resultants(problem, solution, [0, 1], np.tile(np.eye(2), (2, 1, 1)))
    assert known.determined.all()
    slack = replace(problem, rigid_impulse=np.array([[0.4, -1.0, 0]]))
    known = determined_resultants(slack, solved(slack), [0, 1], np.tile(np.eye(2), (2, 1, 1)))
    assert known.determined[:, 0].all()
    assert not known.determined[:, 1].any()


def test_sliding_determines_friction():
    """Sliding legs: all tangential impulses point against the sliding."""
    problem = table(friction=0.3, acceleration=DOWN + np.array([9.81, 0, 0]))
    solution = solved(problem)
    known = determined_resultants(problem, solution, np.zeros(4))
    assert known.determined.all()
    least = least_norm_reaction(problem, solution)
    np.testing.assert_allclose(np.linalg.norm(least.impulse[:, 1:], axis=1), 0.3 * least.impulse[:, 0])
    assert least.quality.error < 1e-9


# --- structures -----------------------------------------------------------------------------------


def test_a_stack_has_determined_resultants():
    boxes = [((0.0, 0, k * 1.0), (1.0, 1, 1)) for k in range(5)]
    problem = walls.rigid_boxes(boxes, walls.touching(boxes), friction=0.6, acceleration=DOWN)
    known = determined_resultants(problem, solved(problem), pairs(problem))
    assert known.determined.all()
    assert not known.unique.any()
    least = least_norm_reaction(problem, solved(problem)).impulse
    expected = 2000 * 9.81 / 4 * np.array([5, 4, 3, 2, 1])
    by_joint = least[:, 0].reshape(5, 4)
    np.testing.assert_allclose(np.sort(by_joint.mean(axis=1))[::-1], expected, rtol=1e-7)
    np.testing.assert_allclose(by_joint, by_joint[:, :1] * np.ones(4), rtol=1e-7)


def test_a_wall_leaves_the_thrust_between_bricks_open():
    problem = walls.rigid_wall(3, 2, friction=0.6, horizontal=0.0)
    solution = solved(problem)
    # world force of each contact, moved to one side
    frames = world_frames(problem)
    known = determined_resultants(problem, solution, pairs(problem), frames)
    heads = np.array([abs(frames[pairs(problem) == k][0, 0, 0]) > 0.5 for k in known.interface])
    assert heads.any()
    assert not known.determined[heads, 0].any()
    least = least_norm_reaction(problem, solution)
    assert least.norm <= np.linalg.norm(solution.impulse) * (1 + 1e-12)
    assert least.quality.error < 1e-9


def world_frames(problem):
    """World axes of the contacts, from the translations of the first side's map, (c, 3, 3)."""
    axes = problem.rigid_map[:, 0, :, :3]
    return (axes / np.linalg.norm(axes, axis=2, keepdims=True)).transpose(0, 2, 1)


def test_an_arch_of_three_hinges_is_determined():
    """Two bars that lean on each other: pinned by frictional points, three hinges, isostatic."""
    points = [[-1.0, 0], [0, 1.0], [1.0, 0]]
    normals = [[0.0, 1], [1, 0], [0, 1]]
    owners = [[0, -1], [1, 0], [1, -1]]
    load = [[0, -1.0, 0.5], [0, -1.0, -0.5]]  # weights at x = ∓0.5, about the origin
    problem = plane(points, normals, 2.0, load, 2, owners)
    known = determined_resultants(problem, solved(problem), [0, 1, 2], np.tile(np.eye(2), (3, 1, 1)))
    assert known.determined.all()
    assert known.unique.all()
    # thrust: 1 · 0.5 (weight about the springing) = H · 1
    assert known.resultant[1, 0] == pytest.approx(0.5)
    # a joint of two points at the crown is statically indeterminate once
    points.insert(2, [0.0, 1.2])
    normals.insert(2, [1.0, 0])
    owners.insert(2, [1, 0])
    problem = plane(points, normals, 2.0, load, 2, owners)
    known = determined_resultants(problem, solved(problem), [0, 1, 1, 2], np.tile(np.eye(2), (4, 1, 1)))
    assert not known.determined[:, 0].all()


# --- all solutions ----------------------------------------------------------------------------------


@pytest.mark.parametrize(("horizontal", "friction"), [(0.1, 0.6), (0.3, 0.2), (0.6, 0.6)])
def test_dense_null_space_agrees(horizontal, friction):
    """Determined is what the null space of the equations within the faces leaves, by a dense SVD."""
    problem = walls.rigid_wall(4, 3, friction=friction, horizontal=horizontal)
    solution = solved(problem)
    found = solution_set(problem, solution)
    group = pairs(problem)
    known = determined_resultants(problem, solution, group, solutions=found)
    matrix = problem.rigid_matrix().toarray().T @ linalg.block_diag(*found.faces.spans())
    inside = linalg.block_diag(*found.faces.spans())
    free = linalg.null_space(np.concatenate([matrix, np.eye(len(inside)) - inside]), rcond=1e-9)
    c = problem.count
    rows = problem.rigid_map[:, 0].transpose(0, 2, 1)
    for k, number in enumerate(known.interface):
        member = group == number
        functional = np.where(member[:, None, None], rows, 0.0).transpose(1, 0, 2).reshape(6, 3 * c)
        change = np.linalg.norm(functional @ free, axis=1) if free.size else np.zeros(6)
        np.testing.assert_array_equal(known.determined[k], change <= 1e-7 * np.abs(rows).max())


@pytest.mark.parametrize(("horizontal", "friction"), [(0.1, 0.6), (0.3, 0.2), (0.6, 0.6)])
def test_no_solution_has_a_smaller_norm(horizontal, friction):
    """At the least norm no step towards another solution goes down (convexity makes that enough)."""
    problem = walls.rigid_wall(4, 3, friction=friction, horizontal=horizontal)
    solution = solved(problem)
    found = solution_set(problem, solution)
    least = least_norm_reaction(problem, solution, solutions=found)
    p = least.impulse
    # slow sliding: directions are as exact as the solution's error over its speed
    assert least.quality.error < 1e-7
    for other in (found.member, found.inner, solution.impulse):
        assert (p * (other - p)).sum() >= -1e-9 * least.norm**2


@given(st.integers(2, 4), st.integers(1, 3), st.floats(0.1, 1.0), st.floats(0.0, 0.8))
@settings(max_examples=15, deadline=None)
def test_what_is_determined_is_the_same_in_other_solutions(bricks, courses, friction, horizontal):
    """Walls that stick, slide and tip."""
    problem = walls.rigid_wall(bricks, courses, friction=friction, horizontal=horizontal)
    solution = solve(problem, SolverSettings(tolerance=1e-9))
    assert solution.solved
    assume(solution.converged)  # what falls has no member to compare
    found, group = solution_set(problem, solution), pairs(problem)
    known = determined_resultants(problem, solution, group, solutions=found)
    least = least_norm_reaction(problem, solution, solutions=found)
    rows = problem.rigid_map[:, 0].transpose(0, 2, 1)
    for other in (least.impulse, found.inner):
        change = np.zeros_like(known.resultant)
        np.add.at(change, group, (rows @ (other - found.member)[:, :, None])[:, :, 0])
        size = np.abs(known.resultant).max()
        assert np.abs(change[known.determined]).max(initial=0.0) <= 1e-6 * size


def test_an_elastic_wall_is_known_up_to_loops_around_vertices():
    problem = walls.wall(3, 1.0).problem()
    solution = solved(problem)
    found = solution_set(problem, solution)
    least = least_norm_reaction(problem, solution, solutions=found)
    assert least.quality.error < 1e-9
    assert least.norm <= least.given_norm * (1 + 1e-12)
    known = determined_resultants(problem, solution, pairs(problem), solutions=found)
    assert 0 < known.unique.sum() < problem.count
    # what is unique is what both have
    np.testing.assert_allclose(
        least.impulse[known.unique], solution.impulse[known.unique], atol=1e-7 * found.size
    )


def test_elastic_cubes_are_determined():
    problem = walls.cubes(4).problem()
    solution = solved(problem)
    known = determined_resultants(problem, solution, pairs(problem))
    assert known.determined.all()
    assert known.unique.all()
    assert least_norm_reaction(problem, solution).attained


# --- invariance -----------------------------------------------------------------------------------


def test_frames_do_not_matter():
    problem = walls.rigid_wall(3, 3, friction=0.3, horizontal=0.2)
    angle = np.random.default_rng(1).uniform(0, 2 * np.pi, problem.count)
    turn = np.tile(np.eye(3), (problem.count, 1, 1))
    turn[:, 1, 1] = turn[:, 2, 2] = np.cos(angle)
    turn[:, 1, 2], turn[:, 2, 1] = np.sin(angle), -np.sin(angle)
    turned = replace(problem, rigid_map=turn[:, None] @ problem.rigid_map)
    solution = solved(problem)
    other = replace(
        solution,
        impulse=(turn @ solution.impulse[:, :, None])[:, :, 0],
        velocity=(turn @ solution.velocity[:, :, None])[:, :, 0],
    )
    first, second = least_norm_reaction(problem, solution), least_norm_reaction(turned, other)
    back = (turn.transpose(0, 2, 1) @ second.impulse[:, :, None])[:, :, 0]
    np.testing.assert_allclose(back, first.impulse, atol=1e-8 * first.norm)


@pytest.mark.parametrize(("force", "length"), [(1e-6, 1e3), (1e6, 1e-3)])
def test_units_do_not_matter(force, length):
    problem = walls.rigid_wall(3, 3, friction=0.3, horizontal=0.2)
    solution = solved(problem)
    scaled = replace(
        problem,
        rigid_map=problem.rigid_map * length,
        rigid_impulse=problem.rigid_impulse * force * length,
        rigid_mass=problem.rigid_mass * force * length,
    )
    other = solved(scaled)
    first, second = least_norm_reaction(problem, solution), least_norm_reaction(scaled, other)
    np.testing.assert_allclose(second.impulse, first.impulse * force, atol=1e-7 * first.norm * force)
    for group in (pairs(problem),):
        a = determined_resultants(problem, solution, group).determined
        b = determined_resultants(scaled, other, group).determined
        np.testing.assert_array_equal(a, b)


# --- edges ----------------------------------------------------------------------------------------


def test_no_load_no_reaction():
    problem = table(acceleration=np.zeros(3))
    solution = solved(problem)
    assert not least_norm_reaction(problem, solution).impulse.any()


def test_an_empty_problem():
    problem = ContactProblem.plain(np.zeros((0, 0)), np.zeros((0, 3)), np.zeros(0))
    solution = solve(problem)
    assert least_norm_reaction(problem, solution).impulse.shape == (0, 3)
    assert determined_resultants(problem, solution, []).determined.shape[0] == 0


def test_what_is_wrong_is_told():
    problem = table()
    solution = solved(problem)
    with pytest.raises(ProblemError, match="stalled"):
        least_norm_reaction(problem, replace(solution, outcome=Outcome.STALLED))
    with pytest.raises(ProblemError, match="weight is -1"):
        least_norm_reaction(problem, solution, -1.0)
    with pytest.raises(ProblemError, match="one number"):
        determined_resultants(problem, solution, [0, 1])
