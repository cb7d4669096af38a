"""Resume: a run that is cut and goes on gives the bits of the run that was not cut."""

from __future__ import annotations

import json
import random
from pathlib import Path

import numpy as np
import pytest

from masonry_fem.analyses.resume import EndedError, resume
from masonry_fem.analyses.run import RunResult, run
from masonry_fem.output.checkpoint import CheckpointError
from masonry_fem.output.history import History
from masonry_fem.records.tree import packed
from masonry_fem.scene import loads

SPENT = ("seconds", "peak_memory_mb", "versions", "factorisations")  # of a summary: what it took, no result

HEAD = """
dimension = 2
loads.gravity = [0.0, -9.81]
materials.stone = { density = 2400.0, young = 1e9, poisson = 0.2 }
materials.tuff = { density = 1600.0, young = 3e9, poisson = 0.2, degree = 2, promote_at = 0.5, \
inelastic = { law = "mohr_coulomb", cohesion = 1.5e6, friction_angle = "30 deg", dilatancy_angle = "10 deg" } }
mesh = { element = "Q1", size = 0.2 }
output = { pictures = false, interfaces = true, checkpoint_steps = 2 }
"""
FLYING = """
structures = [
  { kind = "stack", name = "pile", material = "stone", size = [1.0, 0.5], count = 3 },
  { kind = "block", name = "shot", material = "stone", size = [0.4, 0.4], position = [-0.6, 1.05] },
]
initial = [{ blocks = "shot", velocity = [4.0, 0.5], spin = -2.0 }]
joints = [{ friction = 0.5 }]
analysis = { kind = "dynamics", step = 0.004, duration = 0.12, theta = 0.7 }
"""
WALL = """
structures = [
  { kind = "wall", name = "wall", material = "stone", brick = [0.5, 0.25], columns = 2.5, courses = 4 },
]
loads.accelerations = [{ vector = [2.0, 0.0] }]
joints = [{ friction = 0.4 }]
analysis = { kind = "statics", load_steps = 8 }
"""
PRESS = """
structures = [
  { kind = "block", name = "floor", material = "stone", size = [0.5, 0.1], position = [0, -0.1], support = true },
  { kind = "block", name = "low", material = "tuff", size = [0.5, 0.4] },
  { kind = "block", name = "high", material = "tuff", size = [0.5, 0.4], position = [0, 0.4] },
  { kind = "block", name = "plate", material = "stone", size = [0.5, 0.1], position = [0, 0.8], fidelity = "rigid" },
]
joints = [{ friction = 0.6, placement = "nodes" }]
supports = [{ on = "plate", motion = { displacement = [0.0, -2e-3] } }]
analysis = { kind = "statics", load_steps = 10 }
"""
COHESION = """
joints = [{ friction = 0.5, law = { kind = "bilinear", normal_stiffness = 1e11, tangential_stiffness = 1e11, \
normal_strength = 4e3, tangential_strength = 6e3, normal_energy = 2.0, tangential_energy = 5.0 } }]
"""
SCENES = {
    "rigid, redetected": ("rigid", FLYING + "contact = { update = 'redetect', every = 3 }"),
    "rigid, meeting": ("rigid", FLYING),
    "elastic dynamics": ("elastic", FLYING),
    "elastic dynamics, small": ("elastic", WALL.replace(
        'kind = "statics", load_steps = 8', 'kind = "dynamics", step = 1e-3, duration = 1.6e-2'
    ) + "contact = { update = 'fixed' }"),
    "reduced dynamics": ("reduced", FLYING.replace('"stone"', '"tuff"')),
    "rigid statics": ("rigid", WALL.replace("2.0, 0.0", "0.5, 0.0")),
    "elastic statics": ("elastic", WALL),
    "reduced statics": ("reduced", WALL.replace('"stone"', '"tuff"')),
    "inelastic": ("inelastic", PRESS.replace('"stone"', '"tuff"')),
    "promoted": ("auto", PRESS),
    "cohesive statics": ("elastic", WALL.replace("load_steps = 8", "load_steps = 8, substeps = 4").replace(
        "joints = [{ friction = 0.4 }]", COHESION
    )),
    "cohesive dynamics": ("rigid", FLYING.replace("joints = [{ friction = 0.5 }]", COHESION)),
    "damped": ("rigid", FLYING.replace(
        'kind = "dynamics", step = 0.004, duration = 0.12, theta = 0.7',
        'kind = "equilibrium", strategy = "linear_damping", step = 0.004, max_steps = 30',
    )),
    "path": ("elastic", WALL.replace(
        'kind = "statics"',
        'kind = "path", probe = "top", direction = [1.0, 0.0], distance = 1e-4',
    ) + 'probes = [{ name = "top", block = "wall.c4.b1", point = [0.0, 1.0] }]'),
}  # fmt: skip
every = pytest.mark.parametrize("name", SCENES)


def scene_of(name: str, *overrides: str):
    fidelity, text = SCENES[name]
    # keys of tables first, as TOML has it
    return loads(f"fidelity = '{fidelity}'\n{HEAD}{text}", overrides)


def cut(scene, folder: Path, at: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Run until a step, and end it there as Ctrl-C does."""
    record = History.record

    def ended(self, model, state, report):
        if report.step == at:
            raise KeyboardInterrupt
        record(self, model, state, report)

    with monkeypatch.context() as patched, pytest.raises(KeyboardInterrupt):
        patched.setattr(History, "record", ended)
        run(scene, folder)


def bits(result: RunResult) -> tuple[str, list[bytes]]:
    """All of a state."""
    node, arrays = packed(result.march.state)
    return json.dumps(node), [array.tobytes() for array in arrays]


def told(folder: Path) -> dict:
    summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    return {key: value for key, value in summary.items() if key not in SPENT}


def files(folder: Path) -> dict[str, bytes]:
    """Every file but the summary and the checkpoint, with what is in it."""
    found = [path for path in folder.rglob("*") if path.is_file() and ".masonry-fem" not in path.parts]
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in found
        if path.name not in ("summary.json", "checkpoint.npz")
    }


def assert_same(one: RunResult, other: RunResult, first: Path, second: Path) -> None:
    assert bits(one) == bits(other)
    assert told(first) == told(second)
    assert files(first) == files(second)
    assert one.march.ledger == other.march.ledger


@every
def test_a_run_that_is_cut_gives_the_same_bits(name, tmp_path, monkeypatch):
    scene = scene_of(name)
    whole = run(scene, tmp_path / "whole")
    steps = whole.summary.steps
    assert steps > 6
    draw = random.Random(name)
    moments = sorted(draw.sample(range(2, steps + 1), 3))
    for at in moments:
        out = tmp_path / str(at)
        cut(scene, out, at, monkeypatch)
        assert_same(whole, resume(out), tmp_path / "whole", out)
