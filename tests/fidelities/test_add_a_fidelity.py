"""A file put into masonry_fem/fidelities is a fidelity wherever it matters."""

import json
import os
import re
import subprocess
import sys

import pytest

UPRIGHT = '''
from masonry_fem.bodies.rigid import RigidGroup
from masonry_fem.fidelities.rigid import Rigid as Base

class UprightGroup(RigidGroup):
    kind = "upright"

class Upright(Base):
    """Stones whose lever arms stay those of the start."""
    name, rank = UprightGroup.kind, 1.5

    @classmethod
    def groups(cls, given):
        density = [material.density for material in given.materials.values()]
        return [UprightGroup(given.assembly, list(given.materials), density, turns=False)]
'''
SCENE = """
dimension = 2
fidelity = "rigid"
materials = { stone = { density = 2000 } }
structures = [{ kind = "stack", name = "a", material = "stone", size = [1, 1], count = 3 }]
overrides = [{ blocks = "a.b2", fidelity = "upright" }]
loads = { gravity = [0, -10] }
[output]
fields = true
"""
# the folder is looked into at the first scene: a further place stands for a file that was put there
WITH_FOLDER = (
    "import runpy, sys\nimport masonry_fem.fidelities\nmasonry_fem.fidelities.__path__.append({!r})\n"
)
COMMAND = "from masonry_fem.cli import main\nsys.exit(main({!r}))"
REFERENCE = "print(runpy.run_path({!r})['page']())"
TABLE = """
import pytest
options = ["-v", "-p", "no:cacheprovider", "-o", "addopts=--import-mode=importlib"]
sys.exit(pytest.main([*options, "-k", "upright", {!r}]))
"""


@pytest.fixture(scope="module")
def said(tmp_path_factory, repository):
    """What a program says, with the file among the fidelities."""
    folder = tmp_path_factory.mktemp("fidelities")
    (folder / "upright.py").write_text(UPRIGHT, encoding="utf-8")
    (folder / "scene.toml").write_text(SCENE, encoding="utf-8")

    def run(code, *names):
        done = subprocess.run(
            [sys.executable, "-c", WITH_FOLDER.format(str(folder)) + code.format(*names)], cwd=folder,
            capture_output=True, text=True, check=False, env={**os.environ, "PYTHONPATH": str(repository)},
        )  # fmt: skip
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout

    run.folder = folder
    return run


def test_a_scene_has_it(said):
    assert re.search(r"upright +1", said(COMMAND, ["check", "scene.toml"]))


def test_it_stands_and_results_name_it(said):
    said(COMMAND, ["run", "scene.toml", "--out", "out"])
    supports = json.loads((said.folder / "out/summary.json").read_text(encoding="utf-8"))["supports"]
    assert supports["a.ground"]["force"][1] == pytest.approx(3 * 2000 * 10.0, rel=1e-9)
    (table,) = (said.folder / "out/fields").glob("acting_*.csv")
    kinds = [line.split(",")[2] for line in table.read_text(encoding="utf-8").splitlines()[1:]]
    assert kinds == ["support", "rigid", "upright", "rigid"]


def test_the_reference_has_it(said, repository):
    text = said(REFERENCE, str(repository / "docs/scene_reference.py"))
    assert "one of 'elastic', 'rigid', 'upright'" in text


def test_the_tables_of_tests_have_it(said, repository):
    text = said(TABLE, str(repository / "tests/bodies/test_conformance.py"))
    assert len(re.findall(r"\[upright-[23]d.*\] PASSED", text)) > 20
