"""Limit analysis on structures with pencil answers; statics and kinematics prove each other."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from masonry_fem.build import build
from masonry_fem.errors import ProblemError
from masonry_fem.limit import (
    LimitProblem,
    admissible,
    collapse_multiplier,
    interface_resultant,
    interval,
    limit_problem,
    questions,
    support_resultant,
)
from masonry_fem.limit.conic import maximise_cones
from masonry_fem.limit.linear import maximise_plane
from masonry_fem.limit.problem import Hold
from masonry_fem.limit.program import Program, judged
from masonry_fem.nscd.graphs import lengths
from masonry_fem.results.limit import answers
from masonry_fem.scene.specs import Joint, Loads, Material, Scene
from masonry_fem.structures.arch import ArchStructure
from masonry_fem.structures.block import BlockStructure
from masonry_fem.structures.stack import StackStructure
from masonry_fem.structures.wall import WallStructure
from tests.limit.scenes import GAMMA, G, accelerated, arch, column, number, problem, pushed, scene, weight

BLOCK = {2: (1.0, 2.0), 3: (1.0, 1.0, 2.0)}


def block(dimension: int, friction: float) -> Scene:
    return column(1, BLOCK[dimension], friction)


# --- one block --------------------------------------------------------------------------------------


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize(
    ("friction", "limit", "how"),
    [(0.0, 0.0, "slides"), (0.3, 0.3, "slides"), (0.7, 0.5, "hinge"), (100.0, 0.5, "hinge")],
)
def test_a_block_slides_or_tips(dimension: int, friction: float, limit: float, how: str) -> None:
    """Pushed sideways by an acceleration: min(μ, b/h)."""
    direction = (1.0,) + (0.0,) * (dimension - 1)
    found = collapse_multiplier(problem(block(dimension, friction), accelerated(*direction)))
    assert found.multiplier == pytest.approx(limit, abs=1e-8)
    assert max(found.unbalanced, found.closing, found.gap) < 1e-6
    assert found.mechanism is not None
    assert [joint.how for joint in found.mechanism.joints] == [how]
    assert found.mechanism.moving == 1


@pytest.mark.parametrize("angle", [0.0, 22.5, 45.0, 70.0])
def test_cones_are_round(angle: float) -> None:
    """The same friction in all directions of the plane."""
    a = np.radians(angle)
    found = collapse_multiplier(problem(block(3, 0.2), accelerated(np.cos(a), np.sin(a), 0.0)))
    assert found.multiplier == pytest.approx(0.2, abs=1e-8)
    assert found.mechanism is not None
    velocity = found.mechanism.velocity[0]
    assert velocity[:2] / np.hypot(*velocity[:2]) == pytest.approx([np.cos(a), np.sin(a)], abs=1e-6)


def test_torque_on_four_corners() -> None:
    """Equal corners slide about the middle: μ W √(a² + b²)/2 (A1.8)."""
    made = problem(column(1, (1.0, 1.0, 0.5), 0.4))
    live = np.zeros_like(made.live)
    live[5] = 1.0
    found = collapse_multiplier(replace(made, live=live))
    moment = found.multiplier * made.force * made.length
    assert moment == pytest.approx(0.4 * weight(made) * np.sqrt(2) / 2, rel=1e-6)


def test_weight_downwards_has_no_limit() -> None:
    found = collapse_multiplier(problem(block(2, 0.5), accelerated(0.0, -1.0)))
    assert found.multiplier == np.inf
    assert found.mechanism is None


def test_lifting_takes_the_weight() -> None:
    found = collapse_multiplier(problem(block(2, 0.5), accelerated(0.0, 1.0)))
    assert found.multiplier == pytest.approx(1.0, rel=1e-9)


def test_what_nothing_holds_cannot_be_carried() -> None:
    loose = scene(BlockStructure(name="loose", material="stone", size=(1.0, 1.0), position=(0.0, 3.0)),
                  StackStructure(name="pier", material="stone", size=(1.0, 1.0), count=1))  # fmt: skip
    found = admissible(problem(loose))
    assert not found.holds
    assert found.share == pytest.approx(0.0, abs=1e-9)
    assert found.mechanism is not None
    assert found.mechanism.groups == (("loose",),)
    assert (
        found.mechanism.velocity[found.mechanism.blocks.tolist().index(number(problem(loose), "loose")), 1]
        < 0
    )


def test_without_load_all_is_carried_and_nothing_grows() -> None:
    made = problem(scene(StackStructure(name="p", material="stone", size=(1.0, 1.0), count=1), loads=Loads()))
    assert admissible(made).holds
    with pytest.raises(ProblemError, match="no load grows"):
        collapse_multiplier(made)


# --- wedges, thrust ---------------------------------------------------------------------------------


def keystone(half_angle: float, friction: float) -> LimitProblem:
    stone = ArchStructure(
        name="key", material="stone", radius=2.0, thickness=0.5, voussoirs=1, embrace=2 * half_angle
    )
    return problem(scene(stone, joints=(Joint(friction=friction),)))


@pytest.mark.parametrize(("half_angle", "friction"), [(30.0, 0.2), (20.0, 0.3), (20.0, 0.0), (10.0, 0.6)])
def test_keystone_between_walls(half_angle: float, friction: float) -> None:
    """H from W/(2 tan(a + φ)) to W/(2 tan(a − φ)), and without bound where a ≤ φ (A1.9)."""
    made = keystone(half_angle, friction)
    a, phi = np.radians(half_angle), np.arctan(friction)
    found = interval(made, support_resultant(made, number(made, "key.springing_left"), axis=0))
    assert found.low / weight(made) == pytest.approx(0.5 / np.tan(a + phi), rel=1e-7)
    assert found.high / weight(made) == pytest.approx(0.5 / np.tan(a - phi) if a > phi else np.inf, rel=1e-7)
    assert found.gap < 1e-9


def test_three_supports_share_a_beam() -> None:
    """A rigid beam on 0, .6 L and L: the middle bears between 0 and .8333 W (A6.4)."""
    beam = BlockStructure(name="beam", material="stone", size=(10.0, 0.5), position=(0.0, 0.0))
    feet = [
        BlockStructure(name=f"foot{x:g}".replace(".", "_"), material="stone", size=(0.001, 1.0),
                       position=(x - 0.0005, -1.0), support=True)
        for x in (0.0005, 6.0, 9.9995)
    ]  # fmt: skip
    made = problem(scene(*feet, beam))
    found = interval(made, support_resultant(made, number(made, "foot6"), axis=1))
    assert found.low == pytest.approx(0.0, abs=1e-6 * weight(made))
    assert found.high / weight(made) == pytest.approx(5.0 / 6.0, rel=1e-3)


def test_resultant_of_an_interface_is_the_weight_above() -> None:
    made = problem(column(3, (1.0, 0.5)))
    for index, interface in enumerate(made.model.interfaces):
        upper = max(made.model.assembly.blocks[block].name for block in interface.blocks if block)
        above = 4 - int(upper[-1])
        found = interval(made, interface_resultant(made, index, axis=1))
        assert (found.low, found.high) == pytest.approx((above * 0.5 * GAMMA,) * 2, rel=1e-9)


def test_nothing_is_told_without_a_sign() -> None:
    """A block on a joint without friction: no tilt, no thrust."""
    told = answers(problem(block(2, 0.0), accelerated(1.0, 0.0)), tilt="x")
    assert "may reach 0 g, 0 degrees" in told.message
    assert str(told.supports["column.ground"]["x"]) == "(0.0, 0.0)"


def test_interval_of_what_cannot_be_carried() -> None:
    made = problem(arch(0.05, 11, 0.6))
    found = interval(made, support_resultant(made, number(made, "arch.springing_left"), axis=0))
    assert np.isnan(found.low)
    assert np.isnan(found.high)


# --- dead loads that need live ones -----------------------------------------------------------------


def leaning(friction: float = 0.8) -> LimitProblem:
    """A block whose centre stands over the edge of its ground, pushed back at its top."""
    stair = scene(
        BlockStructure(name="ground", material="stone", size=(1.0, 1.0), position=(0.0, -1.0), support=True),
        BlockStructure(name="stone", material="stone", size=(1.0, 1.0), position=(0.6, 0.0)),
        joints=(Joint(friction=friction),),
    )
    return problem(stair, pushed("stone", (-1.0, 0.0), (1.6, 1.0)))


def test_a_least_factor_is_told_where_the_dead_load_needs_the_live_one() -> None:
    """W over the edge by .1: F·1 ≥ .1 W; it slides at μ W, before F·1 ≤ .5 W + ... tips it back."""
    made = leaning()
    own = weight(made)
    assert not admissible(made).holds
    found = collapse_multiplier(made)
    assert found.least == pytest.approx(0.1 * own, rel=1e-8)
    assert found.multiplier == pytest.approx(min(0.8, 0.5) * own, rel=1e-8)
    assert admissible(made, 0.2 * own).holds
    assert not admissible(made, 0.09 * own).holds


def test_no_factor_helps() -> None:
    made = problem(arch(0.05, 11, 0.6), accelerated(1.0, 0.0))
    found = collapse_multiplier(made)
    assert np.isnan(found.multiplier)
    assert np.isnan(found.least)


# --- both sides, both solvers -----------------------------------------------------------------------


def check_reactions(made: LimitProblem, reaction: np.ndarray, factor: float) -> None:
    """Reactions within the cones that balance the loads, by a sum over blocks."""
    assert (made.strength.friction * reaction[:, 0] - lengths(reaction[:, 1:])).min() > -1e-9 * made.force
    residual = made.equilibrium @ (reaction.ravel() / made.force) + made.load(factor)
    assert np.abs(residual).max() < 1e-8


def check_mechanism(made: LimitProblem, contact: np.ndarray) -> None:
    """No contact point closes."""
    assert (contact[:, 0] - made.strength.friction * lengths(contact[:, 1:])).min() > -1e-7


def wall(friction: float, courses: int, angle: float) -> LimitProblem:
    """Two bricks wide, accelerated at an angle [deg] to the level."""
    a = np.radians(angle)
    stones = WallStructure(name="w", material="stone", brick=(0.4, 0.2), columns=2, courses=courses)
    return problem(scene(stones, joints=(Joint(friction=friction),)), accelerated(np.cos(a), np.sin(a)))


@settings(max_examples=10, deadline=None)
@given(
    friction=st.floats(0.1, 1.5),
    courses=st.integers(1, 4),
    share=st.floats(0.01, 1.0),
)
def test_walls_from_both_sides(friction: float, courses: int, share: float) -> None:
    """An acceleration λ (cos a, sin a), which its own weight leaves as λ cos a sideways and 1 − λ sin a down:
    the wall falls where the first is h times the second, h the multiplier of a level one.
    """
    level = collapse_multiplier(wall(friction, courses, 0.0)).multiplier
    pressed = -np.degrees(np.arctan2(1.0, level))
    angle = pressed + share * (60.0 - pressed)
    a = np.radians(angle)
    made = wall(friction, courses, angle)
    found = collapse_multiplier(made)
    assert found.multiplier == pytest.approx(level / (np.cos(a) + level * np.sin(a)), rel=1e-7)
    assert found.gap < 1e-8
    check_reactions(made, found.reaction, found.multiplier)
    assert found.mechanism is not None
    check_mechanism(made, found.mechanism.contact)
    span = found.multiplier - found.least
    assert admissible(made, found.multiplier - 1e-4 * span).holds
    assert not admissible(made, found.multiplier + 1e-3 * max(found.multiplier, 0.1)).holds
    program = Program(made.equilibrium, made.dead, made.live, made.strength, 2, np.inf)
    linear, conic = maximise_plane(program), maximise_cones(program)
    assert linear is not None
    assert conic is not None
    assert conic.value == pytest.approx(linear.value, rel=1e-7)
    assert conic.gap < 1e-7


@settings(max_examples=10, deadline=None)
@given(friction=st.floats(0.1, 1.5), courses=st.integers(1, 4), share=st.floats(0.0, 0.99))
def test_walls_pressed_against_the_ground_have_no_limit(friction: float, courses: int, share: float) -> None:
    """Accelerated downwards, no farther aside than h (see above)."""
    level = collapse_multiplier(wall(friction, courses, 0.0)).multiplier
    made = wall(friction, courses, -90.0 + share * np.degrees(np.arctan(level)))
    found = collapse_multiplier(made)
    assert found.multiplier == np.inf
    assert found.mechanism is None
    assert admissible(made, 1e3).holds


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize("density", [1e-3, 2400.0, 1e9])
def test_answers_do_not_hang_on_units(scale: float, density: float) -> None:
    stones = ArchStructure(name="arch", material="stone", radius=scale, thickness=0.2 * scale, voussoirs=11)
    made = problem(
        Scene(
            dimension=2, fidelity="rigid", materials={"stone": Material(density=density)},
            structures=(stones,), joints=(Joint(friction=0.6),), loads=Loads(gravity=(0.0, -G)),
        ),
        accelerated(1.0, 0.0),
    )  # fmt: skip
    assert collapse_multiplier(made).multiplier == pytest.approx(0.2955562630, rel=1e-8)
    found = interval(made, support_resultant(made, number(made, "arch.springing_left"), axis=0))
    assert found.low / weight(made) == pytest.approx(0.0942471723 / (0.2 * np.pi), rel=1e-7)


class Blurred:
    """A solver whose answers to intervals are off by a share, or not there at all."""

    def __init__(self, share: float | None) -> None:
        self.share = share

    def __call__(self, program: Program):
        found = maximise_plane(program)
        if len(program.fixed) % 3 == 0 or found is None:  # three equations a block: no interval
            return found
        if self.share is None:
            raise ProblemError("limit analysis: no optimum")
        force = found.force.copy()
        force[::2] *= 1 + self.share
        return judged(program, found.value * (1 + self.share), force, found.velocity)


@pytest.mark.parametrize("share", [8e-4, None])
def test_an_interval_that_is_inexact_says_so_and_the_rest_is_told(share, monkeypatch) -> None:
    made = problem(arch(0.2, 11, 0.6), pushed("arch.v05", (0.0, -100.0)))
    exact = answers(made)
    assert exact.inexact == {}
    monkeypatch.setattr(questions, "maximise_plane", Blurred(share))
    told = answers(made)
    assert told.multiplier == pytest.approx(exact.multiplier, rel=1e-9)
    assert told.admissible is True
    assert set(told.inexact) == {"arch.springing_left", "arch.springing_right"}
    for name, axes in told.inexact.items():
        for axis, error in axes.items():
            if share is None:
                assert (error, told.supports[name][axis]) == (None, (None, None))
                continue
            off = np.abs(np.array(told.supports[name][axis]) - exact.supports[name][axis]).max()
            assert off <= error <= 0.1 * weight(made)
    if share is None:
        assert told.certificate["intervals"] is None
    else:
        assert told.certificate["intervals"] > 1e-4


@pytest.mark.parametrize("turn", [0.0, 30.0, 90.0, 200.0])
def test_answers_turn_with_the_structure(turn: float) -> None:
    """Block on a plane, all of it turned, and gravity with it."""
    a = np.radians(turn)
    rotation = np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]])

    def placed(name: str, size: tuple[float, float], at: tuple[float, float], support: bool = False):
        corner = tuple((rotation @ np.array(at)).tolist())
        return BlockStructure(
            name=name, material="stone", size=size, position=corner, rotation=turn, support=support
        )

    made = problem(
        scene(
            placed("ground", (3.0, 0.5), (-1.0, -0.5), True),
            placed("stone", (1.0, 2.0), (0.0, 0.0)),
            joints=(Joint(friction=0.9),),
            loads=Loads(gravity=tuple((rotation @ [0.0, -G]).tolist())),
        ),
        accelerated(*rotation[:, 0].tolist()),
    )
    assert collapse_multiplier(made).multiplier == pytest.approx(0.5, rel=1e-9)


def test_space_and_plane_agree() -> None:
    plane = collapse_multiplier(problem(arch(0.2, 9, 0.5), accelerated(1.0, 0.0)))
    space = collapse_multiplier(problem(arch(0.2, 9, 0.5, dimension=3), accelerated(1.0, 0.0, 0.0)))
    assert space.multiplier == pytest.approx(plane.multiplier, rel=1e-7)


@pytest.mark.parametrize("block", [1, 2])
def test_a_held_point_pushes_its_own_block(block: int) -> None:
    model = build(scene(StackStructure(name="s", material="stone", size=(1.0, 0.5), count=2)), Path()).model
    free = limit_problem(model)
    row = free.blocks.tolist().index(block)
    point = free.centre[row] + [0.1, 0.2]
    held = limit_problem(model, holds=(Hold(block, point, 0, "side"),)).equilibrium.toarray()[:, -1]
    expected = np.zeros((2, 3))
    expected[row] = 1.0, 0.0, -0.2 / model.length
    assert held == pytest.approx(expected.ravel(), abs=1e-12)
