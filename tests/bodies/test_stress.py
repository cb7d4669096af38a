"""Invariants of stress: closed forms and independence of the frame."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

from masonry_fem.output.strength import principal, tensor, von_mises

stresses = arrays(float, (4, 6), elements=st.floats(-1e6, 1e6, width=32))


def components(matrices):
    return matrices[..., [0, 1, 2, 0, 1, 0], [0, 1, 2, 1, 2, 2]]


def test_closed_forms():
    uniaxial, shear, pressure = np.eye(6)[0] * 3.0, np.eye(6)[4] * 2.0, np.array([1.0, 1, 1, 0, 0, 0])
    np.testing.assert_allclose(
        von_mises(np.array([uniaxial, shear, pressure])), [3.0, 2.0 * np.sqrt(3), 0.0], atol=1e-15
    )
    values, directions = principal(shear)
    np.testing.assert_allclose(values, [2.0, 0.0, -2.0], atol=1e-15)
    np.testing.assert_allclose(np.abs(directions[0]), [0, np.sqrt(0.5), np.sqrt(0.5)], atol=1e-12)


@given(stresses)
def test_principal_values_and_directions_rebuild_the_tensor(stress):
    values, directions = principal(stress)
    assert (np.diff(values, axis=-1) <= 0).all()
    rebuilt = np.einsum("...i,...ia,...ib->...ab", values, directions, directions)
    np.testing.assert_allclose(rebuilt, tensor(stress), atol=1e-9 * (1 + np.abs(stress).max()))
    a, b, c = values.T
    mises = np.sqrt(0.5 * ((a - b) ** 2 + (b - c) ** 2 + (c - a) ** 2))
    np.testing.assert_allclose(von_mises(stress), mises, atol=1e-8 * (1 + np.abs(stress).max()))


@given(stresses, st.integers(0, 100))
def test_invariants_do_not_depend_on_the_frame(stress, seed):
    turn = Rotation.random(rng=seed).as_matrix()
    turned = components(turn @ tensor(stress) @ turn.T)
    scale = 1 + np.abs(stress).max()
    np.testing.assert_allclose(von_mises(turned), von_mises(stress), atol=1e-8 * scale)
    np.testing.assert_allclose(principal(turned)[0], principal(stress)[0], atol=1e-9 * scale)
