"""A6.4: a beam on three supports, indeterminate until one of them settles.

A rigid beam of length L lies on unilateral supports at 0, 0.6 L and L. Once the last settles, by however
little, balance decides: R(0.6 L) = W/1.2 = 0.83333 W, R(0) = 0.16667 W. The supports are stones of 1 mm.
"""

from __future__ import annotations

import pytest

from masonry_fem.analyses.limit import analyse
from masonry_fem.scene.specs import (
    Equilibrium,
    Joint,
    Loads,
    Motion,
    Scene,
    Solver,
    Statics,
    Support,
    Table,
)
from masonry_fem.structures.block import BlockStructure
from tests.validation.scenes import STONE, G, solved

SPAN, WIDTH, HEIGHT = 5.0, 1e-3, 0.3
WEIGHT = SPAN * HEIGHT * STONE.density * G
PLACES = {"left": 0.0, "middle": 0.6 * SPAN - WIDTH / 2, "right": SPAN - WIDTH}


def beam(**keys):
    """Fields of the scene: a beam on three narrow stones."""
    stones = tuple(
        BlockStructure(
            name=name, material="stone", size=(WIDTH, 0.2), position=(x, -0.2), fidelity="rigid", support=True
        )
        for name, x in PLACES.items()
    )
    on = BlockStructure(name="beam", material="stone", size=(SPAN, HEIGHT), position=(0.0, 0.0))
    return {
        "dimension": 2,
        "fidelity": "rigid",
        "structures": (*stones, on),
        "joints": (Joint(friction=0.6, placement="corners"),),
    } | keys


def carried(**keys) -> dict[str, float]:
    """Vertical forces of the supports over the weight."""
    result = solved(**beam(**keys))
    assert result.outcome == "equilibrium"
    return {name: float(value.force[1]) / WEIGHT for name, value in result.summary.supports.items()}


def settled(drop: float, on: str = "right", times: Table | None = None) -> tuple[Support, ...]:
    return (Support(on=on, motion=Motion(displacement=(0.0, -drop), time=times)),)


def test_before_it_settles_the_force_at_the_middle_is_anything() -> None:
    told = analyse(Scene(materials={"stone": STONE}, loads=Loads(gravity=(0.0, -G)), **beam()))
    low, high = told.supports["middle"]["y"]
    assert low / WEIGHT == pytest.approx(0.0, abs=1e-6)
    assert high / WEIGHT == pytest.approx(0.83333, abs=3e-4)


@pytest.mark.parametrize("drop", [1e-6, 1e-4, 1e-2])
@pytest.mark.parametrize(
    "analysis",
    [Statics(load_steps=2), Equilibrium(strategy="large_step", step=0.05, max_steps=100, tolerance=1e-6)],
    ids=["statics", "steps"],
)
def test_a_support_that_settles_hands_its_load_on(drop: float, analysis) -> None:
    found = carried(supports=settled(drop), analysis=analysis)
    assert found["middle"] == pytest.approx(0.83333, abs=2e-4)
    assert found["left"] == pytest.approx(0.16667, abs=2e-4)
    assert found["right"] == pytest.approx(0.0, abs=1e-9)


def test_the_middle_that_settles_is_relieved() -> None:
    found = carried(supports=settled(1e-3, "middle"), analysis=Statics(load_steps=2))
    assert found["middle"] == pytest.approx(0.0, abs=1e-9)
    assert found["left"] == pytest.approx(0.5, abs=2e-4)


def test_a_support_that_comes_back_takes_load_again_only_when_it_lifts() -> None:
    """Down by 1 mm and up by 2: the beam lies on its two ends, the middle carries nothing."""
    times = Table(points=((0.0, 0.0), (0.5, 1.0), (1.0, -1.0)))
    found = carried(supports=settled(1e-3, times=times), analysis=Statics(load_steps=8))
    assert found["middle"] == pytest.approx(0.0, abs=1e-9)
    assert found["right"] == pytest.approx(0.5, abs=2e-4)


def test_an_elastic_beam_needs_as_much_as_it_bends() -> None:
    """A beam that can bend keeps some of the right end's load until that has settled further than it sags."""
    stiff = {"fidelity": "elastic", "solver": Solver()}
    far = carried(supports=settled(1e-3), analysis=Statics(load_steps=2), **stiff)
    near = carried(supports=settled(1e-6), analysis=Statics(load_steps=2), **stiff)
    assert far["middle"] == pytest.approx(0.83333, abs=1e-3)
    assert far["right"] == pytest.approx(0.0, abs=1e-9)
    assert 0.0 < near["right"] < 0.2
