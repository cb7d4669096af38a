"""Random convex polyhedra that touch in known ways: no contact invented, none lost."""

import logging

import numpy as np
import pytest

from masonry_fem.contact.crossing import edges_of
from masonry_fem.contact.detection import detect
from masonry_fem.solid.assembly import Assembly, Block, Shape
from masonry_fem.solid.polytope import Polytope
from masonry_fem.solid.pose import Pose
from tests.contact.blocks import box_shape, moved, turning
from tests.contact.stones import common_area, on_corner, on_edges, outline, prism

GAPS = [0.0, 1e-6, -1e-6, 2e-4, -2e-4]
TURN, SHIFT = turning(1.1), np.array([3.0, 2.0, -7.0])
FLAT = 5.5  # degrees: faces below it touch as faces


@pytest.mark.slow
@pytest.mark.parametrize("gap", GAPS)
@pytest.mark.parametrize("touch", [on_corner, on_edges])
def test_stones_that_touch_in_a_point(touch, gap):
    random = np.random.default_rng(1)
    seen = 0
    for _ in range(60):
        pair = touch(random, gap)
        found = detect(pair.assembly)
        if pair.flattest < FLAT:
            assert found
            continue
        (interface,) = found
        seen += 1
        assert interface.area == 0
        sign = 1 if interface.blocks == (1, 0) else -1
        assert sign * interface.normal == pytest.approx(pair.normal, abs=1e-9)
        assert interface.gap == pytest.approx([gap], abs=1e-12)
        assert interface.polygon == pytest.approx(pair.point[None], abs=1e-3)
    assert seen > 30


@pytest.mark.parametrize("touch", [on_corner, on_edges])
def test_stones_apart_do_not_touch(touch):
    random = np.random.default_rng(2)
    assert not any(detect(touch(random, 5e-3).assembly) for _ in range(60))


