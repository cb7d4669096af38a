"""Combinations: load cases times factors, and the envelope of what they lead to."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest

import masonry_fem.analyses.run.combinations as module
from masonry_fem.analyses.collapse import collapse
from masonry_fem.analyses.inspect import check_scene
from masonry_fem.analyses.limit import analyse
from masonry_fem.analyses.run import run, solve_scene, steps
from masonry_fem.analyses.run.combinations import run_combinations
from masonry_fem.analyses.run.resume import EndedError, resume
from masonry_fem.cli import main
from masonry_fem.errors import MasonryError
from masonry_fem.output.checkpoint import CheckpointError
from masonry_fem.output.history import History
from masonry_fem.scene import loads
from masonry_fem.scene.combinations import combination_scenes

WALL = """
dimension = 2
fidelity = "{fidelity}"
mesh = {{ element = "Q1", size = 0.25 }}
materials.stone = {{ density = 2000.0, young = 1e9, poisson = 0.2, compressive_strength = 5e6 }}
structures = [
  {{ kind = "wall", name = "wall", material = "stone", brick = [0.5, 0.25], columns = 3, courses = 3 }},
]
joints = [{{ friction = 0.6 }}]
output = {{ pictures = false, fields = false, stones = true }}
{loads}
"""
CASES = """
loads.gravity = [0.0, -10.0]
loads.accelerations = [{ vector = [1.0, 0.0], case = "quake" }]
loads.points = [
  { block = "wall.c3.b2", vector = [100.0, -20000.0], case = "roof" },
  { block = "wall.c3.b1", vector = [0.0, -500.0] },
]
combinations = [
  { name = "own", factors = { gravity = 1.35 } },
  { name = "shaken", factors = { gravity = 1.0, quake = 1.5 } },
  { name = "roofed", factors = { gravity = 1.35, roof = 1.5, quake = -0.9 } },
]
"""
POINT = '{ block = "wall.c3.b1", vector = [0.0, -500.0] }'
SEPARATE = {  # the same, multiplied by hand
    "own": f"loads.gravity = [0.0, -13.5]\nloads.points = [{POINT}]",
    "shaken": "loads.gravity = [0.0, -10.0]\nloads.accelerations = [{ vector = [1.5, 0.0] }]\n"
    f"loads.points = [{POINT}]",
    "roofed": "loads.gravity = [0.0, -13.5]\nloads.accelerations = [{ vector = [-0.9, 0.0] }]\n"
    f'loads.points = [{{ block = "wall.c3.b2", vector = [150.0, -30000.0] }}, {POINT}]',
}


def rows(path):
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def extreme(values, choose):
    """The extreme of (value, combination) pairs; of equal ones the first."""
    return choose(values, key=lambda pair: pair[0])


def expected(folders):
    """The lines of the table, from the tables and summaries of separate runs."""
    stones = {name: rows(folder / "stones.csv") for name, folder in folders.items()}
    ends = {
        name: json.loads((folder / "summary.json").read_text("utf-8")) for name, folder in folders.items()
    }
    lines = []
    for column, choose in (("utilisation [-]", max), ("mean_sigma_3 [Pa]", min), ("mean_sigma_1 [Pa]", max)):
        for number, stone in enumerate(next(iter(stones.values()))):
            key = column if stone[column] else "utilisation_of_mean [-]"  # of rigid stones
            values = [(float(table[number][key]), name) for name, table in stones.items()]
            lines.append(("stone", stone["block"], column, *extreme(values, choose)))
    for support in next(iter(ends.values()))["supports"]:
        for end, choose in (("least", min), ("greatest", max)):
            for axis, (part, number) in {
                "force_x [N/m]": ("force", 0), "force_y [N/m]": ("force", 1), "moment [N]": ("moment", 0)
            }.items():  # fmt: skip
                values = [(told["supports"][support][part][number], name) for name, told in ends.items()]
                lines.append(("support", support, f"{end}_{axis}", *extreme(values, choose)))
    return lines


@pytest.mark.parametrize("fidelity", ["rigid", "elastic"])
def test_the_envelope_is_that_of_separate_runs_bit_for_bit(fidelity, tmp_path):
    made = run(loads(WALL.format(fidelity=fidelity, loads=CASES)), tmp_path / "all")
    folders = {name: tmp_path / name for name in SEPARATE}
    for name, own in SEPARATE.items():
        run(loads(WALL.format(fidelity=fidelity, loads=own)), folders[name])
        for file in ("stones.csv", "history.csv"):
            assert (folders[name] / file).read_bytes() == (tmp_path / "all" / name / file).read_bytes()
    lines = expected(folders)
    told = [
        (row["of"], row["name"], row["quantity"], float(row["value"]), row["combination"])
        for row in rows(tmp_path / "all" / "combinations.csv")
    ]
    assert told == lines
    assert len({line[4] for line in lines}) == 3  # each of them governs something

    found = made.summary.combinations
    assert [one.name for one in found.runs] == list(SEPARATE)
    assert {one.outcome for one in found.runs} == {"equilibrium"}
    of = {key: [line for line in lines if line[2] == key] for key in {line[2] for line in lines}}
    worst = max(of["utilisation [-]"], key=lambda line: line[3])
    assert (found.utilisation[0].block, found.utilisation[0].value) == (worst[1], worst[3])
    assert found.compression.value == min(line[3] for line in of["mean_sigma_3 [Pa]"])
    assert found.tension.value == max(line[3] for line in of["mean_sigma_1 [Pa]"])
    ground = found.supports["wall.ground"]
    for end in ("least", "greatest"):
        parts = [line[3:] for line in lines if line[2].startswith(f"{end}_")]
        assert [(one.value, one.combination) for one in getattr(ground, end)] == parts


def test_a_combination_that_falls_is_told_and_left_out_of_the_envelope(tmp_path, capsys):
    text = WALL.format(fidelity="rigid", loads=CASES).replace("quake = 1.5", "quake = 15.0")
    scene = tmp_path / "scene.toml"
    scene.write_text(text, encoding="utf-8")
    assert main(["run", str(scene), "--out", str(tmp_path / "out")]) == 3
    said = capsys.readouterr()
    assert "Combination 'shaken'" in said.err
    assert "no equilibrium: gravity × 1, quake × 15" in " ".join(said.out.split())
    told = json.loads((tmp_path / "out" / "summary.json").read_text("utf-8"))
    assert told["outcome"] == "no_equilibrium"
    ends = [one["outcome"] for one in told["combinations"]["runs"]]
    assert ends == ["equilibrium", "no_equilibrium", "equilibrium"]
    assert {row["combination"] for row in rows(tmp_path / "out" / "combinations.csv")} == {"own", "roofed"}


def test_every_kind_of_load_has_its_factor():
    text = """
