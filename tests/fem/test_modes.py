"""Rigid motions that a clamped block keeps."""

import numpy as np
import pytest
from scipy import sparse

from masonry_fem.fem.modes import rigid_modes


@pytest.mark.parametrize(("line", "kept"), [(1, 3), (2, 1), (3, 0)])
def test_motions_that_held_points_allow(line: int, kept: int) -> None:
    """Of a cube's corners one is held: it turns about it; two: about their line; three: not at all."""
    corners = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
    mass = sparse.eye_array(24, format="csr")
    free = np.setdiff1d(np.arange(24), np.arange(3 * line))
    modes = rigid_modes(corners, mass, free)
    assert modes.count == kept
    held = modes.modes[: 3 * line, : modes.count]
    assert np.abs(held).max(initial=0.0) < 1e-14


def test_a_clamped_face_of_many_nodes_takes_no_square_of_them() -> None:
    """20 000 held nodes: a matrix of 60 000² numbers would be 29 GB."""
    rng = np.random.default_rng(1)
    points = np.concatenate(
        [np.array([1, 1, 0]) * rng.random((20_000, 3)), np.array([0, 0, 1]) + rng.random((10, 3))]
    )
    modes = rigid_modes(points, sparse.eye_array(points.size, format="csr"), np.arange(60_000, points.size))
    assert modes.count == 0
