"""Joint laws from a file of the user's."""

import textwrap
from pathlib import Path

import pytest
from msgspec.structs import replace

from masonry_fem import cli
from masonry_fem.analyses.run import solve_scene
from masonry_fem.build import build
from masonry_fem.errors import SceneError
from masonry_fem.scene import check, load, loads, save, specs
from masonry_fem.structures.stack import StackStructure

CORK = '''\
"""Cork: springs in tension and shear."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, override

import numpy as np

from masonry_fem.joints.laws.parts.adhesive import Adhesive, Evolution
from masonry_fem.joints.parameters import Friction, Parameter, Stiffness, check_ranges


@dataclass(frozen=True, slots=True, eq=False)
class Cork(Adhesive):
    """Springs, the same in every direction."""

    stiffness: Stiffness
    friction: Friction = 0.1
    grade: str = "fine"

    name: ClassVar[str] = "cork"

    def __post_init__(self) -> None:
        check_ranges(self)
        if self.grade not in {"fine", "coarse"}:
            raise KeyError(self.grade)

    @property
    def normal_stiffness(self) -> Parameter:
        return self.stiffness

    @property
    def tangential_stiffness(self) -> Parameter:
        return self.stiffness

    @override
    def evolve(self, state, jump, step):
        return Evolution(state.adhesion, np.zeros(state.count), np.zeros(state.count))


class Unnamed(Cork):
    name = None


class Sketch(Adhesive):
    name = "sketch"


answer = 42
'''

SCENE = """
dimension = 2
fidelity = "rigid"
[materials.stone]
density = 2000.0
[[structures]]
kind = "stack"
name = "s"
material = "stone"
size = [0.5, 0.2]
count = 1
[[joints]]
friction = 0.75
[joints.law]
kind = "python"
file = "laws/cork.py"
law = "Cork"
trusted = true
[joints.law.parameters]
stiffness = 1e9
[[loads.tractions]]
on = "s.b1/top"
vector = [0.0, 1e5]
[[probes]]
name = "p"
block = "s.b1"
point = [0.25, 0.2]
"""


@pytest.fixture
def folder(tmp_path):
    """A folder with a scene file and the law it names."""
    (tmp_path / "laws").mkdir()
    (tmp_path / "laws" / "cork.py").write_text(CORK)
    (tmp_path / "scene.toml").write_text(SCENE)
    return tmp_path


def test_a_law_of_the_users_holds_the_joint(folder):
    scene = load(folder / "scene.toml")
    result = solve_scene(scene, folder)
    assert result.outcome == "equilibrium"
    assert result.march.report.probes["p"] == pytest.approx([0.0, 1e5 / 1e9], abs=1e-15)
    ((law, points),) = result.built.model.laws.parts
    assert law.name == "cork"
    assert law.friction == 0.75  # the joint's
    assert len(points) == 2


def test_a_file_is_read_again_when_it_changed(folder):
    scene = load(folder / "scene.toml")
    build(scene, folder)
    (folder / "laws" / "cork.py").write_text(
        CORK.replace('name: ClassVar[str] = "cork"', 'name: ClassVar[str] = "oak"')
    )
    ((law, _),) = build(scene, folder).model.laws.parts
    assert law.name == "oak"
    assert [one.name for one in (folder / "laws").iterdir()] == ["cork.py"]


def test_files_of_the_same_name_are_two(folder):
    (folder / "other").mkdir()
    (folder / "other" / "cork.py").write_text(CORK.replace("    friction: Friction = 0.1\n", ""))
    both = SCENE.replace("count = 1", "count = 2") + textwrap.dedent("""
        [[joints]]
        between = ["s.b1", "s.b2"]
        [joints.law]
        kind = "python"
        file = "other/cork.py"
        law = "Cork"
        trusted = true
        parameters = {stiffness = 2e9}
        """)
    laws = build(loads(both, base=folder), folder).model.laws
    assert [(law.stiffness, hasattr(law, "friction")) for law, _ in laws.parts] == [(1e9, True), (2e9, False)]


