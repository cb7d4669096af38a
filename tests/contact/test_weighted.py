"""Weighted contacts: consistent forces and exact moments on both sides of any two meshes."""

from dataclasses import replace
from itertools import product
from math import factorial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from masonry_fem.contact.detection import detect
from masonry_fem.contact.interpolation import weights
from masonry_fem.contact.place import place
from masonry_fem.contact.placement import Rule
from masonry_fem.contact.placement.parts import pieces
from masonry_fem.contact.placement.parts.quadrature import gauss_rule, on_polygon, triangle_rule
from masonry_fem.contact.update import chosen, joined
from masonry_fem.records.remark import gathered
from tests.contact.blocks import box_shape, moved, pair, turning, turning_2d, wall
from tests.contact.test_placement import meshed_pair

RATIOS = [(2, 3), (3, 4), (4, 6), (8, 11)]


def placed(assembly, name="weighted", tell=False):
    interfaces = detect(assembly)
    return interfaces, place(assembly, interfaces, [Rule(name)] * len(interfaces), tell=tell)


def carried(assembly, contacts, side):
    """Weights of the nodes of one side's mesh, contacts of one interface, and where these nodes are."""
    block = assembly.blocks[contacts.blocks[0, side]]
    mesh = assembly.shapes[block.shape].mesh
    own = contacts.means[side::2, : len(mesh.points)]
    return own, block.pose.to_world(mesh.points)


def exact_forces(assembly, contacts, side):
    """∫ N dΓ over the interface for each node of one side, by the quadrature of ``gauss``."""
    (interface,), points = placed(assembly, "gauss")
    block = assembly.blocks[interface.blocks[side]]
    mesh = assembly.shapes[block.shape].mesh
    at = block.pose.to_shape(points.points[:, side])
    share = points.area[:, None] * weights(mesh, points.facets[:, side], at)
    nodes = mesh.facets[points.facets[:, side]]
    return np.bincount(nodes.ravel(), share.ravel(), len(mesh.points))


def assert_exact(assembly):
    """Uniform pressure, and linear motions, by which nodal forces have the resultant and moment of p."""
    (interface,), contacts = placed(assembly)
    assert contacts.area.sum() == pytest.approx(interface.area, rel=1e-12)
    assert contacts.area.min() > 0
    for side in (0, 1):
        own, nodes = carried(assembly, contacts, side)
        assert own.sum(axis=1) == pytest.approx(1, abs=1e-12)
        np.testing.assert_allclose(own @ nodes, contacts.points[:, side], atol=1e-12)
        np.testing.assert_allclose(
            own.T @ contacts.area, exact_forces(assembly, contacts, side), atol=1e-13 * interface.area
        )
    return interface, contacts


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("d", [2, 3])
def test_uniform_pressure_gives_both_meshes_their_forces(d, ratio):
    lower, upper = ((n, n + 1, n + 2)[-d:] for n in ratio)
    assert_exact(meshed_pair(lower, upper, dimension=d))


@pytest.mark.parametrize("order", [(1, 2), (2, 1), (2, 2)])
@pytest.mark.parametrize("d", [2, 3])
def test_quadratic_facets(d, order):
    assert_exact(meshed_pair((2,) * d, (3,) * d, dimension=d, order=order, shift=(0.13, 0.41)[: d - 1]))


@pytest.mark.parametrize("triangles", [(True, False), (False, True), (True, True)])
def test_triangles(triangles):
    assert_exact(meshed_pair((2, 2, 2), (3, 3, 3), triangles=triangles, shift=(0.2, -0.3)))


@pytest.mark.parametrize("d", [2, 3])
def test_partly_covered_and_turned(d):
    assembly = meshed_pair((3,) * d, (4,) * d, dimension=d, shift=(0.45, 0.77)[: d - 1])
    turn = turning(np.radians(37)) if d == 3 else turning_2d(np.radians(37))
    assert_exact(moved(assembly, turn, np.arange(1.0, d + 1)))


def test_a_turned_block_cuts_facets_aslant():
    """The upper block is turned by 37° on the lower one: pieces have up to eight corners."""
    assembly = meshed_pair((3, 3, 3), (4, 4, 4))
    c, s = np.cos(np.radians(37)), np.sin(np.radians(37))
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]])
    lower, upper = assembly.blocks
    pose = replace(upper.pose, rotation=turn, translation=np.add(upper.pose.translation, [0.3, -0.2, 0]))
    assert_exact(replace(assembly, blocks=(lower, replace(upper, pose=pose))))


