"""Resume: a run that is cut and goes on gives the bits of the run that was not cut."""

from __future__ import annotations

import json
import os
import random
import re
from collections.abc import Iterator
from dataclasses import fields
from functools import cache
from importlib import import_module
from pathlib import Path
from pkgutil import walk_packages
from tempfile import mkdtemp
from types import ModuleType

import pytest

import masonry_fem
from masonry_fem.analyses.run import RunResult, run
from masonry_fem.analyses.run.reopening import untrusted
from masonry_fem.analyses.run.resume import EndedError, resume
from masonry_fem.output.checkpoint import CheckpointError
from masonry_fem.output.history import History
from masonry_fem.records.tree import is_record, packed
from masonry_fem.scene import loads

SPENT = ("seconds", "peak_memory_mb", "versions", "factorisations")  # of a summary: what it took, no result

HEAD = """
dimension = 2
loads.gravity = [0.0, -9.81]
materials.stone = { density = 2400.0, young = 1e9, poisson = 0.2 }
materials.tuff.density = 1600.0
materials.tuff.young = 3e9
materials.tuff.degree = 2
materials.tuff.promote_at = 0.5
materials.tuff.inelastic = { law = "mohr_coulomb", cohesion = 1.5e6, friction_angle = "30 deg" }
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
  { kind = "block", name = "floor", material = "stone", size = [0.5, 0.1], position = [0, -0.1] },
  { kind = "block", name = "low", material = "tuff", size = [0.5, 0.4] },
  { kind = "block", name = "high", material = "tuff", size = [0.5, 0.4], position = [0, 0.4] },
  { kind = "block", name = "plate", material = "stone", size = [0.5, 0.1], position = [0, 0.8] },
]
joints = [{ friction = 0.6, placement = "nodes" }]
supports = [{ on = "floor" }, { on = "plate", motion = { displacement = [0.0, -2e-3] } }]
analysis = { kind = "statics", load_steps = 10 }
"""
COHESION = """
joints = [{ friction = 0.5, law = { kind = "bilinear", normal_stiffness = 1e11, tangential_stiffness = 1e11, \
normal_strength = 4e3, tangential_strength = 6e3, normal_energy = 2.0, tangential_energy = 5.0 } }]
"""
TIE = """
[[ties]]
name = "bar"
points = [{ block = "wall.c4.b1", point = [0.1, 0.95] }, { block = "wall.ground", point = [1.4, -0.05] }]
section = 1e-4
young = 2e11
yield_stress = 1e6
pretension = 50.0
"""
SHAKEN = 'loads.accelerograms = [{ x = "RECORD", acts = "ACTS", scale = 1.5 }]\n'
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
    "tied statics": ("elastic", WALL + TIE),
    "tied dynamics": ("rigid", FLYING + TIE.replace("wall.c4.b1", "pile.b3").replace("wall.", "pile.")),
    "shaken ground": ("rigid", FLYING + SHAKEN.replace("ACTS", "ground")),
    "shaken mass": ("elastic", FLYING + SHAKEN.replace("ACTS", "inertia")),
}  # fmt: skip
every = pytest.mark.parametrize("name", SCENES)
STAGES = (
    FLYING
    + """
contact = { update = "redetect", every = 3 }
stages = [
  { name = "shot" },
  { name = "slid", loads = { gravity = [1.0, -9.81] }, joints = [{ friction = 0.3 }] },
  { name = "alone", after = "shot", without = ["shot"], analysis = ALONE },
]
""".replace("ALONE", '{ kind = "dynamics", step = 0.01, duration = 0.1 }')
)
COMBINED = (
    WALL.replace("vector = [2.0, 0.0]", 'vector = [2.0, 0.0], case = "quake"')
    + """
combinations = [
  { name = "own", factors = { gravity = 1.35 } },
  { name = "shaken", factors = { gravity = 1.0, quake = 1.1 } },
  { name = "back", factors = { gravity = 1.0, quake = -1.1 } },
]
"""
)
SEVERAL = {  # runs in one folder
    "rigid stages, redetected": ("rigid", STAGES),
    "elastic stages": ("elastic", STAGES.replace('contact = { update = "redetect", every = 3 }', "")),
    "rigid combinations": ("rigid", COMBINED),
    "elastic combinations": ("elastic", COMBINED),
}


