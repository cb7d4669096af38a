"""Elastic beds in series with joint laws, at one point."""

import numpy as np
import pytest

from masonry_fem.errors import LawError
from masonry_fem.joints import Bed, Bilinear, Dry, FremondCangemi, MohrCoulomb, probe, pull
from tests.joints.samples import FRACTURE, finer, wander

K = 2e10, 1e10


def bed(law):
    return Bed(law, *K)


def test_pressure_closes_the_joint_elastically():
    history = probe(bed(Dry(0.6)), [[-1e-5, 0, 0], [-5e-6, 0, 0], [0, 0, 0], [1e-5, 0, 0]], area=0.5)
    assert history.stress[:, 0] == pytest.approx([-2e5, -1e5, 0, 0])
    assert history.stored[:, ] == pytest.approx([0.5, 0.125, 0, 0])  # fmt: skip


def test_pressure_given():
    history = probe(bed(Dry(0.6)), [[0, 0], [0, 1e-6]], pressure=3e5)
    assert history.jump[:, 0] == pytest.approx([-1.5e-5] * 2)


def test_shear_is_elastic_then_slides_and_unloads_stiff():
    """Rectangular loop with flanks of slope k_T; its area is the friction's heat."""
    sigma, mu = 1e6, 0.6
    law, turn = bed(Dry(mu)), mu * sigma / K[1]
    slides = np.concatenate(
        [np.linspace(0, 5, 51)[1:], np.linspace(5, -5, 101)[1:], np.linspace(-5, 5, 101)[1:]]
    )
    history = probe(law, np.stack([0 * slides, slides * turn], axis=1), pressure=sigma)
    expected, force, last = [], 0.0, 0.0
    for x in slides:
        force, last = np.clip(force + (x - last), -1, 1), x
        expected.append(force * mu * sigma)
    assert history.stress[:, 1] == pytest.approx(expected, rel=1e-9, abs=1e-3)
    loop = history.rubbed[-1] - history.rubbed[49]
    assert loop == pytest.approx(mu * sigma * 16 * turn, rel=1e-9)


@pytest.mark.parametrize("angle", np.linspace(0, 2 * np.pi, 5))
def test_shear_has_no_preferred_direction(angle):
    way = np.array([0, np.cos(angle), np.sin(angle)])
    history = probe(bed(Dry(0.6)), np.outer([3e-5, 9e-5], way), pressure=1e6)
    assert history.stress @ way == pytest.approx([3e5, 6e5])


def test_bonded_bed_is_elastic_both_ways_up_to_rupture():
    """Stiffness, strength and friction of the usual joint of limit analysis with springs."""
    law = bed(MohrCoulomb(cohesion=0.35e6, friction=0.75, tensile_strength=0.25e6))
    pulled = probe(law, [[x * 0.25e6 / K[0], 0] for x in (-1, 0.5, 0.999, 1.001, 0.5)])
    assert pulled.stress[:, 0] == pytest.approx([-0.25e6, 0.125e6, 0.24975e6, 0, 0], abs=1e-6)
    # the rupture sets the bed's energy free
    assert pulled.dissipated == pytest.approx([0, 0, 0, *[0.5 * 0.25e6**2 / K[0]] * 2], rel=0.01)
    peak = 0.35e6 + 0.75e6
    sheared = probe(law, [[0, x * peak / K[1]] for x in (0.5, 0.999, 1.001, 1.5)], pressure=1e6)
    assert sheared.stress[:, 1] == pytest.approx([0.5 * peak, 0.999 * peak, 0.75e6, 0.75e6], rel=1e-9)
    assert sheared.settled.all()
    # its shear energy, less what it keeps and what friction takes as it slides back to its residual stress
    assert sheared.dissipated[2] == pytest.approx(0.5 * 0.35e6**2 / K[1], rel=0.02)
    assert sheared.rubbed[2] == pytest.approx(0.75e6 * 0.35e6 / K[1], rel=0.02)


