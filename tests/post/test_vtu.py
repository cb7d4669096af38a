"""Field files: what VTK reads is what was given."""

import xml.etree.ElementTree as ET

import numpy as np
import pytest

from masonry_fem.post.fields import cell_arrays, contact_arrays, point_arrays
from masonry_fem.post.grid import POLYGON, POLYHEDRON, VTK_TYPE, grid_of, polygon_of, three
from masonry_fem.post.vtu import FieldFiles, _compressed, write_points, write_vtu

pv = pytest.importorskip("pyvista")


def test_vtk_reads_back_the_fields(elastic, tmp_path):
    model, state = elastic
    grid = grid_of(model)
    nodal, cells = point_arrays(grid, model, state), cell_arrays(grid, model, state)
    write_vtu(tmp_path / "blocks.vtu", grid, nodal, cells)
    read = pv.read(tmp_path / "blocks.vtu")
    np.testing.assert_array_equal(read.points, grid.points)
    np.testing.assert_array_equal(read.celltypes, grid.types)
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
    assert set(grid.types) == {POLYHEDRON if grid.dimension == 3 else POLYGON}
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


@pytest.mark.parametrize("size", [0, 1, 1 << 20, (1 << 20) + 8])
def test_compression_survives_block_limits(size):
    import zlib

    data = np.random.default_rng(0).integers(0, 4, size, dtype=np.uint8).tobytes()
    packed = _compressed(data)
    count = int.from_bytes(packed[:8], "little")
    head = np.frombuffer(packed[: 8 * (3 + count)], "<u8")
    out, at = b"", 8 * (3 + count)
    for length in head[3:]:
        out += zlib.decompress(packed[at : at + int(length)])
        at += int(length)
    assert out == data
    assert at == len(packed)


def test_grid_for_pictures_is_the_one_in_the_files(elastic, rigid, tmp_path):
    from masonry_fem.post.scenery import pyvista_grid

    for model, _ in (elastic, rigid):
        grid = grid_of(model)
        write_vtu(tmp_path / "b.vtu", grid, {}, {})
        read, made = pv.read(tmp_path / "b.vtu"), pyvista_grid(grid)
        np.testing.assert_array_equal(made.points, read.points)
        np.testing.assert_array_equal(made.celltypes, read.celltypes)
        for i in range(read.n_cells):
            assert sorted(made.get_cell(i).point_ids) == sorted(read.get_cell(i).point_ids)
            assert made.get_cell(i).n_faces == read.get_cell(i).n_faces
