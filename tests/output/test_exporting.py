"""Exporting: what other programs read of a folder is what its field files hold."""

import csv
import json

import numpy as np
import pytest
import pyvista

from masonry_fem.cli import main
from masonry_fem.errors import SceneError
from masonry_fem.output.exporting import FORMATS, export
from masonry_fem.output.exporting.compas import hull_of, shares
from masonry_fem.output.exporting.motion import motion_of
from masonry_fem.output.exporting.stones import stone_columns
from masonry_fem.output.exporting.xdmf import topology_of
from masonry_fem.output.viewing.recorded import Recorded, entries_of, read_grid
from masonry_fem.scene.specs import MeshSettings
from masonry_fem.structures import build_structure
from masonry_fem.structures.file import FileStructure
from tests.output.test_viewing import STEPS, folder


@pytest.fixture(scope="module")
def wall(tmp_path_factory):
    return folder(tmp_path_factory.mktemp("wall"))


def names_of(blocks):
    return bytes(np.asarray(blocks.field_data["block_names"])).decode().split()


def test_the_table_has_the_ends_of_each_block(wall, tmp_path):
    export(wall, tmp_path / "stones.csv", step=2)
    with (tmp_path / "stones.csv").open() as file:
        rows = list(csv.DictReader(file))
    blocks = Recorded.of(wall).blocks(1)
    assert [row["block"] for row in rows] == names_of(blocks)
    own = np.asarray(blocks.point_data["block"])
    for number, row in enumerate(rows):
        here = own == number
        shift = np.asarray(blocks.point_data["displacement"])[here].mean(axis=0)
        np.testing.assert_allclose([float(row[f"displacement_{a}"]) for a in "xyz"], shift, atol=1e-15)
        stress = np.asarray(blocks.point_data["principal_stress"])[here]
        if row["block"] == "ground":
            assert row["least_principal"] == "", "rigid blocks have no stress"
        else:
            assert float(row["least_principal"]) == stress[:, 2].min()
            assert float(row["greatest_principal"]) == stress[:, 0].max()


def test_parts_of_the_multiblock_have_the_names_and_fields_of_the_blocks(wall, tmp_path):
    export(wall, tmp_path / "wall.vtm", step=3)
    parts = pyvista.read(tmp_path / "wall.vtm")
    blocks = Recorded.of(wall).blocks(2)
    assert parts.keys() == names_of(blocks)
    cells, points = (np.asarray(data["block"]) for data in (blocks.cell_data, blocks.point_data))
    for number, part in enumerate(parts):
        assert part.n_cells == (cells == number).sum()
        here = points == number
        np.testing.assert_array_equal(
            np.sort(part.point_data["displacement"], axis=0),
            np.sort(blocks.point_data["displacement"][here], axis=0),
        )
        assert ("von_mises" in part.point_data) == (names_of(blocks)[number] != "ground"), "as it has stress"


def test_motions_are_those_that_blocks_were_given(wall):
    blocks = Recorded.of(wall).blocks(-1).copy()
    own = np.asarray(blocks.point_data["block"])
    count = own.max() + 1
    angle = np.linspace(0.0, 3.0, count)
    c, s, zero, one = np.cos(angle), np.sin(angle), np.zeros(count), np.ones(count)
    turn = np.stack([c, zero, s, zero, one, zero, -s, zero, c], axis=1).reshape(-1, 3, 3)
    shift = np.random.default_rng(1).normal(size=(count, 3))
    points = np.asarray(blocks.points)
    moved = np.einsum("pij,pj->pi", turn[own], points) + shift[own]
    blocks.point_data["displacement"] = moved - points
    motion = motion_of(blocks, count)
    np.testing.assert_allclose(motion.turn, turn, atol=1e-12)
    np.testing.assert_allclose(motion.angle, angle, atol=1e-7)
    whole = np.einsum("pij,pj->pi", motion.matrix[own], np.column_stack([points, np.ones(len(points))]))
    np.testing.assert_allclose(whole[:, :3], moved, atol=1e-12)
    assert stone_columns(blocks)["turn"] == motion.angle.tolist()


@pytest.mark.parametrize("dimension", [2, 3])
def test_meshio_reads_all_steps_of_the_series(dimension, tmp_path, monkeypatch):
    from meshio.xdmf import TimeSeriesReader

    out = folder(tmp_path / "wall", dimension)
    (path,) = export(out, tmp_path / "wall.xdmf")
    recorded = Recorded.of(out)
    monkeypatch.chdir(tmp_path)  # meshio looks for the data in the working folder
    with TimeSeriesReader(path.name) as reader:
        points, cells = reader.read_points_cells()
        assert reader.num_steps == STEPS
        np.testing.assert_array_equal(points, recorded.blocks(0).points)
        kinds = {"quad", "triangle"} if dimension == 2 else {"hexahedron", "quad", "triangle"}
        assert {block.type for block in cells} <= kinds
        for number in range(STEPS):
            time, nodal, by_cell = reader.read_data(number)
            blocks = recorded.blocks(number)
            assert time == recorded.times[number]
            np.testing.assert_array_equal(nodal["displacement"], blocks.point_data["displacement"])
            expected = np.asarray(blocks.cell_data["von_mises"])[topology_of(blocks)[1]]
            np.testing.assert_array_equal(np.concatenate(by_cell["von_mises"]), expected)


