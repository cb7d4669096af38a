"""An incremental dynamic analysis from end to end: what is run, kept, told and refused."""

from __future__ import annotations

import csv
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from masonry_fem import cli
from masonry_fem.analyses.incremental import incremental
from masonry_fem.analyses.incremental.demand import shaken
from masonry_fem.errors import MasonryError
from masonry_fem.output.render import can_render
from masonry_fem.scene import loads

COLUMN = """
title = "column"
dimension = 2
fidelity = "rigid"
materials.stone.density = 2400
structures = [{ kind = "stack", name = "pier", material = "stone", size = [0.5, 2.0], count = 1 }]
joints = [{ friction = 5.0, form = "velocity" }]
probes = [{ name = "top", block = "pier.b1", point = [0.25, 2.0] }]
loads.gravity = [0, -9.81]
analysis = { kind = "dynamics", step = 0.02, duration = 1.6, theta = 0.5 }
"""
ASKED = ("--levels", "2,3,4,7", "--state", "probes.top.peak=0.05")


@pytest.fixture
def column(tmp_path: Path) -> Path:
    (tmp_path / "column.toml").write_text(COLUMN)
    for turn in (4.0, 7.0):
        time = np.linspace(0.0, np.pi / turn, 21)
        pulse = np.column_stack([time, np.sin(turn * time)])
        np.savetxt(tmp_path / f"pulse{turn:g}.csv", pulse, delimiter=",")
    return tmp_path / "column.toml"


def run(column: Path, *more: str) -> int:
    records = [str(path) for path in sorted(column.parent.glob("pulse*.csv"))]
    own = ("--workers", "1", "--quiet", "--out", str(column.parent / "out"))
    return cli.main(["study", str(column), "--records", *records, *own, *ASKED, *more])


def test_a_run_tells_its_demands(column: Path) -> None:
    """The block turns about its edge, so its top goes by the chord of its lean."""
    shaking = [
        'loads.accelerograms.0.x="pulse7.csv"',
        "loads.accelerograms.0.scale=3.5",
        "analysis.step=0.005",
    ]
    scene = loads(COLUMN, shaking, base=column.parent)
    told = shaken(scene, column.parent)
    lean = told["demands"]["lean"]
    assert (told["verdict"], told["leans"]) == ("stands", "pier.b1")
    assert 0.005 < lean < 0.2
    arm = np.hypot(0.25, 2.0)  # from the edge to the probe
    assert told["demands"]["probes.top.peak"] == pytest.approx(2 * arm * np.sin(lean / 2), rel=1e-2)
    assert told["demands"]["probes.top.residual"] < 0.5 * told["demands"]["probes.top.peak"]
    on_ground = loads(COLUMN, [*shaking, 'loads.accelerograms.0.acts="ground"'], base=column.parent)
    moved = shaken(on_ground, column.parent)["demands"]
    assert moved["lean"] == pytest.approx(lean, rel=1e-2)
    assert moved["probes.top.peak"] == pytest.approx(told["demands"]["probes.top.peak"], rel=1e-2)


def test_a_stone_that_falls_has_no_demand(column: Path) -> None:
    shaking = ['loads.accelerograms.0.x="pulse4.csv"', "loads.accelerograms.0.scale=9.0"]
    told = shaken(loads(COLUMN, shaking, base=column.parent), column.parent)
    assert (told["verdict"], told["outcome"]) == ("falls", "toppled")
    assert "demands" not in told


