"""Pictures: there, of the right size, not blank; skipped with one sentence where nothing can draw."""

import logging

import numpy as np
import pytest

from masonry_fem.errors import InstallationError, SceneError
from masonry_fem.host import installation
from masonry_fem.output import mesh_picture, picture, render, scenery, sheet, view
from masonry_fem.output.arrows import interface_resultants, reactions
from masonry_fem.output.asked.fields import FieldFiles
from masonry_fem.output.asked.pictures import Pictures
from masonry_fem.output.mesh_picture import write_mesh_files
from masonry_fem.output.render import View
from masonry_fem.output.scenery import DeformedShape, Scenery, amplification_of
from masonry_fem.output.sheet import colour_end
from tests.output.conftest import ended

pytest.importorskip("pyvista")
draws = pytest.mark.skipif(not render.can_render(), reason="neither EGL nor OSMesa here")


@pytest.fixture(autouse=True)
def small(monkeypatch):
    """Pages half as wide, drawn once: four times as fast."""
    monkeypatch.setattr(sheet, "WIDTH", 900)
    monkeypatch.setattr(render, "FINE", 1)


@pytest.fixture
def blind(monkeypatch):
    """A machine with neither EGL nor OSMesa nor X."""
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    monkeypatch.setattr(installation, "_loadable", lambda name: False)
    monkeypatch.setattr(installation.sys, "platform", "linux")
    render.can_render.cache_clear()
    yield
    render.can_render.cache_clear()


def pixels(path):
    from matplotlib.image import imread

    return imread(path)[..., :3]


def check(path):
    image = pixels(path)
    assert image.shape[1] == 900
    middle = image[sheet.TOP : -sheet.BOTTOM]
    assert middle.std() > 0.05
    assert (image[0] == 1).all(), "the paper is white"
    for edge in (image[:, :8], image[:, -8:]):
        assert (edge == 1).all(), "nothing is cut at the sides"


@draws
def test_all_sheets_of_an_elastic_structure(elastic, tmp_path):
    paths = picture.draw_all(Scenery.of(*elastic, title="Wall"), tmp_path)
    names = ["deformed", "von_mises", "principal_stresses", "overview", "reactions", "resultants"]
    assert [p.stem for p in paths] == names
    for path in paths:
        check(path)


@draws
def test_rigid_structures_get_shape_and_reactions(rigid, report, tmp_path):
    model, state = rigid
    recorder = Pictures(tmp_path, "Wall")
    recorder.start(model)
    recorder.record(model, state, report(1))
    paths = recorder.close(ended())
    assert [p.stem for p in paths] == ["deformed", "reactions", "resultants"]
    for path in paths:
        check(path)
    assert recorder.close(ended()) == []
    recorder.record(model, state, report(1))
    assert recorder.close(ended("interrupted")) == []


@draws
def test_crosses_of_principal_stresses_go_along_with_the_blocks(elastic, tmp_path):
    scenery = Scenery.of(*elastic, title="Wall")
    seen = []
    for name, away in (("here", 0.0), ("away", 3.0 * scenery.length)):
        scenery.blocks.point_data["displacement"] = np.full((scenery.blocks.n_points, 3), [away, 0.0, 0.0])
        seen.append(pixels(picture.draw_principal(scenery, tmp_path / f"{name}.png")))
    assert seen[0].shape == seen[1].shape
    assert np.mean(np.abs(seen[0] - seen[1]).max(axis=-1) > 0.1) < 1e-3


@pytest.mark.slow
@draws
@pytest.mark.parametrize("known", [True, False])
def test_damage_is_drawn_where_there_is_cohesion(rigid, tmp_path, known):
    """Mortar or roughness alone has a state, and adhesion nowhere."""
    sheet_of = Scenery.of(*rigid, title="Wall")
    contacts = sheet_of.contacts
    contacts.point_data["adhesion"] = np.where(known & (np.arange(contacts.n_points) > 0), 0.0, np.nan)
    contacts.point_data["area"] = np.full(contacts.n_points, 4.0)  # large balls at the rim of the structure
    paths = picture.draw_all(sheet_of, tmp_path)
    assert ("damage" in [path.stem for path in paths]) == known
    if known:
        check(paths[-1])
        dark = (pixels(paths[-1]).max(axis=-1) < 0.1)[sheet.TOP : -sheet.BOTTOM]
        rows = np.flatnonzero(dark.any(axis=1))
        first, last = dark[rows[0]].sum(), dark[rows[-1]].sum()
        assert max(first, last) < 0.2 * dark.sum(axis=1).max(), "balls are round, not cut off"


