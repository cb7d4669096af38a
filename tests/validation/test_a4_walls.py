"""A4: columns and corbels of rigid blocks (A4.5, A4.7)."""

from __future__ import annotations

import pytest

from masonry_fem.scene.specs import Equilibrium, Joint, Loads, StackStructure
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
