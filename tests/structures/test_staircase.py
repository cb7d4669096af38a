"""Staircase: steps in a wall, each on the one below."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from masonry_fem.contact.depth import overlapping
from masonry_fem.contact.detection import detect
from masonry_fem.errors import SceneError
from masonry_fem.scene import check
from masonry_fem.scene.specs import Equilibrium, Joint, Material, MeshSettings, Scene, Statics
from masonry_fem.structures import build_structure
from masonry_fem.structures.staircase import StaircaseStructure
from tests.validation.scenes import G, solved

ONE_STEP = Equilibrium(strategy="large_step", step=0.01, max_steps=3, tolerance=1e-6)


def stair(**keys) -> StaircaseStructure:
    given = {"name": "s", "material": "stone", "steps": 5, "going": 0.3, "rise": 0.18, "width": 1.2,
             "lap": 0.04, "bearing": 0.2}  # fmt: skip
    return StaircaseStructure(**(given | keys))


def test_steps_rest_on_each_other_and_in_the_wall() -> None:
    made = build_structure(stair(), 3, Path(), MeshSettings())
    assert overlapping(made) == []
    names = [block.name for block in made.blocks]
    assert len(names) == 1 + 5 + 4 + 5
    lows = np.array([made.solid(names.index(f"s.s{k}")).vertices.min(axis=0) for k in range(1, 6)])
    assert lows == pytest.approx(np.outer(range(5), [0.3, 0.0, 0.18]))
    beds: dict[frozenset[str], float] = {}
    for one in detect(made):
        if one.label == "bed":
            pair = frozenset(names[block] for block in one.blocks)
            beds[pair] = beds.get(pair, 0.0) + one.area
    assert beds.pop(frozenset({"s.s1", "s.ground"})) == pytest.approx(0.34 * 1.4)
    for number in range(1, 6):
        assert beds.pop(frozenset({f"s.s{number}", f"s.above{number}"})) == pytest.approx(0.3 * 0.2)
        if number > 1:
            assert beds.pop(frozenset({f"s.s{number}", f"s.s{number - 1}"})) == pytest.approx(0.04 * 1.4)
            assert beds.pop(frozenset({f"s.s{number}", f"s.below{number}"})) == pytest.approx(0.3 * 0.2)
    assert beds == {}
    assert len(made.shapes) == 3


@pytest.mark.parametrize("fidelity", ["rigid", "elastic"])
def test_steps_hang_from_the_wall(fidelity) -> None:
    spec = stair(steps=3)
    result = solved(fidelity=fidelity, structures=(spec,), joints=(Joint(friction=0.6),),
                    analysis=ONE_STEP if fidelity == "rigid" else Statics(),
                    mesh=MeshSettings(divisions=(1, 4, 1)))  # fmt: skip
    assert result.outcome == "equilibrium"
    force = sum(np.array(one.force) for one in result.summary.supports.values())
    assert force == pytest.approx([0.0, 0.0, 3 * 2400 * G * 0.34 * 1.4 * 0.18], rel=1e-6, abs=1e-3)


def test_impossible_stairs_are_refused() -> None:
    def refusal(dimension: int, **keys) -> str:
        scene = Scene(dimension=dimension, fidelity="rigid", structures=(stair(**keys),),
                      materials={"stone": Material(density=2000.0)})  # fmt: skip
        with pytest.raises(SceneError) as caught:
            check(scene)
        return str(caught.value)

    assert "width is 1.2, expected a scene of dimension 3" in refusal(2)
    assert "lap is 0.3, expected less than the going (0.3 m)" in refusal(3, lap=0.3)
