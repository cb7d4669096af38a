"""Brittle damage against closed forms: the bar in tension, its fracture energy, cracks that close."""

import numpy as np
import pytest

from masonry_fem.errors import LawError
from masonry_fem.fem.material_law import Isotropic
from masonry_fem.fem.materials.brittle_damage import BrittleDamage
from tests.fem.materials.strain_paths import SIZE, Point

STRENGTH, ENERGY, YOUNG = 2e6, 100.0, 10e9
WIDTH = float(SIZE[0])
H = WIDTH / (2 * YOUNG * ENERGY / STRENGTH**2 - WIDTH)
RATIOS = [-0.2, 0.0, 0.2, 0.4]


def bar(poisson):
    return Point(BrittleDamage(STRENGTH, ENERGY), Isotropic.of(YOUNG, poisson))


@pytest.mark.parametrize("poisson", RATIOS)
def test_a_bar_in_tension_softens_exponentially(poisson):
    """s(e) = f_t exp(−2 H (E e/f_t − 1)), with free sides, whatever ν is."""
    point = bar(poisson)
    for strain in np.linspace(0, 12 * STRENGTH / YOUNG, 49)[1:]:
        stress = point.squeezed(strain)
        assert stress == pytest.approx(softened(strain), rel=1e-8)


def softened(strain):
    """The stress s of a bar; e⁻¹⁶ of the strength stays."""
    intact = YOUNG * strain
    return intact if intact <= STRENGTH else STRENGTH * np.exp(-min(2 * H * (intact / STRENGTH - 1), 16.0))


@pytest.mark.parametrize("poisson", RATIOS)
@pytest.mark.parametrize("pressure", [0.0, 1.0, 5.0, 10.0])
def test_a_crack_takes_the_fracture_energy(poisson, pressure):
    """Whatever the steps are, and whatever presses its sides: these only shorten, by p (1 − ν)/E."""
    point = bar(poisson)
    pressure *= STRENGTH
    before = 2 * poisson * pressure / YOUNG
    for strain in np.linspace(0, 1.0, 41)[1:] ** 2 * 40 / H * STRENGTH / YOUNG / 2:
        stress = point.squeezed(before + strain, -pressure)
        assert stress == pytest.approx(softened(strain), rel=1e-8, abs=1e-8 * STRENGTH)
        side = -(pressure * (1 - poisson) + poisson * stress) / YOUNG
        # broken stone hardly resists: what is left of the stress across is 1e-6 Pa
        assert point.strain[0, 0] == pytest.approx(side, rel=1e-8, abs=1e-5 * STRENGTH / YOUNG)
    assert point.dissipated * WIDTH == pytest.approx(ENERGY, rel=1e-5)  # e⁻¹⁶ of the strength stays
    assert point.law.measures(point.internal)["damage"][0] > 1 - 1e-7


@pytest.mark.parametrize("pressure", [0.0, 4.0])
def test_work_is_the_fracture_energy_beside_any_pressure(pressure):
    """∫ σ1 dε1, from where the stone bears no tension on, by the trapezoidal rule."""
    point, rows = bar(0.2), []
    before = 0.4 * pressure * STRENGTH / YOUNG
    for strain in np.linspace(0, 1.0, 401) ** 2 * 40 / H * STRENGTH / YOUNG / 2:
        rows.append((strain, point.squeezed(before + strain, -pressure * STRENGTH)))
    strains, stresses = np.array(rows).T
    assert np.trapezoid(stresses, strains) * WIDTH == pytest.approx(ENERGY, rel=1e-4)


@pytest.mark.parametrize("poisson", [0.0, 0.2, 0.4])
def test_cracks_close_and_open_again(poisson):
    """Pressure between sides that are held is borne as by the intact stone, tension by what is left of it."""
    point = bar(poisson)
    for strain in (5e-4, 1e-3):
        opened = point.squeezed(strain)
    assert opened < 0.8 * STRENGTH
    before = point.dissipated
    point.to([0, 0, -1e-3, 0, 0, 0])
    stiff = point.elastic.bulk + 4 * point.elastic.shear / 3
    assert point.stress[2] == pytest.approx(-1e-3 * stiff, rel=1e-12)
    point.to(np.zeros(6))
    assert point.squeezed(5e-4) == pytest.approx(opened / 2, rel=1e-8)  # a straight line from the origin
    assert point.squeezed(1e-3) == pytest.approx(opened, rel=1e-8)
    assert point.dissipated == before
    assert point.squeezed(2e-3) == pytest.approx(softened(2e-3), rel=1e-8)


