"""Viewing: steps, fields, sections and picks of a window, movies and glTF models, from a folder's files."""

import json
import logging
from itertools import pairwise

import numpy as np
import pytest

from masonry_fem.cli import main
from masonry_fem.errors import InstallationError, SceneError
from masonry_fem.host import installation
from masonry_fem.output import view as module
from masonry_fem.output.asked.fields import FieldFiles
from masonry_fem.output.render import can_render
from masonry_fem.output.view import showing_of, view
from masonry_fem.output.viewing.gltf import write_gltf
from masonry_fem.output.viewing.look import Look, Section, Shade, fields_of, suited_factor
from masonry_fem.output.viewing.movie import SWAY, suited_kind, write_movie
from masonry_fem.output.viewing.recorded import Recorded
from masonry_fem.output.viewing.window import Controls, plane_at
from tests.output.conftest import FakeReport, wall_model, wall_state

draws = pytest.mark.skipif(not can_render(), reason="neither EGL nor OSMesa here")
STEPS = 4


def folder(out, dimension=3, steps=STEPS):
    """A folder of a wall whose displacements grow from step to step."""
    model = wall_model(dimension)
    files = FieldFiles(out)
    files.start(model)
    for index in range(1, steps + 1):
        state = wall_state(model, index)
        for body in state.bodies:
            body.displacement[:] *= index
        files.record(model, state, FakeReport(index, 0.1 * index))
    return out


@pytest.fixture(scope="module")
def wall(tmp_path_factory):
    return folder(tmp_path_factory.mktemp("wall"))


@pytest.fixture(scope="module")
def recorded(wall):
    return Recorded.of(wall)


def test_steps_are_in_order_and_counted_from_one(recorded, wall):
    assert recorded.times == pytest.approx((0.1, 0.2, 0.3, 0.4))
    assert (recorded.number(None), recorded.number(1), recorded.number(STEPS)) == (STEPS - 1, 0, STEPS - 1)
    for wrong in (0, STEPS + 1, -1):
        with pytest.raises(SceneError, match=f"expected 1 to {STEPS}"):
            recorded.number(wrong)
    first, last = (np.asarray(recorded.blocks(i).point_data["displacement"]) for i in (0, -1))
    np.testing.assert_allclose(last, STEPS * first)


def test_a_look_colours_what_files_hold_and_displaces_it(recorded):
    blocks = recorded.blocks(-1)
    assert fields_of(blocks)[0] == "von_mises"
    shown = Look("displacement", 1000.0).shown(blocks).surface
    moved = np.asarray(shown.point_data["displacement"])
    np.testing.assert_allclose(shown.point_data["_shown"], np.linalg.norm(moved, axis=1))
    still = Look("displacement", 0.0).shown(blocks).surface
    np.testing.assert_allclose(shown.points - still.points, 1000 * moved, atol=1e-12)
    assert "_shown" not in blocks.point_data, "what is read once is shared by all that show it"


def test_a_section_keeps_what_is_behind_it(recorded):
    blocks = recorded.blocks(-1)
    for text, keeps in (
        ("x=0.8", lambda p: p[:, 0] >= 0.8), ("y=0.1", lambda p: p[:, 1] >= 0.1),
        ("z=0.3", lambda p: p[:, 2] <= 0.3),
    ):  # fmt: skip
        kept = np.asarray(Look("von_mises", 0.0, Section.read(text)).shown(blocks).surface.points)
        assert keeps(np.round(kept, 9)).all()
        assert len(kept) > 10
    with pytest.raises(SceneError, match=r"between .* and 1\.7 m"):
        Look("von_mises", 0.0, Section.read("x=99")).shown(blocks)
    for wrong in ("", "w=1", "x", "x=a", "x=1=2"):
        with pytest.raises(SceneError, match=r"such as y=0\.25"):
            Section.read(wrong)


def test_stones_are_pulled_apart_as_they_are(recorded):
    """Each goes by the same share of its distance from the middle, and keeps its form."""
    blocks = recorded.blocks(-1)
    together, apart = (Look("von_mises", 0.0, None, share).shown(blocks).surface for share in (0.0, 0.4))
    moves = np.asarray(apart.points) - np.asarray(together.points)
    own = np.asarray(together.point_data["block"]).astype(int)
    middles = np.array([together.points[own == k].mean(axis=0) for k in range(own.max() + 1)])
    for k in range(len(middles)):
        np.testing.assert_allclose(np.ptp(moves[own == k], axis=0), 0.0, atol=1e-12)
    gone = np.array([moves[own == k][0] for k in range(len(middles))])
    np.testing.assert_allclose(np.diff(gone, axis=0), 0.4 * np.diff(middles, axis=0), atol=1e-12)
    assert np.abs(gone).max() > 0.1


@pytest.mark.parametrize("share", ["-0.1", "nan", "inf"])
def test_a_share_to_pull_apart_that_is_none_is_refused(wall, share, tmp_path, capsys):
    asked = ["view", str(wall), "--apart", share, "--gltf", str(tmp_path / "w.glb")]
    assert main(asked) == 1
    assert f"--apart is {share}, expected 0 or more" in capsys.readouterr().err


