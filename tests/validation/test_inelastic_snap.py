"""Statics beyond a snap: a bar that cracks while its ends are pulled apart, against its closed form.

The bar of ``test_inelastic_path`` snaps back: beyond the peak no balance is near the last one. At the same
displacement it has another one, whose crack is further open, and statics goes on from there.
"""

from __future__ import annotations

from dataclasses import replace

import msgspec
import numpy as np
import pytest

from masonry_fem.march import step
from masonry_fem.march.rounds import Round, Rounds
from masonry_fem.nscd import Outcome
from masonry_fem.scene.specs import Loads, MeshSettings, Motion, Statics, Support
from masonry_fem.structures.block import BlockStructure
from tests.validation.test_inelastic_path import (
    ENERGY,
    LENGTH,
    ROW,
    ROWS,
    STAY,
    STRENGTH,
    WEIGHT,
    YOUNG,
    followed,
    hung,
)

PULL = 3e-4  # [m] at the end


def pulled(fidelity: str = "inelastic", rows: int = ROWS, steps: int = 8) -> msgspec.Struct:
    """The bar, its top moved by so much."""
    scene = hung()
    return msgspec.structs.replace(
        scene,
        fidelity=fidelity,
        structures=(
            BlockStructure(
                name="bar", material="m", size=(ROW, LENGTH), mesh=MeshSettings(divisions=(1, rows))
            ),
        ),
        supports=(
            Support(on="bar/bottom"),
            Support(on="bar/top", motion=Motion(displacement=(0.0, PULL))),
        ),
        loads=Loads(gravity=(0.0, -WEIGHT / 2000.0), gravity_time=STAY),
        analysis=Statics(load_steps=steps),
    )


def closed_form(top: float) -> tuple[float, float]:
    """Opening of the cracked row [m] and stress in it [Pa] at a displacement of the top, the far branch."""
    H = ROW / (2 * YOUNG * ENERGY / STRENGTH**2 - ROW)

    def stress(opening: float) -> float:
        strain = opening / ROW
        return min(YOUNG * strain, STRENGTH * np.exp(-2 * H * (YOUNG * strain / STRENGTH - 1)))

    def ends(opening: float) -> float:
        load = stress(opening) + WEIGHT * ROW / 2
        return opening + sum(ROW / YOUNG * (load - WEIGHT * ROW * (row + 0.5)) for row in range(1, ROWS))

    low, high = top / 2, 2 * top
    assert ends(low) < top < ends(high)
    for _ in range(80):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if ends(middle) < top else (low, middle)
    return low, stress(low)


@pytest.mark.parametrize("fidelity", ["inelastic", "auto"])
def test_a_bar_that_is_pulled_snaps_to_the_balance_further_away(fidelity):
    result, curve = followed(pulled(fidelity))
    assert result.outcome == "equilibrium", result.message
    assert sum(remark.code == "snapped" for remark in result.summary.remarks) == 1
    time, top, opening = np.array(curve.rows).T
    np.testing.assert_allclose(top, PULL * time, rtol=1e-9)
    peak = (STRENGTH + WEIGHT * ROW / 2) / YOUNG * LENGTH - WEIGHT * LENGTH**2 / (2 * YOUNG)
    elastic = time * PULL <= peak
    np.testing.assert_allclose(opening[elastic], 0, atol=1.01 * STRENGTH / YOUNG * ROW)
    assert (~elastic).sum() >= 2
    for way, opened in zip(top[~elastic], opening[~elastic], strict=True):
        assert opened == pytest.approx(closed_form(way)[0], rel=1e-7)
    # the snap is found in the part of a step in which the peak lies
    assert time[~elastic][0] - time[elastic][-1] <= 1.01 / 8 / 32
    assert result.march.ledger.imbalance <= 1e-9
    # the crack has taken its energy, nearly all of it in the snap
    taken = result.march.ledger.material_dissipation
    assert taken == pytest.approx(ENERGY * ROW, rel=0.05)


def test_it_snaps_where_contacts_find_no_solution_for_slopes_downwards(monkeypatch):
    """As in walls, where the tangents of a stone that cracks leave a contact problem without a solution."""
    first = step._first

    def unsolved(rounds: Rounds) -> Round:
        made = first(rounds)
        if rounds.settled(made):
            return made
        return replace(made, solution=replace(made.solution, outcome=Outcome.STALLED))

    monkeypatch.setattr(step, "_first", unsolved)
    result, curve = followed(pulled())
    assert result.outcome == "equilibrium", result.message
    assert sum(remark.code == "snapped" for remark in result.summary.remarks) == 1
    assert curve.rows[-1][2] == pytest.approx(closed_form(PULL)[0], rel=1e-7)
