"""Convex polygons clipped, against half-plane counting and a different way to the area."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from masonry_fem.contact.clipping import clip, depths, locate, polygon_area
from tests.contact.blocks import turning_2d

SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
TOLERANCE = 1e-12


@st.composite
def convex_polygons(draw):
    """Corners on an ellipse: any such polygon is convex, and counter-clockwise by its angles."""
    count = draw(st.integers(3, 8))
    gaps = np.array(draw(st.lists(st.floats(0.2, 1.0), min_size=count, max_size=count)))
    angles = 2 * np.pi * np.cumsum(gaps) / gaps.sum()
    axes = draw(st.floats(0.3, 2.0)), draw(st.floats(0.3, 2.0))
    centre = draw(st.floats(-1, 1)), draw(st.floats(-1, 1))
    return np.stack([axes[0] * np.cos(angles), axes[1] * np.sin(angles)], axis=1) + centre


def boundary_area(first, second):
    """Area of the common part by Green's theorem: each polygon's sides cut by the other's half-planes."""
    total = 0.0
    for polygon, other in ((first, second), (second, first)):
        for p, q in zip(polygon, np.roll(polygon, -1, axis=0), strict=True):
            low, high = 0.0, 1.0
            for a, b in zip(other, np.roll(other, -1, axis=0), strict=True):
                normal = np.array([a[1] - b[1], b[0] - a[0]])  # inwards
                start, slope = normal @ (p - a), normal @ (q - p)
                if max(abs(start), abs(start + slope)) < 1e-9:  # a common side counts once
                    high = high if polygon is first else 0.0
                elif slope > 0:
                    low = max(low, -start / slope)
                elif slope < 0:
                    high = min(high, -start / slope)
                elif start < 0:
                    low, high = 1.0, 0.0
            if high > low:
                u, v = p + low * (q - p), p + high * (q - p)
                total += 0.5 * (u[0] * v[1] - u[1] * v[0])
    return total


@given(convex_polygons(), convex_polygons())
def test_area_of_common_part(first, second):
    common = clip(first, second, TOLERANCE)
    assert polygon_area(common) == pytest.approx(boundary_area(first, second), abs=1e-9)
    if len(common):
        assert depths(first, common).min() > -1e-9
        assert depths(second, common).min() > -1e-9


@given(convex_polygons(), convex_polygons())
def test_order_of_the_two_does_not_matter(first, second):
    areas = polygon_area(clip(first, second, TOLERANCE)), polygon_area(clip(second, first, TOLERANCE))
    assert areas[0] == pytest.approx(areas[1], abs=1e-10)


@given(convex_polygons())
def test_a_polygon_clipped_by_itself_is_itself(polygon):
    assert clip(polygon, polygon, TOLERANCE) == pytest.approx(polygon)


@given(st.floats(0, 6.3), st.floats(0.1, 0.9))
def test_shifted_squares_turned(angle, shift):
    turn = turning_2d(angle).T
    common = clip(SQUARE @ turn, (SQUARE + shift) @ turn, TOLERANCE)
    assert len(common) == 4
    assert polygon_area(common) == pytest.approx((1 - shift) ** 2, rel=1e-12)


@pytest.mark.parametrize("shift", [(1.0, 0.0), (1.0, 1.0), (1.0, 0.3), (2.0, 0.0), (0.0, -1.0)])
def test_shared_edges_corners_and_distant_squares_have_nothing_in_common(shift):
    assert len(clip(SQUARE, SQUARE + shift, TOLERANCE)) == 0


def test_collinear_and_double_corners_go():
    loop = np.array([[0, 0], [0.5, 0], [1, 0], [1, 0], [1, 1], [0, 1], [0, 0.2]], dtype=float)
    assert clip(loop, loop, TOLERANCE) == pytest.approx(SQUARE)


def test_locate_takes_the_first_on_a_common_side_and_the_nearest_outside():
    squares = np.array([SQUARE, SQUARE + np.array([1.0, 0.0])])
    points = np.array([[0.5, 0.5], [1.5, 0.5], [1.0, 0.5], [2.2, 0.5], [-0.1, 0.5], [1.0 + 1e-12, 0.5]])
    assert locate(squares, points, 1e-9).tolist() == [0, 1, 0, 1, 0, 0]
