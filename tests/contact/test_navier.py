"""Plane faces: moments of areas, means of motions, and tractions that vary linearly on any two meshes."""

from __future__ import annotations

import numpy as np
import pytest

from masonry_fem.contact.clipping import polygon_area
from masonry_fem.contact.detection import detect
from masonry_fem.contact.interpolation import weights
from masonry_fem.contact.place import place
from masonry_fem.contact.placement import Rule, points_of
from masonry_fem.contact.placement.parts.patch import Patch
from masonry_fem.contact.surface import surfaces_of
from tests.contact.blocks import box_shape, pair, rings
from tests.contact.stones import outline

RULE = Rule("navier")


def plane(polygon: np.ndarray) -> Patch:
    """A polygon between two blocks without meshes."""
    boxes = unit_boxes(3)
    (interface,) = detect(boxes)
    at = Patch.of(boxes, surfaces_of(boxes), interface, np.roll(np.eye(3), 1, axis=0))
    return Patch(interface, at.sides, at.frame, at.origin, polygon)


def unit_boxes(d: int, cells=(None, None), order=(1, 1), shift=None):
    """One on the other, with meshes of so many cells."""
    low = (0.0,) * (d - 1) + (-1.0,)
    lower = box_shape("lower", (1.0,) * d, cells[0], low=low, order=order[0])
    upper = box_shape("upper", (1.0,) * d, cells[1], order=order[1])
    return pair(lower, upper, 0.0, (0.0,) * (d - 1) if shift is None else shift)


def test_areas_on_a_rectangle_and_on_a_line():
    rectangle = points_of("navier")(plane(np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 0.5], [0.0, 0.5]])), RULE)
    assert rectangle.points[4] == pytest.approx([1.0, 0.25])
    assert rectangle.area == pytest.approx([1 / 12, 1 / 12, 1 / 12, 1 / 12, 2 / 3])
    squares = rectangle.area @ (rectangle.points - rectangle.points[4]) ** 2
    assert squares == pytest.approx([2.0**2 / 12, 0.5**2 / 12])
    lines = unit_boxes(2, shift=(0.4,))
    contacts = place(lines, detect(lines), [RULE])
    order = np.argsort(contacts.points[:, 0, 0])
    assert contacts.points[order, 0, 0] == pytest.approx([0.4, 0.7, 1.0])
    assert contacts.area[order] == pytest.approx(0.6 * np.array([1, 4, 1]) / 6)


@pytest.mark.parametrize("seed", range(6))
def test_areas_of_any_face_have_its_centroid_and_second_moment(seed):
    polygon = outline(np.random.default_rng(seed))
    polygon = polygon if polygon_area(polygon) > 0 else polygon[::-1]
    fan = np.array([polygon[[0, i, i + 1]] for i in range(1, len(polygon) - 1)])
    one, other = fan[:, 1] - fan[:, 0], fan[:, 2] - fan[:, 0]
    area = 0.5 * (one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0])
    middles = (fan + np.roll(fan, 1, axis=1)) / 2  # their mean is exact for polynomials of degree 2
    centroid = area @ fan.mean(axis=1) / area.sum()
    square = area @ ((middles - centroid) ** 2).sum(axis=2).mean(axis=1) / area.sum()
    spots = points_of("navier")(plane(polygon), RULE)
    weight = spots.area / spots.area.sum()
    assert weight.min() > 0
    assert weight @ spots.points == pytest.approx(centroid, abs=1e-12)
    assert weight @ ((spots.points - centroid) ** 2).sum(axis=1) == pytest.approx(square)


def test_corners_drawn_in_bear_more_until_nothing_is_left_for_the_centroid():
    square = plane(np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]))
    for inset in (0.8, 3**-0.5, 0.3):
        spots = points_of("navier")(square, Rule("navier", inset=inset))
        corner = min(1.0, 1 / (3 * inset**2))
        assert spots.area == pytest.approx([*(4 * [corner / 4]), 1 - corner])


@pytest.mark.parametrize("order", [(1, 1), (2, 1)])
@pytest.mark.parametrize("dimension", [2, 3])
def test_contacts_move_as_the_plane_nearest_to_a_face_and_spread_linear_pressures(dimension, order):
    """Means of affine motions are these at the contacts; forces of linear pressures are consistent."""
    d = dimension
    assembly = unit_boxes(d, ((3, 4, 1)[-d:], (5, 2, 1)[-d:]), order, (0.27, -0.41)[: d - 1])
    contacts = place(assembly, detect(assembly), [RULE])
    assert contacts.count == (3 if d == 2 else 5)
    assert contacts.means is not None
    random = np.random.default_rng(0)
    slope, pressure = random.normal(size=(d, d)), random.normal(size=d)
    gauss = place(assembly, detect(assembly), [Rule("gauss")])
    for side in (0, 1):
        (block,) = set(contacts.blocks[:, side].tolist())
        stone = assembly.blocks[block]
        mesh = assembly.shapes[stone.shape].mesh
        rows = contacts.means[side::2, : len(mesh.points)].toarray()
        assert rows.sum(axis=1) == pytest.approx(1.0)
        world = stone.pose.to_world(mesh.points)
        assert rows @ (world @ slope) == pytest.approx(contacts.points[:, side] @ slope)
        bears = contacts.area * (1.0 + contacts.points[:, side] @ pressure)
        forces = rows.T @ bears
        assert set(gauss.blocks[:, side].tolist()) == {block}
        facets, at = gauss.facets[:, side], gauss.points[:, side]
        shares = weights(mesh, facets, stone.pose.to_shape(at))
        shares *= (gauss.area * (1.0 + at @ pressure))[:, None]
        exact = np.zeros(len(mesh.points))
        np.add.at(exact, mesh.facets[facets].ravel(), shares.ravel())
        assert forces == pytest.approx(exact, abs=1e-12)


def test_round_faces_have_the_usual_contacts():
    made = rings((6, 3, 1), (6, 3, 1))
    found = [place(made, detect(made), [Rule(name)] * len(detect(made))) for name in ("navier", "auto")]
    assert np.array_equal(found[0].points, found[1].points)
    assert np.array_equal(found[0].area, found[1].area)