@draws
@pytest.mark.parametrize("dimension", [2], indirect=True)
def test_a_structure_at_rest_without_forces_can_be_drawn(elastic, tmp_path):
    from dataclasses import replace

    model, state = elastic
    still = tuple(
        replace(b, displacement=0 * b.displacement, stress=b.stress and type(b.stress)(
            0 * b.stress.gauss, b.stress.weight, 0 * b.stress.nodal))
        for b in state.bodies
    )  # fmt: skip
    state = replace(state, bodies=still, reaction=0 * state.reaction, status=0 * state.status)
    assert len(picture.draw_all(Scenery.of(model, state), tmp_path)) == 6


@pytest.mark.slow
@draws
@pytest.mark.parametrize("dimension", [2], indirect=True)
def test_a_results_folder_can_be_drawn_again(elastic, report, tmp_path):
    model, state = elastic
    files = FieldFiles(tmp_path)
    files.start(model)
    files.record(model, state, report(1))
    drawn = picture.draw_all(Scenery.of(model, state, title=tmp_path.name), tmp_path / "first")
    again = view.view(tmp_path, tmp_path / "second")
    for one, other in zip(drawn, again, strict=True):
        np.testing.assert_array_equal(pixels(one), pixels(other), err_msg=one.name)


@draws
def test_mesh_and_interfaces(elastic, tmp_path):
    import pyvista as pv

    model, _ = elastic
    paths = write_mesh_files(model, tmp_path, "Wall")
    assert [p.name for p in paths] == ["mesh.vtu", "mesh.png", "interfaces.png"]
    assert set(pv.read(paths[0]).cell_data["shape"]) == {0, 1}
    for path in paths[1:]:
        check(path)
    reds = np.abs(pixels(paths[2]) - [0.784, 0.208, 0.169]).max(axis=-1) < 0.15
    assert reds.sum() > 200, f"interfaces are drawn in {mesh_picture.JOINT_COLOURS[0]}"


def test_without_a_driver_one_warning_and_no_picture(blind, elastic, report, tmp_path, caplog, monkeypatch):
    model, state = elastic
    with caplog.at_level(logging.WARNING):
        for _ in range(2):
            recorder = Pictures(tmp_path)
            recorder.record(model, state, report(1))
            assert recorder.close(ended()) == []
    assert len(caplog.records) == 1
    assert "apt install" in caplog.text
    assert [p.suffix for p in write_mesh_files(model, tmp_path)] == [".vtu"]
    monkeypatch.setattr(view, "read_scenery", lambda directory: None)
    with pytest.raises(InstallationError, match="libEGL"):
        view.view(tmp_path, tmp_path)
    monkeypatch.setattr(view.Recorded, "of", lambda directory: None)
    with pytest.raises(InstallationError, match="--png"):
        view.view(tmp_path)


def test_a_folder_without_fields_is_refused(tmp_path):
    with pytest.raises(SceneError, match=r"blocks\.pvd"):
        view.last_file(tmp_path / "blocks.pvd")


@pytest.mark.parametrize(
    ("greatest", "factor"), [(1e-5, 5000.0), (0.0, 1.0), (1e-13, 1.0), (0.3, 1.0), (2e-3, 20.0)]
)
def test_amplification_shows_about_a_twentieth_of_the_structure(greatest, factor):
    points = np.array([[0.0, 0, 0], [0.6, 0.8, 0]])
    assert amplification_of(np.array([[greatest, 0, 0], [0, 0, 0]]), points) == factor


@draws
@pytest.mark.parametrize("dimension", [2], indirect=True)
def test_rounding_is_not_magnified(rigid):
    model, state = rigid
    scenery = Scenery.of(model, state)
    field = scenery.blocks.point_data["displacement"]
    scenery.blocks.point_data["displacement"] = 1e-13 * (field + 1)
    shape = DeformedShape(scenery, None)
    assert (shape.factor, shape.caption()) == (1.0, "No displacement beyond rounding")
    assert "× 1 000" in DeformedShape(scenery, 1000.0).caption()


def test_colours_end_below_a_singular_corner():
    values = np.append(np.linspace(0, 1, 1000), np.nan)
    top, end, over = colour_end(values)
    assert (top, end, over) == (1.0, 1.0, False)
    values[3] = 7.0
    top, end, over = colour_end(values)
    assert top == 7.0
    assert over
    assert end == pytest.approx(0.995, abs=2e-3)


