"""Weighted contacts on round faces: one patch of all facets, with exact forces and moments on both sides."""

import numpy as np
import pytest

from masonry_fem.contact.detection import detect
from masonry_fem.contact.place import place
from masonry_fem.contact.placement import Rule
from masonry_fem.contact.placement.parts.patch import Patch
from masonry_fem.contact.placement.parts.pieces import Pieces, order_of
from masonry_fem.contact.surface import surfaces_of
from masonry_fem.contact.update import chosen, joined, moved, returned
from masonry_fem.records.remark import gathered
from tests.contact.blocks import rings, turning, turning_2d

CASES = {
    "plane": ((12, 2), (8, 2), {}),
    "plane, finer outside": ((8, 2), (12, 2), {}),
    "quadratic": ((6, 2), (9, 2), {"order": 2}),
    "vault": ((12, 3, 1), (8, 2, 1), {}),
    "vault, shifted": ((8, 2, 1), (12, 3, 1), {"shift": (0.0, 0.35, 0.0)}),
    "triangles": ((12, 3, 1), (8, 2, 1), {"triangles": True}),
}


def placed(assembly, name="weighted", tell=False):
    interfaces = detect(assembly, reach=0.05, angle=30.0)
    return interfaces, place(assembly, interfaces, [Rule(name)] * len(interfaces), tell=tell)


@pytest.fixture(params=CASES.values(), ids=CASES)
def case(request):
    inner, outer, how = request.param
    assembly = rings(inner, outer, **how)
    return assembly, *placed(assembly)


def test_areas_and_first_moments(case):
    """Rows sum to one, points are where the nodes are in the mean, areas sum to those of the interfaces."""
    assembly, interfaces, contacts = case
    assert contacts.area.sum() == pytest.approx(sum(one.area for one in interfaces), rel=1e-12)
    assert contacts.area.min() > 0
    for side in (0, 1):
        block = assembly.blocks[contacts.blocks[0, side]]
        nodes = block.pose.to_world(assembly.shapes[block.shape].mesh.points)
        own = contacts.means[side::2, : len(nodes)]
        np.testing.assert_allclose(own.sum(axis=1), 1, atol=1e-12)
        np.testing.assert_allclose(own @ nodes, contacts.points[:, side], atol=1e-12)


def test_a_uniform_traction_gives_both_meshes_their_forces(case):
    """Of one direction everywhere: ∫ N for each node, over all patches."""
    assembly, interfaces, contacts = case
    surfaces = surfaces_of(assembly)
    _, points = placed(assembly, "gauss")
    frames = {number: points.frame[points.interface == number][0] for number in range(len(interfaces))}
    patches = [Patch.of(assembly, surfaces, one, frames[k]) for k, one in enumerate(interfaces)]
    pieces = Pieces.of([patches], order_of(patches))
    for side in (0, 1):
        cover, mesh = pieces.cover(side), patches[0].sides[side].mesh
        share = pieces.weight[:, None] * pieces.functions(side)
        nodes = cover.node[cover.rows[pieces.facets[pieces.piece, side]]]
        exact = np.bincount(nodes.ravel(), share.ravel(), len(mesh.points))
        own = contacts.means[side::2, : len(mesh.points)]
        np.testing.assert_allclose(own.T @ contacts.area, exact, atol=1e-13)


@pytest.mark.parametrize("name", ["plane", "plane, finer outside", "vault", "triangles"])
def test_one_contact_for_each_vertex_of_the_finer_face(name):
    inner, outer, how = CASES[name]
    _, contacts = placed(rings(inner, outer, **how))
    assert contacts.count == np.prod([max(pair) + 1 for pair in zip(inner[:-1], outer[:-1], strict=True)])


def test_normals_are_radial_and_faces_touch(case, request):
    """The mean normal of the facets about a vertex; the gap is that of the arcs, some hundredths of facets'.

    At the ends it is that of half a facet. Triangles tell how round a narrow face is to a seventh.
    """
    within = 0.15 if "triangles" in request.node.name else 0.04
    _, _, contacts = case
    middle = contacts.points.mean(axis=1)[:, [0, -1]]
    radial = middle / np.linalg.norm(middle, axis=1)[:, None]
    assert np.abs((contacts.frame[:, 0][:, [0, -1]] * radial).sum(axis=1)).min() > np.cos(np.radians(5.8))
    apart = np.abs(np.einsum("cd,cd->c", contacts.points[:, 0] - contacts.points[:, 1], contacts.frame[:, 0]))
    if "quadratic" not in request.node.name:  # which has its nodes on the arcs
        assert apart.max() > 5e-4
        assert np.abs(contacts.gap).max() < within * apart.max()
    assert np.abs(contacts.gap).max() < 6e-4


