"""Time functions as callables."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from masonry_fem.errors import SceneError
from masonry_fem.scene.specs import Record, Sine, Table
from masonry_fem.scene.time_function import evaluator


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
