"""Smaller dome: weight, thrust, and where its joints open."""

from __future__ import annotations

import pytest

from demos import dome_section


@pytest.mark.slow
def test_dry_dome_cracks_and_leans_on_its_base():
    found = dome_section.main(rings=8, slices=16)
    assert found.outcome == "equilibrium"
    assert found.blocks == 8 * 16 + 1
    assert found.certificate.natural_map < 1e-9
    assert found.certificate.global_balance < 1e-9
    assert found.ground == pytest.approx(found.weight, rel=1e-9)
    assert 0.96 * dome_section.SHELL < found.weight < dome_section.SHELL
    assert dome_section.LEAST < found.thrust < 1.5 * dome_section.LEAST
    assert 25 < found.opened[0] < dome_section.PRESSED  # the inner face first
    assert found.opened[-1] < 85  # the base holds the lowest ring together
    assert 5e-6 < found.widest < 15e-6
    assert found.sinking == pytest.approx(95e-6, rel=0.1)
