"""A march to equilibrium goes on until what is prescribed has come to its end."""

import logging
from pathlib import Path

import pytest
from msgspec.structs import replace

from masonry_fem.build.supports import last_change
from masonry_fem.scene.specs import (
    Equilibrium,
    Loads,
    Material,
    Motion,
    Scene,
    Sine,
    Support,
    Table,
)
from masonry_fem.structures.block import BlockStructure
from tests.validation.scenes import G, solved

LATE = Table(points=((0.0, 0.0), (1.0, 0.0), (2.0, 1.0), (9.0, 1.0)))


def settling(motion: Motion, max_steps: int = 60, **more):
    """A cube on ground that sinks, marched by steps of 0.1 s."""
    ground = BlockStructure(name="ground", material="stone", size=(3.0, 0.5), position=(-1.0, -0.5))
    block = BlockStructure(name="block", material="stone", size=(1.0, 1.0), position=(0.0, 0.0))
    return solved(
        dimension=2,
        fidelity="rigid",
        structures=(ground, block),
        supports=(Support(on="ground", motion=motion),),
        loads=Loads(gravity=(0.0, -G), **more),
        analysis=Equilibrium(strategy="large_step", step=0.1, max_steps=max_steps, tolerance=1e-6),
    )


def test_a_motion_that_begins_late_is_made() -> None:
    made = settling(Motion(displacement=(0.0, -0.01), time=LATE))
    assert made.outcome == "equilibrium"
    assert made.march.report.time == pytest.approx(2.1, abs=0.11)
    assert made.march.state.bodies[1].shift[0, 1] == pytest.approx(-0.01, abs=1e-6)


def test_a_motion_without_a_time_takes_a_tenth_of_the_steps() -> None:
    made = settling(Motion(displacement=(0.0, -1e-9)), max_steps=100)
    assert made.march.report.time >= 1.0
    assert made.march.state.bodies[1].shift[0, 1] == pytest.approx(-1e-9, abs=1e-12)


def test_too_few_steps_for_a_motion_are_told(caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.WARNING):
        settling(Motion(displacement=(0.0, -0.01), time=LATE), max_steps=15)
    assert "change until t = 2 s, and the march ends at 1.5 s" in caplog.text


def test_what_oscillates_has_no_end(tmp_path: Path) -> None:
    scene = Scene(
        dimension=2,
        materials={"stone": Material(density=2000.0)},
        structures=(BlockStructure(name="ground", material="stone", size=(3.0, 0.5), support=True),),
        loads=Loads(gravity=(0.0, -G), gravity_time=Sine(frequency=1.0)),
    )
    assert last_change(scene, tmp_path) == 0.0
    assert last_change(replace(scene, loads=Loads(gravity=(0.0, -G), gravity_time=LATE)), tmp_path) == 2.0
