"""Time functions as callables."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from masonry_fem.errors import SceneError
from masonry_fem.scene import check, loads
from masonry_fem.scene.specs import Pulse, Record, Sine, Table
from masonry_fem.scene.time_function import endless, evaluator


def test_no_function_is_one():
    factor = evaluator(None)
    assert (factor(3.0), factor.rate(3.0)) == (1.0, 0.0)


def test_a_table_is_linear_between_and_constant_outside():
    factor = evaluator(Table(points=((0.0, 1.0), (2.0, 3.0), (3.0, 0.0))))
    assert [factor(t) for t in (-1, 0, 1, 2, 2.5, 9)] == [1, 1, 2, 3, 1.5, 0]
    assert [factor.rate(t) for t in (-1, 0, 1, 2, 2.5, 3, 9)] == [0, 1, 1, -3, -3, 0, 0]


def test_a_table_of_one_point_is_constant():
    factor = evaluator(Table(points=((5.0, 2.0),)))
    assert (factor(0.0), factor(9.0), factor.rate(5.0)) == (2.0, 2.0, 0.0)


@given(st.floats(0.1, 10), st.floats(-3, 3), st.floats(-4, 4), st.floats(0, 5))
def test_a_sine_and_its_rate(frequency, amplitude, phase, time):
    factor = evaluator(Sine(frequency=frequency, amplitude=amplitude, phase=phase))
    turn = 2 * np.pi * frequency
    assert factor(time) == pytest.approx(amplitude * np.sin(turn * time + phase), abs=1e-12)
    assert factor.rate(time) == pytest.approx(amplitude * turn * np.cos(turn * time + phase), abs=1e-9)


def test_a_record_is_read_beside_the_scene(tmp_path):
    (tmp_path / "quake.csv").write_text("# made up\ntime [s], acceleration\n0, 0\n0.5; 2 # peak\n\n1\t0\n")
    factor = evaluator(Record(path="quake.csv", scale=3.0), tmp_path)
    assert [factor(t) for t in (0, 0.25, 0.5, 1, 2)] == [0, 3, 6, 0, 0]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("0 0\n1 x\n", r"quake.csv, line 2: '1 x', expected two finite numbers"),
        ("0 0\n1 1\n1 2\n", r"quake.csv, line 3: time 1 s after 1 s, expected increasing times"),
        ("t,a\n", r"quake.csv: holds no numbers"),
        ("0 0\n1 nan\n", r"line 2: '1 nan', expected two finite numbers"),
        ("0 0 0\n", r"line 1: '0 0 0', expected two finite numbers"),
        ("nan 0\n0 0\n", r"line 1: 'nan 0', expected two finite numbers"),
        ("time value\ns m\n0 0\n", r"line 2: 's m', expected two finite numbers"),
        ("time value\n0,0\n1;2,5\n", r"line 3: '1;2,5', expected two finite numbers"),
        ("x" * 500 + "\n" + "y" * 500, r"line 2: 'y{56}\.\.\., expected two"),
    ],
)
def test_a_bad_record_is_named(tmp_path, text, expected):
    (tmp_path / "quake.csv").write_text(text)
    with pytest.raises(SceneError, match=expected):
        evaluator(Record(path="quake.csv"), tmp_path)


def test_a_missing_record_is_named(tmp_path):
    with pytest.raises(SceneError, match=r"quake.csv: cannot be read"):
        evaluator(Record(path="quake.csv"), tmp_path)


def test_a_table_that_repeats_begins_anew():
    factor = evaluator(Table(points=((1.0, 0.0), (2.0, 4.0), (3.0, 0.0)), repeats=True))
    assert [factor(t) for t in (0, 1, 1.5, 2, 2.5, 3, 3.5, 4, 5.25)] == [0, 0, 2, 4, 2, 0, 2, 4, 1]
    assert [factor.rate(t) for t in (0, 1, 2.5, 3, 4.5)] == [0, 4, -4, 4, -4]
    assert factor.end == 0.0


@pytest.mark.parametrize(
    ("shape", "quarter", "middle"),
    [
        ("half_sine", np.sqrt(0.5), 1.0),
        ("full_sine", 1.0, 0.0),
        ("triangle", 0.5, 1.0),
        ("rectangle", 1.0, 1.0),
    ],
)
def test_a_pulse_and_its_repetitions(shape, quarter, middle):
    once = evaluator(Pulse(shape=shape, start=1.0, duration=0.5, amplitude=3.0))
    assert [once(t) for t in (0.9, 1.5, 1.6, 9.0)] == [0, 0, 0, 0]
    assert [once(1.125), once(1.25)] == pytest.approx([3.0 * quarter, 3.0 * middle], abs=1e-12)
    assert once.end == 1.5
    thrice = evaluator(Pulse(shape=shape, start=1.0, duration=0.5, amplitude=3.0, every=0.75, count=3))
    assert [thrice(t + 1.125) for t in (0.75, 1.5)] == [once(1.125)] * 2
    assert [thrice(1.625), thrice(3.25), thrice(7.0)] == [0, 0, 0]
    assert thrice.end == 3.0
    for t in (1.05, 1.07, 1.9):
        slope = (thrice(t + 1e-7) - thrice(t - 1e-7)) / 2e-7
        assert thrice.rate(t) == pytest.approx(slope, rel=1e-6, abs=1e-6)


def test_what_has_no_end_is_known():
    assert endless(Sine(frequency=1.0))
    assert endless(Table(points=((0.0, 0.0), (1.0, 0.0)), repeats=True))
    assert endless(Pulse(duration=1.0, every=2.0))
    assert not endless(Pulse(duration=1.0, every=2.0, count=2))
    assert not endless(Pulse(duration=1.0))
    assert not endless(None)


def test_a_record_has_units_and_columns(tmp_path):
    (tmp_path / "rig.csv").write_text('# rig 2\nt,"pull",temp\n0,0,20\n500,2,21\n1000,1,22\n')
    record = Record(path="rig.csv", column="pull", unit="kN", time_unit="ms", scale=0.5, repeats=True)
    factor = evaluator(record, tmp_path)
    assert [factor(t) for t in (0.0, 0.25, 0.5, 0.75, 1.5)] == pytest.approx([0, 500, 1000, 750, 1000])
    heat = evaluator(Record(path="rig.csv", column="temp", unit="degC", time_unit="ms"), tmp_path)
    assert heat(0.5) == pytest.approx(21.0)  # of changes of temperature


@pytest.mark.parametrize(
    ("text", "column", "expected"),
    [
        ("t,a,b\n0,1,2\n", "c", r"line 1: no column 'c', expected one of 'a', 'b' after that of the time"),
        (
            "t,a\n0,1\n1\n",
            "a",
            r"line 3: '1', expected 2 cells, with finite numbers for the time and for 'a'",
        ),
        ("t,a\n0,x\n", "a", r"line 2: '0,x', expected 2 cells"),
        ("t,a\n0,1\n0,2\n", "a", r"line 3: time 0 after 0, expected increasing times"),
        ("t,a\n", "a", r"holds no numbers"),
    ],
)
def test_a_bad_column_is_named(tmp_path, text, column, expected):
    (tmp_path / "rig.csv").write_text(text)
    with pytest.raises(SceneError, match=expected):
        evaluator(Record(path="rig.csv", column=column), tmp_path)


SCENE = """
dimension = 2
fidelity = "rigid"
materials.stone.density = 2400.0
structures = [{ kind = "block", name = "a", material = "stone", size = [1.0, 1.0] }]
loads.gravity = [0.0, -9.81]
"""


@pytest.mark.parametrize(
    ("time", "expected"),
    [
        (
            "{ kind = 'pulse', duration = 0.4, every = 0.3 }",
            r"gravity_time.every is 0.3, expected a time not",
        ),
        ("{ kind = 'pulse', duration = 0.4, count = 3 }", r"gravity_time.count is 3, expected none without"),
        ("{ kind = 'record', path = 'a.csv', unit = 'kNN' }", r"gravity_time.unit is 'kNN', expected a unit"),
        (
            "{ kind = 'record', path = 'a.csv', time_unit = 'kN' }",
            r"time_unit is 'kN', expected a unit of time",
        ),
    ],
)
def test_what_does_not_go_together_is_refused(tmp_path, time, expected):
    (tmp_path / "a.csv").write_text("0 1\n")
    with pytest.raises(SceneError, match=expected):
        check(loads(SCENE, [f"loads.gravity_time={time}"], base=tmp_path), base=tmp_path)