@given(
    divisions=st.tuples(*(st.integers(1, 5),) * 4),
    triangles=st.tuples(st.booleans(), st.booleans()),
    order=st.tuples(st.integers(1, 2), st.integers(1, 2)),
    shift=st.tuples(st.floats(-0.7, 0.7), st.floats(-0.7, 0.7)),
    degrees=st.floats(0, 90),
)
@settings(max_examples=25, deadline=None, derandomize=True)
def test_facets_cut_in_any_way(divisions, triangles, order, shift, degrees):
    """Slivers, corners that poke into a facet, one facet on many: means of both sides stay moderate."""
    lower, upper = ((*divisions[k : k + 2], 1) for k in (0, 2))
    assembly = meshed_pair(lower, upper, triangles=triangles, order=order, shift=shift)
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]])
    below, above = assembly.blocks
    centre = np.array([0.5, 0.5, 0.0])
    place_of = above.pose.translation + centre - turn @ centre
    above = replace(above, pose=replace(above.pose, rotation=turn, translation=place_of))
    _, contacts = assert_exact(replace(assembly, blocks=(below, above)))
    assert np.abs(contacts.means.data).max() < 4


def test_distorted_quadrilaterals():
    """Shape functions of trapezia are no polynomials: the order of the quadrature follows the distortion."""

    def warped(points):
        x, y, z = points.T
        return np.stack([x + 0.8 * x * (1 - x) * (y - 0.5), y + 0.4 * y * (1 - y) * x, z], axis=1)

    shapes = [
        box_shape("lower", (1.0,) * 3, (2, 2, 2), low=(0, 0, -1.0), warp=warped),
        box_shape("upper", (1.0,) * 3, (3, 3, 3)),
    ]
    assembly = pair(*shapes, 0.0, (0.0, 0.0))
    (interface,), contacts = placed(assembly)
    for side, (block, face) in enumerate(zip(interface.blocks, interface.faces, strict=True)):
        own, _ = carried(assembly, contacts, side)
        mesh = assembly.shapes[assembly.blocks[block].shape].mesh
        exact = np.zeros(len(mesh.points))
        for facet in mesh.facets[mesh.facet_face == face]:
            exact[facet] += bilinear(mesh.points[facet][:, :2])
        np.testing.assert_allclose(own.T @ contacts.area, exact, atol=1e-11)


def bilinear(corners):
    """∫ N of a bilinear quadrilateral, by Gauss points of its own coordinates."""
    total = np.zeros(4)
    for x in (-(3**-0.5), 3**-0.5):
        for y in (-(3**-0.5), 3**-0.5):
            n = 0.25 * np.array([(1 - x) * (1 - y), (1 + x) * (1 - y), (1 + x) * (1 + y), (1 - x) * (1 + y)])
            dx = 0.25 * np.array([y - 1, 1 - y, 1 + y, -1 - y]) @ corners
            dy = 0.25 * np.array([x - 1, -1 - x, 1 + x, 1 - x]) @ corners
            total += n * abs(dx[0] * dy[1] - dx[1] * dy[0])
    return total


@pytest.mark.parametrize(("lower", "upper", "count"), [(2, 3, 4), (3, 2, 4), (3, 3, 4)])
def test_the_finer_side_carries_the_weights(lower, upper, count):
    _, contacts = placed(meshed_pair((lower, lower), (upper, upper), dimension=2))
    assert contacts.count == count
    assert contacts.area == pytest.approx([1 / 6, 1 / 3, 1 / 3, 1 / 6][:count])


@pytest.mark.parametrize("d", [2, 3])
def test_where_linear_meshes_match_contacts_are_nodes(d):
    """Dual weights: each contact is at a node of both sides, with the area that ``nodes`` gives it."""
    assembly = meshed_pair((3,) * d, (3,) * d, dimension=d)
    (_, weighted), (_, nodes) = (placed(assembly, name) for name in ("weighted", "nodes"))
    rows = [np.lexsort(one.points[:, 0].round(9).T) for one in (weighted, nodes)]
    np.testing.assert_allclose(weighted.points[rows[0]], nodes.points[rows[1]], atol=1e-13)
    np.testing.assert_allclose(weighted.area[rows[0]], nodes.area[rows[1]], rtol=1e-12)
    assert (np.diff(weighted.means.indptr) == 1).all()
    assert weighted.means.data == pytest.approx(1, abs=1e-12)