@pytest.mark.slow
def test_tables_and_pictures_tell_of_all_runs(column: Path, capsys) -> None:
    assert run(column) == 0
    out = column.parent / "out"
    told = json.loads((out / "incremental.json").read_text())
    assert (told["outcome"], told["missing"], len(told["runs"])) == ("finished", 0, 8)
    falls, leans = told["fragilities"]
    assert [one["record"] for one in falls["capacities"]] == ["pulse4", "pulse7"]
    assert all(one["passes"] > one["stands"] >= 2.0 for one in falls["capacities"])
    assert all(
        one["passes"] <= other["passes"]
        for one, other in zip(leans["capacities"], falls["capacities"], strict=True)
    )
    with (out / "incremental.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["PGA [m/s^2]"] for row in rows[:4]] == ["2.0", "3.0", "4.0", "7.0"]
    assert all((row["lean [rad]"] == "") == (row["verdict"] == "falls") for row in rows)
    assert (out / "fragility.csv").read_text().startswith("PGA [m/s^2],falls,")
    if can_render():
        assert (out / "ida.png").stat().st_size > 10000
        assert (out / "fragility.png").stat().st_size > 10000
    # another level costs one run a record, and another limit none
    stamps = {path: path.stat().st_mtime_ns for path in (out / "cells").glob("*.json")}
    assert run(column, "--levels", "2,3,4,7,8", "--state", "lean=0.05") == 0
    again = {path: path.stat().st_mtime_ns for path in (out / "cells").glob("*.json")}
    assert len(again) == len(stamps) + 2
    assert stamps.items() <= again.items()


@pytest.mark.slow
@pytest.mark.parametrize("sent", [signal.SIGKILL, signal.SIGINT])
def test_an_end_by_a_signal_loses_no_run(column: Path, sent: signal.Signals) -> None:
    records = [str(path) for path in sorted(column.parent.glob("pulse*.csv"))]
    command = [sys.executable, "-m", "masonry_fem", "study", str(column), "--records", *records, *ASKED]
    command += ["--quiet", "--workers", "1", "--out"]
    out = column.parent / "out"
    cells = out / "cells"
    kept: dict[Path, int] = {}
    left = []  # how many runs were done when it was ended
    for wanted in (2, 5):
        process = subprocess.Popen([*command, str(out)], start_new_session=True)
        until = time.monotonic() + 300
        while len(done(cells)) < wanted and process.poll() is None:
            assert time.monotonic() < until
            time.sleep(0.02)
        if process.poll() is None:
            os.killpg(process.pid, sent)
        assert process.wait() in (-signal.SIGKILL, 130, 0)
        for path, stamp in kept.items():
            assert path.stat().st_mtime_ns == stamp
        kept = done(cells)
        left.append(len(kept))
    assert 2 <= min(left) < 8
    assert subprocess.run([*command, str(out)], check=False).returncode == 0
    assert all(path.stat().st_mtime_ns == stamp for path, stamp in kept.items())
    whole = column.parent / "whole"
    assert subprocess.run([*command, str(whole)], check=False).returncode == 0
    assert contents(out) == contents(whole)


def done(cells: Path) -> dict[Path, int]:
    """When the runs were written that have come to an end; one that a signal cut short has "failed"."""
    paths = [path for path in cells.glob("*.json") if '"outcome": "failed"' not in path.read_text()]
    return {path: path.stat().st_mtime_ns for path in paths}


def contents(folder: Path) -> dict[str, object]:
    """All files that are not hidden, without what differs from run to run: times, memory, the log."""
    found: dict[str, object] = {}
    for path in folder.rglob("*"):
        name = path.relative_to(folder)
        if not path.is_file() or any(part.startswith(".") for part in name.parts):
            continue
        if path.suffix == ".json":
            told = json.loads(path.read_text())
            for row in (told, *told.get("runs", ())):
                for key in ("cpu", "wall", "start", "peak_memory_mb"):
                    row.pop(key, None)
            found[str(name)] = told
        elif path.name == "incremental.csv":
            with path.open(newline="") as file:
                found[str(name)] = [row | {"cpu [s]": ""} for row in csv.DictReader(file)]
        elif path.suffix != ".log":
            found[str(name)] = path.read_bytes()
    return found


@pytest.mark.parametrize(
    ("keys", "given", "words"),
    [
        ((), {}, "give either scales"),
        ((), {"scales": "1", "levels": "1"}, "give either scales"),
        ((), {"scales": "1", "states": ["probes.foot.peak=1"]}, "demand 'probes.foot.peak', expected"),
        ((), {"scales": "1", "states": ["lean=-1"]}, "limit of lean is '-1'"),
        ((), {"scales": "1", "demand": "leans"}, "demand 'leans'"),
        ((), {"scales": "1:2000:1"}, "2 records at 2000 scales are 4000 runs, expected at most 2000"),
        (["analysis={kind='statics'}"], {"scales": "1"}, "take analysis.kind = 'dynamics'"),
        (
            ["analysis={kind='equilibrium', strategy='linear_damping', step=0.01}"],
            {"scales": "1"},
            "is no analysis in time",
        ),
        (["stages=[{name='a'}]"], {"scales": "1"}, "has stages"),
        (["probes.top.block='pier.b9'"], {"scales": "1"}, "pier.b9"),
        (["analysis.start='gone'"], {"scales": "1"}, "gone"),
        (
            ["loads.accelerograms=[{x='pulse4.csv'}, {x='pulse7.csv'}]"],
            {"scales": "1"},
            "has 2 loads.accelerograms, expected one",
        ),
    ],
)  # fmt: skip
def test_what_cannot_be_shaken_is_refused(column: Path, keys, given, words: str) -> None:
    records = sorted(column.parent.glob("pulse*.csv"))
    with pytest.raises(MasonryError, match=words):
        incremental(column, records, overrides=list(keys), out=column.parent / "out", **given)
    assert not (column.parent / "out").exists()


def test_a_record_that_does_nothing_is_refused(column: Path) -> None:
    (column.parent / "still.csv").write_text("0, 0\n1, 0\n")
    with pytest.raises(MasonryError, match="'still' does not move the ground"):
        incremental(column, [column.parent / "still.csv"], scales="1", out=column.parent / "out")


def test_records_and_settings_are_two_kinds_of_study(column: Path, capsys) -> None:
    assert run(column, "--vary", "joints.0.friction=0.5,0.6") == 1
    assert "--records and --vary are two kinds of study" in capsys.readouterr().err
