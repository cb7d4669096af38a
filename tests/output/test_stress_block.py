"""Stress blocks against pencil answers: A2.9, corner triangles, and equilibrium for any convex face."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from masonry_fem.output.joint_faces import Facets, JointFaces
from masonry_fem.output.polygon_moments import polygon_moments
from masonry_fem.output.stress_block import (
    _linear,
    kern_share,
    linear_block,
    outline_distance,
    plastic_block,
)

SQUARE = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])


def faces_of(*corners: np.ndarray) -> JointFaces:
    """Faces by their corners about the centroid, all with as many; lengths are (2, 1)."""
    flat = np.array(corners, float)
    count, k, a = flat.shape
    if a == 1:
        area = np.ptp(flat[:, :, 0], axis=1)
        second = (area**3 / 12)[:, None, None]
    else:
        area, first, second = polygon_moments(flat)
        np.testing.assert_allclose(first, 0, atol=1e-12)
    number = np.arange(count)
    facets = Facets(np.zeros((count, k, a + 1)), np.full(count, k), number)
    return JointFaces(
        facets, number, np.ones(count, dtype=bool), facets.corners, np.zeros((count, a + 1)),
        np.zeros((count, a, a + 1)), np.zeros((count, a + 1)), flat,
        np.stack([flat.min(axis=1), flat.max(axis=1)], axis=2), area, second, (),
    )  # fmt: skip


def centred(corners: np.ndarray) -> np.ndarray:
    area, first, _ = polygon_moments(corners[None])
    return corners - first[0] / area[0]


def test_a2_9_length_without_tension():
    face = faces_of(*[np.array([[-0.5], [0.5]])] * 4)
    e = np.array([[0.25], [-0.25], [1 / 6], [0.1]])
    linear, plastic = linear_block(face, e), plastic_block(face, e)
    np.testing.assert_allclose(linear.pressure, [8 / 3, 8 / 3, 2, 1.6])
    np.testing.assert_allclose(linear.area, [0.75, 0.75, 1, 1])
    np.testing.assert_allclose(plastic.pressure, [2, 2, 1.5, 1.25])
    np.testing.assert_allclose(plastic.area, [0.5, 0.5, 2 / 3, 0.8])
    np.testing.assert_allclose(kern_share(face, e), [1.5, 1.5, 1, 0.6])


def test_on_the_edge_pressure_has_no_bound_and_outside_there_is_none():
    for face, e in (
        (faces_of(*[np.array([[-0.5], [0.5]])] * 2), np.array([[0.5], [0.51]])),
        (faces_of(SQUARE, SQUARE), np.array([[0.5, 0.1], [0.1, -0.51]])),
    ):
        for block in (linear_block(face, e), plastic_block(face, e)):
            assert block.pressure[0] == np.inf
            assert block.area[0] == 0
            assert np.isnan(block.pressure[1])
            assert np.isnan(block.area[1])


@pytest.mark.parametrize(("width", "depth"), [(1.0, 1.0), (2.0, 0.3)])
def test_a_rectangle_with_one_eccentricity_is_a_length(width: float, depth: float):
    face = faces_of(SQUARE * [width, depth], SQUARE * [width, depth])
    e = np.array([[0.3 * width, 0.0], [0.0, -0.3 * depth]])
    linear, plastic = linear_block(face, e), plastic_block(face, e)
    area = width * depth
    np.testing.assert_allclose(linear.pressure * area, 2 / (3 * 0.2), rtol=1e-8)
    np.testing.assert_allclose(linear.area / area, 0.6, rtol=1e-8)
    np.testing.assert_allclose(plastic.area / area, 0.4, rtol=1e-8)


def test_a_force_near_a_corner_presses_a_triangle():
    """Legs of four (linear) and three (uniform) times the distances to the two sides."""
    a, b = 0.1, 0.2
    face = faces_of(SQUARE * [1.0, 2.0])
    e = np.array([[0.5 - a, 1.0 - b]])
    linear, plastic = linear_block(face, e), plastic_block(face, e)
    np.testing.assert_allclose(linear.area, 8 * a * b, rtol=1e-8)
    np.testing.assert_allclose(linear.pressure, 6 / (16 * a * b), rtol=1e-8)
    np.testing.assert_allclose(plastic.area, 4.5 * a * b, rtol=1e-8)


def test_the_kern_of_a_rectangle_is_a_rhomb():
    face = faces_of(*[SQUARE * [3.0, 1.0]] * 3)
    e = np.array([[0.25, 1 / 12], [0.5, 0.0], [0.25, 0.0]])
    np.testing.assert_allclose(kern_share(face, e), [1.0, 1.0, 0.5])
    np.testing.assert_allclose(linear_block(face, e).pressure * 3, [2.0, 2.0, 1.5])


@given(st.integers(3, 7), st.integers(0, 10_000))
@example(3, 614)  # the first line that is tried does not cut the face
@settings(max_examples=60, deadline=None)
def test_bounds_that_hold_in_any_convex_face(corners: int, seed: int):
    rng = np.random.default_rng(seed)
    angle = 2 * np.pi * (np.arange(corners) + 0.8 * rng.random(corners)) / corners
    flat = centred(np.stack([np.cos(angle), 0.5 * np.sin(angle)], axis=1))
    towards = rng.normal(size=2)
    reach = 1.0
    face = faces_of(flat)
    while outline_distance(face, reach * towards[None])[0] < 0.02:
        reach *= 0.9
    e = rng.uniform(0.2, 1.0) * reach * towards[None]
    linear, plastic = linear_block(face, e), plastic_block(face, e)
    assert 0 < plastic.area[0] <= face.area[0] * (1 + 1e-9)
    assert linear.area[0] <= face.area[0] * (1 + 1e-9)
    # no block of pressure with this centre is smaller than the uniform one on the largest part
    assert linear.pressure[0] >= plastic.pressure[0] * (1 - 1e-9)
    assert linear.pressure[0] * linear.area[0] <= 3 * (1 + 1e-9)
    assert linear.pressure[0] * linear.area[0] >= 1 - 1e-9


@pytest.mark.parametrize("e", [(0.3, 0.1), (-0.2, 0.3), (0.42, -0.4), (0.0, 0.49)])
def test_linear_pressure_holds_the_force(e: tuple[float, float]):
    """By a fine grid of points, which knows nothing of polygons."""
    values = _linear(SQUARE[None], np.array([e]))[0]
    plane = np.linalg.lstsq(np.column_stack([np.ones(4), SQUARE]), values)[0]
    line = (np.arange(2000) + 0.5) / 2000 - 0.5
    x, y = np.meshgrid(line, line)
    pressure = np.maximum(plane[0] + plane[1] * x + plane[2] * y, 0.0)
    found = [pressure.mean(), (pressure * x).mean(), (pressure * y).mean()]
    np.testing.assert_allclose(found, [1.0, *e], atol=2e-3 if abs(e[1]) > 0.48 else 2e-4)


@given(st.integers(0, 10_000))
@settings(max_examples=60, deadline=None)
def test_moments_of_both_parts_add_up_to_the_whole(seed: int):
    rng = np.random.default_rng(seed)
    angle = np.sort(rng.uniform(0, 2 * np.pi, 6))
    corners = np.stack([np.cos(angle), np.sin(angle)], axis=1)[None] + rng.normal(size=2)
    values = corners[0] @ rng.normal(size=2) + rng.normal()
    whole = polygon_moments(corners)
    parts = [polygon_moments(corners, sign * values[None]) for sign in (1, -1)]
    for one, above, below in zip(whole, *parts, strict=True):
        np.testing.assert_allclose(above + below, one, rtol=1e-9, atol=1e-10)


def test_moments_of_a_triangle():
    area, first, second = polygon_moments(np.array([[[0.0, 0.0], [3.0, 0.0], [0.0, 2.0], [0.0, 2.0]]]))
    np.testing.assert_allclose(area, 3.0)
    np.testing.assert_allclose(first, [[3.0, 2.0]])
    np.testing.assert_allclose(second, [[[3.0**3 * 2 / 12, 36 / 24], [36 / 24, 3 * 2.0**3 / 12]]])


def test_a_square_turned_is_as_strong():
    turn = np.array([[0.6, -0.8], [0.8, 0.6]])
    face = faces_of(SQUARE, SQUARE @ turn.T)
    e = np.array([0.31, 0.22])
    linear = linear_block(face, np.array([e, turn @ e]))
    np.testing.assert_allclose(linear.pressure[0], linear.pressure[1], rtol=1e-9)
    plastic = plastic_block(face, np.array([e, turn @ e]))
    np.testing.assert_allclose(plastic.area[0], plastic.area[1], rtol=1e-9)
