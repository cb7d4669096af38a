"""Limits of all laws: cohesion of no strength is dry, infinitely strong and stiff one is bonded."""

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from masonry_fem.joints import (
    Bed,
    Bilinear,
    ConstantThreshold,
    Dry,
    Elastic,
    ElasticBrittle,
    Exponential,
    FremondCangemi,
    Kinetic,
    MohrCoulomb,
    MonerieAcary,
    Rough,
    Trapezoidal,
    kinds,
    probe,
    pull,
)
from tests.joints.samples import POINTS, path_laplacian, wander

K = 1e12  # of the surroundings [N/m³]
few = settings(max_examples=4, phases=[Phase.explicit, Phase.generate])  # of ten points each


def laws(stiffness, strength, energy):
    """One of every law that has cohesion, alone and put together."""
    springs = {"normal_stiffness": stiffness, "tangential_stiffness": stiffness, "friction": 0.6}
    strengths = {"normal_strength": strength, "tangential_strength": strength}
    whole = springs | strengths | {"normal_energy": energy, "tangential_energy": energy}
    damage = springs | {"energy": energy}
    spread = {"gradient": 1e-4 * energy, "laplacian": path_laplacian(1e-3, POINTS)}
    return [
        ConstantThreshold(strength=strength, friction=0.6),
        MohrCoulomb(cohesion=strength, friction=0.6),
        Elastic(**springs),
        ElasticBrittle(**springs, **strengths),
        FremondCangemi(**damage),
        FremondCangemi(**damage, degree=2),
        FremondCangemi(**damage, viscosity=1e-3),
        FremondCangemi(**damage, **spread),
        MonerieAcary(**whole),
        Bilinear(**whole),
        Trapezoidal(**whole),
        Exponential(**whole),
    ]


BARE = laws(1e-3, 1e-3, 1.0)
BONDED = laws(1e22, 1e12, 1e9)
PUT_ON = {
    "alone": lambda law: law,
    "kinetic": lambda law: Kinetic(law, 0.4),
    "rough": lambda law: Rough(law, 0.2, 5e-5),
    "bed": lambda law: Bed(law, 2e10, 1e10),
    "crushing": lambda law: Bed(Rough(Kinetic(law, 0.4), 0.2, 5e-5), 2e10, 1e10, crushing=1.5e5),
}


def label(law):
    return f"{law.name}-{(BARE if law in BARE else BONDED).index(law)}"


def test_every_law_with_a_page_has_its_limits(repository):
    explained = {name for name in kinds() if (repository / f"docs/laws/{name}.md").is_file()}
    assert {law.name for law in BARE} >= explained >= {"bilinear"}


@pytest.mark.slow
@pytest.mark.parametrize("put_on", PUT_ON)
@pytest.mark.parametrize("law", BARE, ids=label)
@few
@given(seed=st.integers(0, 2**32 - 1), dimension=st.sampled_from([2, 3]), pressed=st.booleans())
def test_soft_joint_is_dry(law, put_on, seed, dimension, pressed):
    path, pressure = wander(seed, dimension), 2e5 if pressed else None
    one, other = (probe(PUT_ON[put_on](each), path, pressure=pressure) for each in (law, Dry(0.6)))
    assert one.settled.all()
    assert one.reaction == pytest.approx(other.reaction, rel=1e-7, abs=1e-2)
    assert one.rubbed == pytest.approx(other.rubbed, rel=1e-7, abs=1e-6)


@pytest.mark.parametrize("law", BONDED, ids=label)
@few
@given(seed=st.integers(0, 2**32 - 1), dimension=st.sampled_from([2, 3]))
def test_stiff_joint_is_bonded(law, seed, dimension):
    """All the displacement is in the surroundings, pulled and sheared, opened and closed."""
    ends = wander(seed, dimension, steps=4)
    ends[:, ::2, 0] *= -1  # half of them pressed
    history = pull(law, ends, stiffness=K)
    assert np.abs(history.jump).max() <= 1.01 * K / 1e22 * np.linalg.norm(ends, axis=-1).max()
    assert history.stress == pytest.approx(K * ends, rel=1e-9, abs=1.0)
    assert (history.adhesion == 1.0).all()
    assert not history.dissipated.any()


@pytest.mark.parametrize("law", BONDED, ids=label)
def test_stiff_joint_on_a_bed_is_the_bed(law):
    """Springs in series: the faces stay together, the layer stretches."""
    ends = wander(5, 3, steps=4)
    history = pull(Bed(law, 2e10, 1e10), ends, stiffness=K)
    series = 1 / (1 / K + 1 / np.array([2e10, 1e10, 1e10]))
    assert history.stress == pytest.approx(series * ends, rel=1e-9, abs=1.0)