@cache
def record() -> Path:
    """An accelerogram."""
    path = Path(mkdtemp()) / "record.csv"
    path.write_text("0.0, 0.0\n0.03, 4.0\n0.07, -5.0\n0.12, 0.0\n")
    return path


def scene_of(name: str, *overrides: str):
    fidelity, text = (SCENES | SEVERAL)[name]
    # keys of tables first, as TOML has it
    text = f"fidelity = '{fidelity}'\n{HEAD}{text}".replace("RECORD", record().as_posix())
    return loads(text, overrides)


def cut(scene, folder: Path, at: int, monkeypatch: pytest.MonkeyPatch, base: Path = Path()) -> None:
    """Run until a step, and end it there as Ctrl-C does."""
    kept = History.record

    def ended(self, model, state, report):
        if report.step == at:
            raise KeyboardInterrupt
        kept(self, model, state, report)

    with monkeypatch.context() as patched:
        patched.setattr(History, "record", ended)
        with pytest.raises(KeyboardInterrupt):
            run(scene, folder, base=base)


@cache
def whole(name: str) -> tuple[RunResult, Path]:
    """The run that is not cut, and its folder."""
    folder = Path(mkdtemp())
    return run(scene_of(name), folder), folder


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
    scene, (uncut, folder) = scene_of(name), whole(name)
    steps = uncut.summary.steps
    assert steps > 6
    for at in sorted(random.Random(name).sample(range(2, steps + 1), 3)):
        out = tmp_path / str(at)
        cut(scene, out, at, monkeypatch)
        assert_same(uncut, resume(out), folder, out)


@pytest.mark.slow
@every
def test_a_run_that_is_cut_at_ten_moments_gives_the_same_bits(name, tmp_path, monkeypatch):
    scene, (uncut, folder) = scene_of(name), whole(name)
    steps = uncut.summary.steps
    for number in range(10):
        out = tmp_path / str(number)
        cut(scene, out, random.Random(f"{name} {number}").randint(2, steps), monkeypatch)
        assert_same(uncut, resume(out), folder, out)


