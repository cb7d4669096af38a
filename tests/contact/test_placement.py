"""Contact points: known counts, areas and first moments, consistent forces, identities."""

from dataclasses import replace

import numpy as np
import pytest

from masonry_fem.contact.clipping import polygon_area
from masonry_fem.contact.detection import detect
from masonry_fem.contact.interpolation import weights
from masonry_fem.contact.place import place
from masonry_fem.contact.placement import Rule, names, points_of
from masonry_fem.contact.placement.corners import _tributary as tributary
from masonry_fem.errors import ExtensionError, GeometryError
from masonry_fem.solid.assembly import Assembly, Block, Shape
from masonry_fem.solid.pose import Pose
from tests.contact.blocks import (
    arch,
    box_shape,
    grid_mesh,
    moved,
    pair,
    split_in_triangles,
    turning,
    turning_2d,
    wall,
)
from tests.contact.stones import prism


def placed(assembly, name, **how):
    interfaces = detect(assembly)
    return interfaces, place(assembly, interfaces, [Rule(name, **how)] * len(interfaces))


def meshed_pair(
    lower, upper, *, dimension=3, order=(1, 1), triangles=(False, False), shift=(0.0, 0.0), gap=0.0
):
    """Two unit boxes with any meshes, the upper shifted."""
    ends = ((0.0,) * (dimension - 1) + (-1.0,), (1.0,) * (dimension - 1) + (0.0,))
    shapes = [
        box_shape("lower", (1.0,) * dimension, lower, low=ends[0], order=order[0]),
        box_shape("upper", (1.0,) * dimension, upper, order=order[1]),
    ]
    shapes = [
        replace(shape, mesh=split_in_triangles(shape.mesh)) if cut else shape
        for shape, cut in zip(shapes, triangles, strict=True)
    ]
    return pair(*shapes, gap, shift)


def nodal_forces(assembly, contacts, side):
    """Nodal forces of a unit pressure carried by the contacts, over the nodes of one side's mesh."""
    block = assembly.blocks[contacts.blocks[0, side]]
    mesh = assembly.shapes[block.shape].mesh
    facets = contacts.facets[:, side]
    local = block.pose.to_shape(contacts.points[:, side])
    share = contacts.area[:, None] * weights(mesh, facets, local)
    total = np.zeros(len(mesh.points))
    np.add.at(total, mesh.facets[facets].ravel(), share.ravel())
    return total


def tensor_forces(cells, order):
    """Consistent nodal forces of a unit pressure on a unit square or line, sorted."""
    one = []
    for count in cells:
        line = np.zeros(order * count + 1)
        for cell in range(count):
            part = [1 / 2, 1 / 2] if order == 1 else [1 / 6, 4 / 6, 1 / 6]
            line[order * cell : order * cell + order + 1] += np.array(part) / count
        one.append(line)
    forces = one[0] if len(one) == 1 else np.multiply.outer(*one).ravel()
    return np.sort(forces)


# --- walls and arches -----------------------------------------------------------------------------


def test_low_wall_of_meshed_bricks_has_501_nodes():
    """A10.4: 22 bricks of 4×2×2 elements on a floor."""
    interfaces, contacts = placed(wall(4, 5, cells=(4, 2, 2)), "nodes")
    assert len(interfaces) == 53
    assert contacts.count == 501
    areas = np.bincount(contacts.interface, contacts.area)
    assert areas == pytest.approx([interface.area for interface in interfaces])
    assert contacts.area.min() > 0
    on_floor = contacts.blocks[:, 1] == 0
    assert on_floor.sum() == 60
    assert (contacts.facets[on_floor] >= 0).tolist() == [[True, False]] * 60


@pytest.mark.parametrize("name", names())
@pytest.mark.parametrize("dimension", [2, 3])
def test_areas_and_first_moments(name, dimension):
    cells = (4, 2, 2) if dimension == 3 else (4, 2)
    interfaces, contacts = placed(wall(3, 3, dimension, cells=cells), name)
    areas = np.bincount(contacts.interface, contacts.area)
    assert areas == pytest.approx([interface.area for interface in interfaces], rel=1e-12)
    moments = np.zeros((len(interfaces), dimension))
    np.add.at(moments, contacts.interface, contacts.area[:, None] * contacts.points[:, 0])
    centres = np.array([interface.polygon.mean(axis=0) for interface in interfaces])
    assert moments / areas[:, None] == pytest.approx(centres, abs=1e-12)


