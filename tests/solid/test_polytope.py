"""Mass properties and normals of flat-faced solids against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from masonry_fem.errors import GeometryError
from masonry_fem.solid.polytope import Polytope
from masonry_fem.solid.pose import Pose

lengths = st.floats(0.1, 10.0)


@given(lengths, lengths, lengths)
def test_box(a: float, b: float, c: float) -> None:
    made = Polytope.box((1.0, 2.0, 3.0), (1 + a, 2 + b, 3 + c)).mass_properties()
    volume = a * b * c
    assert made.volume == pytest.approx(volume)
    assert made.centroid == pytest.approx([1 + a / 2, 2 + b / 2, 3 + c / 2])
    expected = volume / 12 * np.diag([b * b + c * c, a * a + c * c, a * a + b * b])
    assert made.inertia == pytest.approx(expected, abs=1e-9 * volume)


@given(lengths, lengths)
def test_rectangle(a: float, b: float) -> None:
    made = Polytope.box((0.0, 0.0), (a, b)).mass_properties()
    assert made.volume == pytest.approx(a * b)
    assert made.inertia[0, 0] == pytest.approx(a * b * (a * a + b * b) / 12)


@pytest.mark.parametrize("high", [(1.0, 1.0), (1.0,) * 4])
def test_corners_of_a_box_have_as_many_coordinates(high) -> None:
    with pytest.raises(GeometryError, match=r"a box from \[0.0, 0.0, 0.0\] to .*expected corners"):
        Polytope.box((0.0,) * 3, high)


def test_tetrahedron() -> None:
    """∫x² over the unit simplex is 1/60, the centroid ¼ of each edge."""
    solid = Polytope(
        np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]),
        ((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)),
    )
    made = solid.mass_properties()
    assert made.volume == pytest.approx(1 / 6)
    assert made.centroid == pytest.approx([0.25] * 3)
    about_centroid = 2 * (1 / 60 - 1 / 6 / 16)
    assert np.diag(made.inertia) == pytest.approx([about_centroid] * 3)


@pytest.mark.parametrize("dimension", [2, 3])
def test_normals_point_outwards_and_areas_close(dimension: int) -> None:
    solid = Polytope.box((0.0,) * dimension, (1.0,) * dimension)
    centre = np.full(dimension, 0.5)
    for face in range(len(solid.faces)):
        assert solid.normal(face) @ (solid.face_points(face).mean(axis=0) - centre) > 0
    total = sum(solid.area_vector(face) for face in range(len(solid.faces)))
    assert total == pytest.approx(np.zeros(dimension), abs=1e-15)


def test_a_motion_turns_the_inertia() -> None:
    solid = Polytope.box((0.0, 0.0, 0.0), (1.0, 2.0, 3.0))
    turn = Rotation.from_rotvec([0.3, -0.2, 0.7]).as_matrix()
    moved = solid.moved(Pose(turn, np.array([4.0, 5.0, 6.0]))).mass_properties()
    still = solid.mass_properties()
    assert moved.volume == pytest.approx(still.volume)
    assert moved.inertia == pytest.approx(turn @ still.inertia @ turn.T)


def test_pose_goes_there_and_back() -> None:
    pose = Pose(Rotation.from_rotvec([0.1, 0.2, 0.3]).as_matrix(), np.array([1.0, 2.0, 3.0]))
    points = np.arange(12.0).reshape(4, 3)
    assert pose.to_shape(pose.to_world(points)) == pytest.approx(points)