def test_colours_are_those_of_all_steps(recorded):
    grids = [recorded.blocks(i) for i in range(STEPS)]
    most = max(np.linalg.norm(grid.point_data["displacement"], axis=1).max() for grid in grids)
    shade = Shade.of(grids, "displacement")
    assert shade.limits[0] == 0
    assert shade.limits[1] == pytest.approx(most, rel=0.1)
    signed = Shade.of(grids, "least")
    assert signed.limits[0] == -signed.limits[1]


@draws
def test_what_a_window_shows_changes_with_its_controls(recorded):
    showing = showing_of(recorded, Look("von_mises", suited_factor([recorded.blocks(-1)])))
    plotter = showing.plotter

    def picture():
        plotter.render()
        return plotter.screenshot(None, return_img=True).astype(int)

    def changes(act):
        before = picture()
        act()
        return np.abs(picture() - before).max(axis=2) > 40

    plotter.show(auto_close=False)
    controls = Controls(showing)
    controls.fit()
    assert not changes(lambda: None).any(), "what does not change is drawn alike"
    for act in (
        lambda: showing.step(0), controls.next_field, lambda: showing.factor(0.0), controls.pull,
        lambda: controls.across(1), lambda: controls._cut(0.8), controls.pull,
    ):  # fmt: skip
        assert changes(act).sum() > 50
    assert showing.place == 0
    assert "step 1 of 4" in showing.caption()
    assert showing.look.section == plane_at(showing, 1, 0.8)
    controls.across(None)
    assert showing.look.section is None
    showing.section(Section(0, 1e3))
    assert showing.look.section is None, "a plane beside the structure is not taken"
    plotter.close()


@draws
def test_a_click_names_the_block_under_it(tmp_path):
    recorded = Recorded.of(folder(tmp_path, dimension=2))
    showing = showing_of(recorded, Look("von_mises", 0.0))
    plotter = showing.plotter
    plotter.show(auto_close=False)
    named = 0
    for block, name in enumerate(showing._names()):
        own = np.asarray(recorded.blocks(-1).point_data["block"]) == block
        centre = np.asarray(recorded.blocks(-1).points)[own].mean(axis=0)
        renderer = plotter.renderer
        renderer.SetWorldPoint(*centre, 1.0)
        renderer.WorldToDisplay()
        told = showing.pick(*renderer.GetDisplayPoint()[:2])
        assert told.splitlines()[0] == name
        named += 1
    assert named > 10
    assert "von Mises stress:" in told
    assert showing.pick(1, 1) == ""
    assert showing.chosen is None
    plotter.close()


def frames(path):
    from PIL import Image, ImageSequence

    with Image.open(path) as image:
        return [np.asarray(frame.convert("RGB")).astype(int) for frame in ImageSequence.Iterator(image)]


@draws
def test_a_movie_has_a_frame_a_step(recorded, tmp_path):
    look = Look("displacement", suited_factor([recorded.blocks(-1)]))
    assert suited_kind(recorded) == "steps"
    made = frames(write_movie(recorded, tmp_path / "steps.gif", "steps", look))
    assert len(made) == STEPS
    assert all((np.abs(a - b).max(axis=2) > 60).sum() > 300 for a, b in pairwise(made))
    assert made[0].shape[0] % 2 == 0
    assert not list(tmp_path.glob("*.part"))


@pytest.mark.slow
@draws
def test_one_step_grows_and_goes_back(tmp_path):
    recorded = Recorded.of(folder(tmp_path, steps=1))
    assert suited_kind(recorded) == "growth"
    look = Look("displacement", suited_factor([recorded.blocks(-1)]))
    made = frames(write_movie(recorded, tmp_path / "growth.gif", None, look))
    assert len(made) == SWAY
    far = [np.abs(frame - made[0]).sum() for frame in made]
    assert np.argmax(far) == SWAY // 2
    assert np.abs(made[1][120:-80] - made[-1][120:-80]).max() < 60, "it goes back the way it came"


