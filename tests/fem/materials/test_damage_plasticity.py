"""Damage with plasticity against closed forms: the bar in tension, cracks that close, crushing, two axes."""

import numpy as np
import pytest
from scipy.special import lambertw

from masonry_fem.errors import LawError
from masonry_fem.fem.material_law import Isotropic
from masonry_fem.fem.materials.damage_plasticity import DamagePlasticity
from tests.fem.materials.strain_paths import SIZE, Point

TENSION, ENERGY, PRESSURE, FRICTION, DILATANCY = 1e6, 100.0, 8e6, 35.0, 10.0
YOUNG, WIDTH = 10e9, float(SIZE[0])
RATE = TENSION * WIDTH / ENERGY  # of the strength's fall by crack strain
SINE, FLOWING = np.sin(np.radians(FRICTION)), np.sin(np.radians(DILATANCY))
RATIOS = [-0.2, 0.0, 0.2, 0.4]


def bar(poisson=0.2, law=None):
    law = law or DamagePlasticity(TENSION, ENERGY, PRESSURE, FRICTION, DILATANCY)
    return Point(law, Isotropic.of(YOUNG, poisson))


def softened(strain, young=YOUNG):
    """The stress s with strain = s/E + λ(s), s = f_t exp(−a λ): by Lambert's W."""
    return -young / RATE * float(lambertw(-RATE * TENSION / young * np.exp(-RATE * strain)).real)


@pytest.mark.parametrize("poisson", RATIOS)
def test_a_bar_in_tension_softens_by_its_crack(poisson):
    point = bar(poisson)
    for strain in np.linspace(0, 40 * TENSION / YOUNG, 41)[1:]:
        stress = point.squeezed(strain)
        intact = YOUNG * strain
        assert stress == pytest.approx(intact if intact <= TENSION else softened(strain), rel=1e-8)
        assert point.strain[0, 0] == pytest.approx(-poisson * stress / YOUNG, rel=1e-8)  # cracks pull no side


@pytest.mark.parametrize("poisson", RATIOS)
def test_a_crack_takes_the_fracture_energy(poisson):
    """Whatever the steps are: all of it but what stress below e⁻¹⁶ f_t would."""
    point = bar(poisson)
    for strain in np.linspace(0, 1.0, 21)[1:] ** 2 * 40 / RATE:
        point.squeezed(strain)
    assert point.dissipated * WIDTH == pytest.approx(ENERGY, rel=1e-5)
    assert point.law.measures(point.internal)["damage"][0] > 1 - 1e-7


@pytest.mark.parametrize("poisson", RATIOS)
def test_cracks_close_and_the_stone_is_as_stiff_as_before(poisson):
    point = bar(poisson)
    opened = point.squeezed(1e-3)
    assert opened == pytest.approx(softened(1e-3), rel=1e-8)
    before = point.dissipated
    assert point.squeezed(5e-4) == pytest.approx(opened / 2, rel=1e-8)  # a straight line to the origin
    for strain in (-1e-4, -4e-4):
        assert point.squeezed(strain) == pytest.approx(YOUNG * strain, rel=1e-8)
        assert point.strain[0, 0] == pytest.approx(-poisson * strain, rel=1e-8)
    assert not point.to([-1e-4, -1e-4, -3e-4, 0, 0, 0]).changed.any()  # closed cracks are elastic stone
    assert point.squeezed(1e-3) == pytest.approx(opened, rel=1e-8)
    assert point.dissipated == pytest.approx(before, rel=1e-12)
    assert point.squeezed(2e-3) == pytest.approx(softened(2e-3), rel=1e-8)