@pytest.mark.parametrize("touch", [on_corner, on_edges])
def test_turned_copies_touch_alike(touch):
    random = np.random.default_rng(3)
    for _ in range(20):
        pair = touch(random, 1e-6).assembly
        here, there = detect(pair), detect(moved(pair, TURN, SHIFT))
        assert [(i.blocks, i.faces) for i in here] == [(i.blocks, i.faces) for i in there]
        for a, b in zip(here, there, strict=True):
            assert b.normal == pytest.approx(TURN @ a.normal, abs=1e-9)
            assert b.gap == pytest.approx(a.gap, abs=1e-12)
            # polygons may start at another corner
            away = np.linalg.norm((a.polygon @ TURN.T + SHIFT)[:, None] - b.polygon, axis=2)
            assert away.min(axis=1) == pytest.approx(0, abs=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("gap", GAPS)
def test_prisms_of_random_outlines_share_the_common_polygon(gap, caplog):
    random = np.random.default_rng(0)
    touched = apart = slivers = 0
    for _ in range(120):
        first, second = outline(random), outline(random)
        offset = random.uniform(-1.2, 1.2, 2)
        at = SHIFT + TURN @ [*offset, 0.5 + gap]
        shapes = (Shape("a", prism(first, 0.5)), Shape("b", prism(second, 0.5)))
        blocks = (Block("low", 0, Pose(TURN, SHIFT)), Block("high", 1, Pose(TURN, at)))
        caplog.clear()
        found = detect(Assembly(3, shapes, blocks))
        area, radius = common_area(first, second + offset)
        if radius <= 0:
            assert not found
            assert not caplog.records
            apart += 1
        elif not found:  # never without a word
            assert area < 1e-4
            assert "'low' and 'high' have only a sliver in common" in caplog.text
            slivers += 1
        else:
            (interface,) = found
            assert interface.area == pytest.approx(area)
            assert interface.gap == pytest.approx(gap, abs=1e-13)
            touched += 1
    assert touched > 60
    assert apart > 20
    assert slivers < 3


@pytest.mark.parametrize("overlap", [1e-3, 2e-4, 0.9e-4, 1e-5, 1e-6, 0.0])
@pytest.mark.parametrize("dimension", [2, 3])
def test_slivers_are_contacts_or_named(overlap, dimension, caplog):
    """Two unit cubes that share a strip of the upper one's bottom face."""
    shape = box_shape("cube", (1.0,) * dimension)
    up = np.eye(dimension)[-1]
    shift = up + (1 - overlap) * np.eye(dimension)[0]
    blocks = (Block("low", 0, Pose.identity(dimension)), Block("high", 0, Pose.at(*shift)))
    with caplog.at_level(logging.WARNING):
        found = detect(Assembly(dimension, (shape,), blocks))
    if overlap > 1e-4:
        (interface,) = found
        assert interface.area == pytest.approx(overlap)
        assert not caplog.records
    else:
        assert not found
        assert ("'low' and 'high' have only a sliver" in caplog.text) == (overlap > 2e-6)


def test_a_face_shared_by_many():
    """A floor under 20 × 20 cubes, of which every second row stands askew; one slab on all of them."""
    cube = box_shape("cube", (0.05, 0.05, 0.05))
    slab = box_shape("slab", (2.0, 2.0, 0.1))
    blocks = [Block("floor", 1, Pose.at(0, 0, -0.1), support=True)]
    for row in range(20):
        for column in range(20):
            turn = turning(0.3 * (row % 2), (0, 0, 1))
            blocks.append(
                Block(
                    f"c{row}.{column}",
                    0,
                    Pose(turn, np.array([row, column, 0.2]) * 0.1 - [-0.02, -0.02, 0.02]),
                )
            )
    blocks.append(Block("slab", 1, Pose.at(0, 0, 0.05)))
    interfaces = detect(Assembly(3, (cube, slab), tuple(blocks)))
    assert len(interfaces) == 800
    assert sum(interface.area for interface in interfaces) == pytest.approx(2 * 400 * 0.05**2)
    assert {interface.blocks[1] for interface in interfaces} == {0} | set(range(1, 401))


def test_thin_faces_meet_whole():
    """A wedge of 1 degree and plates of 1 to 1000: no part of their faces is lost."""
    tip = np.tan(np.radians(1.0))
    wedge = prism(np.array([[0.0, 0.0], [1.0, 0.0], [1.0, tip]]), 0.3)
    box = Polytope.box((0.0, -1.0, 0.0), (1.0, 0.0, 0.3))
    (interface,) = detect(
        Assembly(
            3,
            (Shape("wedge", wedge), Shape("box", box)),
            (Block("box", 1, Pose.identity(3)), Block("wedge", 0, Pose.identity(3))),
        )
    )
    assert interface.area == pytest.approx(0.3)
    assert interface.normal == pytest.approx([0, 1, 0])
    plate = box_shape("plate", (1.0, 1e-3, 1.0))
    stack = tuple(Block(f"p{k}", 0, Pose.at(0, 1e-3 * k, 0.1 * k)) for k in range(5))
    interfaces = detect(Assembly(3, (plate,), stack), reach=1e-6)
    assert [i.blocks for i in interfaces] == [(k + 1, k) for k in range(4)]
    assert [i.area for i in interfaces] == pytest.approx([0.9] * 4)


def test_edges_of_a_box():
    edges = edges_of(Polytope.box((0, 0, 0), (1, 1, 1)))
    assert len(edges) == 12
    assert (edges[:, 2] != edges[:, 3]).all()
    assert len(edges_of(Polytope.box((0, 0), (1, 1)))) == 0


def test_crossing_edges_of_two_roofs():
    """Two triangular prisms ridge on ridge, crosswise: one point; beside the ridge's end, nothing."""
    roof = prism(np.array([[-0.5, -1.0], [0.5, -1.0], [0.0, 0.0]]), 2.0)  # ridge along z at the origin
    across = turning(np.pi / 2, (0, 1, 0)) @ np.diag([-1.0, -1.0, 1.0])  # upside down, a quarter turn

    def stacked(shift):
        blocks = (Block("floor", 0, Pose.identity(3), support=True), Block("roof", 0, Pose(across, shift)))
        return Assembly(3, (Shape("roof", roof),), blocks)

    (interface,) = detect(stacked(np.array([-0.7, 1e-4, 0.8])))
    assert interface.blocks == (1, 0)
    assert interface.polygon == pytest.approx(np.array([[0.0, 5e-5, 0.8]]))
    assert interface.normal == pytest.approx([0, 1, 0])
    assert interface.gap == pytest.approx([1e-4])
    assert not detect(stacked(np.array([0.1, 1e-4, 0.8])))
    (swapped,) = detect(
        Assembly(3, (Shape("roof", roof),), stacked(np.array([-0.7, 1e-4, 0.8])).blocks[::-1])
    )
    assert swapped.blocks == (0, 1)  # the support is the antagonist


def _ell(depth=1.0):
    loop = np.array([[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]], dtype=float)
    return prism(loop, depth)


@pytest.mark.parametrize("gap", [0.0, 1e-6, -1e-6])
def test_block_that_is_not_convex_stands_on_its_corners(gap):
    """An L on its two tips, a wedge in its hollow: corners are found, and nothing on the hull."""
    shape, ground = Shape("ell", _ell()), box_shape("ground", (10.0, 10.0, 1.0), low=(-5.0, -5.0, -1.0))
    # the tips (2, 1) and (1, 2) down: turned by −135 degrees about z, then that axis upright
    upright = turning(np.pi / 2, (1, 0, 0)) @ turning(-3 * np.pi / 4, (0, 0, 1))
    lowest = (shape.solid.vertices @ upright.T)[:, 2].min()
    blocks = (
        Block("ground", 1, Pose.identity(3), support=True),
        Block("ell", 0, Pose(upright, np.array([0.0, 0.0, gap - lowest]))),
    )
    found = detect(Assembly(3, (shape, ground), blocks))
    assert all(interface.blocks == (1, 0) for interface in found)
    assert all(interface.normal == pytest.approx([0, 0, 1]) for interface in found)
    touched = {tuple(np.round(point, 6)) for interface in found for point in interface.polygon}
    expected = shape.solid.vertices @ upright.T
    expected = expected[expected[:, 2] < lowest + 1e-6]
    assert len(expected) == 4
    assert touched == {tuple(np.round([x, y, 0.0], 6)) for x, y, _ in expected}
    assert [interface.gap for interface in found] == [pytest.approx([gap], abs=1e-12)] * 4


def test_corner_in_a_hollow_stands_on_the_inner_face():
    """A cube on its corner in the hollow of an L: on the inner face, not on the hull."""
    shape, cube = Shape("ell", _ell()), box_shape("cube", (0.5, 0.5, 0.5))
    diagonal = turning(np.arctan(np.sqrt(2)), (1, -1, 0))
    diagonal = diagonal if (diagonal @ np.ones(3))[2] > 0.8 else diagonal.T
    up = turning(-np.pi / 2, (1, 0, 0)) @ diagonal  # the corner at the origin points down −y
    for at, touches in (((1.6, 1.0, 0.5), True), ((1.6, 1.2, 0.5), False)):
        blocks = (Block("ell", 0, Pose.identity(3)), Block("cube", 1, Pose(up, np.array(at))))
        found = detect(Assembly(3, (shape, cube), blocks))
        if touches:
            (interface,) = found
            assert interface.blocks == (1, 0)
            assert interface.normal == pytest.approx([0, 1, 0])
            assert interface.polygon == pytest.approx(np.array([at]))
        else:
            assert not found
