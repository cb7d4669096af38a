"""Interfaces of walls, arches and pairs of blocks with known answers."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from masonry_fem.contact import detection, facing
from masonry_fem.contact.detection import detect
from masonry_fem.errors import GeometryError
from masonry_fem.solid.assembly import Assembly, Block, Shape
from masonry_fem.solid.polytope import Polytope
from masonry_fem.solid.pose import Pose
from tests.contact.blocks import arch, box_shape, moved, pair, turning, turning_2d, wall

CUBE = box_shape("cube", (1.0, 1.0, 1.0))
BELOW = box_shape("below", (1.0, 1.0, 1.0), low=(0.0, 0.0, -1.0))
WIDE = box_shape("wide", (10.0, 10.0, 1.0), low=(-5.0, -5.0, -1.0))
GROUND = box_shape("ground", (10.0, 1.0), low=(-5.0, -1.0))


def two(first, second, pose, *, support=True):
    d = first.solid.dimension
    blocks = (Block("first", 0, Pose.identity(d), support=support), Block("second", 1, pose))
    return Assembly(d, (first, second), blocks)


@pytest.mark.parametrize("dimension", [2, 3])
def test_low_wall(dimension):
    interfaces = detect(wall(4, 5, dimension))
    depth = 0.25 if dimension == 3 else 1.0
    heads = [interface for interface in interfaces if interface.label == "head"]
    beds = [interface for interface in interfaces if interface.label == "bed"]
    assert len(heads) == 3 * 3 + 2 * 4
    assert len(beds) == 4 + 4 * 8
    assert len(interfaces) == len(heads) + len(beds)
    assert sum(interface.area for interface in heads) == pytest.approx(17 * 0.25 * depth)
    assert sum(interface.area for interface in beds) == pytest.approx(5 * 2.0 * depth)
    assert all(not interface.gap.any() for interface in interfaces)
    assert all(interface.normal == pytest.approx(np.eye(dimension)[-1], abs=1e-12) for interface in beds)
    assert all(interface.blocks[0] > interface.blocks[1] for interface in interfaces)
    assert all(len(interface.polygon) == 2 ** (dimension - 1) for interface in interfaces)


@pytest.mark.parametrize("dimension", [2, 3])
def test_arch_of_voussoirs(dimension):
    interfaces = detect(arch(11, dimension))
    assert [interface.blocks for interface in interfaces] == [(k + 1, k) for k in range(10)]
    for joint, interface in enumerate(interfaces, start=1):
        angle = np.pi - joint * np.pi / 11
        along = np.array([np.cos(angle), np.sin(angle)])
        assert interface.label == "radial"
        assert interface.area == pytest.approx(0.2 * (0.3 if dimension == 3 else 1.0))
        plane = interface.polygon[:, [0, -1]]
        assert plane @ [-along[1], along[0]] == pytest.approx(0, abs=1e-12)
        assert interface.normal[[0, -1]] == pytest.approx([along[1], -along[0]])
        assert np.linalg.norm(plane.mean(axis=0)) == pytest.approx(1.1)


@pytest.mark.slow
@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("build", [lambda d: wall(3, 3, d), lambda d: arch(7, d)])
def test_rotated_and_translated_copies(build, dimension):
    assembly = build(dimension)
    rotation = turning(0.7) if dimension == 3 else turning_2d(0.7)
    shift = np.array([20.0, -7.0, 3.0])[:dimension]
    here, there = detect(assembly), detect(moved(assembly, rotation, shift))
    assert [i.blocks for i in here] == [i.blocks for i in there]
    assert [i.faces for i in here] == [i.faces for i in there]
    for a, b in zip(here, there, strict=True):
        assert b.normal == pytest.approx(rotation @ a.normal, abs=1e-12)
        assert b.area == pytest.approx(a.area)
        assert b.gap == pytest.approx(a.gap, abs=1e-12)
        moved_points = a.polygon @ rotation.T + shift
        away = np.linalg.norm(moved_points[:, None] - b.polygon, axis=2)
        assert away.min(axis=1) == pytest.approx(0, abs=1e-10)


@pytest.mark.parametrize("gap", [1e-6, -1e-6, 9e-4, -9e-4, 0.0])
def test_small_gaps_and_overlaps_are_contacts(gap):
    (interface,) = detect(pair(BELOW, CUBE, gap, (0.3, 0.2)))
    assert interface.gap == pytest.approx(gap, abs=1e-15)
    assert interface.area == pytest.approx(0.7 * 0.8)
    assert interface.polygon[:, 2] == pytest.approx(gap / 2)


@pytest.mark.slow
@pytest.mark.parametrize("gap", [1.1e-3, -1.1e-3])
def test_beyond_the_reach_there_is_nothing(gap):
    assert not detect(pair(BELOW, CUBE, gap))
    assert len(detect(pair(BELOW, CUBE, gap), reach=2e-3)) == 1


@pytest.mark.parametrize("deep", [0.03, 0.4, 0.6])
def test_overlaps_beyond_the_reach_are_found_where_asked(deep):
    """What fell in by more than the reach is still held; beyond half of a block it is seen through it."""
    found = detect(pair(BELOW, CUBE, -deep), reach=1e-3, overlap=1.5)
    assert [interface.gap.min() for interface in found] == ([pytest.approx(-deep)] if deep < 0.5 else [])


@pytest.mark.parametrize(
    "shift", [(1.0, 0.0, 0.0), (1.0, 1.0, 0.0), (1.0, -1.0, 0.0), (0.5, 1.0, 0.0), (1.00001, 0.0, 0.0)]
)
@pytest.mark.parametrize("angle", [0.0, 1.1])
def test_shared_edges_and_corners_are_no_contacts(shift, angle):
    assembly = two(BELOW, CUBE, Pose.at(*shift))
    assert not detect(moved(assembly, turning(angle), np.ones(3)))


def test_candidate_is_later_or_not_a_support():
    (interface,) = detect(two(WIDE, CUBE, Pose.at(0, 0, 0)))
    assert interface.blocks == (1, 0)
    swapped = Assembly(
        3,
        (CUBE, WIDE),
        (Block("cube", 0, Pose.identity(3)), Block("floor", 1, Pose.identity(3), support=True)),
    )
    (interface,) = detect(swapped)
    assert interface.blocks == (0, 1)
    assert interface.normal == pytest.approx([0, 0, 1])


def test_supports_touch_only_on_demand():
    assembly = pair(BELOW, CUBE)
    held = replace(assembly, blocks=tuple(replace(block, support=True) for block in assembly.blocks))
    assert not detect(held)
    assert len(detect(held, support_pairs=True)) == 1


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
@pytest.mark.parametrize("tilt", [0.02, 0.1, 0.19])
@pytest.mark.parametrize("dimension", [2, 3])
def test_rocking_block_keeps_its_corners(dimension, tilt, order):
    """A 0.5 × 2 m block (A1.6) turned about a bottom corner: contacts where the corners are."""
    width, shape = 0.5, box_shape("block", (0.5, 2.0) if dimension == 2 else (0.5, 0.4, 2.0))
    turn = turning_2d(tilt) if dimension == 2 else turning(-tilt, (0, 1, 0))
    blocks = (
        Block("floor", 0, Pose.identity(dimension)),
        Block("block", 1, Pose(turn, np.zeros(dimension))),
    )
    floor = GROUND if dimension == 2 else WIDE
    assembly = Assembly(dimension, (floor, shape), tuple(blocks[k] for k in order))
    (interface,) = detect(assembly, reach=0.12, angle=12)
    assert [assembly.blocks[k].name for k in interface.blocks] == ["block", "floor"]
    assert interface.normal == pytest.approx(np.eye(dimension)[-1])
    expected = {0.0, round(width * np.sin(tilt), 12)}
    assert {round(float(gap), 12) for gap in interface.gap} == expected
    assert interface.polygon[:, 0].max() == pytest.approx(width * np.cos(tilt))
    assert interface.polygon[:, -1] == pytest.approx(0, abs=1e-12)


def test_block_on_its_edge_and_on_its_corner():
    edge = turning(-np.pi / 4, (0, 1, 0))
    (interface,) = detect(two(WIDE, CUBE, Pose(edge, np.zeros(3))))
    assert interface.blocks == (1, 0)
    along = interface.polygon[np.argsort(interface.polygon[:, 1])]
    assert along == pytest.approx(np.array([[0, 0, 0], [0, 1, 0]]), abs=1e-12)
    corner = turning(np.arctan(np.sqrt(2)), (1, -1, 0))  # the cube's diagonal upright
    corner = corner if (corner @ np.ones(3))[2] > 1.7 else corner.T
    (interface,) = detect(two(WIDE, CUBE, Pose(corner, np.array([0.1, 0.2, 1e-4]))))
    assert interface.polygon == pytest.approx(np.array([[0.1, 0.2, 0.0]]))
    assert interface.gap == pytest.approx([1e-4])
    assert interface.normal == pytest.approx([0, 0, 1])
    assert interface.area == 0


def test_edge_that_overhangs_is_cut_at_the_face():
    edge = turning(-np.pi / 4, (0, 1, 0))
    (interface,) = detect(two(WIDE, CUBE, Pose(edge, np.array([0.0, 4.4, 0.0]))))
    assert sorted(interface.polygon[:, 1]) == pytest.approx([4.4, 5.0])


def test_square_on_its_corner_in_the_plane():
    square = box_shape("square", (1.0, 1.0))
    (interface,) = detect(two(GROUND, square, Pose(turning_2d(np.pi / 4), np.array([0.3, 0.0]))))
    assert interface.blocks == (1, 0)
    assert interface.polygon == pytest.approx(np.array([[0.3, 0.0]]))


@st.composite
def split_stones(draw):
    """A convex stone cut in two by a line: outlines of the parts and the length of the cut."""
    count = draw(st.integers(3, 7))
    gaps = np.array(draw(st.lists(st.floats(0.4, 1.0), min_size=count, max_size=count)))
    angles = 2 * np.pi * np.cumsum(gaps) / gaps.sum()
    outline = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    first = draw(st.integers(0, count - 1))
    second = (first + draw(st.integers(1, count - 1))) % count
    parts = draw(st.floats(0.1, 0.9)), draw(st.floats(0.1, 0.9))
    ends = [
        (1 - s) * outline[k] + s * outline[(k + 1) % count]
        for k, s in zip((first, second), parts, strict=True)
    ]
    loops = []
    for (a, i), (b, j) in (((ends[0], first), (ends[1], second)), ((ends[1], second), (ends[0], first))):
        between = [outline[(i + 1 + k) % count] for k in range((j - i) % count)]
        loops.append(np.array([a, *between, b]))
    return loops, float(np.linalg.norm(ends[1] - ends[0]))


def _prism(outline, depth):
    k = len(outline)
    vertices = np.concatenate([np.c_[outline, np.zeros(k)], np.c_[outline, np.full(k, depth)]])
    sides = tuple((i, (i + 1) % k, (i + 1) % k + k, i + k) for i in range(k))
    return Polytope(vertices, (tuple(range(k))[::-1], tuple(range(k, 2 * k)), *sides))


@given(split_stones(), st.floats(0, 6), st.sampled_from([2, 3]))
def test_a_stone_cut_in_two_touches_along_the_cut(stone, angle, dimension):
    loops, length = stone
    depth = 0.7 if dimension == 3 else 1.0
    if dimension == 3:
        solids, turn = [_prism(loop, depth) for loop in loops], turning(angle)
    else:
        solids = [Polytope(loop, tuple((i, (i + 1) % len(loop)) for i in range(len(loop)))) for loop in loops]
        turn = turning_2d(angle)
    pose = Pose(turn, np.full(dimension, 2.0))
    shapes = tuple(Shape(str(k), solid) for k, solid in enumerate(solids))
    assembly = Assembly(dimension, shapes, tuple(Block(str(k), k, pose) for k in (0, 1)))
    (interface,) = detect(assembly)
    assert interface.area == pytest.approx(length * depth)
    assert interface.gap == pytest.approx(0, abs=1e-12)
    centroids = [shape.solid.mass_properties().centroid for shape in shapes]
    assert interface.normal @ turn @ (centroids[1] - centroids[0]) > 0


def test_faces_that_are_not_convex_touch_in_pieces():
    ell = np.array([[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]], dtype=float)
    vertices = np.concatenate([np.c_[ell, np.zeros(6)], np.c_[ell, np.ones(6)]])
    sides = tuple((k, (k + 1) % 6, (k + 1) % 6 + 6, k + 6) for k in range(6))
    solid = Polytope(vertices, ((5, 4, 3, 2, 1, 0), (6, 7, 8, 9, 10, 11), *sides))
    assembly = Assembly(
        3,
        (WIDE, Shape("ell", solid)),
        (Block("floor", 0, Pose.identity(3)), Block("ell", 1, Pose.at(0, 0, 0))),
    )
    interfaces = detect(assembly)
    assert sum(interface.area for interface in interfaces) == pytest.approx(3)
    centroid = sum(interface.area * _centroid(interface.polygon) for interface in interfaces) / 3
    assert centroid == pytest.approx([5 / 6, 5 / 6, 0])


def _centroid(polygon):
    spokes = polygon - polygon[0]
    area = np.linalg.norm(np.cross(spokes[1:-1], spokes[2:]), axis=1)
    return polygon[0] + (area[:, None] * (spokes[1:-1] + spokes[2:])).sum(axis=0) / 3 / area.sum()


def test_same_answer_twice():
    first, second = detect(wall(4, 4)), detect(wall(4, 4))
    for a, b in zip(first, second, strict=True):
        assert (a.blocks, a.faces, a.area) == (b.blocks, b.faces, b.area)
        assert a.polygon.tobytes() == b.polygon.tobytes()


def test_pairs_in_lots_give_the_same_bits(monkeypatch):
    whole = detect(wall(3, 3, 3))
    monkeypatch.setattr(facing, "AT_ONCE", 4)
    monkeypatch.setattr(detection, "TOGETHER", 5)
    lots = detect(wall(3, 3, 3))
    assert len(lots) == len(whole) > 5
    for one, other in zip(lots, whole, strict=True):
        assert (one.blocks, one.faces, one.label, one.area) == (
            other.blocks, other.faces, other.label, other.area,
        )  # fmt: skip
        np.testing.assert_array_equal(one.polygon, other.polygon)
        np.testing.assert_array_equal(one.gap, other.gap)


def test_interfaces_come_by_blocks_then_faces():
    keys = [(*sorted(i.blocks), *i.faces) for i in detect(wall(4, 4))]
    assert keys == sorted(keys)


def test_a_thousand_bricks():
    """How long it takes: ``benchmarks.detection``."""
    assembly = wall(32, 31)
    interfaces = detect(assembly)
    assert len(assembly.blocks) > 1000
    assert len(interfaces) == 32 + 30 * 64 + 16 * 31 + 15 * 32


def test_nothing_to_pair():
    assert not detect(Assembly(3, (CUBE,), (Block("alone", 0, Pose.identity(3)),)))


@pytest.mark.parametrize(
    ("wrong", "named"), [({"reach": -1.0}, "reach is -1.0"), ({"angle": 95.0}, "angle is 95.0")]
)
def test_settings_out_of_range(wrong, named):
    with pytest.raises(GeometryError, match=named):
        detect(pair(BELOW, CUBE), **wrong)
