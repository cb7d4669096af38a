"""Rubble wall of fewer stones: statics and limit analysis say the same of its weight."""

from __future__ import annotations

import pytest

from demos import rubble_wall


@pytest.mark.slow
def test_friction_decides_whether_rubble_stands():
    rough, smooth, slippery = rubble_wall.main(stones=36, frictions=(0.6, 0.4, 0.15))
    for one in (rough, smooth):
        assert one.outcome == "equilibrium"
        assert one.admitted
        assert one.ground == pytest.approx(rubble_wall.WEIGHT, rel=1e-6)
        assert one.natural_map < 1e-9
        assert (one.below, one.beyond) == ("equilibrium", "no_equilibrium")
    assert rough.tilt <= rubble_wall.ONE_BLOCK * (1 + 1e-6)
    assert rough.tilt > 0.95 * rubble_wall.ONE_BLOCK
    assert smooth.tilt <= rough.tilt * (1 + 1e-6)
    assert slippery.outcome == "no_equilibrium"
    assert slippery.moving > 0
    assert not slippery.admitted
