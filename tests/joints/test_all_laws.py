"""What every law in the list owes, whatever its parameters and the path."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from masonry_fem.joints import Dry, JointState, kinds, probe, pull
from masonry_fem.joints.law import layers_of
from masonry_fem.records.docstring import meanings
from tests.joints.samples import ALL, POINTS, finer, label, wander

seeds = st.integers(0, 2**32 - 1)
every_law = pytest.mark.parametrize("law", ALL, ids=label)
few = settings(max_examples=3, phases=[Phase.explicit, Phase.generate])  # of ten points each
fewer = settings(few, max_examples=2)


def dried(law, friction):
    """The same bed, roughness and dynamic friction, on a dry joint."""
    return replace(law, law=dried(law.law, friction)) if hasattr(law, "law") else Dry(friction=friction)


@pytest.mark.parametrize("name", kinds())
def test_its_keys_are_explained(name):
    kind = kinds()[name]
    assert set(meanings(kind.record)) == set(kind.record.__struct_fields__), kind.file


@every_law
@few
@given(seed=seeds, dimension=st.sampled_from([2, 3]), pressed=st.booleans())
def test_losses_never_shrink_and_adhesion_never_heals(law, seed, dimension, pressed):
    history = probe(law, wander(seed, dimension), pressure=2e5 if pressed else None)
    for lost in (history.dissipated, history.rubbed):
        # heat on a rough joint is a difference of two works, and has their rounding
        rounding = 1e-12 * lost.max() if "rough" in {layer.name for layer in layers_of(law)} else 0.0
        assert (np.diff(lost, axis=0, prepend=0.0) >= -rounding).all()
    assert (np.diff(history.adhesion, axis=0) <= 0).all()
    assert ((history.adhesion >= 0) & (history.adhesion <= 1)).all()
    assert (history.stored >= 0).all()
    assert (history.demand >= 0).all()
    assert history.settled.all()


@pytest.mark.slow
@every_law
@fewer
@given(seed=seeds, dimension=st.sampled_from([2, 3]), pressed=st.booleans())
def test_energy_is_not_created(law, seed, dimension, pressed):
    """Work put in = stored + lost, but for what the trapezoids miss where the force jumps."""
    path = wander(seed, dimension, steps=3)
    push = 2e5 if pressed else None
    for parts in (10, 40):
        history = probe(law, finer(path, parts), pressure=push, step=1 / parts)
        spent = history.stored + history.dissipated + history.rubbed
        jump = np.concatenate([np.zeros_like(path[:1]), history.jump])
        longest = np.linalg.norm(np.diff(jump, axis=0), axis=-1).max(axis=0)
        force = np.linalg.norm(history.reaction, axis=-1).max(axis=0)
        assert (np.abs(history.work() - spent) <= 3 * force * longest + 1e-12).all()


@pytest.mark.slow
@every_law
@few
@given(seed=seeds, angle=st.floats(0, 2 * np.pi), pressed=st.booleans())
def test_objective_in_the_tangent_plane(law, seed, angle, pressed):
    turn = np.eye(3)
    turn[1:, 1:] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    path, push = wander(seed, 3), 2e5 if pressed else None
    one, other = probe(law, path, pressure=push), probe(law, path @ turn.T, pressure=push)
    assert other.reaction == pytest.approx(one.reaction @ turn.T, rel=1e-9, abs=1e-3)
    assert other.adhesion == pytest.approx(one.adhesion, rel=1e-9, abs=1e-12)


@pytest.mark.slow
@every_law
@few
@given(seed=seeds)
def test_plane_is_space_with_one_direction(law, seed):
    path = wander(seed, 2)
    space = np.zeros((*path.shape[:2], 3))
    space[..., :2] = path
    one, other = probe(law, path), probe(law, space)
    assert other.reaction[..., :2] == pytest.approx(one.reaction, rel=1e-12, abs=1e-9)
    assert not other.reaction[..., 2].any()


def breaks(law):
    """Whether the law says of joints that they are broken, or holds those less that are."""
    path = np.zeros((2, 10, 3))
    path[1, :, :2] = 1.0
    fresh = law.initial(10, 3)
    broken = replace(fresh, broken=np.ones(10, dtype=bool), adhesion=np.zeros(10))
    held, left = (law.reduce(state, path[1] * 1e-6, np.ones(10), 1.0) for state in (fresh, broken))
    return probe(law, path).state.broken.any() or (held.offset != left.offset).any()


@pytest.mark.parametrize("law", [law for law in ALL if breaks(law)], ids=label)
@few
@given(seed=seeds, pressed=st.booleans())
def test_no_tension_after_rupture(law, seed, pressed):
    broken = replace(law.initial(10, 3), broken=np.ones(10, dtype=bool), adhesion=np.zeros(10))
    path, push = wander(seed, 3), 2e5 if pressed else None
    history = probe(law, path, pressure=push, state=broken)
    assert (history.reaction[..., 0] >= 0).all()
    friction = law.reduce(broken, np.zeros((10, 3)), np.ones(10), 1.0).friction[0]
    dry = probe(dried(law, friction), path, pressure=push)
    assert history.reaction == pytest.approx(dry.reaction, rel=1e-12, abs=1e-9)


@every_law
@few
@given(seed=seeds, dimension=st.sampled_from([2, 3]), at=st.integers(1, 11), pressed=st.booleans())
def test_goes_on_bit_for_bit(law, seed, dimension, at, pressed, tmp_path_factory):
    """A path interrupted, its state written to a file and read again."""
    path, push = wander(seed, dimension), 2e5 if pressed else None
    whole = probe(law, path, pressure=push)
    first = probe(law, path[:at], pressure=push)
    file = tmp_path_factory.mktemp("state") / "state.npz"
    np.savez(file, **first.state.arrays())
    with np.load(file) as stored:
        state = JointState(**stored)
    rest = probe(law, path[at:], pressure=push, state=state, start=first.jump[-1])
    assert (rest.reaction == whole.reaction[at:]).all()
    for name, values in rest.state.arrays().items():
        assert (values == getattr(whole.state, name)).all(), name


@every_law
def test_committed_state_is_left_alone(law):
    state = law.initial(POINTS, 2)
    kept = {name: values.copy() for name, values in state.arrays().items()}
    half = POINTS // 2
    jump, area = np.zeros((POINTS, 2)), np.ones(POINTS)
    velocity = np.repeat([[1e-3, 0], [0, 1e-3]], half, axis=0)
    reaction = np.repeat([[1e5, -1e6], [-1e7, 0]], half, axis=0)
    law.reduce(state, jump, area, 0.1)
    law.update(state, state, jump, reaction, velocity, area, 0.1)
    for name, values in kept.items():
        assert (getattr(state, name) == values).all(), name


@pytest.mark.slow
@every_law
@fewer
@given(seed=seeds)
def test_finer_steps_converge(law, seed):
    """Rate-independent or not: the end of a path in the limit of small steps."""
    path = wander(seed, 3, steps=3)
    runs = [probe(law, finer(path, parts), pressure=2e5, step=1 / parts) for parts in (10, 20, 60)]
    coarse, fine, finest = (run.adhesion[-1] for run in runs)
    errors = [np.abs(run - finest).mean() for run in (coarse, fine)]
    assert errors[1] <= max(0.75 * errors[0], 1e-3)


@every_law
def test_law_scales_with_area(law):
    path = wander(3, 3)
    one, other = probe(law, path, pressure=2e5), probe(law, path, pressure=2e5, area=0.05)
    assert other.stress == pytest.approx(one.stress, rel=1e-9, abs=1e-3)
    for name in ("stored", "dissipated", "rubbed"):
        assert getattr(other, name) == pytest.approx(0.05 * getattr(one, name), rel=1e-9, abs=1e-12)


@every_law
def test_sticks_under_pressure(law):
    """Far from its strength a joint holds, and gives back what it stored."""
    ends = np.array([[-1e6 / 1e12, 0.01e6 / 1e12], [-1e6 / 1e12, 0.0]])
    history = pull(law, np.repeat(ends[:, None], POINTS, axis=1), stiffness=1e12)
    assert history.settled.all()
    if law.name != "bed":
        assert history.stress[..., 0] == pytest.approx(-1e6)
    assert not history.dissipated.any()
    assert (history.rubbed <= 1e-18).all()
