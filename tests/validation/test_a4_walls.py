"""A4: columns, corbels and a wall of blocks (A4.5, A4.7, A4.1 as in A9.9)."""

from __future__ import annotations

import pytest

from masonry_fem.scene.specs import (
    BlockStructure,
    Equilibrium,
    Joint,
    Loads,
    Material,
    MeshSettings,
    StackStructure,
    Statics,
    WallStructure,
)
from tests.validation.scenes import G, solved

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
    return result.outcome == "equilibrium"


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
    return result.outcome == "equilibrium"


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
        return result.outcome == "equilibrium"

    assert holds(0.995)
    assert not holds(1.005)


# A4.1: five bricks wide, six courses, half bricks at the ends of the odd courses
WALL_1 = WallStructure(
    name="wall", material="stone", brick=(0.4, 0.175), columns=5, courses=6, half_bricks="odd"
)


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
