"""Field files: what VTK and meshio read is what was given."""

import xml.etree.ElementTree as ET
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest

from masonry_fem.analyses.run import run
from masonry_fem.output.asked.fields import FieldFiles
from masonry_fem.output.fields import cell_arrays, contact_arrays, point_arrays
from masonry_fem.output.grid import (
    HEXAHEDRON,
    POLYGON,
    POLYHEDRON,
    PYRAMID,
    TETRA,
    VTK_TYPE,
    grid_of,
    polygon_of,
    standard_cell,
    three,
)
from masonry_fem.output.vtu import with_nan, write_points, write_vtu
from masonry_fem.scene import loads
from masonry_fem.solid.assembly import Assembly, Block, Shape
from masonry_fem.solid.polytope import Polytope
from masonry_fem.solid.pose import Pose
from tests.output.conftest import FakeGroup

pv = pytest.importorskip("pyvista")
meshio = pytest.importorskip("meshio")


def test_vtk_reads_back_the_fields(elastic, tmp_path):
    model, state = elastic
    grid = grid_of(model)
    nodal, cells = point_arrays(grid, model, state), cell_arrays(grid, model, state)
    write_vtu(tmp_path / "blocks.vtu", grid, nodal, cells)
    read = pv.read(tmp_path / "blocks.vtu")
    np.testing.assert_array_equal(read.points, grid.points)
    np.testing.assert_array_equal(read.celltypes, grid.types)
    with_nan(read.point_data)
    with_nan(read.cell_data)
    for name, values in nodal.items():
        np.testing.assert_array_equal(read.point_data[name], values, err_msg=name)
    for name, values in cells.items():
        np.testing.assert_array_equal(read.cell_data[name], values, err_msg=name)
    assert read.point_data["displacement"].shape[1] == 3


def test_cells_keep_their_size(elastic, tmp_path):
    model, _ = elastic
    grid = grid_of(model)
    write_vtu(tmp_path / "blocks.vtu", grid, {}, {"block": grid.cell_block})
    read = pv.read(tmp_path / "blocks.vtu").compute_cell_sizes(length=False)
    measure = read["Volume"] if grid.dimension == 3 else read["Area"]
    per_block = np.bincount(read["block"], measure)
    solids = [model.assembly.solid(b).mass_properties().volume for b in range(len(per_block))]
    np.testing.assert_allclose(per_block, solids, rtol=1e-10)


def test_rigid_blocks_are_polytopes_without_stress(rigid, tmp_path):
    model, state = rigid
    grid = grid_of(model)
    assert set(grid.types) == {HEXAHEDRON if grid.dimension == 3 else POLYGON}
    write_vtu(tmp_path / "b.vtu", grid, point_arrays(grid, model, state), cell_arrays(grid, model, state))
    read = pv.read(tmp_path / "b.vtu")
    assert "stress" not in read.point_data
    assert read.n_cells == len(model.assembly.blocks)
    if grid.dimension == 3:
        assert all(read.get_cell(i).n_faces == 6 for i in range(read.n_cells))
        assert read.extract_cells([3]).bounds[5] - read.extract_cells([3]).bounds[4] == pytest.approx(0.15)


def test_every_element_has_a_vtk_type():
    from masonry_fem.solid.mesh import FACET_OF

    assert set(VTK_TYPE) == set(FACET_OF)


def test_polygon_is_chained_from_edges_in_any_order():
    loop = polygon_of([(3, 0), (1, 2), (0, 1), (2, 3)])
    assert list(loop) == [3, 0, 1, 2]


def test_contact_reactions_are_in_world_axes(elastic, tmp_path):
    model, state = elastic
    write_points(tmp_path / "c.vtu", three(state.points), contact_arrays(model, state))
    read = pv.read(tmp_path / "c.vtu")
    up = model.assembly.dimension - 1
    np.testing.assert_allclose(read["reaction"][:, up], state.reaction[:, 0])
    np.testing.assert_allclose(read["normal"][:, up], 1.0)
    total = read["traction"] * model.contacts.area[:, None]
    np.testing.assert_allclose(total, read["reaction"])
    assert list(read["status"]) == list(state.status)


def test_points_without_area_have_no_traction(elastic):
    from dataclasses import replace

    model, state = elastic
    area = model.contacts.area.copy()
    area[::3] = 0.0
    arrays = contact_arrays(replace(model, contacts=replace(model.contacts, area=area)), state)
    assert np.isfinite(arrays["traction"]).all()
    assert (arrays["traction"][::3] == 0).all()


def test_series_is_readable_after_each_step(elastic, state_at, report, tmp_path):
    model, _ = elastic
    files = FieldFiles(tmp_path)
    files.start(model)
    for index in (0, 4):
        files.record(model, state_at(model, index), report(index))
        reader = pv.get_reader(tmp_path / "blocks.pvd")
        assert reader.time_values[-1] == pytest.approx(0.1 * index)
    reader.set_active_time_value(0.4)
    step = reader.read()[0]
    assert step.n_points == len(grid_of(model).points)
    assert step.field_data["dimension"][0] == model.assembly.dimension
    assert [p.name for p in files.close({})] == ["blocks.pvd", "contacts.pvd"]
    assert len(ET.parse(tmp_path / "contacts.pvd").findall(".//DataSet")) == 2
    assert not list(tmp_path.rglob("*.part"))


