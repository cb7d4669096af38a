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
RATIOS = [0.0, 0.2, 0.4]


def bar(poisson):
    return Point(BrittleDamage(STRENGTH, ENERGY), Isotropic.of(YOUNG, poisson))


@pytest.mark.parametrize("poisson", RATIOS)
def test_a_bar_in_tension_softens_exponentially(poisson):
    """s(e) = f_t exp(−2 H (E e/f_t − 1)), with free sides, whatever ν is."""
    point = bar(poisson)
    for strain in np.linspace(0, 12 * STRENGTH / YOUNG, 49)[1:]:
        stress = point.squeezed(strain)
        intact = YOUNG * strain
        expected = intact if intact <= STRENGTH else STRENGTH * np.exp(-2 * H * (intact / STRENGTH - 1))
        assert stress == pytest.approx(expected, rel=1e-8)


@pytest.mark.slow
@pytest.mark.parametrize("poisson", RATIOS)
def test_a_crack_takes_the_fracture_energy(poisson):
    """Over the width of its band: to second order in the steps of the path."""
    taken = []
    for steps in (400, 800):
        point = bar(poisson)
        for strain in np.linspace(0, 1.0, steps + 1)[1:] ** 2 * 60 / H * STRENGTH / YOUNG / 2:
            point.squeezed(strain)
        taken.append(point.dissipated * WIDTH)
    assert taken[1] == pytest.approx(ENERGY, rel=2e-3)
    assert abs(taken[1] - ENERGY) < 0.35 * abs(taken[0] - ENERGY)


@pytest.mark.parametrize("poisson", RATIOS)
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


@pytest.mark.parametrize("poisson", RATIOS)
def test_the_sides_of_cracked_stone_bulge_more(poisson):
    """Free sides under pressure are stretched: E falls to 2 μ as g → 0, E/(1 + ν)."""
    point = bar(poisson)
    for strain in np.linspace(0, 0.05, 60)[1:]:
        point.squeezed(strain)
    assert point.internal[0, 1] > 1 - 1e-6
    assert point.squeezed(-1e-3) == pytest.approx(-1e-3 * YOUNG / (1 + poisson), rel=1e-4)


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
    with pytest.raises(LawError, match=r"poisson is -0\.1, expected at least 0"):
        law.refuse(Isotropic.of(YOUNG, -0.1), SIZE)
