"""Scenes to begin with, and what keys mean: both from the records, so that they cannot be out of date."""

import re

import pytest

from masonry_fem import solve
from masonry_fem.analyses.inspect import check_scene
from masonry_fem.cli import main
from masonry_fem.errors import MasonryError
from masonry_fem.scene import explaining, loads
from masonry_fem.scene.beginning import beginning
from masonry_fem.scene.explaining import all_keys, explain
from masonry_fem.structures import kinds

FROM_FILES = ("file", "survey")


@pytest.mark.parametrize("kind", [kind for kind in kinds() if kind not in FROM_FILES])
def test_a_scene_to_begin_with_can_be_built(kind):
    scene = loads(beginning(kind))
    assert scene.structures[0].__struct_config__.tag == kind
    assert check_scene(scene).blocks >= 1


@pytest.mark.parametrize("kind", [kind for kind in kinds() if kind not in FROM_FILES])
def test_its_comments_have_the_defaults(kind):
    """With the '#' before each of them taken away nothing changes."""
    text = beginning(kind)
    whole = re.sub(r"^# (\w+ = .+)$", r"\1", text, flags=re.M)
    assert whole != text
    assert loads(whole) == loads(text)


@pytest.mark.parametrize("kind", [kind for kind in kinds() if kind not in FROM_FILES])
def test_a_scene_to_begin_with_stands(kind):
    """As rigid stones, which need neither meshes nor pictures to say so."""
    quick = ["fidelity=rigid", "output={fields=false, pictures=false}"]
    assert solve(loads(beginning(kind), quick)).outcome == "equilibrium"


def test_what_a_file_has_to_be_held_by_is_left_to_its_user():
    text = beginning("file")
    assert '# [[supports]]\n# on = "file/bottom"' in text
    assert "[[supports]]" not in beginning("survey")  # it brings its ground


def test_a_kind_that_is_none_is_refused():
    with pytest.raises(MasonryError, match=r"'archh' is no kind of structure; did you mean 'arch'\?.*'?wall"):
        beginning("archh")


def test_the_command_writes_a_file_and_leaves_others_alone(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["new", "stack"]) == 0
    assert loads((tmp_path / "stack.toml").read_text(encoding="utf-8")).structures[0].count == 5
    (tmp_path / "mine.toml").write_text("mine", encoding="utf-8")
    capsys.readouterr()
    assert main(["new", "stack", "mine.toml"]) == 1
    assert "'mine.toml' exists and is left alone" in capsys.readouterr().err
    assert (tmp_path / "mine.toml").read_text(encoding="utf-8") == "mine"


def test_every_key_is_explained_by_its_path(monkeypatch):
    """With words of the user's in the place of NAME, too."""
    keys = list(all_keys())
    assert len(keys) > 500
    monkeypatch.setattr(explaining, "all_keys", lambda: keys)  # made once: it takes a while
    for key in keys:
        told = explain(key.name.replace("NAME", "granite"))
        assert key.meaning in told
        assert key.expected in told


@pytest.mark.parametrize(
    ("asked", "told"),
    [
        ("materials.granite.young", "materials.NAME.young: a pressure > 0 in Pa\n  Young's modulus"),
        ("young", "materials.NAME.orthotropic.young"),  # wherever it stands
        ("joints.0.friction", "joints.friction: a number >= 0, or 'no slip'; default 0.6"),
        ("structures.wall", 'example:\n    kind = "wall"'),
        ("wall", "structures.wall: Wall of"),
        ("[design]", "material_factor: a number > 0; default 1.0\n    factor γ_M by which strengths"),
        ("analysis", "kinds: crossing, dynamics, equilibrium, path, statics"),
        ("structures.kind", "kinds: arch, arch_bridge"),
        ("materials.granite.inelastic.law", "kinds: brittle_damage"),
        ("output.stones", "stones.csv (docs/results.md#stonescsv)"),
    ],
)
def test_keys_tables_and_kinds_are_found(asked, told, capsys):
    assert main(["explain", asked]) == 0
    assert told in capsys.readouterr().out.replace("`", "")


def test_a_key_that_is_none_is_refused_with_the_nearest(capsys):
    assert main(["explain", "frictoin"]) == 1
    assert "'frictoin' is no key of scene files; did you mean 'friction'?" in capsys.readouterr().err
