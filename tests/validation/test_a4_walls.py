"""A4: columns, corbels, walls of blocks and the dry shear wall, by simulation.

Coulomb joints that slide do not dilate: between the least load of a motion and the greatest that can be
carried (limit analysis, ``test_limit_walls.py``) both rest and motion solve the equations. True statics
asks for rest; a step in time from rest, that the load strikes at once, may take the motion.
"""

from __future__ import annotations

import pytest

from masonry_fem.scene.specs import (
    Equilibrium,
    Joint,
    Loads,
    Material,
    MeshSettings,
    PointForce,
    Solver,
    Statics,
)
from masonry_fem.structures.block import BlockStructure
from masonry_fem.structures.stack import StackStructure
from masonry_fem.structures.wall import WallStructure
from tests.validation.scenes import G, solved, stands

ONE_STEP = Equilibrium(strategy="large_step", step=0.01, max_steps=3, tolerance=1e-6)


def column_stands(acceleration: float) -> bool:
    """Six blocks of 0.5 × 0.3 m in stack bond under a horizontal acceleration [g]."""
    result = solved(
        dimension=2,
        fidelity="rigid",
        structures=(StackStructure(name="column", material="stone", size=(0.5, 0.3), count=6),),
        joints=(Joint(friction=0.65),),
        loads=Loads(gravity=(acceleration * G, -G)),
        analysis=ONE_STEP,
    )
    return stands(result)


def test_a4_5_column_overturns_at_b_over_h() -> None:
    limit = 0.5 / 1.8
    assert column_stands(0.995 * limit)
    assert not column_stands(1.005 * limit)


def corbel_stands(count: int, offset: float) -> bool:
    result = solved(
        dimension=2,
        fidelity="rigid",
        structures=(
            StackStructure(name="stair", material="stone", size=(1.0, 0.3), count=count, offset=offset),
        ),
        joints=(Joint(friction=0.6),),
        analysis=ONE_STEP,
    )
    return stands(result)


@pytest.mark.parametrize("count", [3, 5])
def test_a4_7_staircase_stands_to_one_over_n(count: int) -> None:
    assert corbel_stands(count, 0.995 / count)
    assert not corbel_stands(count, 1.005 / count)


@pytest.mark.parametrize("count", [4, 10])
def test_a4_7_harmonic_stack(count: int) -> None:
    """Blocks offset by L/2(n−k), k from below: the greatest overhang, ½ Σ 1/k of the length."""
    limits = {4: 1.041667, 10: 1.464484}
    overhang = 0.5 * sum(1 / k for k in range(1, count + 1))
    assert overhang == pytest.approx(limits[count], abs=1e-6)

    def holds(share: float) -> bool:
        blocks, x = [], 0.0
        for level in range(count):
            # the lowest block stands on the edge of a table at x = 0; steps grow towards the top
            x += share * 0.5 / (count - level)
            corner = (x - 1.0, 0.2 * level)
            blocks.append(
                BlockStructure(name=f"b{level}", material="stone", size=(1.0, 0.2), position=corner)
            )
        table = BlockStructure(
            name="table", material="stone", size=(3.0, 1.0), position=(-3.0, -1.0), support=True
        )
        result = solved(
            dimension=2,
            fidelity="rigid",
            structures=(table, *blocks),
            joints=(Joint(friction=0.6),),
            analysis=ONE_STEP,
        )
        return stands(result)

    assert holds(0.995)
    assert not holds(1.005)


# A4.1: five bricks wide, six courses, half bricks at the ends of the odd courses
WALL_1 = WallStructure(
    name="wall", material="stone", brick=(0.4, 0.175), columns=5, courses=6, half_bricks="odd"
)


