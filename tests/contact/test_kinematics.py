"""Local frames and how they follow the antagonist."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from masonry_fem.contact.contacts import height, local_frames

component = st.floats(-1, 1)


@given(component, component, component)
def test_frames_are_right_handed(x, y, z):
    normal = np.array([x, y, z])
    assume(np.linalg.norm(normal) >= 1e-3)
    (frame,) = local_frames((normal / np.linalg.norm(normal))[None])
    assert frame @ frame.T == pytest.approx(np.eye(3), abs=1e-12)
    assert np.linalg.det(frame) == pytest.approx(1)


def test_frames_of_level_and_upright_joints_and_their_rounding():
    level, rounded = local_frames(np.array([[0.0, 0.0, 1.0], [1e-16, 0.0, 1.0]]))
    expected = np.eye(3)[[2, 0, 1]]
    assert level == pytest.approx(expected)
    assert rounded == pytest.approx(expected)
    (plane,) = local_frames(np.array([[0.0, 1.0]]))
    assert plane == pytest.approx(np.array([[0.0, 1.0], [-1.0, 0.0]]))


def test_height_of_an_inclined_plane():
    ahead = height(
        np.array([[2.0, 0.0]]), np.array([[0.0, 1.0]]), np.array([[0.0, 1.0]]), np.array([[-0.6, 0.8]])
    )
    assert ahead == pytest.approx(2.5)  # y = 1 + 0.75 x at x = 2
