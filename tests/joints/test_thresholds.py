"""Constant thresholds and Mohr–Coulomb: rigid joints that break."""

import numpy as np
import pytest

from masonry_fem.errors import LawError
from masonry_fem.joints import ConstantThreshold, MohrCoulomb, probe, pull

STIFF = 1e12


@pytest.mark.parametrize(("pressure", "peak"), [(0.1e6, 0.425e6), (0.5e6, 0.725e6), (1e6, 1.1e6)])
@pytest.mark.parametrize("dimension", [2, 3])
def test_triplet(pressure, peak, dimension):
    """A7.8: τ = c + μ σ, after rupture μ σ; the cohesion of a joint that may slip 1 mm before."""
    law = MohrCoulomb(cohesion=0.35e6, friction=0.75, critical_slip=1e-3)
    direction = np.array([0, 1.0]) if dimension == 2 else np.array([0, -0.8, 0.6])
    history = probe(law, np.outer([0.0, 0.5e-3, 0.9e-3, 2e-3, 3e-3], direction), pressure=pressure)
    shear = history.stress @ direction
    assert shear == pytest.approx([0, peak, peak, 0.75 * pressure, 0.75 * pressure], rel=1e-12)
    assert history.state.broken[0]
    assert history.state.slip[0] == pytest.approx(3e-3)


@pytest.mark.parametrize("pressure", [0.1e6, 0.5e6, 1e6])
def test_strength_in_shear_under_force(pressure):
    """Pulled through a spring the joint sticks up to c + μσ, and falls to μσ for good."""
    law = MohrCoulomb(cohesion=0.35e6, friction=0.75)
    peak = 0.35e6 + 0.75 * pressure
    pushed = -pressure / STIFF
    ends = [[pushed, x * peak / STIFF] for x in (0.5, 0.99999, 1.000001, 2.0, 0.0, 1.0)]
    history = pull(law, ends, STIFF)
    assert history.settled.all()
    residual = 0.75 * pressure
    expected = [0.5 * peak, 0.99999 * peak, residual, residual]
    assert history.stress[:4, 1] == pytest.approx(expected, rel=1e-9)
    assert history.adhesion.tolist() == [1, 1, 0, 0, 0, 0]
    assert history.demand[1] == pytest.approx(0.99999)
    assert np.abs(history.stress[4:, 1]).max() <= residual * (1 + 1e-12)
    assert history.stress[:, 0] == pytest.approx(-pressure)


def test_strength_in_tension():
    law = MohrCoulomb(cohesion=0.35e6, friction=0.75)
    apex = 0.35e6 / 0.75
    history = pull(law, [[x * apex / STIFF, 0.0] for x in (0.5, 0.99999, 1.000001, 0.5)], STIFF)
    assert history.stress[:, 0] == pytest.approx([0.5 * apex, 0.99999 * apex, 0, 0], rel=1e-9)
    assert history.jump[:2, 0] == pytest.approx(0.0, abs=1e-15)
    assert history.jump[2:, 0] == pytest.approx([1.000001 * apex / STIFF, 0.5 * apex / STIFF])


def test_tension_cut_off():
    law = MohrCoulomb(cohesion=0.35e6, friction=0.75, tensile_strength=0.25e6)
    ends = [[x * 0.25e6 / STIFF, 0.0] for x in (0.5, 0.99999, 1.000001)]
    history = pull(law, ends, STIFF)
    assert history.stress[:, 0] == pytest.approx([0.125e6, 0.25e6 * 0.99999, 0.0], rel=1e-9)
    assert history.demand[:2] == pytest.approx([0.5, 0.99999])
    # pressed, the cut-off takes nothing from shear
    pressed = pull(law, [[-1e6 / STIFF, 1.0999e6 / STIFF]], STIFF)
    assert pressed.stress[0, 1] == pytest.approx(1.0999e6)


def test_residual_friction_and_angle():
    law = MohrCoulomb.of_angle(cohesion=0.1e6, angle=45.0, residual_friction=0.5)
    history = probe(law, [[0, 1e-6]], pressure=1e6)
    assert history.stress[0, 1] == pytest.approx(0.5e6)
    assert law.friction == pytest.approx(1.0)


def test_constant_threshold_holds_until_it_opens():
    law = ConstantThreshold(strength=0.25e6, friction=0.6)
    history = pull(law, [[0.2499e6 / STIFF, 0.0], [0.2501e6 / STIFF, 0.0], [-1e6 / STIFF, 0.0]], STIFF)
    assert history.stress[:, 0] == pytest.approx([0.2499e6, 0.0, -1e6])
    shear = pull(law, [[-1e6 / STIFF, 0.7499e6 / STIFF], [-1e6 / STIFF, 0.7501e6 / STIFF]], STIFF)
    assert shear.stress[:, 1] == pytest.approx([0.7499e6, 0.6e6])


def test_constant_threshold_may_yield_before_it_breaks():
    """r_c over the critical opening: dissipates their product."""
    law = ConstantThreshold(strength=0.25e6, friction=0.6, critical_opening=1e-4)
    history = probe(law, [[0.5e-4, 0], [0.25e-4, 0], [1e-4, 0], [1.0001e-4, 0], [0, 0]])
    assert history.stress[:, 0] == pytest.approx([0.25e6] * 3 + [0, 0])
    assert history.stored == pytest.approx([12.5, 6.25, 25, 0, 0])
    assert history.dissipated == pytest.approx([0, 0, 0, 25, 25])


def test_cohesion_of_zero_is_dry():
    law = MohrCoulomb(cohesion=0.0, friction=0.6)
    history = probe(law, [[0, 1e-3], [1e-3, 1e-3]], pressure=None)
    assert not history.reaction.any()


@pytest.mark.parametrize(
    ("law", "values", "match"),
    [(MohrCoulomb, {"cohesion": 1.0, "friction": 0.0}, "friction is 0, expected a number > 0"),
     (MohrCoulomb, {"cohesion": -1.0, "friction": 0.6}, "cohesion is -1"),
     (MohrCoulomb, {"cohesion": 1.0, "friction": 0.6, "tensile_strength": -2.0}, "tensile_strength is -2"),
     (ConstantThreshold, {"strength": -3.0}, "strength is -3")],
)  # fmt: skip
def test_impossible_parameters(law, values, match):
    with pytest.raises(LawError, match=match):
        law(**values)