def test_polygons_become_triangles_of_the_same_area():
    import pyvista as pv

    corners = np.array(
        [[0, 0, 0], [2, 0, 0], [3, 1, 0], [1, 3, 0], [-1, 1, 0], [5, 0, 0], [6, 0, 0], [5, 1, 0.0]]
    )
    grid = pv.UnstructuredGrid(np.array([5, 0, 1, 2, 3, 4, 3, 5, 6, 7]), np.array([7, 5]), corners)
    stream, rows = topology_of(grid)
    triangles = stream.reshape(-1, 4)
    assert (triangles[:, 0] == 4).all()
    a, b, c = corners[triangles[:, 1:]].transpose(1, 0, 2)
    area = np.bincount(rows, 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1))
    np.testing.assert_allclose(area, [7.0, 0.5])


def test_compas_has_the_forces_of_the_joints(wall, tmp_path):
    export(wall, tmp_path / "wall.json")
    told = json.loads((tmp_path / "wall.json").read_text())
    recorded = Recorded.of(wall)
    cloud = read_grid(entries_of(wall / "contacts.pvd")[recorded.times[-1]])
    points, reaction = np.asarray(cloud.points), np.asarray(cloud.point_data["reaction"])
    pair = np.column_stack([cloud.point_data["antagonist"], cloud.point_data["candidate"]])
    edges = told["results"]["data"]["edge_data"]
    assert len(edges) == len(np.unique(pair, axis=0))
    for edge, joint in edges.items():
        own = (pair == [int(one) for one in edge.split(",")]).all(axis=1)
        data = joint["contact_data"]["data"]
        at = np.array([point["data"] for point in data["points"]])
        frame = data["frame"]["data"]
        u, v = np.array(frame["xaxis"]), np.array(frame["yaxis"])
        local = np.array([[one[k] for k in ("c_u", "c_v", "c_np", "c_nn")] for one in data["forces"]])
        force = local @ [u, v, np.cross(u, v), -np.cross(u, v)]
        np.testing.assert_allclose(force.sum(axis=0), reaction[own].sum(axis=0), atol=1e-9)
        moment = np.cross(points[own], reaction[own]).sum(axis=0)
        np.testing.assert_allclose(np.cross(at, force).sum(axis=0), moment, atol=1e-8)
        assert all(one["c_nn"] == 0 for one in data["forces"]), "nothing pulls"


def test_shares_fall_to_corners_around_the_point():
    random = np.random.default_rng(3)
    for _ in range(20):
        flat = random.normal(size=(12, 2))
        corners = hull_of(flat)
        weights = shares(flat, corners)
        assert weights.min() > -1e-12
        np.testing.assert_allclose(weights @ flat[corners], flat, atol=1e-12)
    line = np.column_stack([np.linspace(0, 1, 4), np.linspace(0, 2, 4)])
    assert hull_of(line) is None
    assert hull_of(flat[:2]) is None


def test_what_is_exported_is_read_again(wall, tmp_path):
    export(wall, tmp_path / "wall.json")
    spec = FileStructure(name="w", material="stone", path="wall.json")
    assembly = build_structure(spec, 3, tmp_path, MeshSettings())
    blocks = Recorded.of(wall).blocks(-1)
    assert len(assembly.blocks) == len(names_of(blocks))
    assert [block.support for block in assembly.blocks] == [name == "ground" for name in names_of(blocks)]
    low = np.min([shape.solid.vertices.min(axis=0) for shape in assembly.shapes], axis=0)
    np.testing.assert_allclose(low, np.asarray(blocks.bounds)[::2], atol=1e-12)


def test_compas_dem_reads_it(wall, tmp_path):
    compas = pytest.importorskip("compas")
    pytest.importorskip("compas_dem.models")
    export(wall, tmp_path / "wall.json")
    data = compas.json_load(tmp_path / "wall.json")
    results = data["results"]
    assert [block.name for block in data["model"].supports()] == ["ground"]
    for edge in results.edges():
        assert list(results.contact_data(edge).resultant) == pytest.approx(results.resultant_global(edge))


def test_what_cannot_be_exported_is_told(wall, tmp_path, capsys):
    with pytest.raises(SceneError, match=", ".join(FORMATS)):
        export(wall, tmp_path / "wall.docx")
    with pytest.raises(SceneError, match="expected solids"):
        export(folder(tmp_path / "flat", 2), tmp_path / "wall.json")
    assert main(["export", str(wall), str(tmp_path / "a.csv"), str(tmp_path / "a.glb"), "--step", "1"]) == 0
    assert (tmp_path / "a.csv").exists()
    assert (tmp_path / "a.glb").exists()
    capsys.readouterr()
    assert main(["export", str(tmp_path / "nowhere"), str(tmp_path / "a.csv")]) == 1
    assert "expected the results folder of a run" in capsys.readouterr().err
