"""Structures of every kind: what is saved is what was read."""

from __future__ import annotations

import pytest

from masonry_fem.scene import load as load_scene
from masonry_fem.scene import loads, save
from masonry_fem.scene.specs import Opening
from masonry_fem.structures.buttress import ButtressStructure
from masonry_fem.structures.column import ColumnStructure
from masonry_fem.structures.corbel import CorbelStructure
from masonry_fem.structures.rubble import RubbleStructure
from masonry_fem.structures.staircase import StaircaseStructure
from masonry_fem.structures.wall import WallStructure

TEXT = """
fidelity = "rigid"
[materials.stone]
density = "2400 kg/m^3"
[[structures]]
name = "it"
material = "stone"
"""
KINDS = {
    WallStructure: """
kind = "wall"
brick = ["220 mm", "110 mm", "60 mm"]
columns = 5.5
courses = 8
bond = "english"
wythes = 2
openings = [{ position = ["0.44 m", 0.12], size = [0.44, "240 mm"], bearing = "11 cm" }]
""",
    CorbelStructure: """
kind = "corbel"
size = [1.0, 0.4, 0.2]
count = 4
offset = "500 mm"
profile = "harmonic"
table = true
""",
    ButtressStructure: """
kind = "buttress"
width = 1.5
height = 4
courses = 8
top = 0.6
stages = 4
lean = "0.1 rad"
""",
    ColumnStructure: """
kind = "column"
drums = 5
height = 4
diameter = "80 cm"
top_diameter = 0.6
entasis = 0.02
plinth = 0.2
projection = 0.1
""",
    StaircaseStructure: """
kind = "staircase"
steps = 7
going = 0.3
rise = "17 cm"
width = 1.2
lap = 0.04
bearing = 0.2
""",
    RubbleStructure: """
kind = "rubble"
size = [2.0, 0.5, 1.0]
stones = 30
seed = 4
elongation = 2
joint = "5 mm"
""",
}


@pytest.mark.parametrize("kind", KINDS)
def test_kinds_are_saved_as_they_were_read(kind, tmp_path) -> None:
    scene = loads(TEXT + KINDS[kind])
    assert isinstance(scene.structures[0], kind)
    save(scene, tmp_path / "scene.toml")
    assert load_scene(tmp_path / "scene.toml") == scene


def test_openings_are_read_with_units() -> None:
    (wall,) = loads(TEXT + KINDS[WallStructure]).structures
    assert wall.openings == (Opening(position=(0.44, 0.12), size=(0.44, 0.24), bearing=0.11),)


def test_pattern_is_read() -> None:
    text = KINDS[WallStructure].split("columns")[0] + "courses = 4\npattern = [[1, 1, 1], [0.5, -1, 1, 0.5]]"
    (wall,) = loads(TEXT + text).structures
    assert wall.pattern == ((1.0, 1.0, 1.0), (0.5, -1.0, 1.0, 0.5))
    assert wall.length == pytest.approx(0.66)
