"""Static and dynamic friction beside cohesion, at one point."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from masonry_fem.errors import LawError
from masonry_fem.joints import Bed, Bilinear, Dry, FremondCangemi, Kinetic, MohrCoulomb, Rough, probe
from tests.joints.samples import FRACTURE, SAMPLES, STIFFNESS, label, wander

seeds = st.integers(0, 2**32 - 1)
FRICTIONAL = [law for law in SAMPLES if law.name not in {"dry", "bed", "rough"}]


def slid(law, steps, pressure=1e5):
    return probe(law, np.stack([np.zeros(len(steps)), steps], axis=1), pressure=pressure)


@pytest.mark.parametrize("law", FRICTIONAL, ids=label)
@settings(max_examples=3)
@given(seed=seeds)
def test_the_same_friction_changes_nothing(law, seed):
    path = wander(seed, 3)
    one, other = (probe(each, path, pressure=2e5) for each in (Kinetic(law, law.friction), law))
    assert one.reaction == pytest.approx(other.reaction, rel=1e-12, abs=1e-9)
    np.testing.assert_array_equal(one.adhesion, other.adhesion)
    assert one.rubbed == pytest.approx(other.rubbed, rel=1e-12, abs=1e-12)


@pytest.mark.parametrize("law", FRICTIONAL, ids=label)
@settings(max_examples=3)
@given(seed=seeds, dimension=st.sampled_from([2, 3]))
def test_losses_never_shrink(law, seed, dimension):
    history = probe(Kinetic(law, 0.3), wander(seed, dimension), pressure=2e5)
    assert history.settled.all()
    for lost in (history.dissipated, history.rubbed):
        assert (np.diff(lost, axis=0, prepend=0.0) >= 0).all()
    assert (np.diff(history.adhesion, axis=0) <= 0).all()


def test_peak_static_then_dynamic():
    """c + μσ, then μ_d σ; at rest it sticks up to μσ again."""
    law = Kinetic(MohrCoulomb(cohesion=0.2e6, friction=0.7), dynamic_friction=0.5)
    history = slid(law, [1e-3, 2e-3, 2e-3, 3e-3, 4e-3])
    assert history.stress[:, 1] == pytest.approx([0.7e5, 0.5e5, 0.5e5, 0.7e5, 0.5e5])
    assert history.rubbed[-1] == pytest.approx(1e-3 * (0.7 + 0.5 + 0.7 + 0.5) * 1e5)


def test_the_cone_of_a_sound_joint_keeps_its_slope():
    """While it yields on its critical slip c + μσ holds, not μ_d."""
    law = Kinetic(MohrCoulomb(cohesion=0.2e6, friction=0.7, critical_slip=2.5e-3), dynamic_friction=0.35)
    history = slid(law, [1e-3, 2e-3, 3e-3, 4e-3])
    assert history.stress[:, 1] == pytest.approx([0.27e6, 0.27e6, 0.035e6, 0.035e6])


def test_residual_friction_is_the_static_one_of_a_broken_joint():
    law = Kinetic(MohrCoulomb(cohesion=0.2e6, friction=0.7, residual_friction=0.6), dynamic_friction=0.3)
    assert slid(law, [1e-3, 2e-3, 2e-3, 3e-3]).stress[:, 1] == pytest.approx([0.6e5, 0.3e5, 0.3e5, 0.6e5])


def test_springs_add_to_the_dynamic_friction():
    law = Bilinear(**FRACTURE, friction=0.6)
    slides = np.linspace(0, 1e-4, 21)[1:]
    one, other = slid(Kinetic(law, 0.4), slides), slid(law, slides)
    assert one.adhesion == pytest.approx(other.adhesion)
    assert (other.stress - one.stress)[1:, 1] == pytest.approx([0.2e5] * 19)


def test_friction_that_comes_with_damage_falls_in_proportion():
    law = FremondCangemi(**STIFFNESS, energy=20.0, friction=0.6, friction_mode="damage")
    slides = np.linspace(0, 2e-4, 21)[1:]
    one, other = slid(Kinetic(law, 0.3), slides), slid(law, slides)
    lost, slides = 0.3 * (1 - one.adhesion) * 1e5, one.adhesion < 1.0
    slides[slides.argmax()] = False  # in the step it begins in it has the static one
    assert (other.stress - one.stress)[:, 1] == pytest.approx(np.where(slides, lost, 0.0), rel=1e-9)


def test_within_roughness_and_bed():
    rough = Rough(Kinetic(Dry(0.6), 0.4), dilatancy=0.2, bound=1e-3)
    law = Bed(rough, 1e12, 1e12)
    history = slid(law, [1e-3, 2e-3, 3e-3])
    assert history.stress[:, 1] == pytest.approx([0.6e5, 0.4e5, 0.4e5], rel=1e-9)
    assert history.settled.all()


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Kinetic(Dry(0.0), 0.5), r"dynamic_friction is 0\.5 beside a friction of 0"),
        (lambda: Kinetic(Dry(0.5), -0.1), r"dynamic_friction is -0\.1"),
        (
            lambda: Rough(Kinetic(Dry(0.6), 0.1), 0.2, 1e-3),
            r"dilatancy is 0\.2, expected at most the friction 0\.1",
        ),
        (lambda: Kinetic(Bed(Dry(0.5), 1e9, 1e9), 0.3), r"law 'bed' has no friction"),
    ],
)
def test_what_it_refuses(make, words):
    with pytest.raises(LawError, match=words):
        make()