def test_contacts_stand_at_the_vertices_of_whole_facets():
    """So a joint of any two meshes bears up to its rim, where stones that rock turn."""
    _, contacts = placed(meshed_pair((2, 2, 2), (3, 3, 3)))
    x = np.unique(contacts.points[:, 0, 0].round(12))
    np.testing.assert_allclose(x, np.linspace(0, 1, 4), atol=1e-12)


def test_candidate_and_antagonist_stay():
    """Unlike ``nodes``: the direction of the normal does not depend on the meshes."""
    for lower, upper in ((2, 3), (3, 2)):
        interfaces, contacts = placed(meshed_pair((lower,) * 3, (upper,) * 3))
        assert (contacts.blocks == interfaces[0].blocks).all()


@pytest.mark.parametrize("beyond", [1e-7, 1e-3, 2e-2])
def test_a_sliver_of_support_goes_to_the_neighbours(beyond):
    """The polygon ends just beyond a line of the finer mesh: the next line's vertices get no contacts."""
    assembly = meshed_pair((3, 3, 3), (4, 4, 4), shift=(0.5 - beyond, 0.0))
    _, contacts = assert_exact(assembly)
    assert contacts.count == 3 * 5 if beyond < 1e-2 else contacts.count == 4 * 5
    assert contacts.area.min() > 1e-3 * contacts.area.max()


def test_rigid_on_elastic():
    """The meshed side has the weights; the rigid one moves with the mean point."""
    lower = box_shape("floor", (3.0, 3.0, 1.0), None, low=(-1.0, -1.0, -1.0))
    upper = box_shape("stone", (1.0, 1.0, 1.0), (2, 3, 2))
    assembly = pair(lower, upper, 0.0, (0.0, 0.0))
    (interface,), contacts = placed(assembly)
    assert contacts.count == 12
    meshed = interface.blocks.index(1)
    own, nodes = carried(assembly, contacts, meshed)
    np.testing.assert_allclose(own @ nodes, contacts.points[:, meshed], atol=1e-13)
    assert np.diff(contacts.means[1 - meshed :: 2].indptr).max() == 0


def test_rigid_pairs_have_corners():
    assembly = pair(box_shape("a", (1.0,) * 3, low=(0, 0, -1.0)), box_shape("b", (1.0,) * 3), 0.0, (0.0, 0.0))
    _, contacts = placed(assembly)
    assert contacts.count == 4
    assert contacts.means is None


@pytest.mark.parametrize(
    ("lower", "upper", "how", "rule"),
    [
        ((3, 3, 3), (3, 3, 3), {}, "nodes"),
        ((2, 2, 2), (2, 2, 2), {"order": (2, 2)}, "nodes"),
        ((2, 2, 2), (2, 2, 2), {"shift": (0.5, 0.0)}, "nodes"),  # whole facets on whole facets
        ((2, 2, 2), (2, 2, 2), {"shift": (0.3, 0.0)}, "weighted"),  # cut
        ((2, 2, 2), (2, 2, 2), {"order": (1, 2)}, "nodes"),  # the linear nodes are among the others
        ((2, 2, 2), (4, 4, 4), {}, "nodes"),  # of one mesh among those of the other
        ((2, 3, 3), (3, 3, 3), {}, "weighted"),
        ((2, 2, 2), (4, 4, 4), {"order": (2, 1)}, "weighted"),  # vertices of one among those of the other
        (None, (3, 3, 3), {"shift": (0.3, 0.0)}, "weighted"),  # 0.2 % of a pressure would be misplaced
        (None, (2, 2, 2), {"shift": (0.3, 0.0)}, "weighted"),
        ((3, 3, 3), (3, 3, 2), {"triangles": (True, False)}, "weighted"),  # the same vertices, other facets
        (None, None, {}, "corners"),
    ],
)
def test_auto_has_nodes_where_they_are_exact(lower, upper, how, rule):
    assembly = meshed_pair(lower, upper, **how)
    with gathered() as told:
        (_, chosen_one), (_, expected) = placed(assembly, "auto", tell=True), placed(assembly, rule)
    assert np.array_equal(chosen_one.points, expected.points)
    assert told == []