@pytest.mark.parametrize("name", names())
@pytest.mark.parametrize("dimension", [2, 3])
def test_rotated_copies_have_the_same_contacts(name, dimension):
    assembly = wall(2, 3, dimension, cells=(4, 2, 2)[:dimension])
    turn = turning(1.2) if dimension == 3 else turning_2d(1.2)
    shift = np.array([3.0, 5.0, -2.0])[:dimension]
    _, here = placed(assembly, name)
    _, there = placed(moved(assembly, turn, shift), name)
    assert np.array_equal(here.facets, there.facets)
    assert there.points == pytest.approx(here.points @ turn.T + shift, abs=1e-10)
    assert there.frame[:, 0] == pytest.approx(here.frame[:, 0] @ turn.T, abs=1e-12)
    assert there.area == pytest.approx(here.area)
    assert there.gap == pytest.approx(here.gap, abs=1e-12)


def test_contacts_of_an_arch_and_their_frames():
    interfaces, contacts = placed(arch(9, 3), "corners", inset=0.95)
    assert contacts.count == 4 * len(interfaces)
    assert contacts.frame @ contacts.frame.transpose(0, 2, 1) == pytest.approx(
        np.broadcast_to(np.eye(3), (contacts.count, 3, 3)), abs=1e-12
    )
    assert np.linalg.det(contacts.frame) == pytest.approx(1)
    radii = np.linalg.norm(contacts.points[:, 0][:, [0, 2]], axis=1)
    assert np.unique(radii.round(9)) == pytest.approx([1.1 - 0.095, 1.1 + 0.095])


# --- corners --------------------------------------------------------------------------------------


@pytest.mark.parametrize("inset", [1.0, 0.75])
def test_corners_of_a_rectangle(inset):
    _, contacts = placed(meshed_pair(None, None, shift=(0.4, 0.5)), "corners", inset=inset)
    assert contacts.area == pytest.approx(0.6 * 0.5 / 4)
    assert np.abs(contacts.points[:, 0] - [0.7, 0.75, 0.0]) == pytest.approx(
        np.tile([0.3 * inset, 0.25 * inset, 0.0], (4, 1))
    )


@pytest.mark.parametrize("origin", [(0.0, 0.0), (10.0, -5.0)])
def test_tributary_areas_are_kites_about_the_centroid(origin):
    """A trapezium 4 m wide, 3 m high on one side and 1 m on the other: its centroid is at (5/3, 13/12)."""
    polygon = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 1.0], [0.0, 3.0]]) + origin
    centroid, area = tributary(polygon)
    assert centroid - origin == pytest.approx([5 / 3, 13 / 12], rel=1e-12)
    middle = (polygon + np.roll(polygon, -1, axis=0)) / 2
    kites = [
        polygon_area(np.array([corner, after, centroid, before]))
        for corner, after, before in zip(polygon, middle, np.roll(middle, 1, axis=0), strict=True)
    ]
    assert area == pytest.approx(kites, rel=1e-12)
    assert area.sum() == pytest.approx(8.0, rel=1e-12)


def test_corners_in_the_plane():
    _, contacts = placed(meshed_pair(None, None, dimension=2, shift=(0.5,)), "corners", inset=0.5)
    assert sorted(contacts.points[:, 0, 0]) == pytest.approx([0.625, 0.875])
    assert contacts.area == pytest.approx(0.25)