@pytest.mark.parametrize("dimension", [2, 3])
def test_view_holds_every_point(dimension):
    points = np.random.default_rng(1).normal(size=(50, 3)) * [3, 1, 0 if dimension == 2 else 2]
    seen = View.of(points, dimension)
    at = (points - seen.centre) @ seen.axes.T
    np.testing.assert_allclose(seen.axes @ seen.axes.T, np.eye(3), atol=1e-14)
    assert np.linalg.det(seen.axes) == pytest.approx(1.0)
    np.testing.assert_allclose(np.abs(at[:, :2]).max(axis=0), seen.half)


def test_outlines_and_element_edges_move_with_their_own_block(elastic):
    from dataclasses import replace

    model, state = elastic
    moved = state.bodies[1]
    bodies = np.arange(len(model.groups[1].blocks))[:, None, None]
    apart = replace(moved, displacement=np.broadcast_to(1e-3 * (1.0 + bodies), moved.displacement.shape))
    blocks = Scenery.of(model, replace(state, bodies=(state.bodies[0], apart))).blocks
    for edges in (scenery.outline_of(scenery.surface_of(blocks)), scenery.element_edges_of(blocks)):
        owner = edges.point_data["block"]
        np.testing.assert_allclose(edges.point_data["displacement"][:, 0], 1e-3 * owner)
        for block in range(len(model.assembly.blocks)):
            solid, own = model.assembly.solid(block).vertices, edges.points[owner == block]
            # VTK keeps the edges in single precision
            np.testing.assert_allclose(
                np.ptp(own, axis=0)[: solid.shape[1]], np.ptp(solid, axis=0), rtol=1e-6
            )


def test_resultants_stand_at_the_centre_of_pressure():
    import pyvista as pv

    cloud = pv.PolyData(np.array([[0.0, 0, 0], [1, 0, 0], [5, 0, 0], [6, 0, 0]]))
    cloud["reaction"] = np.array([[0.0, 0, 3], [1, 0, 1], [0, 0, 0], [0, 0, 0]])
    cloud["normal"] = np.tile([0.0, 0, 1], (4, 1))
    cloud["interface"] = np.array([7, 7, 9, 9])
    points, force, friction = interface_resultants(cloud)
    np.testing.assert_allclose(points, [[0.25, 0, 0]])
    np.testing.assert_allclose(force, [[1, 0, 4]])
    np.testing.assert_allclose(friction, [[1, 0, 0]])
    cloud["normal"] = -np.asarray(cloud["normal"])
    cloud["reaction"] = -np.asarray(cloud["reaction"])
    np.testing.assert_allclose(interface_resultants(cloud)[1], [[1, 0, 4]])


@pytest.mark.parametrize(
    ("normal", "sign"),
    [((0.6, 0, 0.8), 1), ((0.6, 0, -0.8), -1), ((0.6, -0.8, 0), -1), ((-1, 0, 1e-9), -1), ((1, -1e-9, 0), 1)],
)
def test_forces_of_pictures_act_on_the_upper_block(normal, sign):
    """Of blocks beside each other on that towards +y or +x, whichever of them the candidate is."""
    import pyvista as pv

    cloud = pv.PolyData(np.zeros((2, 3)))
    cloud["normal"] = np.tile(np.array(normal, float), (2, 1))
    cloud["reaction"] = np.array([[1.0, 2, 3], [4, 5, 6]])
    cloud["interface"] = np.array([3, 3])
    np.testing.assert_array_equal(reactions(cloud), sign * np.asarray(cloud["reaction"]))


@draws
def test_long_lines_and_many_keys_stay_on_the_page(tmp_path):
    keys = [sheet.Key(f"shape number {i} × 12", "#c8352b") for i in range(9)]
    page = sheet.Sheet("A very long title of a structure " * 4, "and a caption " * 20, keys)
    stage = render.Stage(View.of(np.array([[0.0, 0, 0], [2, 1, 0]]), 2), page.image_width)
    image = pixels(page.save(tmp_path / "long.png", stage))
    assert (image[:, :8] == 1).all()
    assert (image[:, -8:] == 1).all()
    assert (image[: sheet.TOP] < 1).any()
    below = image[-sheet.BOTTOM :]
    assert (np.abs(below - [0.784, 0.208, 0.169]).max(axis=-1) < 0.05).any()