def test_congruent_patches_are_placed_once_and_alike():
    """The bricks of a wall: each contact where a patch of its own would have it, whichever side is finer."""
    bricks = wall(3, 3, cells=(4, 2, 2))
    other = box_shape("other", (0.5, 0.25, 0.25), (5, 3, 2))
    blocks = tuple(
        replace(block, shape=3) if block.shape == 0 and number % 2 else block
        for number, block in enumerate(bricks.blocks)
    )
    assembly = replace(bricks, shapes=(*bricks.shapes, other), blocks=blocks)
    interfaces = detect(assembly)
    for name in ("nodes", "weighted"):
        together = place(assembly, interfaces, [Rule(name)] * len(interfaces))
        for number, interface in enumerate(interfaces):
            alone = place(assembly, [interface], [Rule(name)])
            own = together.interface == number
            assert np.array_equal(together.blocks[own], alone.blocks)
            np.testing.assert_allclose(together.points[own], alone.points, atol=1e-12)
            np.testing.assert_allclose(together.area[own], alone.area, rtol=1e-11)


@pytest.mark.parametrize("name", ["auto", "nodes", "weighted"])
def test_unlike_joints_are_placed_in_batches_as_alone(name, monkeypatch):
    """Bricks of two meshes, each shifted along its course by a length of its own, on a rigid floor."""
    bricks = wall(4, 3, cells=(4, 2, 2))
    other = box_shape("other", (0.5, 0.25, 0.25), (5, 3, 2))
    shifts = np.random.default_rng(3).uniform(-0.05, 0.05, len(bricks.blocks))
    blocks = tuple(
        replace(
            block,
            shape=3 if block.shape == 0 and number % 2 else block.shape,
            pose=replace(block.pose, translation=np.add(block.pose.translation, [shift, 0, 0])),
        )
        for number, (block, shift) in enumerate(zip(bricks.blocks, shifts, strict=True))
    )
    assembly = replace(bricks, shapes=(*bricks.shapes, other), blocks=blocks)
    interfaces = detect(assembly)
    monkeypatch.setattr(pieces, "TOGETHER", 1000)
    together = place(assembly, interfaces, [Rule(name)] * len(interfaces))
    for number, interface in enumerate(interfaces):
        alone = place(assembly, [interface], [Rule(name)])
        own = together.interface == number
        assert np.array_equal(together.blocks[own], alone.blocks)
        assert np.array_equal(together.facets[own], alone.facets)
        np.testing.assert_allclose(together.points[own], alone.points, atol=1e-14)
        np.testing.assert_allclose(together.area[own], alone.area, rtol=1e-12)
        if alone.means is not None:
            means = together.means[np.repeat(own, 2)].toarray()[:, : alone.means.shape[1]]
            np.testing.assert_allclose(means, alone.means.toarray(), atol=1e-14)


def test_contacts_of_both_kinds_are_chosen_and_joined():
    assembly = meshed_pair((2, 2, 2), (3, 3, 3))
    (weighted, points) = (placed(assembly, name) for name in ("weighted", "nodes"))
    interfaces, both = joined(points, weighted)
    count = points[1].count
    assert np.diff(both.means.indptr)[: 2 * count].max() == 0
    assert (both.means[2 * count :] != weighted[1].means).nnz == 0
    _, again = chosen(interfaces, both, np.array([False, True]))
    assert (again.means != weighted[1].means).nnz == 0
    assert joined(points, points)[1].means is None


@pytest.mark.parametrize("order", [2, 3, 5, 9])
def test_gauss_points_of_an_order_integrate_its_polynomials(order):
    """x^i y^j over a triangle, a parallelogram and a trapezium, i + j = 2 order − 2."""
    shapes = (
        (np.array([[0.0, 0], [1, 0], [0, 1]]), 1, beta),
        (np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]]), 1, lambda i, j: 1 / ((i + 1) * (j + 1))),
        (np.array([[1.0, 0], [2, 0], [0, 2], [0, 1]]), 2, lambda i, j: (2 ** (i + j + 2) - 1) * beta(i, j)),
    )
    rules = *gauss_rule(order), *triangle_rule(order)
    for (polygon, triangles, exact), quadrilaterals in product(shapes, (False, True)):
        points, weight, _ = on_polygon(polygon, polygon[None], polygon[None], *rules, 1, quadrilaterals)
        assert len(points) == (1 if quadrilaterals else triangles) * order**2
        for i in range(2 * order - 1):
            j = 2 * order - 2 - i
            assert weight @ (points[:, 0] ** i * points[:, 1] ** j) == pytest.approx(exact(i, j), rel=1e-12)


def beta(i, j):
    """∫ x^i y^j over the unit triangle: i! j! / (i + j + 2)!."""
    return factorial(i) * factorial(j) / factorial(i + j + 2)