@draws
def test_a_mechanism_moves_its_parts_and_no_others(tmp_path):
    out = folder(tmp_path, dimension=2)
    part = {"blocks": ["wall.b13"], "at": [0.4, 0.5], "velocity": [0.6, 0.3], "spin": [0.0]}
    (out / "summary.json").write_text(
        json.dumps({"mechanism": {"sentence": "1 block moves", "parts": [part]}})
    )
    recorded = Recorded.of(out)
    assert suited_kind(recorded) == "mechanism"
    made = frames(write_movie(recorded, out / "fall.gif", None, Look("von_mises", 1.0)))
    moved = np.abs(made[SWAY // 2] - made[0]).max(axis=2) > 60
    rows, columns = np.nonzero(moved)
    assert 0 < moved.mean() < 0.1
    assert rows.max() < 0.6 * moved.shape[0], "lower courses rest"
    assert columns.max() > columns.min() + 50
    (out / "summary.json").write_text("{}")
    with pytest.raises(SceneError, match="no mechanism"):
        write_movie(recorded, out / "fall.gif", "mechanism", Look("von_mises", 1.0))


@draws
def test_mp4_plays_the_same_frames(recorded, tmp_path):
    ffmpeg = pytest.importorskip("imageio_ffmpeg")
    path = write_movie(recorded, tmp_path / "steps.mp4", "steps", Look("displacement", 1.0))
    count, seconds = ffmpeg.count_frames_and_secs(str(path))
    assert count == STEPS
    assert seconds == pytest.approx(STEPS / 6.0, rel=0.1)


def test_other_endings_and_missing_ffmpeg_are_told(recorded, tmp_path, monkeypatch):
    with pytest.raises(SceneError, match=r"\.mp4 or \.gif"):
        write_movie(recorded, tmp_path / "a.avi", None, Look("von_mises", 1.0))
    monkeypatch.setitem(installation.EXTRAS, "movies", ("no_such_library",))
    with pytest.raises(InstallationError, match="masonry-fem\\[movies\\]"):
        write_movie(recorded, tmp_path / "a.mp4", None, Look("von_mises", 1.0))
    with pytest.raises(SceneError, match=r"ends in \.glb"):
        write_gltf(recorded, -1, Look("von_mises", 1.0), tmp_path / "a.gltf")


def chunks(path):
    data = path.read_bytes()
    magic, version, length = np.frombuffer(data[:12], "<u4")
    assert (magic, version, length) == (0x46546C67, 2, len(data))
    size = int(np.frombuffer(data[12:16], "<u4")[0])
    return json.loads(data[20 : 20 + size]), data[20 + size + 8 :]


def test_gltf_has_a_node_a_block_that_moves_as_the_block_does(recorded, tmp_path):
    look = Look("von_mises", 500.0)
    told, data = chunks(write_gltf(recorded, -1, look, tmp_path / "wall.glb"))
    names = bytes(recorded.blocks(-1).field_data["block_names"]).decode().split()
    assert [node["name"] for node in told["nodes"][:-1]] == names
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for mesh in told["meshes"]:
        (primitive,) = mesh["primitives"]
        rest = told["accessors"][primitive["attributes"]["POSITION"]]
        moves = told["accessors"][primitive["targets"][0]["POSITION"]]

        def values(accessor):
            view = told["bufferViews"][accessor["bufferView"]]
            start = view["byteOffset"]
            return np.frombuffer(data[start : start + view["byteLength"]], "<f4").reshape(-1, 3)

        np.testing.assert_allclose(values(rest).min(axis=0), rest["min"])
        assert values(rest).shape == values(moves).shape
        moved = values(rest) + values(moves)
        low, high = np.minimum(low, moved.min(axis=0)), np.maximum(high, moved.max(axis=0))
    x0, x1, y0, y1, z0, z1 = look.shown(recorded.blocks(-1)).surface.bounds
    np.testing.assert_allclose([low, high], [[x0, y0, z0], [x1, y1, z1]], atol=1e-6)


def test_vtk_reads_the_gltf_model(recorded, tmp_path):
    import pyvista as pv

    path = write_gltf(recorded, -1, Look("von_mises", 0.0), tmp_path / "wall.glb")
    read = pv.get_reader(str(path)).read().combine()
    x0, x1, y0, y1, z0, z1 = recorded.blocks(-1).bounds
    np.testing.assert_allclose(read.bounds, [x0, x1, z0, z1, -y1, -y0], atol=1e-6)


def test_the_page_has_all_controls(recorded):
    pytest.importorskip("trame")
    pytest.importorskip("trame_vtk")
    pytest.importorskip("trame_vuetify")
    from masonry_fem.output.viewing.browser import page_of

    showing = showing_of(recorded, Look("von_mises", 100.0))
    state = page_of(showing).state
    assert (state.step, state.field, state.axis) == (STEPS, "von_mises", "none")
    showing.plotter.close()


@draws
def test_the_command_writes_all_of_it(wall, tmp_path, capsys):
    made = [tmp_path / "a.glb", tmp_path / "a.gif"]
    words = ["view", str(wall), "--gltf", str(made[0]), "--movie", str(made[1]), "--step", "2"]
    assert main([*words, "--field", "displacement", "--amplification", "50", "--section", "y=0.1"]) == 0
    assert all(path.stat().st_size > 1000 for path in made)
    for wrong, said in (
        (["--step", "9"], "expected 1 to 4"), (["--field", "colour"], "expected one of von_mises"),
        (["--section", "y=9"], "leaves nothing"), (["--amplification", "-1"], "expected 0 or more"),
    ):  # fmt: skip
        capsys.readouterr()
        assert main([*words, *wrong]) == 1
        assert said in capsys.readouterr().err


def test_without_a_screen_it_says_what_to_do(wall, monkeypatch, caplog, tmp_path):
    """A folder without results comes first: it cannot be shown anywhere."""
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    monkeypatch.setattr(module.sys, "platform", "linux")
    with pytest.raises(SceneError, match="expected the results folder of a run"):
        view(tmp_path)
    with caplog.at_level(logging.ERROR), pytest.raises(InstallationError, match="--browser"):
        view(wall)
