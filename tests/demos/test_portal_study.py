"""The demo of speed against accuracy: the advice against a finer run."""

import pytest

from demos import portal_study


@pytest.mark.slow
def test_the_thrust_is_as_true_as_was_asked(tmp_path):
    found = portal_study.main(out=tmp_path, sizes=(0.2, 0.1, 0.05), accuracy=0.05, truth=0.025)
    assert found.cells == 12
    assert found.settings is not None
    assert found.error <= found.bound <= 0.05
    assert (tmp_path / "pareto.png").stat().st_size > 20000
