"""Portal with flying buttresses and without."""

from __future__ import annotations

import pytest

from demos import flying_buttresses


@pytest.mark.slow
def test_flyers_hold_up_what_falls_alone():
    propped, alone = flying_buttresses.main(divisions=4)
    assert propped.outcome == "equilibrium"
    assert propped.admitted
    assert propped.upward == pytest.approx(propped.weight, rel=1e-9)
    # arch, piers, buttresses and flyers
    by_hand = 2000 * 9.81 * (0.4712389 + 2 * 0.3 * 1.45 + 1.68 + 2 * 0.9 * 0.12 / 0.9848078)
    assert propped.weight == pytest.approx(by_hand, rel=2e-3)
    low, high = propped.interval
    assert (low, high) == pytest.approx((2005.2, 4086.0), rel=1e-3)
    assert low * 0.999 <= propped.thrust <= high * 1.001
    assert propped.tilt == pytest.approx(0.12535, rel=1e-3)
    assert propped.natural_map < 1e-9
    assert alone.outcome == "no_equilibrium"
    assert not alone.admitted
    assert alone.moving == 28
    assert "5 hinges" in alone.mechanism