# --- gauss ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("order", [(1, 1), (1, 2), (2, 2)])
@pytest.mark.parametrize("cells", [((2, 3, 1), (3, 2, 1)), ((5, 1, 1), (7, 2, 1))])
def test_uniform_pressure_on_meshes_that_do_not_match(cells, order):
    assembly = meshed_pair(*cells, order=order)
    _, contacts = placed(assembly, "gauss")
    for side, (own, degree) in enumerate(zip(cells[::-1], order[::-1], strict=True)):
        forces = np.sort(nodal_forces(assembly, contacts, side))
        expected = tensor_forces(own[:2], degree)
        assert forces[-len(expected) :] == pytest.approx(expected, abs=1e-13)
        assert forces[: -len(expected)] == pytest.approx(0, abs=1e-13)


@pytest.mark.parametrize("order", [(1, 1), (1, 2), (2, 2)])
def test_uniform_pressure_in_the_plane(order):
    assembly = meshed_pair((2, 1), (3, 1), dimension=2, order=order)
    _, contacts = placed(assembly, "gauss")
    for side, cells in ((0, (3,)), (1, (2,))):
        degree = order[1 - side]
        forces = np.sort(nodal_forces(assembly, contacts, side))
        expected = tensor_forces(cells, degree)
        assert forces[-len(expected) :] == pytest.approx(expected, abs=1e-13)


def test_uniform_pressure_on_triangles_against_quadrilaterals():
    assembly = meshed_pair((3, 2, 1), (2, 2, 1), triangles=(True, False))
    _, contacts = placed(assembly, "gauss")
    upper = np.sort(nodal_forces(assembly, contacts, 0))
    assert upper[-9:] == pytest.approx(tensor_forces((2, 2), 1), abs=1e-13)
    mesh = assembly.shapes[0].mesh
    expected = np.zeros(len(mesh.points))
    np.add.at(expected, mesh.facets[mesh.facet_face == 5].ravel(), 1 / 12 / 3)
    assert nodal_forces(assembly, contacts, 1) == pytest.approx(expected, abs=1e-13)


def test_products_of_bilinear_functions_are_exact():
    """∫ x²y² over the joint: what mortar matrices of both sides need."""
    _, contacts = placed(meshed_pair((2, 3, 1), (3, 2, 1)), "gauss")
    x, y = contacts.points[:, 0, 0], contacts.points[:, 0, 1]
    assert contacts.area @ (x**2 * y**2) == pytest.approx(1 / 9, rel=1e-13)


def test_meshes_turned_against_each_other():
    """Element edges that are not parallel: areas and first moments stay exact."""
    lower = box_shape("lower", (4.0, 4.0, 1.0), (5, 3, 1), low=(-2.0, -2.0, -1.0))
    upper = box_shape("upper", (1.0, 1.0, 1.0), (3, 2, 1), low=(-0.5, -0.5, 0.0))
    turn = turning(0.4, (0, 0, 1))
    blocks = (Block("lower", 0, Pose.identity(3)), Block("upper", 1, Pose(turn, np.array([0.3, 0.1, 0.0]))))
    assembly = Assembly(3, (lower, upper), blocks)
    _, contacts = placed(assembly, "gauss")
    assert contacts.area.sum() == pytest.approx(1)
    assert contacts.area @ contacts.points[:, 0] == pytest.approx([0.3, 0.1, 0.0], abs=1e-12)
    upper_forces = np.sort(nodal_forces(assembly, contacts, 0))
    assert upper_forces[-12:] == pytest.approx(tensor_forces((3, 2), 1), abs=1e-13)


@pytest.mark.parametrize("density", [1, 3])
def test_density_where_nothing_is_meshed(density):
    _, contacts = placed(meshed_pair(None, None, shift=(0.5, 0.0)), "gauss", density=density)
    assert contacts.count == 4 * density**2
    assert contacts.area @ contacts.points[:, 0, 0] ** 2 == pytest.approx((1 - 0.5**3) / 3)
    assert (contacts.facets == -1).all()