loads.gravity = [0.0, -10.0]
loads.gravity_time = { kind = "table", points = [[0.0, 0.0], [1.0, 1.0]] }
loads.accelerations = [{ vector = [1.0, 2.0], case = "a" }]
loads.tractions = [{ on = "wall.c3.*/top", vector = [3.0, 4.0], case = "a" }]
loads.points = [{ block = "wall.c3.b1", vector = [5.0, 6.0], case = "a" }]
loads.lines = [
  { block = "wall.c3.b1", vector = [7.0, 8.0], start = [0.0, 0.75], end = [0.5, 0.75], case = "a" },
]
loads.temperatures = [{ on = "wall.c3.b1", change = 9.0, case = "b" }]
combinations = [
  { name = "one", factors = { a = 2.0 } },
  { name = "two", factors = { gravity = 3.0, b = -1.0 } },
]
"""
    (_, one), (_, two) = combination_scenes(loads(WALL.format(fidelity="elastic", loads=text)))
    assert (one.loads.gravity, one.loads.gravity_time, one.loads.temperatures) == (None, None, ())
    kinds = ("accelerations", "tractions", "points", "lines")
    assert [getattr(one.loads, kind)[0].vector for kind in kinds] == [(2, 4), (6, 8), (10, 12), (14, 16)]
    assert two.loads.gravity == (0, -30)
    assert two.loads.gravity_time is not None
    assert two.loads.temperatures[0].change == -9
    assert [getattr(two.loads, kind) for kind in kinds] == [(), (), (), ()]


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("roof = 1.5", "rooof = 1.5", "did you mean 'roof'"),
        ("loads.gravity = [0.0, -10.0]", "", "expected a load case"),
        ('name = "shaken"', 'name = "own"', "a name of its own"),
        ("{ gravity = 1.35 }", "{}", "combinations.own.factors is .*at least one load case"),
        ("combinations = [", 'stages = [{ name = "first" }]\ncombinations = [', "none beside 'stages'"),
    ],
)
def test_what_cannot_be_combined_is_refused(old, new, words):
    text = WALL.format(fidelity="rigid", loads=CASES)
    assert old in text
    with pytest.raises(MasonryError, match=words):
        loads(text.replace(old, new, 1))


def test_what_is_of_one_run_refuses_combinations(tmp_path):
    scene = loads(WALL.format(fidelity="rigid", loads=CASES))
    for call in (
        lambda: solve_scene(scene),
        lambda: steps(scene),
        lambda: analyse(scene),
        lambda: collapse(scene, tmp_path),
        lambda: run(scene, tmp_path, save_contact=1),
    ):
        with pytest.raises(MasonryError, match="combinations"):
            call()
    assert check_scene(scene).most_steps == 3 * scene.analysis.steps


def test_what_a_load_cannot_act_on_is_refused_before_any_run(tmp_path):
    text = WALL.format(fidelity="rigid", loads=CASES).replace('"wall.c3.b2"', '"wall.c9.b2"')
    with pytest.raises(MasonryError, match=r"wall\.c9\.b2"):
        run(loads(text), tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_what_is_ended_early_says_how_much_is_done(tmp_path):
    done = []

    def once(scene, out, before, checkpoint):
        if done:
            raise KeyboardInterrupt
        done.append(out.name)
        return run(scene, out)

    with pytest.raises(KeyboardInterrupt):
        run_combinations(loads(WALL.format(fidelity="rigid", loads=CASES)), tmp_path, Path(), once)
    told = json.loads((tmp_path / "summary.json").read_text("utf-8"))
    assert told["outcome"] == "interrupted"
    assert "1 of 3 combinations are done" in told["message"]
    assert (tmp_path / "own" / "stones.csv").exists()


SPENT = ("seconds", "peak_memory_mb", "versions", "factorisations")  # what it took, no result


def left(folder: Path) -> dict[str, object]:
    """What stands in a folder, without what it took."""
    files = [path for path in folder.rglob("*") if path.is_file() and ".masonry-fem" not in path.parts]
    found: dict[str, object] = {}
    for path in files:
        name = path.relative_to(folder).as_posix()
        if path.name == "summary.json":
            told = json.loads(path.read_text("utf-8"))
            found[name] = {key: value for key, value in told.items() if key not in SPENT}
        elif path.name != "checkpoint.npz":
            found[name] = path.read_bytes()
    return found


@pytest.mark.parametrize("more", ["", "checkpoint_steps = 2, "])
@pytest.mark.parametrize("at", [3, 8, 14])
def test_a_run_that_is_cut_goes_on_with_what_is_not_done(more, at, tmp_path, monkeypatch):
    """Five steps each: cut in the first, the second and the last one."""
    text = WALL.format(fidelity="rigid", loads=CASES).replace("pictures =", f"{more}pictures =")
    scene = loads(text, ["analysis={kind='statics', load_steps=5}"])
    run(scene, tmp_path / "whole")
    record, seen = History.record, []

    def ended(self, model, state, report):
        seen.append(report.step)
        if len(seen) == at:
            raise KeyboardInterrupt
        record(self, model, state, report)

    with monkeypatch.context() as patched:
        patched.setattr(History, "record", ended)
        with pytest.raises(KeyboardInterrupt):
            run(scene, tmp_path / "cut")
        seen.extend([0] * 100)
        resumed = resume(tmp_path / "cut")
    made = len(seen) - 100 - at
    assert made == 15 - (at - 1) // 5 * 5 - (2 * ((at - 1) % 5 // 2) if more else 0)
    assert [one.name for one in resumed.summary.combinations.runs] == ["own", "shaken", "roofed"]
    assert left(tmp_path / "cut") == left(tmp_path / "whole")
    with pytest.raises(EndedError, match="nothing is left to do"):
        resume(tmp_path / "cut")


def ctrl_c(_):
    raise KeyboardInterrupt


def test_a_kill_before_the_envelope_is_written_loses_nothing(tmp_path, monkeypatch):
    """All are done: only the one that the summary is of is run once more."""
    scene = loads(WALL.format(fidelity="rigid", loads=CASES), ["combinations.1.factors.quake=9.0"])
    run(scene, tmp_path / "whole")
    with monkeypatch.context() as patched:
        patched.setattr(module, "envelope", ctrl_c)
        with pytest.raises(KeyboardInterrupt):
            run(scene, tmp_path / "cut")
    stamps = {name: (tmp_path / "cut" / name / "stones.csv").stat().st_mtime_ns for name in ("own", "roofed")}
    assert resume(tmp_path / "cut").outcome == "no_equilibrium"
    assert left(tmp_path / "cut") == left(tmp_path / "whole")
    for name, stamp in stamps.items():
        assert (tmp_path / "cut" / name / "stones.csv").stat().st_mtime_ns == stamp


def test_another_analysis_of_those_that_are_left_is_refused(tmp_path, monkeypatch):
    scene = loads(WALL.format(fidelity="rigid", loads=CASES), ["analysis={kind='statics', load_steps=2}"])
    monkeypatch.setattr(module, "envelope", ctrl_c)
    with pytest.raises(KeyboardInterrupt):
        run(scene, tmp_path)
    with pytest.raises(
        CheckpointError, match=r"done would be of another analysis .*load_steps was 2, and is 4"
    ):
        resume(tmp_path, ["analysis.load_steps=4"])


def test_the_report_tells_of_the_combinations(tmp_path):
    text = WALL.format(fidelity="rigid", loads=CASES).replace("stones = true", "report = true")
    run(loads(text), tmp_path)
    page = (tmp_path / "report.html").read_text("utf-8")
    assert "<h2>Load combinations</h2>" in page
    assert "equilibrium: gravity × 1.35, roof × 1.5, quake × -0.9" in page
    assert "<h2>Load combinations</h2>" not in (tmp_path / "own" / "report.html").read_text("utf-8")