@pytest.mark.parametrize("pressure", [0.0, 1e6, 5e6])
def test_stone_is_crushed_at_the_strength_of_mohr_and_coulomb(pressure):
    """f_c and (1 + sin φ)/(1 − sin φ) times the pressure on the sides, and dilates by ψ."""
    point = bar()
    strength = PRESSURE + pressure * (1 + SINE) / (1 - SINE)
    ends = []
    for strain in np.linspace(0, -2.5 * strength / YOUNG, 26)[1:]:
        stress = point.squeezed(strain, -pressure)
        if strain < -1.2 * strength / YOUNG:
            assert stress == pytest.approx(-strength, rel=1e-8)
            ends.append(point.strain[0].copy())
    shares = np.diff(ends, axis=0)
    np.testing.assert_allclose(2 * shares[:, 0] / -shares[:, 2], (1 + FLOWING) / (1 - FLOWING), rtol=1e-8)
    assert point.internal[0, 7] == 0.0  # nothing cracks


def test_a_cycle_of_cracking_and_crushing_keeps_both():
    """What is crushed stays short: the crack opens and closes about the new length, with its own strength."""
    point = bar()
    opened = point.squeezed(8e-4)
    point.squeezed(-PRESSURE / YOUNG - 1e-3)
    assert point.stress[2] == pytest.approx(-PRESSURE, rel=1e-8)
    assert point.squeezed(-1e-3 - 1e-4) == pytest.approx(-YOUNG * 1e-4, rel=1e-8)
    assert point.squeezed(-1e-3 + 4e-4) == pytest.approx(opened / 2, rel=1e-8)
    assert point.squeezed(-1e-3 + 8e-4) == pytest.approx(opened, rel=1e-8)
    assert point.squeezed(-1e-3 + 1.5e-3) == pytest.approx(softened(1.5e-3), rel=1e-8)
    energy = point.stored + point.dissipated + point.excess
    assert point.work == pytest.approx(energy, rel=1e-10)


@pytest.mark.parametrize("share", [0.0, 0.25, 0.5])
def test_tension_beside_pressure(share):
    """A crack across x beside pressure along z: what one bears does not ask for the other."""
    point, pressure = bar(), share * PRESSURE
    for crack in np.array([0.02, 0.5, 2.0, 6.0]) / RATE:
        tension = TENSION * np.exp(-RATE * crack)
        stress = np.array([tension, 0.0, -pressure])
        assert (1 + SINE) * tension + (1 - SINE) * pressure < (1 - SINE) * PRESSURE
        own = (1.2 * stress - 0.2 * stress.sum()) / YOUNG + [crack, 0, 0]
        point.to([*own, 0, 0, 0])
        np.testing.assert_allclose(point.stress[:3], stress, rtol=1e-8, atol=1e-8 * TENSION)
    np.testing.assert_allclose(point.internal[0, :7], 0.0, atol=1e-15)


def test_tension_along_two_axes_cracks_both():
    """σ = f_t along both, each with its crack: (1 − ν) s/E + λ = ε, and twice the energy."""
    point = bar()
    for share in (0.0, 0.1, 0.5, 1.0, 2.0, 4.0, 8.0, 12.0):
        crack = share / RATE
        tension = TENSION * np.exp(-RATE * crack)
        strain = 0.8 * tension / YOUNG + crack
        point.to([strain, strain, -0.4 * tension / YOUNG, 0, 0, 0])
        np.testing.assert_allclose(point.stress[:3], [tension, tension, 0], rtol=1e-8, atol=1e-8 * TENSION)
        taken = 2 * ENERGY * (1 - np.exp(-share) * (1 + share / 2))  # but for what can be given back
        assert point.dissipated * WIDTH == pytest.approx(taken, rel=1e-8, abs=1e-12)