@pytest.mark.parametrize("size", [1, 1 << 20, (1 << 20) + 8])
def test_long_arrays_survive_block_limits(size, tmp_path):
    data = np.random.default_rng(0).integers(0, 4, size, dtype=np.uint8)
    write_points(tmp_path / "p.vtu", np.zeros((1, 3)), {}, {"bytes": data})
    np.testing.assert_array_equal(read_twice(tmp_path / "p.vtu").field_data["bytes"], data)


def test_grid_for_pictures_is_the_one_in_the_files(elastic, rigid, tmp_path):
    from masonry_fem.output.scenery import pyvista_grid

    for model, _ in (elastic, rigid):
        grid = grid_of(model)
        write_vtu(tmp_path / "b.vtu", grid, {}, {})
        read, made = pv.read(tmp_path / "b.vtu"), pyvista_grid(grid)
        np.testing.assert_array_equal(made.points, read.points)
        np.testing.assert_array_equal(made.celltypes, read.celltypes)
        for i in range(read.n_cells):
            assert sorted(made.get_cell(i).point_ids) == sorted(read.get_cell(i).point_ids)
            assert made.get_cell(i).n_faces == read.get_cell(i).n_faces


# --- two readers -----------------------------------------------------------------------------


def texts(data, name):
    return bytes(data[name]).decode().splitlines()


def read_twice(path):
    """What VTK reads, once it is seen that meshio reads the same and that all of it is finite."""
    ours, other = pv.read(path), meshio.read(path)
    np.testing.assert_array_equal(other.points, ours.points)
    assert sum(len(block.data) for block in other.cells) == ours.n_cells
    nodes = [np.asarray(cell).ravel() for block in other.cells for cell in block.data]
    for at in range(ours.n_cells):
        np.testing.assert_array_equal(nodes[at], ours.get_cell(at).point_ids)
    assert set(other.point_data) == set(ours.point_data.keys())
    for name, values in other.point_data.items():
        np.testing.assert_array_equal(values, ours.point_data[name], err_msg=name)
        assert np.isfinite(values).all(), name
    assert set(other.cell_data) == set(ours.cell_data.keys())
    for name, parts in other.cell_data.items():
        np.testing.assert_array_equal(np.concatenate(parts), ours.cell_data[name], err_msg=name)
        assert np.isfinite(ours.cell_data[name]).all(), name
    assert set(other.field_data) == set(ours.field_data.keys())
    for name, values in other.field_data.items():
        np.testing.assert_array_equal(values, ours.field_data[name], err_msg=name)
    return ours


SCENE = """
dimension = {dimension}
fidelity = "{fidelity}"
mesh = {{ element = "{element}", size = 0.5 }}
materials = {{ lime = {{ density = 2400, young = "10 GPa", poisson = 0.2 }} }}
structures = [{{ kind = "stack", name = "pier", material = "lime", size = {size}, count = 2 }}]
loads = {{ gravity = {gravity} }}
output = {{ pictures = false, interfaces = true }}
{more}
"""


@pytest.mark.parametrize(
    ("fidelity", "element", "kinds"),
    [
        ("rigid", "P1", ({7}, {12})),
        ("elastic", "P1", ({5, 7}, {10, 12})),
        ("elastic", "P2", ({22, 7}, {24, 12})),
        ("elastic", "Q1", ({9, 7}, {12})),
        ("elastic", "Q2", ({28, 7}, {29, 12})),
    ],
)
@pytest.mark.parametrize("dimension", [2, 3])
def test_two_readers_agree_on_each_kind_of_element(dimension, fidelity, element, kinds, tmp_path):
    size, gravity = [1.0, 1.0, 0.5][3 - dimension :], [0.0] * (dimension - 1) + [-9.81]
    scene = SCENE.format(
        dimension=dimension, fidelity=fidelity, element=element, size=size, gravity=gravity, more=""
    )
    assert run(loads(scene), tmp_path).outcome == "equilibrium"
    blocks = read_twice(tmp_path / "fields" / "blocks_000001.vtu")
    assert set(blocks.celltypes) == kinds[dimension - 2]
    names = texts(blocks.field_data, "block_names")
    assert sorted(names)[:2] == ["pier.b1", "pier.b2"]
    assert texts(blocks.field_data, "material_names") == ["lime"]
    kind = np.array(texts(blocks.field_data, "fidelity_names"))[blocks.cell_data["fidelity"]]
    stones = np.isin(blocks.cell_data["block"], [names.index("pier.b1"), names.index("pier.b2")])
    assert (kind[stones] == fidelity).all()
    assert (kind[~stones] == "support").all()
    assert "velocity" not in blocks.point_data  # what statics has is no velocity
    if fidelity == "elastic":
        np.testing.assert_array_equal(blocks.cell_data["has_stress"], kind == "elastic")
        assert (blocks.cell_data["von_mises"][kind == "elastic"] > 0).all()
    contacts = read_twice(tmp_path / "fields" / "contacts_000001.vtu")
    assert texts(contacts.field_data, "block_names") == names
    assert texts(contacts.field_data, "status_names") == ["open", "stick", "slip", "bonded"]
    assert np.count_nonzero(contacts["status"] == 1) >= 4
    assert "relative_velocity" not in contacts.point_data
    faces = read_twice(tmp_path / "fields" / "interfaces_000001.vtu")
    assert texts(faces.field_data, "label_names") == ["bed"]
    assert (np.array(texts(faces.field_data, "status_names"))[faces["status"]] == "middle third").all()


