"""Elastic and elastic–brittle joints at one point."""

import numpy as np
import pytest

from masonry_fem.joints import Elastic, ElasticBrittle, probe, pull

C = 1e10


def brittle(**changes):
    values = {"normal_stiffness": C, "tangential_stiffness": C, "normal_strength": 0.25e6,
              "tangential_strength": 0.35e6}  # fmt: skip
    return ElasticBrittle(**(values | changes))


def test_elastic_is_linear_and_gives_all_back():
    law = Elastic(normal_stiffness=C, tangential_stiffness=0.4 * C, friction=0.0)
    path = np.array([[1e-5, 0, 0], [2e-5, 3e-5, -1e-5], [0, 0, 0]])
    history = probe(law, path, area=0.3)
    assert history.stress == pytest.approx(path * [C, 0.4 * C, 0.4 * C])
    assert history.stored[1] == pytest.approx(0.5 * 0.3 * C * (4e-10 + 0.4 * 10e-10))
    assert history.stored[-1] == 0.0
    assert history.dissipated[-1] == 0.0


def test_elastic_in_series_with_a_spring():
    """Two springs in series, c and k: c U/(1 + c/k)."""
    law = Elastic(normal_stiffness=C, tangential_stiffness=C)
    history = pull(law, [[1e-5, 2e-5]], stiffness=3 * C)
    assert history.stress[0] == pytest.approx(0.75 * C * np.array([1e-5, 2e-5]), rel=1e-12)


def test_brittle_tension():
    """A7.6: u_c = r_c/c = 2.5e-5 m, energy r_c²/2c = 3.125 J/m², then exactly 0."""
    history = probe(brittle(), [[2.4999e-5, 0], [2.5001e-5, 0], [1e-5, 0], [1e-3, 0]])
    assert history.stress[:, 0] == pytest.approx([0.24999e6, 0, 0, 0], abs=1e-9)
    assert history.stress[1:, 0].tolist() == [0, 0, 0]
    assert history.dissipated[1:] == pytest.approx([3.125] * 3, rel=1e-12)
    assert history.state.broken[0]


def test_brittle_energy_does_not_hang_on_the_step():
    for step in (1e-4, 3e-5, 2.6e-5):
        assert probe(brittle(), [[step, 0]]).dissipated[0] == pytest.approx(3.125, rel=1e-12)


def test_brittle_mixed_mode_is_an_ellipse():
    for angle in np.linspace(0, np.pi / 2, 9):
        opening = np.array([0.25e6 * np.cos(angle), 0.35e6 * np.sin(angle)]) / C
        history = probe(brittle(friction=0.0), [0.9999 * opening, 1.0001 * opening])
        assert history.demand[0] == pytest.approx(0.9999)
        assert history.adhesion.tolist() == [1.0, 0.0]


def test_brittle_shear_leaves_friction():
    history = probe(brittle(friction=0.6), [[0, 3.4e-5], [0, 3.6e-5], [0, 1e-5]], pressure=1e5)
    assert history.stress[:, 1] == pytest.approx([0.34e6 + 6e4, 6e4, -6e4])


def test_properties_may_scatter():
    """Each contact point has its own strength."""
    law = brittle(normal_strength=np.array([1e5, 2e5, 3e5]))
    state = law.initial(3, 2)
    jump, area = np.zeros((3, 2)), np.ones(3)
    velocity = np.array([[2.5e-5, 0.0]] * 3)
    trial = law.update(state, state, jump, np.zeros((3, 2)), velocity, area, 1.0)
    assert trial.adhesion.tolist() == [0.0, 0.0, 1.0]
