"""history.csv: a line a step, readable at once."""

import csv
from dataclasses import dataclass
from enum import Enum

import numpy as np

from masonry_fem.output.history import History, columns


def rows(path):
    with path.open(encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_lines_are_there_before_the_file_is_closed(elastic, report, tmp_path):
    model, state = elastic
    history = History(tmp_path)
    history.start(model)
    for step in (1, 2, 3):
        history.record(model, state, report(step))
        assert len(rows(history.path)) == step
    assert history.close({}) == [tmp_path / "history.csv"]
    assert history.close({}) == [tmp_path / "history.csv"]
    last = rows(history.path)[-1]
    assert list(last)[:2] == ["time", "step"]
    assert float(last["support_resultants.ground_fz"]) == 13.0
    assert float(last["support_resultants.ground_my"]) == 1.0
    assert float(last["applied_fz"]) == -10.0
    assert float(last["probes.top_z"]) == -2e-5
    assert int(last["iterations"]) == 7


def test_numbers_survive_to_the_last_bit(elastic, report, tmp_path):
    model, state = elastic
    history = History(tmp_path)
    history.start(model)
    history.record(model, state, report(3))
    history.close({})
    assert float(rows(history.path)[0]["time"]) == report(3).time


def test_any_report_becomes_columns():
    class Colour(Enum):
        RED = "r"

    @dataclass(frozen=True, slots=True)
    class Inner:
        error: float

    @dataclass(frozen=True, slots=True)
    class Report:
        colour: Colour
        quality: Inner
        plane: np.ndarray
        support_resultants: dict
        good: bool
        step: int
        time: float

    made = Report(Colour.RED, Inner(0.5), np.array([1.0, 2.0]), {"g": np.arange(3.0)}, True, 4, 0.25)
    assert dict(columns(made)) == {
        "time": 0.25, "step": 4, "colour": "red", "quality.error": 0.5, "plane_x": 1.0, "plane_y": 2.0,
        "support_resultants.g_fx": 0.0, "support_resultants.g_fy": 1.0, "support_resultants.g_mz": 2.0,
        "good": 1,
    }  # fmt: skip


def test_closing_without_a_step_writes_nothing(tmp_path):
    assert History(tmp_path).close({}) == []
