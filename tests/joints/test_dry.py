"""The dry joint at one point, and the fold with nothing to fold."""

import numpy as np
import pytest

from masonry_fem.errors import LawError
from masonry_fem.joints import Dry, JointState, Kinetic, probe


def test_slides_at_the_cone_in_any_direction():
    for angle in np.linspace(0, 2 * np.pi, 7):
        direction = np.array([0.0, np.cos(angle), np.sin(angle)])
        history = probe(Dry(friction=0.7), np.outer([1e-3, 2e-3], direction), pressure=2e5, area=0.5)
        assert history.stress @ direction == pytest.approx([1.4e5, 1.4e5])
        assert history.reaction[:, 0] == pytest.approx([1e5, 1e5])
        assert history.jump[:, 0].tolist() == [0.0, 0.0]


def test_opens_without_reaction():
    history = probe(Dry(), [[1e-3, 0], [1e-3, 1e-3], [0, 1e-3]])
    assert not history.reaction.any()
    assert history.rubbed[-1] == 0.0


def test_dynamic_friction_rules_once_it_slid():
    law = Kinetic(Dry(friction=0.6), dynamic_friction=0.5)
    history = probe(law, [[0, 1e-3], [0, 2e-3], [0, 2e-3], [0, 3e-3]], pressure=1e5)
    assert history.stress[:, 1] == pytest.approx([6e4, 5e4, 5e4, 6e4])


def test_heat_is_the_work():
    history = probe(Dry(friction=0.6), [[0, 1e-3], [0, -2e-3]], pressure=1e5)
    assert history.rubbed == pytest.approx([60.0, 240.0])
    assert history.state.slip[0] == pytest.approx(4e-3)


def test_has_no_adhesion():
    state = Dry().initial(3, 3)
    assert state.adhesion.tolist() == [0.0] * 3
    assert state.broken.all()
    reduction = Dry(friction=np.array([0.1, 0.2, 0.3])).reduce(state, state.jump, np.ones(3), 0.1)
    assert reduction.friction.tolist() == [0.1, 0.2, 0.3]
    rng = np.random.default_rng(0)
    W, free = rng.normal(size=(3, 3, 3)), rng.normal(size=(3, 3))
    folded, velocity = reduction.fold(W, free, 0.1)
    assert folded == pytest.approx(W, abs=1e-15)
    assert velocity == pytest.approx(free, abs=1e-15)


def test_states_are_taken_and_put():
    state = JointState.intact(4, 2)
    part = JointState.dry(2, 2)
    merged = state.put(np.array([1, 3]), part)
    assert merged.broken.tolist() == [False, True, False, True]
    assert not state.broken.any()
    assert merged.take(np.array([3])).broken.tolist() == [True]
    assert merged.distance(state) == 1.0
    assert state.distance(state) == 0.0


def test_impossible_friction():
    with pytest.raises(LawError, match=r"friction is -0\.5, expected a number >= 0"):
        Dry(friction=-0.5)
