"""A4, A6.1-A6.3 by limit analysis: walls, columns, corbels, a buttress, a portal and a straight flyer."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import sparse

from masonry_fem.limit import (
    Collapse,
    LimitProblem,
    admissible,
    collapse_multiplier,
    group_forces,
    interval,
    limit_problem,
    support_resultant,
)
from masonry_fem.scene.specs import Joint, Scene
from masonry_fem.structures.arch import ArchStructure
from masonry_fem.structures.block import BlockStructure
from masonry_fem.structures.stack import StackStructure
from masonry_fem.structures.wall import WallStructure
from tests.limit.scenes import GAMMA, accelerated, column, number, problem, pushed, scene, weight

DIGIT = 6e-6
BRICK = (0.4, 0.175)


def shaken(made: Scene) -> Collapse:
    """Collapse under a horizontal acceleration of everything [g], proven from both sides."""
    found = collapse_multiplier(problem(made, accelerated(1.0, 0.0)))
    assert max(found.gap, found.unbalanced, found.closing) < 1e-8
    return found


def wall(courses: int, friction: float, **keys) -> Scene:
    given = {"brick": BRICK, "columns": 5, "half_bricks": "odd"} | keys
    stones = WallStructure(name="wall", material="stone", courses=courses, **given)
    return scene(stones, joints=(Joint(friction=friction),))


@pytest.mark.parametrize(("courses", "expected"), [(6, 0.64286), (10, 0.58000)])
def test_a4_1_and_2_walls(courses: int, expected: float) -> None:
    assert shaken(wall(courses, 0.65)).multiplier == pytest.approx(expected, abs=DIGIT)


def listed(courses: list[list[float]], friction: float) -> Scene:
    """Blocks laid by their lengths in block lengths, negative for an opening, from the bottom."""
    blocks = [
        BlockStructure(name="ground", material="stone", size=(4.0, 0.2), position=(-1.0, -0.2), support=True)
    ]
    for level, lengths in enumerate(courses):
        ends = np.cumsum(np.abs([0.0, *lengths])) * BRICK[0]
        for index, (start, length) in enumerate(zip(ends, lengths, strict=False)):
            if length > 0:
                at = (float(start), level * BRICK[1])
                size = (length * BRICK[0], BRICK[1])
                name = f"c{level}b{index}"
                blocks.append(BlockStructure(name=name, material="stone", size=size, position=at))
    return scene(*blocks, joints=(Joint(friction=friction),))


def test_a4_3_wall_with_two_windows() -> None:
    even, odd = [0.5, 1, 1, 1, 1, 0.5], [1.0] * 5
    piers, halves = [1, -1, 1, -1, 1], [0.5, 0.5, -1, 0.5, 0.5, -1, 0.5, 0.5]
    courses = [even, odd, even, piers, halves, piers, halves, piers, even, odd, even]
    assert shaken(listed(courses, 0.65)).multiplier == pytest.approx(0.33195, abs=DIGIT)


@pytest.mark.parametrize(
    ("friction", "expected"),
    [
        (0.2, 0.2), (0.3, 0.3), (0.4, 0.4), (0.5, 0.5), (0.6, 0.6), (0.65, 0.64286), (0.7, 0.66165),
        (0.8, 0.70735), (1.0, 1.0), (2.0, 1.84139),
    ],
)  # fmt: skip
def test_a4_4_friction(friction: float, expected: float) -> None:
    assert shaken(wall(6, friction)).multiplier == pytest.approx(expected, abs=DIGIT)


def test_a4_5_column() -> None:
    found = shaken(column(6, (0.5, 0.3)))
    assert found.multiplier == pytest.approx(0.5 / 1.8, abs=1e-9)
    assert found.mechanism is not None
    assert [(joint.how, joint.between) for joint in found.mechanism.joints] == [
        ("hinge", ("column.b1", "column.ground"))
    ]


@pytest.mark.parametrize(("columns", "friction", "expected"), [(1, 0.65, 0.2), (2, 0.65, 0.37114)])
def test_a4_6_running_bond(columns: int, friction: float, expected: float) -> None:
    found = shaken(wall(10, friction, brick=(0.4, 0.2), columns=columns, half_bricks="even"))
    assert found.multiplier == pytest.approx(expected, abs=DIGIT)


@pytest.mark.parametrize("columns", [1, 2, 3])
def test_a4_6_without_slip_a_wall_is_a_monolith(columns: int) -> None:
    found = shaken(wall(10, 100.0, brick=(0.4, 0.2), columns=columns, half_bricks="even"))
    assert found.multiplier == pytest.approx(columns * 0.4 / 2.0, rel=1e-6)


@pytest.mark.parametrize("count", [3, 5])
def test_a4_7_staircase(count: int) -> None:
    for share, holds in ((1 - 1e-6, True), (1 + 1e-6, False)):
        made = problem(column(count, (1.0, 0.3), offset=share / count))
        assert admissible(made).holds is holds


@pytest.mark.parametrize(("count", "limit"), [(4, 1.041667), (10, 1.464484)])
def test_a4_7_harmonic_stack(count: int, limit: float) -> None:
    assert 0.5 * sum(1 / k for k in range(1, count + 1)) == pytest.approx(limit, abs=1e-6)
    for share, holds in ((1 - 1e-6, True), (1 + 1e-6, False)):
        table = BlockStructure(
            name="table", material="stone", size=(3.0, 1.0), position=(-3.0, -1.0), support=True
        )
        blocks, x = [table], -1.0
        for level in range(count):
            x += share * 0.5 / (count - level)
            blocks.append(
                BlockStructure(name=f"b{level}", material="stone", size=(1.0, 0.2), position=(x, 0.2 * level))
            )
        assert admissible(problem(scene(*blocks))).holds is holds


# --- A4.8: the wall of the shear tests without cohesion -----------------------------------------

UNIT, DEPTH, LENGTH, HEIGHT = (0.22, 0.0625), 0.1, 0.99, 1.0
PRESSURE = 0.30e6


def sheared(friction: float, free: bool) -> Collapse:
    """The wall under a beam that is pressed down, and pushed at its lower edge until something gives.

    Blocks have a millionth of a brick's weight. A beam kept level passes any moment on: one more
    unknown in its equation of moments.
    """
    stones = WallStructure(
        name="wall", material="stone", brick=UNIT, columns=4.5, courses=16, half_bricks="even"
    )
    beam = BlockStructure(name="beam", material="stone", size=(LENGTH, 0.1), position=(0.0, HEIGHT))
    made = problem(scene(stones, beam, joints=(Joint(friction=friction),)))
    model = made.model
    pressed = pushed("beam", (0.0, -PRESSURE * LENGTH))(model)
    light = group_forces(model, {"gravity": 1e-6})
    dead = [own + extra for own, extra in zip(light, pressed, strict=True)]
    made = limit_problem(model, dead, pushed("beam", (1.0, 0.0), (0.0, HEIGHT))(model))
    if not free:
        made = _kept_level(made, "beam")
    return collapse_multiplier(made)


def _kept_level(made: LimitProblem, block: str) -> LimitProblem:
    row = 3 * made.blocks.tolist().index(number(made, block)) + 2
    moment = sparse.csr_array(([1.0], ([row], [0])), shape=(made.equilibrium.shape[0], 1))
    return replace(made, equilibrium=sparse.csr_array(sparse.hstack([made.equilibrium, moment])))


@pytest.mark.parametrize("friction", [0.3, 0.4, 0.75, 1.2])
@pytest.mark.parametrize("free", [False, True])
def test_a4_8_dry_shear_wall(friction: float, free: bool) -> None:
    """V/N = min(μ, L/H) under a level beam, min(μ, L/2H) under one that turns."""
    normal = PRESSURE * LENGTH
    limit = min(friction, LENGTH / HEIGHT / (2 if free else 1))
    assert sheared(friction, free).multiplier / normal == pytest.approx(limit, rel=1e-4)


def test_a4_8_residual_strength_of_the_test() -> None:
    assert sheared(0.75, False).multiplier * DEPTH == pytest.approx(22.275e3, rel=1e-4)


# --- A6 -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("height", [1.0, 3.0, 10.0])
def test_a6_1_buttress(height: float) -> None:
    """Turned over by γb²/2 at its top whatever its height, unless it slides at μγbh before."""
    made = scene(
        StackStructure(name="pier", material="stone", size=(1.0, height), count=1),
        joints=(Joint(friction=0.6),),
    )
    found = collapse_multiplier(problem(made, pushed("pier.b1", (1.0, 0.0), (0.0, height))))
    assert found.multiplier == pytest.approx(GAMMA * min(0.5, 0.6 * height), rel=1e-9)


def test_a6_1_low_buttress_slides() -> None:
    made = scene(
        StackStructure(name="pier", material="stone", size=(1.0, 0.5), count=1), joints=(Joint(friction=0.6),)
    )
    found = collapse_multiplier(problem(made, pushed("pier.b1", (1.0, 0.0), (0.0, 0.5))))
    assert found.multiplier == pytest.approx(0.3 * GAMMA, rel=1e-9)
    assert found.mechanism is not None
    assert [joint.how for joint in found.mechanism.joints] == ["slides"]


def portal(height: float, width: float, courses: int) -> Scene:
    """Semicircular arch of t = .15 R on piers whose inner faces carry on its intrados."""
    size = (width, height / courses)
    return scene(
        ArchStructure(
            name="arch", material="stone", radius=1.0, thickness=0.15, voussoirs=20, springings=False
        ),
        *(
            StackStructure(
                name=name, material="stone", size=size, count=courses, position=(x, -height), ground=False
            )
            for name, x in (("left", -0.925 - width), ("right", 0.925))
        ),
        BlockStructure(
            name="ground", material="stone", size=(4.0, 0.5), position=(-2.0, -height - 0.5), support=True
        ),
        joints=(Joint(friction=0.6),),
    )


@pytest.mark.parametrize("courses", [1, 8])
def test_a6_2_portal(courses: int) -> None:
    """1.32272 R to 2e-5: a change of 1e-7 γR² of the thrust moves this height by 6e-6 R."""
    assert admissible(problem(portal(1.32270, 0.3, courses))).holds
    fallen = admissible(problem(portal(1.32275, 0.3, courses)))
    assert not fallen.holds
    assert fallen.mechanism is not None
    turning = [joint for joint in fallen.mechanism.joints if "ground" in joint.between]
    assert {joint.how for joint in turning} == {"hinge"}


@pytest.mark.parametrize("height", [5.0, 20.0])
def test_a6_2_wide_piers_stand_to_any_height(height: float) -> None:
    assert admissible(problem(portal(height, 0.5, 8))).holds


@pytest.mark.parametrize(("friction", "least"), [(100.0, 0.56247), (0.6, 0.67614)])
def test_a6_3_straight_flyer(friction: float, least: float) -> None:
    """A strut at 30 degrees between walls: a least thrust, and no greatest."""
    along = np.array([np.cos(np.pi / 6), np.sin(np.pi / 6)])
    across = np.array([-along[1], along[0]])

    def block(name: str, start: float, size: tuple[float, float], low: float, support: bool = False):
        at = tuple((start * along + low * across).tolist())
        return BlockStructure(
            name=name, material="stone", size=size, position=at, rotation=30.0, support=support
        )

    walls = [block("low", -0.5, (0.5, 1.0), -0.25, True), block("high", 3.0, (0.5, 1.0), -0.25, True)]
    stones = [block(f"v{index}", 0.3 * index, (0.3, 0.5), 0.0) for index in range(10)]
    made = problem(scene(*walls, *stones, joints=(Joint(friction=friction),)))
    found = interval(made, support_resultant(made, number(made, "low"), axis=0))
    assert found.low / weight(made) == pytest.approx(least, abs=DIGIT)
    assert found.high == np.inf