@pytest.mark.slow
@pytest.mark.parametrize("young", [None, 1e9, 1e12, 1e15])
def test_a9_9_collapse_of_wall_1_does_not_depend_on_its_stiffness(young: float | None) -> None:
    """Horizontal body force λ W: it stands at 0.98 and falls at 1.02 of λ = 0.64286.

    The published collapse is between 0.636 and 0.646 (A4.1); impulses that carry the loads exist up to
    0.64286 (static theorem, on the same contact points).
    """

    def outcome(factor: float) -> str:
        result = solved(
            dimension=2,
            materials={"stone": Material(density=2400.0, young=young, poisson=0.2)},
            fidelity="rigid" if young is None else "elastic",
            mesh=MeshSettings(divisions=(2, 1)),
            structures=(WALL_1,),
            joints=(Joint(friction=0.65, placement="corners"),),
            loads=Loads(gravity=(factor * G, -G)),
            analysis=Statics() if young else ONE_STEP,
        )
        return result.outcome

    limit = 0.64286
    assert outcome(0.98 * limit) == "equilibrium"
    assert outcome(1.02 * limit) == "no_equilibrium"


# --- walls under a horizontal body force λ W ------------------------------------------------------


def wall_rests(structures, limit: float, friction: float, analysis) -> str:
    """Outcome of plane walls of rigid blocks."""
    result = solved(
        dimension=2,
        fidelity="rigid",
        structures=structures,
        joints=(Joint(friction=friction),),
        loads=Loads(gravity=(limit * G, -G)),
        analysis=analysis,
        solver=Solver(),
    )
    return result.outcome


def bond(courses: int, columns: int = 5, **keys) -> tuple[WallStructure]:
    given = {"brick": (0.4, 0.175), "half_bricks": "odd"} | keys
    return (WallStructure(name="wall", material="stone", columns=columns, courses=courses, **given),)


@pytest.mark.parametrize("friction", [0.2, 0.3, 0.4, 0.5, 0.6])
def test_a4_4_low_friction_lets_the_wall_slide(friction: float) -> None:
    """λ = μ, the only solution: no joint that dilates takes part."""
    assert wall_rests(bond(6), 0.98 * friction, friction, ONE_STEP) == "equilibrium"
    assert wall_rests(bond(6), 1.02 * friction, friction, ONE_STEP) == "no_equilibrium"


@pytest.mark.parametrize(("friction", "limit"), [(0.65, 0.64286), (0.8, 0.70735)])
def test_a4_4_higher_friction(friction: float, limit: float) -> None:
    assert wall_rests(bond(6), 0.98 * limit, friction, Statics()) == "equilibrium"
    assert wall_rests(bond(6), 1.02 * limit, friction, Statics()) == "no_equilibrium"


@pytest.mark.slow
def test_a4_2_wall_of_ten_courses() -> None:
    """Rest up to 0.58000; published collapse at 0.563, and here some steps in time from 0.568 on move."""
    assert wall_rests(bond(10), 0.55, 0.65, ONE_STEP) == "equilibrium"
    assert wall_rests(bond(10), 0.98 * 0.58, 0.65, Statics()) == "equilibrium"
    assert wall_rests(bond(10), 1.02 * 0.58, 0.65, Statics()) == "no_equilibrium"


def test_a4_3_wall_with_two_windows() -> None:
    """Rest up to 0.33195; steps in time from rest move from 0.2636 on."""
    structures = windows()
    assert wall_rests(structures, 0.25, 0.65, ONE_STEP) == "equilibrium"
    assert wall_rests(structures, 0.98 * 0.33195, 0.65, Statics()) == "equilibrium"
    assert wall_rests(structures, 1.02 * 0.33195, 0.65, Statics()) == "no_equilibrium"