def test_density_on_a_polygon_of_triangles():
    upper = box_shape("upper", (1.0, 1.0, 1.0), low=(-0.5, -0.5, 0.0))
    lower = box_shape("lower", (1.0, 1.0, 1.0), low=(-0.5, -0.5, -1.0))
    turn = turning(np.pi / 4, (0, 0, 1))
    blocks = (Block("lower", 0, Pose.identity(3)), Block("upper", 1, Pose(turn, np.zeros(3))))
    interfaces, contacts = placed(Assembly(3, (lower, upper), blocks), "gauss", density=2)
    assert len(interfaces[0].polygon) == 8
    assert contacts.count == 6 * 4 * 3
    assert contacts.area.sum() == pytest.approx(2 * (np.sqrt(2) - 1))
    assert contacts.area @ contacts.points[:, 0] == pytest.approx([0, 0, 0], abs=1e-14)


# --- nodes ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("lower", "upper", "finer"), [((2, 2, 1), (3, 3, 1), "upper"), ((4, 4, 1), (3, 3, 1), "lower")]
)
def test_nodes_of_the_finer_side(lower, upper, finer):
    assembly = meshed_pair(lower, upper, gap=1e-4)
    _, contacts = placed(assembly, "nodes")
    candidate = 1 if finer == "upper" else 0
    assert (contacts.blocks == [candidate, 1 - candidate]).all()
    assert contacts.frame[:, 0] == pytest.approx(
        np.tile([0, 0, 1.0 if candidate else -1.0], (contacts.count, 1))
    )
    assert contacts.gap == pytest.approx(1e-4)
    assert contacts.points[:, candidate ^ 1, 2] == pytest.approx(1e-4)
    cells = upper if candidate else lower
    assert contacts.count == (cells[0] + 1) * (cells[1] + 1)
    assert np.sort(contacts.area) == pytest.approx(tensor_forces(cells[:2], 1))


def test_nodes_of_quadratic_facets_carry_their_integrals():
    _, contacts = placed(meshed_pair(None, (2, 1, 1), order=(1, 2)), "nodes")
    assert contacts.count == 15
    assert np.sort(contacts.area) == pytest.approx(tensor_forces((2, 1), 2))


def test_nodes_of_a_partial_overlap_share_all_of_the_area():
    _, contacts = placed(meshed_pair((1, 1, 1), (4, 4, 1), shift=(0.6, 0.3)), "nodes")
    # nodes at x = .6, .85 and y = .3, .55, .8; those beyond stand at the edges x = 1 and y = 1
    grid = np.array([[x, y] for x in (0.6, 0.85, 1.0) for y in (0.3, 0.55, 0.8, 1.0)])
    found = contacts.points[:, 0, :2]
    assert found[np.lexsort(found.T[::-1])] == pytest.approx(grid)
    # tributary lengths: linear shape functions over [.6, 1] and [.3, 1], what lies beyond at the edge
    along_x, along_y = [0.125, 0.125 + 0.105, 0.045], [0.125, 0.25, 0.125 + 0.12, 0.08]
    areas = np.outer(along_x, along_y).ravel()
    assert contacts.area[np.lexsort(found.T[::-1])] == pytest.approx(areas)


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("shift", [0.0024, 0.4, 0.9])
def test_contact_ends_where_the_faces_do(dimension, shift):
    """A block that overhangs, its mesh nowhere near the edge below: 2 mm or nearly all of it."""
    cells = (2,) * dimension
    _, contacts = placed(
        meshed_pair(cells, cells, dimension=dimension, shift=(shift, 0.0)[: dimension - 1]), "nodes"
    )
    x = contacts.points[:, 0, 0]
    assert x.min() == pytest.approx(shift)
    assert x.max() == pytest.approx(1.0)
    assert contacts.area.sum() == pytest.approx(1.0 - shift)
    assert contacts.area.min() > 0


