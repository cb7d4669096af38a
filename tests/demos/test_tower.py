"""Tower: its weight, its foot, its sinking."""

from __future__ import annotations

import pytest

from demos import tower


@pytest.mark.slow
def test_foot_bears_weight_over_area():
    found = tower.main()
    assert found.outcome == "equilibrium"
    assert found.weight == pytest.approx(tower.WEIGHT, rel=1e-9)
    assert found.ground == pytest.approx(tower.WEIGHT, rel=1e-9)
    assert found.area == pytest.approx(tower.FOOT, rel=1e-9)
    assert found.pressure == pytest.approx(438.7e3, rel=1e-3)
    assert tower.SINKING < found.sinking < 1.15 * tower.SINKING
    assert found.compression[0] < -found.pressure
    assert found.certificate.natural_map < 1e-9
    assert found.certificate.global_balance < 1e-9
