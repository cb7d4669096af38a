"""Limits of the adhesive laws: springs of no stiffness are dry, infinitely stiff ones are bonded."""

import numpy as np
import pytest

from masonry_fem.nscd.laws import Bilinear, Dry, Elastic, FremondCangemi, MonerieAcary, probe, pull
from tests.nscd.laws.samples import wander

K = 1e12  # of the surroundings [N/m³]


def laws(stiffness, strength, energy):
    springs = {"normal_stiffness": stiffness, "tangential_stiffness": stiffness, "friction": 0.6}
    whole = springs | {"normal_strength": strength, "tangential_strength": strength,
                       "normal_energy": energy, "tangential_energy": energy}  # fmt: skip
    return [
        Elastic(**springs),
        FremondCangemi(**springs, energy=energy),
        Bilinear(**whole),
        MonerieAcary(**whole),
    ]


@pytest.mark.parametrize("law", laws(1e-3, 1e-3, 1.0), ids=lambda law: law.name)
@pytest.mark.parametrize("pressure", [None, 2e5])
def test_soft_joint_is_dry(law, pressure):
    path = wander(11, 3)
    one, other = probe(law, path, pressure=pressure), probe(Dry(0.6), path, pressure=pressure)
    assert one.reaction == pytest.approx(other.reaction, rel=1e-9, abs=1e-6)


@pytest.mark.parametrize("law", laws(1e22, 1e12, 1e9), ids=lambda law: law.name)
def test_stiff_joint_is_bonded(law):
    """All the displacement is in the surroundings, pulled and sheared, opened and closed."""
    ends = np.array([[1e-5, 2e-5, 0], [1e-6, -3e-5, 1e-5], [-1e-5, 0, 5e-5]])
    history = pull(law, ends, stiffness=K)
    assert np.abs(history.jump).max() < 1e-14
    assert history.stress == pytest.approx(K * ends, rel=1e-9, abs=1.0)
    assert history.adhesion.tolist() == [1.0, 1.0, 1.0]
