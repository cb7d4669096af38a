"""Accelerograms: files of PEER and CSV files, what is wrong in them, and what the ground does."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from masonry_fem.analyses.run import solve_scene
from masonry_fem.errors import MasonryError
from masonry_fem.march.shaking import GroundMotion, corrected
from masonry_fem.scene import loads
from masonry_fem.scene.accelerogram import read_accelerogram

HEAD = "PEER STRONG MOTION DATABASE RECORD\nSomewhere, 1/1/1999, 180\nACCELERATION {what} UNITS OF {unit}\n"
NEW = HEAD.format(what="TIME SERIES IN", unit="G") + "NPTS=   5, DT=   .0100 SEC\n"
OLD = HEAD.format(what="TIME HISTORY IN", unit="G") + "   5    0.0100    NPTS, DT\n"
VALUES = "  .1000000E+00  -.2000000E+00 0.3E-01\n  .4 -.5\n"
SCENE = """
dimension = 2
fidelity = "rigid"
materials.stone.density = 2000
structures = [{ kind = "stack", name = "pier", material = "stone", size = [1.0, 1.0], count = 1 }]
joints = [{ friction = 2.0 }]
analysis = { kind = "dynamics", step = 0.01, duration = 0.1 }
loads.gravity = [0, -9.81]
"""


@pytest.mark.parametrize("head", [NEW, OLD])
def test_files_of_peer_are_in_g(tmp_path: Path, head: str) -> None:
    path = tmp_path / "record.AT2"
    path.write_text(head + VALUES)
    times, values = read_accelerogram(path, "x", None)
    np.testing.assert_allclose(times, 0.01 * np.arange(5))
    np.testing.assert_allclose(values, 9.80665 * np.array([0.1, -0.2, 0.03, 0.4, -0.5]))


def test_csv_files_have_units_and_columns(tmp_path: Path) -> None:
    path = tmp_path / "record.csv"
    path.write_text("# measured\ntime; x; z\n0; 1; 2\n0.1; 3; 4\n")
    for axis, expected in (("x", [1.0, 3.0]), ("z", [2.0, 4.0])):
        np.testing.assert_allclose(read_accelerogram(path, axis, "cm/s^2")[1], np.array(expected) / 100)
    path.write_text("time [s], x [cm/s²], z [cm/s²]\n0, 1, 2\n0.1, 3, 4\n")
    np.testing.assert_allclose(read_accelerogram(path, "z", "cm/s^2")[1], [0.02, 0.04])
    path.write_text("0, 1\n0.1, 3\n")
    np.testing.assert_allclose(read_accelerogram(path, "y", None)[1], [1.0, 3.0])


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("a.AT2", "", "line 4: .*expected 'NPTS= 4000"),
        ("a.AT2", HEAD.format(what="IN", unit="G") + "DT= .01\n" + VALUES, "expected 'NPTS= 4000"),
        ("a.AT2", NEW.replace("UNITS OF G", "UNITS OF CM/S") + VALUES, "UNITS OF CM/S"),
        ("a.AT2", NEW + ".1 .2 .3\n", "holds 3 values, expected NPTS = 5"),
        ("a.AT2", NEW + ".1 .2 x .3 .4\n", "line 5: .*expected finite numbers"),
        ("a.AT2", NEW.replace(".0100", "0.0") + VALUES, "DT = 0 s"),
        ("a.csv", "", "holds 0 lines of numbers"),
        ("a.csv", "0, 1\n0, 2\n", "line 2: time 0 s after 0 s"),
        ("a.csv", "0, 1\n0.1, nan\n", "line 2: .*expected finite numbers"),
        ("a.csv", "0, 1\n0.1, 2, 3\n", "line 2: 3 numbers, expected 2"),
        ("a.csv", "0, 1, 2\n0.1, 2, 3\n", "none titled 'x'"),
        ("a.csv", "time, y, z\n0, 1, 2\n0.1, 2, 3\n", "none titled 'x'"),
        ("a.csv", "time, x, x\n0, 1, 2\n0.1, 2, 3\n", "2 titled 'x'"),
        ("a.csv", "time [s], x [g]\n0, 1\n0.1, 2\n", "titles say 'g', and it is read in s and m/s\\^2"),
        ("a.csv", "time (ms), x\n0, 1\n5, 2\n", "titles say 'ms'"),
    ],
)
def test_what_is_wrong_in_a_file_is_named(tmp_path: Path, name: str, text: str, said: str) -> None:
    (tmp_path / name).write_text(text)
    with pytest.raises(MasonryError, match=said) as caught:
        read_accelerogram(tmp_path / name, "x", None)
    assert name in str(caught.value)


def test_a_file_that_is_no_text_is_named(tmp_path: Path) -> None:
    (tmp_path / "a.AT2").write_bytes(bytes(range(128, 256)))
    with pytest.raises(MasonryError, match="cannot be read as text"):
        read_accelerogram(tmp_path / "a.AT2", "x", None)


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ("{}", "lacks the key 'x', expected a file along some axis"),
        ("{ x = 'b.csv' }", "existing file"),
        ("{ z = 'a.csv' }", "none in a 2D scene"),
        ("{ x = 'a.AT2', unit = 'm/s^2' }", "units of g"),
        ("{ x = 'a.csv', unit = 'gal' }", "unit"),
    ],
)
def test_what_is_wrong_in_a_scene_is_named(tmp_path: Path, more: str, said: str) -> None:
    (tmp_path / "a.csv").write_text("0, 1\n0.1, 2\n")
    (tmp_path / "a.AT2").write_text(NEW + VALUES)
    with pytest.raises(MasonryError, match=said):
        loads(SCENE + f"loads.accelerograms = [{more}]\n", base=tmp_path)


def test_statics_has_no_time(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("0, 1\n0.1, 2\n")
    text = SCENE + "loads.accelerograms = [{ x = 'a.csv' }]\n"
    with pytest.raises(MasonryError, match="statics, which has no time"):
        loads(text, ["analysis={kind='statics'}"], base=tmp_path)


def test_the_ground_moves_by_the_exact_integral() -> None:
    """Linear acceleration: a cubic between samples, and the last velocity after the end."""
    record = GroundMotion(np.array([1.0, 1.5, 3.0]), np.array([0.0, 1.0, 4.0]))
    assert record.acceleration(2.0) == pytest.approx(2.0)
    assert record.acceleration(0.5) == record.acceleration(3.5) == 0.0
    for time in (1.2, 2.0, 3.0):  # a = 2 (t - 1)
        assert record.displacement(time) == pytest.approx((time - 1) ** 3 / 3)
    assert record.displacement(4.0) == pytest.approx(8 / 3 + 4.0)


@pytest.mark.parametrize("degree", [0, 1, 2])
def test_a_baseline_is_found_and_taken_away(degree: int) -> None:
    """Of a motion that returns, shifted by a polynomial of that degree, the motion is left, nearly."""
    times = np.linspace(0.0, 20.0, 4001)
    true = np.exp(-0.5 * (times - 10) ** 2) * np.sin(6 * times)
    wrong = true + np.polynomial.polynomial.polyval(times / 20, [0.05, -0.08, 0.06][: degree + 1])
    found = corrected(GroundMotion(times, wrong), degree)
    assert np.abs(found.values - true).max() < 2e-3
    assert abs(GroundMotion(times, wrong).velocities[-1]) > 0.1
    assert abs(found.velocities[-1]) < 5e-3


def test_supports_carry_a_block_as_inertia_does(tmp_path: Path, caplog) -> None:
    """A block that sticks goes with the ground; as inertia it stays and its base feels the same force."""
    (tmp_path / "a.csv").write_text("0, 0\n0.05, 1\n0.1, 0\n")
    force, way = {}, {}
    for acts in ("inertia", "ground"):
        more = f"loads.accelerograms = [{{ x = 'a.csv', scale = 2.0, acts = '{acts}' }}]\n"
        more += "probes = [{ name = 'top', block = 'pier.b1', point = [0.5, 1.0] }]\n"
        forces: list[float] = []

        class Base:
            def record(self, model, state, report, forces=forces) -> None:
                forces.append(report.support_resultants["pier.ground"][0])

        made = solve_scene(loads(SCENE + more, base=tmp_path), tmp_path, (Base(),))
        force[acts], way[acts] = np.array(forces), made.march.report.probes["top"][0]
    kink = 80.0 * 0.01 / 6  # of the acceleration: what a step's mean velocity makes of it [m/s²]
    np.testing.assert_allclose(force["inertia"], force["ground"], atol=1.01 * 2000 * kink)
    assert np.abs(force["ground"]).max() == pytest.approx(2000 * 2, rel=0.15)
    assert way["inertia"] == pytest.approx(0.0, abs=1e-9)
    # a step of 10 ms lags by 7e-4 of it, one of 5 ms by 8e-5
    assert way["ground"] == pytest.approx(2 * 0.05**2, rel=1e-3)


def test_a_ground_that_drifts_and_a_coarse_step_are_told(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("0, 0\n0.005, 1\n0.01, 1\n")
    more = "loads.accelerograms = [{ x = 'a.csv', acts = 'ground' }]\nmaterials.stone.damping.mass = 0.1\n"
    made = solve_scene(loads(SCENE + more, base=tmp_path), tmp_path)
    said = {one.code: one.sentence for one in made.summary.remarks}
    assert "drifts on" in said["drifting_ground"]
    assert "peaks between steps are missed" in said["coarse_record"]
    assert "drags stones back" in said["scene"]