@pytest.mark.parametrize("poisson", RATIOS)
def test_tension_along_three_axes_cracks_all(poisson):
    """σ = f_t along each: (1 − 2 ν) s/E + λ = ε, and three times the energy of one crack."""
    point = bar(poisson)
    for share in (0.0, 0.1, 0.5, 1.0, 2.0, 4.0, 8.0):
        crack = share / RATE
        tension = TENSION * np.exp(-share)
        point.to(np.array([1, 1, 1, 0, 0, 0]) * ((1 - 2 * poisson) * tension / YOUNG + crack))
        np.testing.assert_allclose(point.stress[:3], tension, rtol=1e-8, atol=1e-8 * TENSION)
        taken = 3 * ENERGY * (1 - np.exp(-share) * (1 + share / 2))
        assert point.dissipated * WIDTH == pytest.approx(taken, rel=1e-8, abs=1e-12)


@pytest.mark.parametrize("poisson", [0.0, 0.1, 0.2])
def test_simple_shear_cracks_one_axis(poisson):
    """At 45°, beside pressure that crushes nothing: (1 + ν)(1 − 2 ν) σ3 = ν (1 + 2 ν) s − (s + E λ)."""
    point = bar(poisson)
    for share in (0.0, 0.03, 0.06, 0.12):
        crack, stress = share / RATE, TENSION * np.exp(-share)
        across = poisson * (1 + 2 * poisson) * stress - stress - YOUNG * crack
        across /= (1 + poisson) * (1 - 2 * poisson)
        assert (1 + SINE) * stress - (1 - SINE) * across < (1 - SINE) * PRESSURE
        angle = 2 * (1 + poisson) * (poisson * stress - (1 - poisson) * across) / YOUNG
        point.to([0, 0, 0, angle, 0, 0])
        mean, shear = (stress + across) / 2, (stress - across) / 2
        expected = [mean, mean, poisson * (stress + across), shear, 0, 0]
        np.testing.assert_allclose(point.stress, expected, rtol=1e-8, atol=1e-8 * TENSION)
        taken = ENERGY * (1 - np.exp(-share) * (1 + share / 2))
        assert point.dissipated * WIDTH == pytest.approx(taken, rel=1e-8, abs=1e-12)


def test_a_crack_that_is_wholly_open_closes_and_is_crushed():
    """What it still bears is less than rounding of what the closed stone does."""
    point = bar()
    point.squeezed(50 / RATE)
    assert point.squeezed(-2 * PRESSURE / YOUNG) == pytest.approx(-PRESSURE, rel=1e-8)
    assert point.squeezed(-PRESSURE / YOUNG) == pytest.approx(0.0, abs=1e-3)  # as long as half of it was flow


def test_an_open_crack_and_crushing_along_it_at_once():
    """Between its cracks stone bears f_c less what tension across takes, and flows with its dilatancy."""
    point = bar()
    for step in range(1, 31):
        point.to([2e-4 * step, 0.0, -8e-5 * step, 0.0, 0.0, 0.0])
    first, _, last = point.stress[:3]
    crack = point.internal[0, 7]
    assert crack > 1e-4
    assert first == pytest.approx(TENSION * np.exp(-RATE * crack), rel=1e-8)
    assert (1 + SINE) * first - (1 - SINE) * last == pytest.approx((1 - SINE) * PRESSURE, rel=1e-8)
    assert point.internal[0, 6] > 1e-4
    assert point.work == pytest.approx(point.stored + point.dissipated + point.excess, rel=1e-10)


def test_what_contradicts_itself_or_its_stone_is_refused():
    with pytest.raises(LawError, match=r"tensile_strength is 3e\+06 Pa, expected at most 2\.168e\+06 Pa"):
        DamagePlasticity(3e6, ENERGY, PRESSURE, FRICTION)
    with pytest.raises(LawError, match=r"dilatancy_angle is 40, expected at most the friction_angle 35"):
        DamagePlasticity(TENSION, ENERGY, PRESSURE, FRICTION, 40.0)
    law = DamagePlasticity(TENSION, ENERGY, PRESSURE, FRICTION)
    with pytest.raises(LawError, match=r"elements are up to 1\.5 m wide, expected less than 1 m"):
        law.refuse(Isotropic.of(YOUNG, 0.2), np.array([0.1, 1.5]))
