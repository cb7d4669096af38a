"""Peaks of histories: of a column that a jack pushes, whose stone cracks at a strength that is varied."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from masonry_fem import cli
from masonry_fem.analyses.study import study
from masonry_fem.analyses.study.peak import Peaks, asked_for
from masonry_fem.analyses.study.table import print_study
from masonry_fem.errors import MasonryError

TIE = """
title = "bar that is torn"
dimension = 2
plane = "stress"
fidelity = "inelastic"
mesh = { element = "Q1", divisions = [1, 1] }
[materials.stone]
density = 2000
young = "10 GPa"
poisson = 0.0
[materials.stone.inelastic]
law = "brittle_damage"
tensile_strength = "2 MPa"
fracture_energy = 100
[[structures]]
kind = "block"
name = "bar"
material = "stone"
size = [0.1, 0.1]
position = [0.0, 0.0]
[[supports]]
on = "bar/bottom"
[[supports]]
on = "bar/top"
motion = { displacement = [0.0, "0.1 mm"] }
[[probes]]
name = "top"
block = "bar"
point = [0.05, 0.1]
[analysis]
kind = "statics"
load_steps = 20
"""


def _report(time: float, force: list[float], moved: list[float]) -> SimpleNamespace:
    return SimpleNamespace(
        time=time, support_resultants={"jack": np.array([*force, 0.0])}, probes={"top": np.array(moved)}
    )


def test_a_peak_keeps_its_sign_its_time_and_where_the_probes_were():
    peaks = Peaks(2)
    for step in (
        (0.25, [1.0, 0.0], [0.0, 1e-3]),
        (0.5, [-3.0, 4.0], [2e-3, 1e-3]),
        (0.75, [2.0, -4.0], [1e-3, -9e-3]),
    ):
        peaks.record(None, None, _report(*step))
    told = json.loads(json.dumps(peaks.told()))
    level, size, last = asked_for(told, ["supports.jack.x", "supports.jack", "time"])
    assert (level.value, level.time, level.unit) == (-3.0, 0.5, "N/m")
    assert level.probes == {"top": [2e-3, 1e-3]}
    assert (size.value, size.time) == (5.0, 0.5)
    assert (last.value, last.time) == (0.75, 0.75)
    with pytest.raises(MasonryError, match=r"--peak supports\.jak\.x: no such number .*did you mean"):
        asked_for(told, ["supports.jak.x"])
    assert asked_for([], ["supports.jack.x"]) == ()  # of a cell that made no step


@pytest.fixture(scope="module")
def scene(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("torn") / "bar.toml"
    path.write_text(TIE)
    return path


@pytest.mark.slow
def test_the_force_that_tears_a_bar_is_its_strength(scene: Path, tmp_path: Path, capsys):
    """Steps of 5 µm pull by 0.5 MPa each: the peak is the strength, at the end of the last elastic step."""
    vary = {"materials.*.inelastic.tensile_strength": ["1 MPa", "2 MPa"]}
    made = study(scene, vary, out=tmp_path, peaks=["supports.bar/top.y"], quantities=["peak"])
    for row, strength, cells in zip(made.rows, (1e6, 2e6), (2, 4), strict=True):
        (peak,) = row.peaks
        assert peak.value == pytest.approx(0.1 * strength, rel=1e-6)
        assert peak.time == pytest.approx(cells / 20)
        assert peak.probes["top"][1] == pytest.approx(5e-6 * cells)
        assert row.quantities["peak.supports.bar/top.y"].values == (peak.value,)
        assert row.yielded.startswith("bar (damage 0.")
    print_study(made)
    told = capsys.readouterr().out
    assert "supports.bar/top.y  1e+05 N/m  0.1" in told
    assert repr(made) == told.rstrip()
    with made.write(pictures=False)[0].open(newline="") as file:
        lines = list(csv.DictReader(file))
    assert float(lines[1]["peak.supports.bar/top.y.probes.top.y"]) == pytest.approx(2e-5)
    assert lines[1]["yielded"] == made.rows[1].yielded


@pytest.mark.slow
def test_a_number_that_no_history_has_is_refused(scene: Path, capsys):
    """After cells are computed: they are kept, so that the next attempt computes none."""
    line = ["study", str(scene), "--vary", "analysis.load_steps=20", "--out", str(scene.parent / "out")]
    assert cli.main([*line, "--peak", "supports.bar/topp.y"]) == 1
    assert "did you mean 'supports.bar/top.y'?" in capsys.readouterr().err


@pytest.mark.slow
def test_a_cell_that_ends_early_tells_its_peak_up_to_there(scene: Path, tmp_path: Path):
    """A traction that grows beyond the strength: the cell is not compared, but what it bore is written."""
    text = scene.read_text().replace('motion = { displacement = [0.0, "0.1 mm"] }', "")
    push = '[[loads.tractions]]\non = "bar/top"\nvector = [0, 2.5e6]\n'
    text = text.replace('[[supports]]\non = "bar/top"\n', push)
    path = tmp_path / "pulled.toml"
    path.write_text(text)
    strengths = {"materials.stone.inelastic.tensile_strength": ["2 MPa", "3 MPa"]}
    weak, strong = study(path, strengths, out=tmp_path / "out", peaks=["supports.bar/bottom.y"]).rows
    assert (weak.outcome, strong.outcome) == ("no_convergence", "equilibrium")
    assert weak.quantities == {}
    assert weak.peaks[0].value == pytest.approx(-0.1 * 2e6)
    assert strong.peaks[0].value == pytest.approx(-0.1 * 2.5e6)
