"""Material laws from a file of the user's: the one that docs/add_a_material.md writes, beside a scene."""

import re

import pytest

from masonry_fem import cli
from masonry_fem.analyses.run import solve_scene
from masonry_fem.build import build
from masonry_fem.errors import LawError, SceneError
from masonry_fem.scene import load, save

SCENE = """
dimension = 2
fidelity = "inelastic"
mesh = { element = "Q1", divisions = [2, 2] }

[materials.tuff]
density = 1e-3
young = "1 GPa"
poisson = 0.2

[materials.tuff.inelastic]
law = "python"
file = "compaction.py"
name = "Compaction"
trusted = true
parameters = { crushing_pressure = 1e5 }

[[structures]]
kind = "block"
name = "floor"
material = "tuff"
size = [2.0, 0.2]
position = [-0.5, -0.2]
support = true

[[structures]]
kind = "block"
name = "cube"
material = "tuff"
size = [1.0, 1.0]

[[joints]]
friction = 0.0

[[supports]]
on = "cube/left"
components = ["x"]

[[loads.tractions]]
on = "cube/top"
vector = [0.0, -4e5]

[[probes]]
name = "top"
block = "cube"
point = [1.0, 1.0]

[analysis]
kind = "statics"

[output]
pictures = false
"""


@pytest.fixture(name="folder")
def _folder(tmp_path, repository):
    page = (repository / "docs/add_a_material.md").read_text(encoding="utf-8")
    (block,) = re.findall(r"`[\w/]*compaction\.py`:\n\n```python\n(.*?)```", page, re.S)
    (tmp_path / "compaction.py").write_text(block, encoding="utf-8")
    (tmp_path / "scene.toml").write_text(SCENE, encoding="utf-8")
    return tmp_path


def test_a_law_beside_the_scene_crushes_a_cube(folder):
    """Plane strain, free to the side: with −p = p_c the top sinks by (2 q − 3 p_c)/2G."""
    scene = load(folder / "scene.toml")
    result = solve_scene(scene, folder)
    assert result.outcome == "equilibrium"
    shear = 1e9 / (2 * 1.2)
    assert result.summary.probes["top"][1] == pytest.approx(-(2 * 4e5 - 3 * 1e5) / (2 * shear), rel=1e-6)
    assert [one.block for one in result.summary.stress.yielded] == ["cube"]


def test_it_survives_saving(folder):
    scene = load(folder / "scene.toml")
    save(scene, folder / "again.toml")
    assert load(folder / "again.toml") == scene


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("trusted = true", "trusted = false", r"materials\.tuff\.inelastic\.trusted .* is a program"),
        ('file = "compaction.py"', 'file = "nowhere.py"', r"materials\.tuff\.inelastic\.file .*nowhere\.py"),
        (
            'name = "Compaction"',
            'name = "Compactor"',
            r"does not have, expected one of its laws 'Compaction'",
        ),
        ('name = "Compaction"', 'name = "Plastic"', r"Plastic' of '.*' lacks"),
        (
            "crushing_pressure = 1e5",
            "crushing = 1e5",
            r"unknown key 'crushing'.*expected 'crushing_pressure'",
        ),
        ("{ crushing_pressure = 1e5 }", "{}", r"lacks 'crushing_pressure'"),
    ],
)
def test_what_is_wrong_is_said_in_a_sentence(folder, old, new, message):
    assert old in SCENE
    (folder / "scene.toml").write_text(SCENE.replace(old, new), encoding="utf-8")
    with pytest.raises(SceneError, match=message):
        build(load(folder / "scene.toml"), folder)


def test_check_runs_no_file_unasked(folder, capsys, monkeypatch):
    """And --trust is asking."""
    (folder / "scene.toml").write_text(SCENE.replace("trusted = true\n", ""), encoding="utf-8")
    (folder / "compaction.py").write_text("open('ran', 'w').close()\nraise SystemError", encoding="utf-8")
    monkeypatch.chdir(folder)
    assert cli.main(["check", str(folder / "scene.toml")]) == 1
    assert "trusted" in capsys.readouterr().err
    assert not (folder / "ran").exists()
    assert cli.main(["check", str(folder / "scene.toml"), "--trust"]) == 1
    assert "failed with SystemError" in capsys.readouterr().err
    assert (folder / "ran").exists()


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            "volume = np.where(crushed",
            "volum = np.where(crushed",
            r"(update|yields) failed with NameError: name 'vol",
        ),
        ("(elastic, (start, strain)", "((start, strain)", r"(update|yields) failed with TypeError: "),
        (
            "        return self.response(",
            "        self.response(",
            r"(update|yields) failed with AttributeError: 'None",
        ),
        ("over / elastic.bulk, 0.0)", "np.nan, 0.0)", "'Compaction': update: stress is not finite, expected"),
        ("np.zeros((len(strain), 0))", "np.zeros((len(strain), 1))", r"internal has the shape \(16, 8\)"),
    ],
)
@pytest.mark.parametrize("key", ['"inelastic"', '"inelastic"\nplane = "stress"', '"auto"'])
def test_what_a_law_does_wrong_as_stone_yields_is_told_as_its_own(folder, old, new, message, key):
    text = (folder / "compaction.py").read_text(encoding="utf-8")
    assert old in text
    (folder / "compaction.py").write_text(text.replace(old, new), encoding="utf-8")
    (folder / "scene.toml").write_text(SCENE.replace('"inelastic"', key), encoding="utf-8")
    with pytest.raises(LawError, match=message):
        solve_scene(load(folder / "scene.toml"), folder)
