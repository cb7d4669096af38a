"""Pictures of mechanisms, in the plane and in space, and what runs tell of them."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from masonry_fem.analyses.collapse import collapse
from masonry_fem.analyses.run import run
from masonry_fem.output.mechanism_picture import FIXED, PART_COLOURS, SLIDING, draw_mechanism
from masonry_fem.output.render import can_render
from masonry_fem.output.scenery import Scenery
from masonry_fem.scene.specs import Acceleration, Joint, Loads, Material, Output, Scene
from masonry_fem.structures.wall import WallStructure

pytestmark = pytest.mark.skipif(not can_render(), reason="this machine cannot draw")


def wall(dimension: int, friction: float, **keys) -> Scene:
    brick = (0.4, 0.2, 0.2)[:dimension]
    stones = WallStructure(name="wall", material="stone", brick=brick, columns=2, courses=3)
    given = {
        "dimension": dimension,
        "fidelity": "rigid",
        "materials": {"stone": Material(density=2400.0)},
        "structures": (stones,),
        "joints": (Joint(friction=friction),),
        "loads": Loads(gravity=(0.0,) * (dimension - 1) + (-9.81,)),
    } | keys
    return Scene(**given)


def shares(path: Path) -> dict[str, float]:
    """Part of the picture's pixels within a few shades of each colour."""
    pixels = np.asarray(Image.open(path).convert("RGB"), float).reshape(-1, 3)
    found = {}
    for colour in (*PART_COLOURS[:2], FIXED, SLIDING):
        own = np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)])
        found[colour] = float((np.abs(pixels - own).max(axis=1) < 14).mean())
    return found


@pytest.mark.slow
@pytest.mark.parametrize("dimension", [2, 3])
def test_parts_and_sliding_joints_are_drawn(dimension: int, tmp_path: Path) -> None:
    found = collapse(wall(dimension, 0.3), acceleration="x", tolerance=0.05)
    assert found.mechanism.of("slides")
    path = draw_mechanism(
        Scenery.of(found.model, found.state, "wall"), found.mechanism, tmp_path / "mechanism.png"
    )
    seen = shares(path)
    assert seen[SLIDING] > 1e-5
    if dimension == 2:  # in space light shades them
        assert seen[PART_COLOURS[0]] > 0.05
        assert seen[FIXED] > 0.01


def test_a_run_without_equilibrium_tells_and_draws_its_mechanism(tmp_path: Path) -> None:
    loads = Loads(gravity=(0.0, -9.81), accelerations=(Acceleration(vector=(4.0, 0.0)),))
    result = run(wall(2, 0.3, loads=loads, output=Output(fields=False)), tmp_path)
    assert result.outcome == "no_equilibrium"
    told = json.loads((tmp_path / "summary.json").read_text())["mechanism"]
    assert "sliding joint" in told["sentence"]
    assert told["joints"][0]["how"] == "slides"
    assert {name for group in told["groups"] for name in group} >= {"wall.c1.b1", "wall.c3.b1"}
    assert tmp_path / "mechanism.png" in result.files


@pytest.mark.slow
def test_a_run_that_rests_has_none(tmp_path: Path) -> None:
    result = run(wall(2, 0.3, output=Output(fields=False)), tmp_path)
    assert result.summary.mechanism is None
    assert not (tmp_path / "mechanism.png").exists()
