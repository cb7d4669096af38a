"""Asperities that close under pressure, in series with joint laws, at one point."""

import numpy as np
import pytest

from masonry_fem.errors import LawError
from masonry_fem.joints import Bed, Closure, Dry, MohrCoulomb, probe

K, GREATEST = 18e9, 1e-4
LAW = Closure(Dry(0.6), K, GREATEST)


def closing(pressure):
    return pressure * GREATEST / (K * GREATEST + pressure)


def stiffness(pressure):
    return K * (1 + pressure / (K * GREATEST)) ** 2


@pytest.mark.parametrize("pressure", [1e3, 1e5, 1e6, 1e8])
def test_first_loading_follows_the_hyperbola(pressure):
    """Whether in one step or in many, and whether pressure or closing is given."""
    for steps in (1, 7):
        history = probe(LAW, np.zeros((steps, 2)), pressure=np.linspace(0, pressure, steps + 1)[1:])
        assert -history.jump[-1, 0] == pytest.approx(closing(pressure), rel=1e-9)
        way = -closing(pressure) * np.linspace(0, 1, steps + 1)[1:]
        history = probe(LAW, np.stack([way, 0 * way], axis=1))
        assert -history.stress[-1, 0] == pytest.approx(pressure, rel=1e-8)


def test_unloading_goes_along_the_tangent_and_leaves_a_set():
    most = 1e6
    history = probe(LAW, np.zeros((5, 2)), pressure=[most, 0.5 * most, 0.0, most, 2 * most])
    closed = -history.jump[:, 0]
    expected = closing(most) - np.array([0, 0.5, 1, 0]) * most / stiffness(most)
    assert closed[:4] == pytest.approx(expected, rel=1e-9)
    assert closed[2] == pytest.approx(GREATEST * (most / (K * GREATEST + most)) ** 2)
    assert closed[4] == pytest.approx(closing(2 * most), rel=1e-9)


def test_no_pressure_closes_it_wholly():
    history = probe(LAW, np.zeros((1, 2)), pressure=1e13)
    assert 0.99 * GREATEST < -history.jump[0, 0] < GREATEST


def test_shear_is_elastic_by_its_share_until_it_slides():
    pressure, ratio = 1e6, 0.25
    law = Closure(Dry(0.6), K, GREATEST, shear_ratio=ratio)
    slope = ratio * stiffness(pressure)
    turn = 0.6 * pressure / slope
    ways = np.array([0, 0.5, 0.99, 3.0, 2.5]) * turn
    history = probe(law, np.stack([0 * ways, ways], axis=1), pressure=pressure)
    expected = [0, 0.5 * 0.6e6, 0.99 * 0.6e6, 0.6e6, 0.5 * 0.6e6]
    assert history.stress[:, 1] == pytest.approx(expected, rel=1e-6, abs=1)


def test_energy_is_stored_or_lost_and_never_made():
    """The work of the mean reaction of each step, to rounding; loops lose what lies between the two lines."""
    generator = np.random.default_rng(3)
    ways = np.cumsum(generator.normal(size=(60, 3)) * 1e-6, axis=0)
    ways[:, 0] = -GREATEST * np.maximum.accumulate(0.8 * generator.random(60))
    ways[::3, 0] *= 0.95
    history = probe(LAW, ways)
    assert (np.diff(history.dissipated) >= 0).all()
    moved, mean = np.diff(history.jump, axis=0), 0.5 * (history.stress[1:] + history.stress[:-1])
    work = (moved * mean).sum(axis=1)
    spent = sum(np.diff(getattr(history, name)) for name in ("stored", "dissipated", "rubbed"))
    pressed = history.stress[:, 0] < 0
    stick = (np.diff(history.rubbed) == 0) & pressed[1:] & pressed[:-1]  # what parts or slides moves, too
    np.testing.assert_allclose(work[stick], spent[stick], rtol=1e-6, atol=1e-9)
    assert stick.sum() > 30


def test_cohesion_and_mortar_beside_it():
    """Layers in series: closings add; a tie holds in tension with the line of the greatest pressure."""
    glued = Closure(MohrCoulomb(cohesion=0.3e6, friction=0.6, tensile_strength=0.2e6), K, GREATEST)
    pulled = probe(glued, [[0.5 * 0.2e6 / K, 0], [0.99 * 0.2e6 / K, 0], [1.01 * 0.2e6 / K, 0]])
    assert pulled.stress[:, 0] == pytest.approx([0.1e6, 0.198e6, 0], abs=1e-3)
    bedded = probe(Bed(LAW, 2e10, 1e10), np.zeros((1, 2)), pressure=1e6)
    assert -bedded.jump[0, 0] == pytest.approx(closing(1e6) + 1e6 / 2e10, rel=1e-9)


def test_wrong_numbers_are_named():
    with pytest.raises(LawError, match="greatest is 0, expected a number > 0"):
        Closure(Dry(0.6), K, 0.0)
    with pytest.raises(LawError, match="shear_ratio is 0, expected a number > 0"):
        Closure(Dry(0.6), K, GREATEST, shear_ratio=0.0)