def cut_of_several(name: str, moments: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Cut runs in one folder at random ones of all their steps, and let them go on."""
    scene, (uncut, folder) = scene_of(name), whole(name)
    kept, seen = History.record, []

    def ended(self, model, state, report):
        seen.append(report.step)
        if len(seen) == at:
            raise KeyboardInterrupt
        kept(self, model, state, report)

    with monkeypatch.context() as patched:
        patched.setattr(History, "record", ended)
        at = 0
        run(scene, tmp_path / "all")
        steps = len(seen)
        assert steps > 20
        for number in range(moments):
            seen.clear()
            at, out = random.Random(f"{name} {number}").randint(2, steps), tmp_path / str(number)
            with pytest.raises(KeyboardInterrupt):
                run(scene, out)
            at = 0
            assert_same(uncut, resume(out), folder, out)


@pytest.mark.parametrize("name", ["rigid stages, redetected", "rigid combinations"])
def test_several_runs_that_are_cut_give_the_same_bits(name, tmp_path, monkeypatch):
    cut_of_several(name, 2, tmp_path, monkeypatch)


@pytest.mark.slow
@pytest.mark.parametrize("name", SEVERAL)
def test_several_runs_that_are_cut_at_ten_moments_give_the_same_bits(name, tmp_path, monkeypatch):
    cut_of_several(name, 10, tmp_path, monkeypatch)


@pytest.mark.parametrize("every", [1, 3])
def test_no_field_file_of_a_later_step_is_left(every, tmp_path, monkeypatch):
    """Field files that were written after the checkpoint go, also where fewer of them are made then."""
    asked = "output={pictures=false, interfaces=true, checkpoint_steps=10"
    scene = scene_of("rigid, redetected", f"{asked}, every={every}}}")
    cut(scene, tmp_path / "cut", 19, monkeypatch)  # the checkpoint is of step 10
    names = {path.name for path in (tmp_path / "cut" / "fields").glob("blocks*")}
    assert max(names) > "blocks_000014.vtu"
    (tmp_path / "cut" / "fields" / "contacts_000019.vtu.part").write_text("half")
    (tmp_path / "cut" / "fields" / "own.vtu").write_text("the user's")
    resume(tmp_path / "cut", ["output.every=7"])
    found = {path.name for path in (tmp_path / "cut" / "fields").iterdir()}
    assert "own.vtu" in found
    for kind in ("blocks", "contacts", "interfaces"):
        series = (tmp_path / "cut" / f"{kind}.pvd").read_text()
        assert {name for name in found if name.startswith(kind)} == set(
            re.findall(rf"{kind}_\d+\.vtu", series)
        )
    steps = {name[-10:-4] for name in found if name.startswith("blocks")}
    assert {name[-10:-4] for name in found if name.startswith("acting")} == steps


def test_a_power_cut_finds_what_a_checkpoint_speaks_of_on_the_disk(tmp_path, monkeypatch):
    """Before a checkpoint takes its name it is on the disk, and before that all that it names."""
    settled: list[str] = []
    sync, replace = os.fsync, os.replace

    def synced(file: int) -> None:
        settled.append(Path(os.readlink(f"/proc/self/fd/{file}")).name)
        sync(file)

    def named(old: Path, new: Path) -> None:
        if Path(new).name == "checkpoint.npz":
            settled.append("named")
        replace(old, new)

    monkeypatch.setattr(os, "fsync", synced)
    monkeypatch.setattr(os, "replace", named)
    run(scene_of("rigid statics"), tmp_path / "out")
    kinds = [re.sub(r"_\d+", "", name) for name in settled]
    assert kinds[:3] == ["checkpoint.npz.part", "named", "out"]
    second = kinds[3 : kinds.index("named", 3) + 2]
    assert second[0] == "history.csv"
    assert {"blocks.vtu", "contacts.vtu", "interfaces.vtu", "fields"} <= set(second)
    assert second[-3:] == ["checkpoint.npz.part", "named", "out"]
    written = [name for name in settled if re.match(r"\w+_\d+\.vtu", name)]
    assert len(written) >= len(set(written)) > 10


def test_a_run_that_is_cut_again_and_again_gives_the_same_bits(tmp_path, monkeypatch):
    uncut, folder = whole("rigid, redetected")
    cut(scene_of("rigid, redetected"), tmp_path, 5, monkeypatch)
    record = History.record
    for at in (9, 14, 22):

        def ended(self, model, state, report, at=at):
            record(self, model, state, report)
            if report.step == at:
                raise KeyboardInterrupt

        monkeypatch.setattr(History, "record", ended)
        with pytest.raises(KeyboardInterrupt):
            resume(tmp_path)
    monkeypatch.setattr(History, "record", record)
    assert_same(uncut, resume(tmp_path), folder, tmp_path)


@pytest.mark.parametrize(
    ("name", "key", "less", "more"),
    [
        ("elastic dynamics", "analysis.duration", "0.06", "0.12"),
        ("rigid, redetected", "analysis.duration", "0.052", "0.12"),
        ("damped", "analysis.max_steps", "11", "30"),
    ],
)
def test_more_steps_after_the_end_are_those_of_the_longer_run(name, key, less, more, tmp_path):
    uncut, folder = whole(name)
    run(scene_of(name, f"{key}={less}"), tmp_path)
    longer = resume(tmp_path, [f"{key}={more}"])
    assert_same(uncut, longer, folder, tmp_path)


def test_a_run_that_is_done_is_told_so(tmp_path):
    run(scene_of("rigid statics"), tmp_path)
    with pytest.raises(EndedError, match=r"come to its end \(equilibrium\), nothing is left to do"):
        resume(tmp_path)


@pytest.mark.parametrize(
    ("override", "sentence"),
    [
        ("materials.stone.density=2500", r"density was 2400\.0, and is 2500\.0.*analysis\.start"),
        ("joints.0.friction=0.3", r"joints\.0\.friction was 0\.5, and is 0\.3"),
        ("analysis.step=0.002", r"analysis\.step was 0\.004, and is 0\.002.*longer duration"),
        ("analysis.theta=1.0", r"analysis\.theta was 0\.7, and is 1\.0"),
    ],
)
def test_what_does_not_fit_is_refused_with_the_difference(override, sentence, tmp_path, monkeypatch):
    cut(scene_of("rigid, meeting"), tmp_path, 5, monkeypatch)
    with pytest.raises(CheckpointError, match=sentence):
        resume(tmp_path, [override])


def test_a_motion_that_would_have_been_slower_is_refused(tmp_path):
    scene = scene_of("damped", "supports.0.on=pile.ground", "supports.0.motion.displacement=[0.0, -0.01]")
    run(scene, tmp_path)
    with pytest.raises(CheckpointError, match="give motions and temperatures a time"):
        resume(tmp_path, ["analysis.max_steps=60"])


def test_no_checkpoint_is_told(tmp_path):
    run(scene_of("rigid statics", "output={pictures=false}"), tmp_path)
    assert not (tmp_path / "checkpoint.npz").exists()
    with pytest.raises(CheckpointError, match=r"has no checkpoint\.npz.*output\.checkpoint_steps"):
        resume(tmp_path)


def test_a_damaged_checkpoint_is_told(tmp_path):
    run(scene_of("rigid statics"), tmp_path)
    path = tmp_path / "checkpoint.npz"
    path.write_bytes(path.read_bytes()[:5000])
    with pytest.raises(CheckpointError, match="damaged"):
        resume(tmp_path)


def test_a_history_that_was_cut_is_told(tmp_path, monkeypatch):
    cut(scene_of("rigid, meeting"), tmp_path, 9, monkeypatch)
    (tmp_path / "history.csv").write_bytes(b"")
    with pytest.raises(masonry_fem.errors.OutputError, match="changed since"):
        resume(tmp_path)


def test_trust_is_not_read_from_a_file():
    text = "[[joints]]\nlaw = { kind = 'python', file = 'a.py', trusted = true }\n"
    assert "trusted" in text
    assert "trusted" not in untrusted(text)


def modules() -> Iterator[ModuleType]:
    for room in ("bodies", "fem", "joints", "march"):
        package = import_module(f"masonry_fem.{room}")
        yield package
        for one in walk_packages(package.__path__, f"{package.__name__}."):
            yield import_module(one.name)


def states() -> set[type]:
    """Every class that a state is made of: what ends in State, memories, and what these hold."""
    found = {
        kind
        for module in modules()
        for kind in vars(module).values()
        if isinstance(kind, type) and kind.__module__ == module.__name__
        if re.search("[a-z]State$", kind.__name__) or any(base.__name__ == "Memory" for base in kind.__mro__)
        if hasattr(kind, "__dataclass_fields__")
    }
    assert {"RigidState", "TurningState", "JointState", "SystemState", "Memory"} <= {
        kind.__name__ for kind in found
    }
    return found


def test_every_state_in_the_package_can_be_saved():
    simple = {
        "FloatArray",
        "IntArray",
        "Mask",
        "NDArray",
        "np",
        "int8",
        "float",
        "int",
        "bool",
        "str",
        "None",
    }
    simple |= {"tuple", "dict", "Any", "Acting"} | {kind.__name__ for kind in states()}
    for kind in states():
        assert is_record(kind), f"{kind}: make it a frozen dataclass"
        for field in fields(kind):
            words = set(re.findall(r"\w+", str(field.type)))
            assert words <= simple, (
                f"{kind}.{field.name} is {field.type}, expected numbers, arrays, or states"
            )


def test_every_state_in_the_package_is_in_some_of_these_scenes():
    seen: set[str] = set()
    for name in SCENES:
        seen |= set(re.findall(r'"[\w.]+:(\w+)"', json.dumps(packed(whole(name)[0].march.standing)[0])))
    # the memory of stones that yield is a Memory, of those that wait for it a Waiting
    assert {kind.__name__ for kind in states()} <= seen