def test_a_corner_in_the_middle_of_a_facet_gets_a_point():
    """One facet on a smaller turned square: its corners bear, wherever the facet's nodes come to stand."""
    lower = box_shape("lower", (0.5, 0.5, 1.0), low=(-0.25, -0.25, -1.0))
    upper = box_shape("upper", (2.0, 2.0, 1.0), (2, 2, 1), low=(-1.0, -1.0, 0.0))
    shapes, quarter = pair(lower, upper), turning(np.pi / 4, axis=(0, 0, 1))
    posed = [replace(shapes.blocks[0], pose=Pose(quarter, np.zeros(3))), shapes.blocks[1]]
    _, contacts = placed(replace(shapes, blocks=tuple(posed)), "nodes")
    corners = 0.25 * np.sqrt(2.0) * np.array([[1, 0], [0, 1], [-1, 0], [0, -1]])
    away = np.linalg.norm(contacts.points[:, 0, None, :2] - corners, axis=2)
    assert away.min(axis=0) == pytest.approx(0.0, abs=1e-9)
    assert contacts.area.sum() == pytest.approx(0.25)


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
def test_every_corner_of_a_face_with_many_gets_a_share_of_its_neighbour(scale):
    """Twelve corners under a mesh of nine nodes: four stand at corners, four between two, one inside."""
    angles = np.radians(30.0 * np.arange(12))
    corners = 0.3 * scale * np.column_stack([np.cos(angles), np.sin(angles)])
    lower = Shape("lower", prism(corners, scale))
    size = (2 * scale, 2 * scale, scale)
    upper = box_shape("upper", size, (2, 2, 1), low=(-scale, -scale, 0.0))
    blocks = (Block("lower", 0, Pose.at(0.0, 0.0, -scale)), Block("upper", 1, Pose.identity(3)))
    _, contacts = placed(Assembly(3, (lower, upper), blocks), "nodes")
    assert contacts.count == 17
    away = np.linalg.norm(contacts.points[:, 0, None, :2] - corners, axis=2)
    assert away.min(axis=0) == pytest.approx(0.0, abs=1e-9 * scale)
    assert contacts.area.sum() == pytest.approx(3 * (0.3 * scale) ** 2, rel=1e-12)
    assert contacts.area @ contacts.points[:, 0, :2] == pytest.approx(0.0, abs=1e-3 * scale**3)
    assert contacts.area.min() > 0


def test_nodes_where_none_lies_inside_fall_back_to_corners():
    lower = box_shape("lower", (0.2, 0.2, 1.0), low=(0.4, 0.4, -1.0))
    upper = box_shape("upper", (1.0, 1.0, 1.0), (1, 1, 1))
    assembly = pair(lower, upper)
    _, contacts = placed(assembly, "nodes")
    assert contacts.count == 4
    assert (contacts.facets[:, 0] >= 0).all()


def test_nodes_without_a_mesh_is_refused():
    with pytest.raises(GeometryError, match=r"blocks \(1, 0\).*neither has a mesh"):
        placed(meshed_pair(None, None), "nodes")


# --- facets, gaps, identities ---------------------------------------------------------------------


@pytest.mark.parametrize("name", sorted({*names()} - {"auto", "navier", "weighted"}))
def test_facets_hold_their_points(name):
    assembly = meshed_pair((3, 4, 1), (5, 2, 1), shift=(0.27, -0.41), gap=2e-4)
    _, contacts = placed(assembly, name)
    for side in (0, 1):
        for block in (0, 1):
            own = contacts.blocks[:, side] == block
            if own.any():
                stone = assembly.blocks[block]
                mesh = assembly.shapes[stone.shape].mesh
                local = stone.pose.to_shape(contacts.points[own, side])
                found = weights(mesh, contacts.facets[own, side], local)
                assert found.min() > -1e-9
                there = np.einsum("kn,knd->kd", found, mesh.points[mesh.facets[contacts.facets[own, side]]])
                assert there == pytest.approx(local, abs=1e-12)
    jump = contacts.points[:, 0] - contacts.points[:, 1]
    assert jump == pytest.approx(contacts.gap[:, None] * contacts.frame[:, 0], abs=1e-15)
    assert contacts.gap == pytest.approx(2e-4)


def test_points_of_a_tilted_block_stay_on_both_faces():
    tilt = 0.1
    floor = box_shape("floor", (10.0, 1.0), low=(-5.0, -1.0))
    block = box_shape("block", (0.5, 2.0))
    blocks = (Block("floor", 0, Pose.identity(2)), Block("block", 1, Pose(turning_2d(tilt), np.zeros(2))))
    assembly = Assembly(2, (floor, block), blocks)
    contacts = place(assembly, detect(assembly, reach=0.1, angle=12), [Rule("corners")])
    local = blocks[1].pose.to_shape(contacts.points[:, 0])
    assert sorted(local.round(12).tolist()) == [[0.0, 0.0], [0.5, 0.0]]
    assert contacts.points[:, 1, 1] == pytest.approx(0, abs=1e-15)
    assert sorted(contacts.gap) == pytest.approx([0.0, 0.5 * np.sin(tilt)])


