"""Runs that are killed at random moments; ``benchmarks.kills`` kills more of them."""

import pytest

from benchmarks.kills import kills


@pytest.mark.slow
def test_nobody_reads_old_figures_as_new():
    found = kills(5, 7, ("dynamics, a file a step",))
    assert [one.unreadable + one.stale + one.other for one in found] == [[]] * 5
    assert {one.outcome for one in found} <= {"not begun", "running", "interrupted", "finished"}