def test_points_are_those_of_the_reference_in_all_files(tmp_path):
    """A stone on a slope slides: all that belongs to it moves by the same vector."""
    more = """
joints = [{ friction = 0.1 }]
analysis = { kind = "dynamics", step = 0.01, duration = 0.1 }
[[supports]]
on = "pier.b1"
"""
    scene = SCENE.format(
        dimension=2, fidelity="rigid", element="P1", size=[1.0, 0.5], gravity=[3.0, -9.0], more=more
    )
    run(loads(scene), tmp_path)
    read = {
        kind: [pv.read(tmp_path / "fields" / f"{kind}_{step:06d}.vtu") for step in (1, 10)]
        for kind in ("blocks", "contacts", "interfaces")
    }
    for start, end in read.values():
        np.testing.assert_allclose(start.points, end.points, atol=1e-12)
    blocks, contacts, faces = (end for _, end in read.values())
    upper = texts(blocks.field_data, "block_names").index("pier.b2")
    moved = blocks["displacement"][blocks.point_data["block"] == upper]
    assert moved[:, 0].min() > 1e-3
    assert (contacts["candidate"] == upper).all()
    np.testing.assert_allclose(contacts["displacement"], moved[: len(contacts["displacement"])], atol=1e-9)
    assert (faces["displacement"][:, 0] > 1e-3).all()
    assert "velocity" in blocks.point_data
    assert "relative_velocity" in contacts.point_data


HULLS = {
    TETRA: [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0.2, 0.2, 1)],
    PYRAMID: [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0.4, 0.6, 1)],
    HEXAHEDRON: [(x, y, z) for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1 + z), (0, 1 + z))],
}


@pytest.mark.parametrize("kind", HULLS)
@pytest.mark.parametrize("turn", range(3))
def test_rigid_blocks_are_cells_of_vtks(kind, turn):
    """The volume is positive and that of the block, whichever face comes first."""
    points = np.array(HULLS[kind], float)
    block = hull(points)
    order = np.random.default_rng(turn).permutation(len(block))
    found = standard_cell(tuple(block[i] for i in order))
    assert found is not None
    assert found[0] == kind
    cell = pv.UnstructuredGrid([len(found[1]), *found[1]], [kind], points)
    assert cell.compute_cell_sizes()["Volume"][0] == pytest.approx(volume(points, block), rel=1e-12)


def hull(points):
    """Faces of the hull of points as loops, counter-clockwise seen from outside."""
    from scipy.spatial import ConvexHull

    made = {}
    for equation in ConvexHull(points).equations:
        key = tuple(np.round(equation, 9))
        on = np.flatnonzero(np.abs(points @ equation[:3] + equation[3]) < 1e-9)
        normal = equation[:3]
        first = np.cross(normal, np.eye(3)[np.abs(normal).argmin()])
        second = np.cross(normal, first)
        flat = points[on] - points[on].mean(axis=0)
        made[key] = tuple(int(i) for i in on[np.argsort(np.arctan2(flat @ second, flat @ first))])
    return list(made.values())


def volume(points, faces):
    fans = [(face[0], *pair) for face in faces for pair in pairwise(face[1:])]
    return sum(np.linalg.det(points[[*fan]]) for fan in fans) / 6


def test_blocks_of_other_forms_are_their_faces(tmp_path):
    """Stones of rubble, which meshio could not read as polyhedra beside others."""
    prism = Polytope.box((0.0, 0.0, 0.0), (1.0, 1.0, 1.0))
    cut = (*prism.faces[:-1], prism.faces[-1][:3], (prism.faces[-1][0], *prism.faces[-1][2:]))
    assert standard_cell(cut) is None
    ground = FakeGroup(np.array([0]), None, [prism.vertices], cut, prescribed=True)
    solid = Polytope(prism.vertices, cut)
    assembly = Assembly(3, (Shape("cut", solid),), (Block("a", 0, Pose.identity(3)),))
    model = SimpleNamespace(assembly=assembly, groups=(ground,))
    shell, whole = grid_of(model, shells=True), grid_of(model)
    assert list(shell.types) == [POLYGON] * 7
    assert list(whole.types) == [POLYHEDRON]
    write_vtu(tmp_path / "b.vtu", shell, {}, {"block": shell.cell_block})
    read = read_twice(tmp_path / "b.vtu")
    assert read.extract_surface(algorithm=None).triangulate().volume == pytest.approx(1.0, rel=1e-12)