def windows() -> tuple[BlockStructure, ...]:
    """Wall 4: five wide, eleven courses, two windows over courses 4 to 8; lengths in block lengths."""
    even, odd = [0.5, 1, 1, 1, 1, 0.5], [1.0] * 5
    piers, halves = [1, -1, 1, -1, 1], [0.5, 0.5, -1, 0.5, 0.5, -1, 0.5, 0.5]
    blocks = [
        BlockStructure(name="ground", material="stone", size=(4.0, 0.2), position=(-1.0, -0.2), support=True)
    ]
    for level, lengths in enumerate([even, odd, even, piers, halves, piers, halves, piers, even, odd, even]):
        start = 0.0
        for index, length in enumerate(lengths):
            if length > 0:
                at, size = (0.4 * start, 0.175 * level), (0.4 * length, 0.175)
                blocks.append(
                    BlockStructure(name=f"c{level}b{index}", material="stone", size=size, position=at)
                )
            start += abs(length)
    return tuple(blocks)


def test_a4_6_column_of_single_bricks() -> None:
    walls = bond(10, 1, brick=(0.4, 0.2), half_bricks="even")
    assert wall_rests(walls, 0.98 * 0.2, 0.65, ONE_STEP) == "equilibrium"
    assert wall_rests(walls, 1.02 * 0.2, 0.65, ONE_STEP) == "no_equilibrium"


def test_a4_6_two_bricks_wide() -> None:
    walls = bond(10, 2, brick=(0.4, 0.2), half_bricks="even")
    assert wall_rests(walls, 0.34, 0.65, ONE_STEP) == "equilibrium"
    assert wall_rests(walls, 0.98 * 0.37114, 0.65, Statics()) == "equilibrium"
    assert wall_rests(walls, 1.02 * 0.37114, 0.65, Statics()) == "no_equilibrium"


@pytest.mark.slow
@pytest.mark.parametrize("friction", [10.0, "no slip"])
@pytest.mark.parametrize("columns", [2, 3])
def test_a4_6_without_slip_a_wall_is_a_monolith(columns: int, friction) -> None:
    walls = bond(10, columns, brick=(0.4, 0.2), half_bricks="even")
    assert wall_rests(walls, 0.98 * columns * 0.2, friction, Statics()) == "equilibrium"
    assert wall_rests(walls, 1.02 * columns * 0.2, friction, Statics()) == "no_equilibrium"


def dry_shear_wall(friction: float, ratio: float, pressed_at: float, analysis) -> str:
    """Wall 0.99 × 1 m, all but without weight; beam pressed by N, pushed by V/N at the top joint."""
    normal = 0.3e6 * 0.99
    structures = (
        *bond(16, 4.5, brick=(0.22, 0.0625), half_bricks="even"),
        BlockStructure(name="beam", material="stone", size=(0.99, 0.1), position=(0.0, 1.0)),
    )
    push = PointForce(block="beam", point=(0.0, 1.0), vector=(ratio * normal, 0.0))
    press = PointForce(block="beam", point=(pressed_at, 1.1), vector=(0.0, -normal))
    result = solved(
        dimension=2,
        fidelity="rigid",
        structures=structures,
        joints=(Joint(friction=friction),),
        loads=Loads(gravity=(0.0, -1e-3), points=(press, push)),
        analysis=analysis,
        solver=Solver(),
    )
    return result.outcome


@pytest.mark.slow
@pytest.mark.parametrize("friction", [0.4, 0.75])
def test_a4_8_dry_shear_wall_under_a_beam_that_turns(friction: float) -> None:
    """V/N = min(μ, L/2H) for a force at the top joint."""
    limit = min(friction, 0.495)
    assert dry_shear_wall(friction, 0.98 * limit, 0.495, ONE_STEP) == "equilibrium"
    assert dry_shear_wall(friction, 1.02 * limit, 0.495, Statics()) == "no_equilibrium"


@pytest.mark.slow
@pytest.mark.parametrize("friction", [0.4, 0.75, 2.0])
def test_a4_8_dry_shear_wall_under_a_level_beam(friction: float) -> None:
    """V/N = min(μ, L/H): what holds the beam level presses it at the corner behind, where it lifts."""
    limit = min(friction, 0.99)
    assert dry_shear_wall(friction, 0.98 * limit, 0.0, Statics()) == "equilibrium"
    assert dry_shear_wall(friction, 1.02 * limit, 0.0, Statics()) == "no_equilibrium"
