"""Results that hold to rounding and mean nothing, or whose rounding is large: the run says so."""

from __future__ import annotations

import logging

import pytest

from masonry_fem.analyses.run import solve_scene
from masonry_fem.scene.specs import Contact, Dynamics, Initial, Loads, Material, MeshSettings, Scene
from masonry_fem.structures.block import BlockStructure
from tests.extremes.solids import DENSITY, arch, column, slender, wall


def told(caplog: pytest.LogCaptureFixture, words: str) -> list[str]:
    """Warnings with these words."""
    messages = [record.getMessage() for record in caplog.records if record.levelno >= logging.WARNING]
    return [message for message in messages if words in message]


@pytest.mark.slow
@pytest.mark.parametrize(("young", "strain"), [(1e3, ["82"]), (1e5, ["0.82"]), (1e6, ["0.082"]), (1e7, [])])
def test_large_strain_is_told(young: float, strain: list[str], caplog: pytest.LogCaptureFixture) -> None:
    """Four cubes: the lowest one's mean strain is 3.5 ρ g L / E."""
    result = solve_scene(column([young] * 4))
    assert result.outcome == "equilibrium"
    found = told(caplog, "small strains")
    assert [message.split(":")[0] for message in found] == [
        f"'stack.b1' is strained by {one}" for one in strain
    ]


@pytest.mark.parametrize(
    ("spin", "update", "degrees"),
    [
        (0.1, "fixed", []), (0.3, "fixed", []), (0.5, "fixed", ["28.6"]), (3.0, "fixed", ["172"]),
        (3.0, "moving", []),
    ],
)  # fmt: skip
def test_large_turn_is_told(
    spin: float, update: str, degrees: list[str], caplog: pytest.LogCaptureFixture
) -> None:
    """A free elastic block that spins for a second: with fixed contacts its kinematics are small."""
    scene = Scene(
        dimension=2,
        materials={"stone": Material(density=DENSITY, young=1e10)},
        structures=(BlockStructure(name="cube", material="stone", size=(1.0, 1.0)),),
        mesh=MeshSettings(divisions=(2, 2)),
        initial=(Initial(blocks="cube", spin=spin),),
        loads=Loads(),
        contact=Contact(update=update),
        analysis=Dynamics(step=0.1, duration=1.0),
    )
    assert solve_scene(scene).outcome == "finished"
    found = told(caplog, "small strains")
    assert [message.split(":")[0] for message in found] == [
        f"'cube' has turned by {one} degrees" for one in degrees
    ]


@pytest.mark.parametrize(("aspect", "doubted"), [(1e2, False), (1e4, False), (1e6, True)])
def test_rounding_of_balances_is_told(aspect: float, doubted: bool, caplog: pytest.LogCaptureFixture) -> None:
    """Needles a million times as long as thick balance their own weight to 4e-4 only."""
    result = solve_scene(slender(aspect, lying=False))
    assert result.outcome == "equilibrium"
    assert (result.summary.certificate.block_balance > 1e-6) == doubted
    assert bool(told(caplog, "forces balance to")) == doubted


def test_common_masonry_is_not_doubted(caplog: pytest.LogCaptureFixture) -> None:
    for scene in (wall(), arch(), arch(fidelity="rigid"), wall(fidelity="rigid")):
        assert solve_scene(scene).outcome == "equilibrium"
    assert not told(caplog, "")
