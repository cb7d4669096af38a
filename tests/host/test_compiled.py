"""What is compiled is compiled once, and whoever waits for it knows why."""

import os
import subprocess
import sys

import pytest

from masonry_fem.analyses import rehearsal, run

LOOP = """
import logging
from masonry_fem.host.compiled import compiled

@compiled
def total(values):
    result = 0.0
    for value in values:
        result += value
    return result

@compiled
def product(values):
    return values[0] * values[1]

if __name__ == "__main__":
    logging.basicConfig(level=logging.INFO)
    print(total((1.0, 2.0)), product((3.0, 4.0)))
"""
DEMOS = ("arch", "bouncing", "slope", "low_wall", "rubble_wall", "dome_section")
COVERED = """
import sys
from numba.core.dispatcher import Dispatcher
from masonry_fem import load, solve
from masonry_fem.analyses.rehearsal import rehearse

def known():
    return {
        (name, key, signature)
        for name, module in list(sys.modules.items()) if name.startswith("masonry_fem.")
        for key, one in vars(module).items() if isinstance(one, Dispatcher)
        for signature in one.signatures
    }

for name in rehearse():
    pass
before = known()
assert len(before) > 30
for file in sys.argv[1:]:
    solve(load(file))
print("new:", sorted({f"{name}.{key}" for name, key, _ in known() - before}))
"""


@pytest.mark.slow
def test_it_is_said_once_and_kept(tmp_path, monkeypatch):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "cache"))
    (tmp_path / "loop.py").write_text(LOOP)
    said = []
    for _ in range(2):
        done = subprocess.run(
            [sys.executable, "loop.py"], cwd=tmp_path, capture_output=True, text=True, check=True
        )
        assert done.stdout == "3.0 12.0\n"
        said.append(done.stderr.count("compiling for this processor, once after installation"))
    assert said == [1, 0]


@pytest.mark.slow
def test_demos_need_nothing_that_was_not_rehearsed(repository):
    demos = [str(repository / "demos" / f"{name}.toml") for name in DEMOS]
    done = subprocess.run([sys.executable, "-c", COVERED, *demos], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "new: []"


@pytest.mark.slow
@pytest.mark.parametrize(("begins", "solved_here"), [(rehearsal.silence, 2), (os.abort, 4)])
def test_a_second_process_takes_scenes_in_space_and_is_done_without_if_it_dies(
    monkeypatch, begins, solved_here
):
    names = ["rigid blocks at rest, 2D", "rigid blocks sliding, 2D", "rigid blocks at rest, 3D", "dome"]
    solved = []

    def solve_scene(scene):
        solved.append(scene)
        return original(scene)

    original = run.solve_scene
    monkeypatch.setattr(rehearsal, "SCENES", {name: rehearsal.SCENES[name] for name in names})
    monkeypatch.setattr(rehearsal, "silence", begins)
    monkeypatch.setattr(run, "solve_scene", solve_scene)
    assert sorted(rehearsal.rehearse(aided=True)) == sorted(names)
    assert len(solved) == solved_here