@pytest.mark.parametrize("command", ["check", "run", "limit", "collapse"])
def test_no_command_runs_it_unasked(command, folder, capsys):
    """Law files are programs: not even a check runs one that the user has not said to trust."""
    mark, scene = folder / "ran", folder / "scene.toml"
    with (folder / "laws" / "cork.py").open("a") as file:
        file.write(f"open({str(mark)!r}, 'w').close()\n")
    asked = SCENE.replace("trusted = true\n", "")
    trusted = loads(SCENE, base=folder)
    joint = trusted.joints[0]
    scene.write_text(asked)
    out = [] if command in ("check", "limit") else ["--out", str(folder / "out")]
    assert cli.main([command, str(scene), *out, "--quiet"]) == 1
    told = capsys.readouterr().err
    assert not mark.exists()
    assert "joints.0.law.trusted is false, expected true: 'laws/cork.py' is a program" in told
    assert "--trust" in told
    assert cli.main(["check", str(scene), "--quiet", "--trust"]) == 0
    assert mark.exists()
    with pytest.raises(SceneError, match=r"law\.trusted is false"):
        loads(asked, base=folder)
    mark.unlink()
    unasked = replace(joint, law=replace(joint.law, trusted=False))
    with pytest.raises(SceneError, match=r"law\.trusted is False, expected true"):
        build(replace(trusted, joints=(unasked,)), folder)  # which nobody has checked
    assert not mark.exists()


def test_a_scene_with_it_is_written_and_read(folder):
    scene = loads(SCENE, base=folder)
    save(scene, folder / "again.toml")
    assert load(folder / "again.toml") == scene
    assert scene.joints[0].law == specs.PythonLaw(
        file="laws/cork.py", law="Cork", trusted=True, parameters={"stiffness": 1e9}
    )


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("laws/cork.py", "laws/crok.py", r"line 16: joints\.0\.law\.file is .*crok.*did you mean 'cork\.py'"),
        ("laws/cork.py", "cork.txt", r"joints\.0\.law\.file is 'cork\.txt', expected a Python file"),
        ("= 1e9", "= [1]", r"parameters\.stiffness is \[1\], expected .*number.*text"),
        ("stiffness = 1e9", "'9' = 1.0", r"expected a name"),
    ],
)  # fmt: skip
def test_what_the_scene_gets_wrong(folder, old, new, words):
    with pytest.raises(SceneError, match=words):
        loads(SCENE.replace(old, new), base=folder)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('"Cork"', '"Kork"', r"law is 'Kork', which '.*cork\.py' does not have.*did you mean 'Cork'"),
        ('"Cork"', '"answer"', r"'answer' of '.*cork\.py' is a int that is no joint law.*there is 'Cork'"),
        ('"Cork"', '"Evolution"', r"'Evolution' of '.*cork\.py' is a class that is no joint law"),
        ('"Cork"', '"Unnamed"', r"'Unnamed' of '.*' lacks 'name'"),
        ('"Cork"', '"Sketch"', r"'Sketch' of '.*' lacks 'evolve'"),
        ("stiffness =", "stifness =", r"unknown key 'stifness'.*did you mean 'stiffness'"),
        ("stiffness = 1e9", "", r"parameters lacks 'stiffness', which 'Cork'"),
        ("= 1e9", "= -1", r"joints\.0\.law: law 'cork': stiffness is -1"),
        ("= 1e9", "= '1 GPa'", r"failed with ValueError.*numbers without quotes"),
        ("= 1e9", "= 1e9\ngrade = 'bad'", r"Cork\(.*grade='bad'.*\) of '.*' failed with KeyError"),
    ],
)  # fmt: skip
def test_what_the_law_refuses(folder, old, new, words):
    with pytest.raises(SceneError, match=words):
        build(loads(SCENE.replace(old, new), base=folder), folder)


@pytest.mark.parametrize(
    ("code", "words"),
    [
        ("def f(:\n", r"joints\.0\.law\.file: '.*cork\.py' failed with SyntaxError.*line 1"),
        ("x = 1\ny = x / 0\n", r"'.*cork\.py', line 2, failed with ZeroDivisionError"),
        ("import no_such_thing\n", r"line 1, failed with ModuleNotFoundError: .*no_such_thing"),
    ],
)
def test_a_file_that_does_not_run(folder, code, words):
    (folder / "laws" / "cork.py").write_text(code)
    with pytest.raises(SceneError, match=words):
        build(loads(SCENE, base=folder), folder)


def test_from_python_the_file_must_be_there_too():
    law = specs.PythonLaw(file="nowhere.py", law="Cork", trusted=True)
    block = StackStructure(name="s", material="m", size=(1.0, 1.0), count=1)
    scene = specs.Scene(dimension=2, materials={"m": specs.Material(density=2000.0)}, structures=(block,),
                        joints=(specs.Joint(law=law),), fidelity="rigid")  # fmt: skip
    with pytest.raises(SceneError, match=r"nowhere\.py.*expected an existing file"):
        check(scene)
    with pytest.raises(SceneError, match=r"nowhere\.py' does not exist"):
        build(scene, Path())
