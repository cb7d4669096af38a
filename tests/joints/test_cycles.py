"""Cyclic shear under constant pressure (Atkinson et al. 1989; A7.13, shape only)."""

import numpy as np
import pytest

from masonry_fem.joints import Bed, FremondCangemi, MohrCoulomb, MonerieAcary, probe

SIGMA, AMPLITUDE = 0.5e6, 4e-3
J4D = {"normal_stiffness": 82e9, "tangential_stiffness": 36e9, "normal_strength": 0.25e6,
       "tangential_strength": 0.35e6, "normal_energy": 18.0, "tangential_energy": 125.0}  # fmt: skip
LAWS = {
    "monerie_acary": (MonerieAcary(**J4D, friction=0.75), 0.35e6 + 0.75 * SIGMA),
    "fremond_cangemi": (
        FremondCangemi(normal_stiffness=1e10, tangential_stiffness=1e10, energy=12.25, friction=0.75),
        0.35e6 + 0.75 * SIGMA,
    ),
    "bedded": (
        Bed(MohrCoulomb(cohesion=0.35e6, friction=0.75), 82e9, 36e9), 0.35e6 + 0.75 * SIGMA,
    ),
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("name", LAWS)
def test_loops_are_rectangles_without_recovery(name):
    law, peak = LAWS[name]
    first = np.concatenate([np.linspace(0, 5e-5, 1001)[1:], np.linspace(5e-5, AMPLITUDE, 200)[1:]])
    cycle = np.cos(np.linspace(0, 2 * np.pi, 801)[1:]) * AMPLITUDE  # small steps where it turns
    path = np.concatenate([first, cycle, cycle])
    history = probe(law, np.stack([0 * path, path], axis=1), pressure=SIGMA)
    shear, n, m = history.stress[:, 1], len(first), len(cycle)
    assert shear[:n].max() == pytest.approx(peak, rel=1e-2)
    tail = 1e6 * 1e-2 if name == "fremond_cangemi" else 1.0  # its hyperbola never quite ends
    assert np.abs(shear[n:]).max() == pytest.approx(0.75 * SIGMA, abs=tail)
    second, third = shear[n : n + m], shear[n + m :]
    assert second == pytest.approx(third, abs=1e-3 * SIGMA)
    # the loop's area is the energy lost in it
    lost = (history.rubbed + history.dissipated)[[n + m - 1, -1]]
    area = np.trapezoid(shear[n + m - 1 :], path[n + m - 1 :])
    assert lost[1] - lost[0] == pytest.approx(area, rel=1e-3)
    # the rectangle is 4 σ μ A but for elastic flanks
    assert lost[1] - lost[0] == pytest.approx(4 * 0.75 * SIGMA * AMPLITUDE, rel=1e-2)