@pytest.mark.parametrize("poisson", RATIOS)
def test_cracked_stone_is_pressed_as_if_there_were_no_cracks(poisson):
    """E, and sides that bulge by ν."""
    point = bar(poisson)
    for strain in np.linspace(0, 0.05, 60)[1:]:
        point.squeezed(strain)
    assert point.internal[0, 1] > 1 - 1e-6
    assert point.squeezed(-1e-3) == pytest.approx(-1e-3 * YOUNG, rel=1e-8)
    assert point.strain[0, 0] == pytest.approx(1e-3 * poisson, rel=1e-8, abs=1e-15)
    assert not point.to([-1e-3, -1e-3, -2e-3, 0, 0, 0]).changed.any()  # nor is any solved for


@pytest.mark.parametrize("poisson", RATIOS)
def test_tension_along_two_axes_cracks_both(poisson):
    """σ = s along both: ε = κ − ν s/E, and twice the energy but for what can be given back."""
    point = bar(poisson)
    for share in (0.5, 1.0, 1.5, 3.0, 8.0, 30.0):
        reached = share * STRENGTH / YOUNG
        stress = softened(reached)
        strain = reached - poisson * stress / YOUNG
        point.to([strain, strain, -2 * poisson * stress / YOUNG, 0, 0, 0])
        np.testing.assert_allclose(point.stress[:3], [stress, stress, 0], rtol=1e-8, atol=1e-8 * STRENGTH)
        assert point.dissipated == pytest.approx(2 * taken(reached), rel=1e-8)


@pytest.mark.parametrize("poisson", RATIOS)
def test_tension_along_three_axes_cracks_all(poisson):
    """σ = s along each: ε = κ − 2 ν s/E, and three times the energy of one crack."""
    point = bar(poisson)
    for share in (0.5, 1.0, 1.5, 3.0, 8.0, 30.0):
        reached = share * STRENGTH / YOUNG
        stress = softened(reached)
        point.to(np.array([1, 1, 1, 0, 0, 0]) * (reached - 2 * poisson * stress / YOUNG))
        np.testing.assert_allclose(point.stress[:3], stress, rtol=1e-8, atol=1e-8 * STRENGTH)
        assert point.dissipated == pytest.approx(3 * taken(reached), rel=1e-8)


def taken(reached):
    """Energy of one crack per volume where a bar has been strained to κ."""
    stress = softened(reached)
    if YOUNG * reached <= STRENGTH:
        return 0.0
    work = STRENGTH**2 / YOUNG * (0.5 + (1 - stress / STRENGTH) / (2 * H))
    return work - 0.5 * stress * reached


@pytest.mark.parametrize("poisson", [0.0, 0.1, 0.2])
def test_simple_shear_cracks_one_axis(poisson):
    """At 45°, beside pressure across: (1 + ν)(1 − 2 ν) σ3 = ν (1 + 2 ν) s − E κ, and σ2 = ν (s + σ3)."""
    point = bar(poisson)
    for share in (0.5, 1.0, 1.2, 2.0, 5.0, 20.0):
        reached = share * STRENGTH / YOUNG
        stress = softened(reached)
        across = (poisson * (1 + 2 * poisson) * stress - YOUNG * reached) / (1 + poisson) / (1 - 2 * poisson)
        angle = 2 * (1 + poisson) * (poisson * stress - (1 - poisson) * across) / YOUNG
        point.to([0, 0, 0, angle, 0, 0])
        mean, shear = (stress + across) / 2, (stress - across) / 2
        expected = [mean, mean, poisson * (stress + across), shear, 0, 0]
        np.testing.assert_allclose(point.stress, expected, rtol=1e-8, atol=1e-8 * STRENGTH)
        assert point.dissipated == pytest.approx(taken(reached), rel=1e-8)


def test_pressure_never_damages():
    point = bar(0.2)
    for strain in np.linspace(0, -1e-2, 5)[1:]:
        assert point.squeezed(strain) == pytest.approx(YOUNG * strain, rel=1e-9)
    assert point.dissipated == 0.0


def test_shear_cracks_at_the_strength_as_principal_tension():
    """τ = f_t is the greatest principal stress of pure shear."""
    point = bar(0.0)
    angle = STRENGTH / point.elastic.shear
    point.to([0, 0, 0, 0.999 * angle, 0, 0])
    assert point.internal[0, 1] == 0.0
    point.to([0, 0, 0, 1.001 * angle, 0, 0])
    assert point.internal[0, 1] > 0.0


def test_what_does_not_go_with_its_stone_is_refused():
    law = BrittleDamage(STRENGTH, ENERGY)
    with pytest.raises(LawError, match=r"elements are up to 0.6 m wide, expected less than 0.5 m"):
        law.refuse(Isotropic.of(YOUNG, 0.2), np.array([0.1, 0.6]))