@pytest.mark.parametrize("friction", [0.0, 0.6])
def test_what_breaks_in_coarse_steps_loses_all_the_work_put_in(friction):
    """Of a step in which damage grows nothing is missing: what springs and friction did not take it lost."""
    law = bed(Bilinear(**FRACTURE | {"friction": friction}))
    slide = 1.2e-4 * np.arange(1.0, 5.0)
    history = probe(law, np.column_stack([0 * slide, slide]), pressure=2e5)
    work = 0.5 * (history.stress[1:, 1] + history.stress[:-1, 1]) * np.diff(slide)
    taken = np.diff(history.stored + history.dissipated + history.rubbed)
    broke = np.diff(history.adhesion) < 0
    assert broke.sum() > 1
    assert (taken - work)[broke].min() > -1e-9


def test_two_springs_of_a_sound_joint():
    """Bed and adhesion in series: 1/(1/k + 1/c)."""
    law = bed(FremondCangemi(normal_stiffness=4e10, tangential_stiffness=4e10, energy=1e3, friction=0.0))
    history = pull(law, [[1e-6, 2e-6]], stiffness=1e10)
    series = [1 / (1 / k + 1 / 4e10 + 1e-10) for k in K]
    assert history.stress[0] == pytest.approx(np.array(series) * [1e-6, 2e-6], rel=1e-9)


def test_soft_pull_under_pressure():
    history = pull(bed(Dry(0.6)), [[-1e-4, 1e-5], [-1e-4, 1e-3]], stiffness=1e10)
    normal = 1e-4 / (1 / K[0] + 1e-10)
    assert history.stress[:, 0] == pytest.approx(-normal)
    assert history.stress[:, 1] == pytest.approx([1e-5 / (1 / K[1] + 1e-10), 0.6 * normal])


def test_mortar_layer():
    law = Bed.of_mortar(Dry(), thickness=0.01, young=1e9, poisson=0.25)
    assert law.normal_stiffness == pytest.approx(1.2e11)
    assert law.tangential_stiffness == pytest.approx(4e10)
    with pytest.raises(LawError, match="normal_stiffness is -1"):
        Bed(Dry(), -1.0, 1.0)


def test_crushing_caps_the_pressure():
    """Elastic to f_c, then hardening; what was crushed stays."""
    law = Bed(Dry(0.6), *K, crushing=2e6, hardening=1e8)
    closing = np.array([0.5, 1.0, 2.0, 4.0, 3.5, 2.9, 2.0, 4.0, 5.0]) * 2e6 / K[0]
    history = probe(law, np.stack([-closing, 0 * closing], axis=1), area=0.3)
    crushed, expected = 0.0, []
    for u in closing:
        crushed = max(crushed, (K[0] * u - 2e6) / (K[0] + 1e8))
        expected.append(max(K[0] * (u - crushed), 0.0))
    assert history.settled.all()
    assert -history.stress[:, 0] == pytest.approx(expected, rel=1e-9, abs=1e-3)
    assert history.state.crushed[0] == pytest.approx(-crushed)
    elastic = 0.5 * 0.3 * expected[-1] ** 2 / K[0]
    assert history.stored[-1] == pytest.approx(elastic)
    assert history.dissipated[-1] == pytest.approx(0.3 * (2e6 * crushed + 0.5e8 * crushed**2), rel=1e-9)


def test_crushing_under_given_pressure_and_between_springs():
    law = Bed(Dry(0.6), *K, crushing=2e6)
    history = probe(law, [[0, 0], [0, 1e-3], [0, 1e-3]], pressure=[1e6, 2.02e6, 1e6])
    crushed = 0.02e6 / (1e-3 * K[0])
    assert history.jump[:, 0] == pytest.approx([-5e-5, -1.01e-4 - crushed, -5e-5 - crushed])
    assert history.stress[1, 1] == pytest.approx(0.6 * 2.02e6)
    pressed = pull(law, [[-1e-3, 0], [0, 0]], stiffness=1e10)
    assert pressed.settled.all()
    assert -pressed.stress[0, 0] == pytest.approx(1e10 * (1e-3 + pressed.jump[0, 0]))
    assert 2e6 < -pressed.stress[0, 0] < 2.2e6
    assert pressed.stress[1, 0] == 0.0


