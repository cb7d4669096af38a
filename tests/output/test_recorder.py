"""Recorders: thinning, last step, failures that stay where they are."""

import pytest

from masonry_fem.errors import InstallationError
from masonry_fem.output.recorder import Recorders


class Listener:
    def __init__(self, dense=False, error=None):
        self.dense, self.error, self.steps, self.closed = dense, error, [], 0

    def start(self, model):
        self.steps = []

    def record(self, model, state, report):
        if self.error:
            raise self.error
        self.steps.append(report.step)

    def close(self, summary):
        self.closed += 1
        return []


@pytest.mark.parametrize(
    ("count", "every", "seen"),
    [(1, 5, [0]), (6, 5, [0, 5]), (8, 5, [0, 5, 7]), (3, 1, [0, 1, 2]), (0, 2, [])],
)
def test_first_each_nth_and_last_are_recorded(report, count, every, seen):
    thin, dense = Listener(), Listener(dense=True)
    recorders = Recorders([thin, dense], every=every)
    recorders.start(None)
    for step in range(count):
        recorders.record(None, None, report(step))
    recorders.close({})
    recorders.close({})
    assert thin.steps == seen
    assert dense.steps == list(range(count))


def test_a_failing_recorder_is_left_out(report, caplog):
    bad, good = Listener(error=OSError("disk full")), Listener()
    recorders = Recorders([bad, good])
    recorders.start(None)
    for step in range(3):
        recorders.record(None, None, report(step))
    recorders.close({})
    assert good.steps == [0, 1, 2]
    assert caplog.text.count("left out") == 1


def test_files_that_are_no_list_are_not_taken_apart(report, caplog):
    wrong = Listener()
    wrong.close = lambda summary: "speeds.csv"
    assert Recorders([wrong]).close({}) == []
    assert "Listener gives 'speeds.csv' in close, expected a list of its files" in caplog.text


@pytest.mark.parametrize("error", [InstallationError("no EGL"), KeyboardInterrupt()])
def test_what_a_user_must_hear_passes(report, error):
    recorders = Recorders([Listener(error=error)])
    recorders.start(None)
    with pytest.raises(type(error)):
        recorders.record(None, None, report(0))


def test_every_must_be_positive():
    with pytest.raises(ValueError, match="every is 0"):
        Recorders([], every=0)
