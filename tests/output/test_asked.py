"""Outputs that scenes ask for: a file in the folder is a key of ``[output]``, wherever such keys matter."""

import os
import re
import subprocess
import sys

import pytest

FILE = '''"""Weights of the blocks.

The rest of the docstring is no meaning.
"""

from masonry_fem.host.atomic import write_atomic

class Weights:
    dense = False

    def __init__(self, path):
        self.path = path

    def start(self, model):
        self.count = len(model.assembly.blocks)

    def record(self, model, state, report):
        """Nothing of a step."""

    def end(self, made, determinacy):
        write_atomic(self.path, f"{self.count} blocks, {made.outcome}".encode())

    def close(self, summary):
        return [self.path]

def recorder(request):
    return Weights(request.folder / "weights.txt")
'''
SCENE = """
dimension = 2
fidelity = "rigid"
materials.stone.density = 2400.0
structures = [{ kind = "stack", name = "it", material = "stone", size = [1.0, 1.0], count = 2 }]
loads.gravity = [0.0, -10.0]
output = { pictures = false, KEY = true }
"""
# the folder is looked into at the first scene: a further place stands for a file that was put there
WITH_FOLDER = """
import runpy, sys
import masonry_fem.output.asked
masonry_fem.output.asked.__path__.append(sys.argv[1])
"""
COMMAND = """
from masonry_fem.cli import main
sys.exit(main(["run", "scene.toml", "--out", "out"]))
"""
REFERENCE = "print(runpy.run_path(sys.argv[2])['page']())"


@pytest.fixture
def said(tmp_path, repository):
    """What a program says, with a file among the outputs."""
    page = str(repository / "docs/scene_reference.py")

    def run(code, text, key="weights"):
        (tmp_path / "weights.py").write_text(text, encoding="utf-8")
        (tmp_path / "scene.toml").write_text(SCENE.replace("KEY", key), encoding="utf-8")
        return subprocess.run(
            [sys.executable, "-c", WITH_FOLDER + code, str(tmp_path), page],
            cwd=tmp_path, env={**os.environ, "PYTHONPATH": str(repository)},
            capture_output=True, text=True, check=False,
        )  # fmt: skip

    return run


def test_a_scene_has_it(said, tmp_path):
    done = said(COMMAND, FILE)
    assert done.returncode == 0, done.stderr
    assert f"wrote {os.path.join('out', 'weights.txt')}" in done.stdout
    assert (tmp_path / "out/weights.txt").read_text(encoding="utf-8") == "3 blocks, equilibrium"
    assert "weights.txt" in (tmp_path / "out/.masonry-fem/run").read_text(encoding="utf-8")


@pytest.mark.slow
def test_the_output_of_the_guide_tells_the_speed(said, tmp_path, repository, monkeypatch):
    """Blocks that friction 0.3 does not hold slide from the start: speed (0.5 − 0.3) g t."""
    page = (repository / "docs/add_a_part.md").read_text(encoding="utf-8")
    (file,) = re.findall(r"`[\w/]*/sliding_speed\.py`:\n\n```python\n(.*?)```", page, re.S)
    sliding = (
        SCENE.replace("[0.0, -10.0]", "[5.0, -10.0]")
        + """
joints = [{ friction = 0.3 }]
analysis = { kind = "dynamics", step = 0.01, duration = 0.05 }
"""
    )
    monkeypatch.setattr(sys.modules[__name__], "SCENE", sliding)
    done = said(COMMAND, file, key="weights")
    assert done.returncode == 0, done.stderr
    header, *lines = (tmp_path / "out/sliding_speed.csv").read_text(encoding="utf-8").splitlines()
    assert header == "time [s],speed [m/s]"
    for line in lines:
        time, speed = map(float, line.split(","))
        assert speed == pytest.approx(2.0 * time, rel=1e-6, abs=1e-9)
    assert float(lines[-1].split(",")[0]) == pytest.approx(0.05)


def test_the_reference_has_it(said):
    done = said(REFERENCE, FILE)
    assert "| `weights` | true or false | `false` | Weights of the blocks |" in done.stdout, done.stderr


def test_what_no_file_makes_is_refused(said):
    done = said(COMMAND, FILE, key="weight")
    assert done.returncode == 1
    assert "weight" in done.stderr
    assert "weights" in done.stderr


@pytest.mark.slow
def test_what_a_file_lacks_is_said(said):
    done = said(COMMAND, "")
    assert done.returncode == 1
    assert "weights.py has no function recorder, expected one that makes the output 'weights'" in done.stderr


@pytest.mark.slow
def test_what_a_recorder_lacks_is_said(said):
    done = said(COMMAND, FILE.replace("def close", "def closed").replace("dense = False", ""))
    assert done.returncode == 1
    assert "weights.py: recorder gives a Weights, which lacks dense, close, expected" in done.stderr