def test_shear_crushes_below_the_strength_of_pressure_alone():
    law = Bed(Dry(0.6), *K, crushing=2e6, hardening=1e2, shear_weight=9.0)
    history = probe(law, [[-1e-4 * 0.75, 0.0], [-1e-4 * 0.75, 1e-4]])
    assert -history.stress[0, 0] == pytest.approx(1.5e6)
    assert -history.stress[1, 0] == pytest.approx(2e6 / np.sqrt(1 + 9 * 0.36), rel=1e-6)
    assert history.settled.all()


@pytest.mark.parametrize("shift", [0.0, 1e-5, 5e-3], ids=["pure pressure", "stuck", "sliding"])
def test_shear_helps_to_crush(shift):
    """σ² + C τ² = f_c² with next to no hardening, whether τ is the bed's or friction's."""
    weight, strength = 9.0, 2e6
    law = Bed(Dry(0.6), *K, crushing=strength, hardening=1e2, shear_weight=weight)
    path = [[-1e-4 * s, shift * s] for s in np.linspace(0.05, 4.0, 80)]
    history = probe(law, path)
    sigma, tau = -history.stress[-1, 0], history.stress[-1, 1]
    assert history.settled.all()
    assert history.state.crushed[0] < -1e-5
    assert sigma**2 + weight * tau**2 == pytest.approx(strength**2, rel=1e-6)
    if shift == 5e-3:
        assert tau == pytest.approx(0.6 * sigma, rel=1e-9)
        assert sigma == pytest.approx(strength / np.sqrt(1 + weight * 0.36), rel=1e-6)
    assert (np.diff(history.dissipated) >= 0).all()


def test_what_begins_to_crush_does_not_break_its_faces():
    """The turn that finds the crushing is not solved with it: what it closes is no opening."""
    law = Bed(Bilinear(**FRACTURE), 4e10, 2e10, crushing=0.15e6, shear_weight=9.0)
    history = probe(law, finer(wander(0, 3, steps=3), 10), pressure=2e5, step=0.1)
    assert history.settled.all()
    assert (history.state.crushed < -1e-4).any()
    plain = probe(law.law, finer(wander(0, 3, steps=3), 10), pressure=2e5, step=0.1)
    assert (history.adhesion >= plain.adhesion - 1e-9).all(), "the layer takes some of the slide"


def test_shear_alone_does_not_crush():
    """Springs hold shear as the joint just closes: pressure of rounding, τ above the cap."""
    law = Bed(Bilinear(**FRACTURE), 4e10, 2e10, crushing=0.15e6, shear_weight=9.0)
    history = probe(law, wander(1, 3))
    assert history.settled.all()
    assert np.abs(history.state.crushed).max() < 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("lean", [0.2, 0.5, 1.0, 2.0], ids=lambda lean: f"slide/closing {lean:g}")
@pytest.mark.parametrize("strength", [0.15e6, 2e6, 10e6], ids=lambda strength: f"{strength / 1e6:g} MPa")
def test_crushing_beside_shear_settles_in_few_turns(strength, lean):
    """Whether springs, then softening springs, then friction bear the shear.

    Turns that took the ratio of shear to pressure from the last one needed up to 500.
    """
    law = Bed(Bilinear(**FRACTURE), 4e10, 2e10, crushing=strength, shear_weight=9.0)
    closing = 2e-10 * strength * np.linspace(0.0, 1.0, 40)
    history = probe(law, np.column_stack([-closing, lean * closing]))
    assert history.settled.all()
    assert history.turns.max() <= 60
    assert history.state.crushed[0] < 0
