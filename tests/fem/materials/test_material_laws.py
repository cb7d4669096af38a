"""What every material law owes, with the parameters of its own example and some more."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from masonry_fem.bodies.rotation import exponential
from masonry_fem.fem.material_conformance import violations
from tests.fem.materials.every_law import LAWS
from tests.fem.materials.strain_paths import SIZE, STONE, turned

POINTS = 300


@pytest.fixture(params=LAWS, name="law")
def _law(request):
    return LAWS[request.param]


def walked(law, seed=0, scale=1e-3):
    """A committed state after a random step, and the strain of another: start, strain, committed."""
    random = np.random.default_rng(seed)
    zero = np.zeros((POINTS, 6))
    start = scale * random.normal(size=(POINTS, 6))
    committed = law.update(STONE, zero, start, law.initial(POINTS), SIZE).internal
    return start, start + scale * random.normal(size=(POINTS, 6)), committed


def test_it_conforms(law):
    assert violations(law) == []


def test_tangent_is_the_derivative_of_the_stress(law):
    start, strain, committed = walked(law)
    made, h = law.update(STONE, start, strain, committed, SIZE), 1e-8
    assert made.changed.sum() > POINTS / 10
    columns = [
        (
            law.update(STONE, start, strain + h * unit, committed, SIZE).stress
            - law.update(STONE, start, strain - h * unit, committed, SIZE).stress
        )
        / (2 * h)
        for unit in np.eye(6)
    ]
    wrong = np.abs(np.stack(columns, axis=2) - made.tangent).max(axis=(1, 2))
    assert wrong.max() <= 1e-6 * STONE.matrix.max()


def test_unchanged_points_have_the_elastic_tangent(law):
    start, strain, committed = walked(law, scale=1e-4)
    made = law.update(STONE, start, strain, committed, SIZE)
    same = ~made.changed
    assert same.any()
    np.testing.assert_array_equal(made.tangent[same], np.broadcast_to(STONE.matrix, (same.sum(), 6, 6)))


def test_small_strains_are_elastic(law):
    strain = 1e-7 * np.random.default_rng(2).normal(size=(POINTS, 6))
    made = law.update(STONE, np.zeros_like(strain), strain, law.initial(POINTS), SIZE)
    np.testing.assert_allclose(made.stress, strain @ STONE.matrix, rtol=1e-12)
    np.testing.assert_allclose(made.stored, 0.5 * (made.stress * strain).sum(axis=1), rtol=1e-12)
    assert not made.changed.any()
    assert not made.dissipation.any()


def test_committed_variables_are_left_as_they_are(law):
    start, strain, committed = walked(law)
    kept = committed.copy()
    law.update(STONE, start, strain, committed, SIZE)
    np.testing.assert_array_equal(committed, kept)


def test_a_step_that_goes_nowhere_changes_nothing(law):
    start, strain, committed = walked(law)
    made = law.update(STONE, start, strain, committed, SIZE)
    again = law.update(STONE, strain, strain, made.internal, SIZE)
    scale = np.abs(made.stress).max()
    np.testing.assert_allclose(again.stress, made.stress, atol=1e-11 * scale)
    np.testing.assert_allclose(again.internal, made.internal, atol=1e-11)
    assert again.dissipation.max() <= 1e-11 * made.dissipation.max()


def test_turned_strains_have_turned_stresses(law):
    random = np.random.default_rng(5)
    first, second = 2e-3 * random.normal(size=(2, POINTS, 6))
    turn = exponential(np.array([0.7, -1.1, 0.4]))
    zero = np.zeros_like(first)
    plain = law.update(
        STONE, first, second, law.update(STONE, zero, first, law.initial(POINTS), SIZE).internal, SIZE
    )
    one, two = turned(first, turn, shears=2), turned(second, turn, shears=2)
    other = law.update(
        STONE, one, two, law.update(STONE, zero, one, law.initial(POINTS), SIZE).internal, SIZE
    )
    expected = turned(plain.stress, turn, shears=1)
    np.testing.assert_allclose(other.stress, expected, atol=1e-10 * np.abs(expected).max())
    np.testing.assert_allclose(other.dissipation, plain.dissipation, atol=1e-10 * plain.dissipation.max())
    for name, values in law.measures(plain.internal).items():
        np.testing.assert_allclose(law.measures(other.internal)[name], values, atol=1e-10)


strains = st.lists(
    st.lists(st.floats(-1.0, 1.0, allow_subnormal=False), min_size=6, max_size=6), min_size=1, max_size=6
)


@settings(max_examples=60)
@given(path=strains, scale=st.sampled_from([1e-5, 1e-3, 1e-1]), name=st.sampled_from(sorted(LAWS)))
def test_no_step_gives_energy_and_none_is_lost_without_a_name(path, scale, name):
    law = LAWS[name]
    start, committed, stored = np.zeros((1, 6)), law.initial(1), 0.0
    for step in path:
        strain = scale * np.array([step])
        made = law.update(STONE, start, strain, committed, SIZE)
        # rounding is that of trial stresses, from which all comes
        trial = STONE.matrix.max() * max(np.abs(strain).max(), np.abs(start).max()) ** 2
        assert made.dissipation[0] >= -1e-14 * trial
        work = float(made.stress[0] @ (strain - start)[0])
        named = made.stored[0] - stored + made.dissipation[0] + made.excess[0]
        assert abs(work - named) <= 1e-12 * trial
        start, committed, stored = strain, made.internal, made.stored[0]


@pytest.mark.slow
def test_the_excess_of_a_path_falls_with_its_steps(law):
    """What the ends' stresses work too much is of second order in a step: of first order over a path."""
    path = 1.5e-3 * np.array([[1.0, -0.2, 0.1, 0.3, 0.0, 0.2], [-2.0, 0.5, -1.0, 0.1, 0.6, 0.0], [0.0] * 6])
    excess = []
    for steps in (200, 400, 800):
        total, start, committed = 0.0, np.zeros((1, 6)), law.initial(1)
        for corner in path:
            first = start[0]
            for share in np.arange(1, steps + 1) / steps:
                strain = (first + share * (corner - first))[None]
                made = law.update(STONE, start, strain, committed, SIZE)
                total += float(made.excess[0])
                start, committed = strain, made.internal
        excess.append(total)
    assert excess[0] > 0
    np.testing.assert_allclose(np.divide(excess[:-1], excess[1:]), 2.0, rtol=0.1)
