"""Runs that are killed at random moments; ``benchmarks.kills`` and ``resumed`` kill more of them."""

import pytest

from benchmarks.kills import kills
from benchmarks.resumed import resumed


@pytest.mark.slow
def test_nobody_reads_old_figures_as_new():
    found = kills(5, 7, ("dynamics, a file a step",))
    assert [one.unreadable + one.stale + one.other for one in found] == [[]] * 5
    assert {one.outcome for one in found} <= {"not begun", "running", "interrupted", "finished"}


@pytest.mark.slow
def test_runs_that_are_killed_and_resumed_leave_what_others_do():
    (found,) = resumed(3, 7, ("rigid, dynamics, redetected",))
    assert found.kills == 3
    assert found.other == ()