def test_block_on_its_corner_has_one_contact():
    floor = box_shape("floor", (10.0, 1.0), low=(-5.0, -1.0))
    square = box_shape("square", (1.0, 1.0), (2, 2))
    blocks = (
        Block("floor", 0, Pose.identity(2)),
        Block("square", 1, Pose(turning_2d(np.pi / 4), np.zeros(2))),
    )
    for name in names():
        _, contacts = placed(Assembly(2, (floor, square), blocks), name)
        assert contacts.count == 1
        assert contacts.points[0] == pytest.approx(np.zeros((2, 2)), abs=1e-15)
        assert contacts.facets[0, 0] >= 0


def test_same_contacts_twice():
    first, second = (placed(wall(3, 3, cells=(4, 2, 2)), "nodes")[1] for _ in range(2))
    for name in ("points", "frame", "area", "gap"):
        assert getattr(first, name).tobytes() == getattr(second, name).tobytes()


def test_no_interfaces_no_contacts():
    contacts = place(Assembly(3, (box_shape("cube", (1.0, 1.0, 1.0)),), ()), (), [])
    assert contacts.count == 0
    assert contacts.dimension == 3


def test_mesh_that_leaves_a_hole_is_named():
    assembly = meshed_pair(None, (2, 2, 1))
    mesh = assembly.shapes[1].mesh
    keep = np.arange(len(mesh.facets)) != np.flatnonzero(mesh.facet_face == 4)[0]
    holed = Shape(
        "upper",
        assembly.shapes[1].solid,
        replace(mesh, facets=mesh.facets[keep], facet_face=mesh.facet_face[keep]),
    )
    with pytest.raises(GeometryError, match=r"'upper'.*cover 0\.75"):
        placed(replace(assembly, shapes=(assembly.shapes[0], holed)), "gauss")


@pytest.mark.parametrize(
    ("rule", "named"),
    [
        (Rule("mortar"), "'mortar', expected one of"),
        (Rule(inset=1.5), "inset is 1.5"),
        (Rule(density=0), "density is 0"),
    ],
)
def test_rules_out_of_range(rule, named):
    assembly = meshed_pair(None, None)
    with pytest.raises(GeometryError, match=named):
        place(assembly, detect(assembly), [rule])


def test_mesh_helper_has_outward_facets():
    for order in (1, 2):
        mesh = grid_mesh((0, 0, 0), (1, 2, 3), (2, 1, 3), order=order)
        corners = mesh.points[mesh.facets[:, :4]]
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        outward = np.eye(3)[mesh.facet_face // 2] * (2 * (mesh.facet_face % 2) - 1)[:, None]
        assert normal / np.linalg.norm(normal, axis=1)[:, None] == pytest.approx(outward)


@pytest.mark.parametrize(
    ("made", "sentence"),
    [
        (lambda spots: (spots.points, spots.area), r"'corners' gives a tuple, expected Spots; .*facets_at"),
        (
            lambda spots: replace(spots, area=spots.area[:1]),
            r"shapes .*, expected \(\(4, 2\), \(4,\), \(4, 2\)\)",
        ),
        (
            lambda spots: replace(spots, area=1.1 * spots.area),
            r"'corners' gives areas that sum to .* on interface 0, expected .*patch\.interface\.area",
        ),
    ],
)
def test_what_a_rule_gives_back_is_checked(made, sentence, monkeypatch):
    real = points_of("corners")
    monkeypatch.setattr(
        "masonry_fem.contact.joint_points.points_of", lambda name: lambda *how: made(real(*how))
    )
    with pytest.raises(ExtensionError, match=sentence):
        placed(wall(1, 1), "corners")
