"""Unstressed: a stone between two faces comes to rest where these lean under it, and else runs off."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import sparse

from masonry_fem.nscd import Outcome, solve
from masonry_fem.nscd.problem import ContactProblem
from masonry_fem.nscd.residuals import assess
from masonry_fem.nscd.solvers.drag import STEPS, Drag
from masonry_fem.nscd.unstressed import from_no_stress
from tests.nscd import plane, walls


def wedge(angle, *, friction=0.8, mass=1.0, length=1.0, load=10.0, compliance=None):
    """A stone of unit half width and height on two faces that lean by an angle [rad] under it."""
    normal = np.array([[np.cos(angle), np.sin(angle)], [-np.cos(angle), np.sin(angle)]])
    maps = []
    for x, n in zip((-1.0, 1.0), normal, strict=True):
        tangent = np.array([-n[1], n[0]])
        for y in (-0.5, 0.5):
            arm = length * np.array([x, y])
            rows = [[*axis, arm[0] * axis[1] - arm[1] * axis[0]] for axis in (n, tangent)]
            maps.append(np.array(rows) / np.sqrt(mass) / [1, 1, length * np.sqrt(5 / 12)])
    count = len(maps)
    rigid_map = np.zeros((count, 2, 2, 3))
    rigid_map[:, 0] = maps
    matrix = sparse.bsr_array((2 * count, 2 * count), blocksize=(2, 2))
    if compliance is not None:
        matrix = sparse.bsr_array(compliance * np.eye(2 * count), blocksize=(2, 2))
    return ContactProblem(
        friction=np.full(count, friction),
        free_velocity=np.zeros((count, 2)),
        compliance=matrix,
        bodies=np.tile([0, -1], (count, 1)),
        rigid_map=rigid_map,
        rigid_mass=np.zeros((1, 3)),
        rigid_impulse=np.array([[0.0, -np.sqrt(mass) * load, 0.0]]),
        rigid_velocity=np.zeros((1, 3)),
    )


@pytest.mark.parametrize("angle", [1.2, 0.5, 0.1, 1e-2])
def test_a_stone_in_a_notch_is_reached(angle):
    problem = wedge(angle)
    told = from_no_stress(problem)
    assert told.reached is True
    left = problem.body_impulse(told.impulse) + problem.rigid_impulse
    assert np.linalg.norm(left) < 1e-3 * np.linalg.norm(problem.rigid_impulse)


@pytest.mark.parametrize("angle", [0.0, 1e-8, -1e-8, -0.1, -0.5])
def test_a_stone_that_widens_downwards_runs_off(angle):
    # friction of 0.8 holds faces up to 0.67 rad, once they are pressed
    problem = wedge(angle)
    told = from_no_stress(problem)
    assert told.reached is False
    if angle <= 0:  # else the faces' closing in by rounding holds it at last
        assert told.lacking == pytest.approx([1.0, 1.0, 1.0], abs=1e-6)
    assert told.motion[0, 1] < 0
    assert np.abs(told.motion[0, [0, 2]]).max() < 1e-6 * abs(told.motion[0, 1])


@pytest.mark.parametrize(("mass", "length", "load"), [(1e6, 1.0, 1.0), (1e-6, 1e-3, 1e4), (1.0, 1e3, 1e-9)])
@pytest.mark.parametrize("angle", [0.3, -0.3])
def test_units_do_not_decide(angle, mass, length, load):
    assert from_no_stress(wedge(angle, mass=mass, length=length, load=load)).reached is (angle > 0)


def test_without_loads_nothing_is_lacking():
    assert from_no_stress(wedge(0.0, load=0.0)).reached is True


def test_open_contacts_take_no_part():
    closed = np.array([True, True, False, False])
    assert from_no_stress(wedge(1.2), closed).reached is False


def test_a_wall_is_reached_and_its_impulses_are_within_the_cones():
    problem = walls.rigid_wall(4, 5)
    told = from_no_stress(problem)
    assert told.reached is True
    tangent = np.linalg.norm(told.impulse[:, 1:], axis=1)
    size = np.abs(told.impulse).max()
    assert (tangent - problem.friction * told.impulse[:, 0]).max() < 1e-5 * size


@pytest.mark.parametrize(
    ("angle", "outcome"), [(0.3, Outcome.CONVERGED), (0.0, Outcome.UNSTRESSED), (-0.3, Outcome.UNSTRESSED)]
)
def test_elastic_blocks_that_only_pre_stress_would_hold_have_no_equilibrium(angle, outcome):
    problem = wedge(angle, compliance=1e-6)
    found = solve(problem)
    assert found.outcome is outcome
    if outcome.moves:
        assert found.rigid_velocity[0, 1] < 0


@pytest.mark.parametrize(("mass", "length", "load"), [(1, 1, 10), (1e16, 1, 1), (1e-16, 1e-3, 1e4)])
@pytest.mark.parametrize("angle", [0.3, 1e-8, -0.3])
def test_balance_without_friction_tells_where_no_drag_is_reached_at_once(
    angle, mass, length, load, monkeypatch
):
    at_once, asked = Drag.at_once, []
    monkeypatch.setattr(
        Drag, "at_once", lambda *given: asked.append(given) or (len(asked) > 1 and at_once(*given))
    )
    told = from_no_stress(wedge(angle, mass=mass, length=length, load=load))
    assert told.reached is (angle > 0.1)
    if told.reached:
        assert len(asked) == 1
        assert not told.impulse[:, 1].any()
        assert told.lacking == (0.0,)


def test_strides_lead_to_drags_that_newton_does_not_come_to_at_once():
    problem = plane.soft(plane.plane_wall(4, 5, friction=0.8, horizontal=0.3, mass=0.0))
    dragged = Drag(problem)
    assert dragged.towards(1e-6)
    assert dragged.solves > STEPS
    held = dragged.reached * dragged.resistance * dragged.motion
    left = problem.body_impulse(dragged.impulse) + problem.rigid_impulse - held
    assert np.abs(left).max() < 1e-6 * np.abs(problem.rigid_impulse).max()
    found = solve(problem)
    assert found.converged
    size = np.abs(found.impulse).max()
    resultant = problem.body_impulse(dragged.impulse) - problem.body_impulse(found.impulse)
    assert np.abs(resultant).max() < 1e-3 * size


@pytest.mark.parametrize(
    ("bricks", "courses", "friction", "reached"), [(2, 4, 1.2, False), (3, 3, 5.0, True)]
)
def test_where_steps_cycle_a_drag_is_come_to_kink_by_kink(bricks, courses, friction, reached):
    wall = plane.plane_wall(bricks, courses, friction=friction, horizontal=0.7, mass=0.0)
    problem = plane.soft(wall)
    dragged = Drag(problem)
    assert dragged.kink_by_kink(1e-6)
    own = sparse.diags_array(np.repeat(dragged.own, 2))
    compliance = sparse.bsr_array(problem.compliance + own, blocksize=(2, 2))
    held = replace(problem, compliance=compliance, rigid_mass=1e-6 * dragged.resistance)
    assert assess(held, dragged.impulse, dragged.motion).natural_map < 1e-6
    assert from_no_stress(problem).reached is reached


def test_nothing_is_tried_after_the_time_given():
    """With all the time there is it is reached kink by kink, in many more systems."""
    problem = plane.soft(plane.plane_wall(3, 3, friction=5.0, horizontal=0.7, mass=0.0))
    late, whole = from_no_stress(problem, until=0.0), from_no_stress(problem)
    assert (late.reached, whole.reached) == (None, True)
    assert late.solves < 0.2 * whole.solves