def test_the_gap_follows_the_arcs_by_the_fourth_power():
    largest = [np.abs(placed(rings((3 * n // 2, 2), (n, 2)))[1].gap).max() for n in (8, 16, 32)]
    assert np.log2(largest[0] / largest[1]) > 3.8
    assert np.log2(largest[1] / largest[2]) > 3.8


@pytest.mark.parametrize("d", [2, 3])
def test_it_does_not_depend_on_where_the_bodies_stand(d):
    assembly = rings(*(((12, 2), (8, 2)) if d == 2 else ((12, 3, 1), (8, 2, 1))))
    turn = turning(0.7) if d == 3 else turning_2d(0.7)
    rotation, shift = np.tile(turn, (2, 1, 1)), np.tile(np.arange(1.0, d + 1), (2, 1))
    _, contacts = placed(assembly)
    _, elsewhere = placed(moved(assembly, rotation, shift))
    back = returned(elsewhere, rotation, shift)
    order, other = (np.lexsort(one.points[:, 0].round(8).T) for one in (contacts, back))
    np.testing.assert_allclose(back.points[other], contacts.points[order], atol=1e-12)
    np.testing.assert_allclose(back.gap[other], contacts.gap[order], atol=1e-12)
    np.testing.assert_allclose(back.area[other], contacts.area[order], rtol=1e-10)


def test_where_facets_coincide_contacts_are_at_the_nodes():
    assembly = rings((8, 2), (8, 2))
    (_, weighted), (_, nodes), (_, auto) = (placed(assembly, name) for name in ("weighted", "nodes", "auto"))
    assert auto.means is None
    assert np.array_equal(auto.points, nodes.points)
    at, of = np.unique(nodes.points[:, 0].round(9), axis=0, return_inverse=True)
    order = np.lexsort(weighted.points[:, 0].round(9).T[::-1])
    np.testing.assert_allclose(weighted.points[order, 0], at, atol=1e-9)
    np.testing.assert_allclose(weighted.area[order], np.bincount(of, nodes.area), rtol=1e-9)
    assert (np.diff(weighted.means.indptr) == 1).all()
    assert np.abs(weighted.gap).max() < 1e-12


def test_auto_takes_the_whole_face():
    assembly = rings((12, 2), (8, 2))
    with gathered() as told:
        _, contacts = placed(assembly, "auto", tell=True)
    assert contacts.count == 13
    assert [one.code for one in told] == ["round_faces"]


def test_contacts_stand_in_order_of_their_interfaces_and_can_be_chosen():
    interfaces, contacts = placed(rings((12, 2), (8, 2)))
    assert (np.diff(contacts.interface) >= 0).all()
    keep = np.arange(len(interfaces)) < 5
    some, own = chosen(interfaces, contacts, keep)
    rows = np.flatnonzero(contacts.interface < 5)
    assert np.array_equal(own.bulge, contacts.bulge[rows])
    again = joined((some, own), (some, own))[1]
    assert np.array_equal(again.bulge, np.tile(own.bulge, 2))
    assert (again.means[: own.means.shape[0]] != own.means).nnz == 0


def test_faces_of_two_labels_are_two_faces():
    """Names part a round face as a kink does."""
    assembly = rings((12, 2), (8, 2))
    interfaces = detect(assembly, reach=0.05, angle=30.0)
    rules = [Rule("weighted") if number % 2 else Rule("nodes") for number in range(len(interfaces))]
    contacts = place(assembly, interfaces, rules)
    total = np.bincount(contacts.interface % 2, contacts.area)
    expected = np.bincount(np.arange(len(interfaces)) % 2, [one.area for one in interfaces])
    np.testing.assert_allclose(total, expected, rtol=1e-12)


@pytest.mark.parametrize("outer", [(13, 2), (24, 2)], ids=["nearly alike", "one divides the other"])
def test_auto_is_weighted_where_vertices_face_facets(outer):
    """Contacts at nodes had the right area on both sides, but gaps of what facets miss the arc by."""
    _, contacts = placed(rings((12, 2), outer), "auto")
    assert contacts.means is not None
    assert contacts.count == outer[0] + 1
    assert np.abs(contacts.gap).max() < 2e-4
