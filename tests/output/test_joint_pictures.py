"""Thrust lines, joint maps and cuts: what they show is right, and they are drawn without anything cut off."""

from __future__ import annotations

import logging
from typing import get_args

import msgspec
import numpy as np
import pytest

from masonry_fem.analyses.run import RunResult, run
from masonry_fem.build import build
from masonry_fem.errors import SceneError
from masonry_fem.output import (
    chart,
    cut,
    fields,
    interface_fields,
    joint_map,
    picture,
    principal_picture,
    render,
    sheet,
    thrust,
)
from masonry_fem.output.asked.pictures import Pictures, recorder
from masonry_fem.output.cut import Plane, area_of, section_of
from masonry_fem.output.recorder import Request
from masonry_fem.output.render import Stage, View
from masonry_fem.output.scenery import Scenery
from masonry_fem.output.thrust import thrust_segments
from masonry_fem.scene import check
from masonry_fem.scene.output import PictureName
from masonry_fem.scene.specs import (
    Cut,
    Joint,
    Loads,
    Material,
    MeshSettings,
    Motion,
    Output,
    Scene,
    Statics,
    Support,
    Traction,
)
from masonry_fem.structures.block import BlockStructure
from masonry_fem.structures.stack import StackStructure
from masonry_fem.structures.wall import WallStructure
from tests.output.conftest import ended
from tests.validation.scenes import STONE, G, rigid_arch, solved

pv = pytest.importorskip("pyvista")
draws = pytest.mark.skipif(not render.can_render(), reason="neither EGL nor OSMesa here")


@pytest.fixture(autouse=True)
def small(monkeypatch):
    """Pages half as wide, drawn once: four times as fast."""
    monkeypatch.setattr(sheet, "WIDTH", 900)
    monkeypatch.setattr(render, "FINE", 1)


def scenery_of(result: RunResult) -> Scenery:
    return Scenery.of(result.march.model, result.march.state, title="Test", joints=True)


def pixels(path) -> np.ndarray:
    from matplotlib.image import imread

    return imread(path)[..., :3]


def assert_whole(path) -> None:
    """Not blank, the paper white at its rim."""
    image = pixels(path)
    assert image[sheet.TOP : -sheet.BOTTOM].std() > 0.03
    for rim in (image[0], image[:, :8], image[:, -8:]):
        assert (rim == 1).all()


def coloured(path, colour: str) -> int:
    """Pixels of a colour above the legend."""
    wanted = np.array([int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)])
    image = pixels(path)[sheet.TOP : -sheet.BOTTOM]
    return int((np.abs(image - wanted).max(axis=-1) < 0.02).sum())


@pytest.fixture(scope="module")
def arch() -> RunResult:
    moved = Support(on="arch.springing_right", motion=Motion(displacement=(1e-3, 0.0)))
    return rigid_arch(
        thickness=0.2, voussoirs=12, friction=5.0, supports=(moved,), analysis=Statics(load_steps=2)
    )


@pytest.fixture(scope="module", params=[2, 3], ids=["2D", "3D"])
def wall(request) -> RunResult:
    """Part of the ground settles by 5 mm."""
    flat = request.param == 2
    brick, ground = ((0.4, 0.2), (0.8, 0.2)) if flat else ((0.4, 0.2, 0.2), (0.8, 0.2, 0.2))
    left, right = ((0.0, -0.2), (0.8, -0.2)) if flat else ((0.0, 0.0, -0.2), (0.8, 0.0, -0.2))
    sink = (0.0, -5e-3) if flat else (0.0, 0.0, -5e-3)
    return solved(
        dimension=request.param,
        fidelity="rigid",
        structures=(
            WallStructure(name="wall", material="stone", brick=brick, columns=4, courses=3, ground=False),
            BlockStructure(name="left", material="stone", size=ground, position=left, support=True),
            BlockStructure(name="right", material="stone", size=ground, position=right, support=True),
        ),
        joints=(Joint(friction=0.6),),
        supports=(Support(on="right", motion=Motion(displacement=sink)),),
        analysis=Statics(load_steps=2),
    )


def test_thrust_goes_from_joint_to_joint(arch: RunResult):
    """Twelve stones of two joints each: as many straight pieces, on end where the next begins."""
    scenery = scenery_of(arch)
    faces = scenery.interfaces
    centre = np.asarray(faces.cell_data[interface_fields.CENTRE])
    size = np.linalg.norm(faces.cell_data[interface_fields.FORCE], axis=1)
    starts, ends, force = thrust_segments(scenery, np.ones(13, bool), centre, size)
    assert len(starts) == 12
    met = np.concatenate([starts, ends])
    _, times = np.unique(np.round(met, 9), axis=0, return_counts=True)
    assert sorted(times) == [1, 1, *[2] * 11]
    assert sorted(force.ravel())[-1] == pytest.approx(size.max())


def test_a_single_block_hands_its_weight_down_from_its_middle():
    """A lone joint's band starts in the middle of the block above; the support ends it."""
    result = solved(
        dimension=2,
        fidelity="rigid",
        structures=(StackStructure(name="s", material="stone", size=(1.0, 0.6), count=1),),
        analysis=Statics(load_steps=1),
    )
    scenery = scenery_of(result)
    centre = np.asarray(scenery.interfaces.cell_data[interface_fields.CENTRE])
    starts, ends, force = thrust_segments(scenery, np.ones(1, bool), centre, np.array([7.0]))
    np.testing.assert_allclose(starts, [[0.5, 0.0, 0.0]], atol=1e-9)
    np.testing.assert_allclose(ends, [[0.5, 0.3, 0.0]], atol=1e-9)
    np.testing.assert_array_equal(force, [[7.0, 7.0]])


@draws
def test_thrust_picture_shows_hinges(arch: RunResult, tmp_path):
    path = thrust.draw_thrust(scenery_of(arch), tmp_path / "thrust.png")
    assert_whole(path)
    assert coloured(path, thrust.BAND) > 500
    assert coloured(path, thrust.COLOURS[thrust.HINGE]) > 50


@draws
def test_maps_of_a_settled_wall(wall: RunResult, tmp_path):
    scenery = scenery_of(wall)
    drawn = [
        thrust.draw_thrust(scenery, tmp_path / "thrust.png"),
        joint_map.draw_opening(scenery, tmp_path / "opening.png"),
        joint_map.draw_sliding(scenery, tmp_path / "sliding.png", 10.0),
    ]
    for path in drawn:
        assert_whole(path)
    image = pixels(drawn[1])[sheet.TOP : -sheet.BOTTOM]
    red = (image[..., 0] > 0.4) & (image[..., 1] < 0.15)
    assert red.sum() > 20, "the widest crack is dark red"
    opening = np.asarray(scenery.interfaces.cell_data[interface_fields.OPENING])
    assert 1e-3 < opening.max() < 6e-3


@draws
def test_maps_of_what_neither_opens_nor_slides(tmp_path):
    """Nothing but rounding is no crack."""
    result = solved(
        dimension=2,
        fidelity="rigid",
        structures=(StackStructure(name="s", material="stone", size=(1.0, 0.6), count=2),),
        analysis=Statics(load_steps=1),
    )
    scenery = scenery_of(result)
    for draw in (joint_map.draw_opening, joint_map.draw_sliding):
        assert_whole(draw(scenery, tmp_path / "map.png"))


@pytest.mark.slow
@draws
def test_a_results_folder_can_be_drawn_again_with_its_joints(tmp_path):
    from masonry_fem.output.view import view

    scene = Scene(
        title="Stack", dimension=2, fidelity="rigid", materials={"stone": STONE},
        structures=(StackStructure(name="s", material="stone", size=(1.0, 1.0), count=2),),
        loads=Loads(gravity=(1.0, -G)), analysis=Statics(load_steps=1), output=Output(interfaces=True),
    )  # fmt: skip
    first = [path for path in run(scene, tmp_path).files if path.suffix == ".png"]
    names = ["deformed", "reactions", "resultants", "thrust", "opening", "sliding"]
    assert [path.stem for path in first] == names
    again = view(tmp_path, tmp_path / "again")
    assert [path.stem for path in again] == names
    np.testing.assert_array_equal(pixels(first[3]), pixels(again[3]))


# --- cuts -------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def cube() -> RunResult:
    """1 m, ν = 0, 1 MPa on its top: the stress is −1 MPa everywhere."""
    return solved(
        dimension=3,
        fidelity="elastic",
        materials={"stone": Material(density=2400.0, young=1e10, poisson=0.0)},
        structures=(BlockStructure(name="cube", material="stone", size=(1.0, 1.0, 1.0)),),
        mesh=MeshSettings(divisions=(3, 3, 3)),
        supports=(Support(on="cube/bottom"),),
        loads=Loads(tractions=(Traction(on="cube/top", vector=(0.0, 0.0, -1e6)),)),
        analysis=Statics(load_steps=1),
    )


@pytest.mark.parametrize(
    ("normal", "area"),
    [
        ((0.0, 0.0, 1.0), 1.0),
        ((1.0, 0.0, 1.0), 2**0.5),
        ((1.0, 1.0, 1.0), 0.75 * 3**0.5),
        ((0, -3.0, 0), 1.0),
    ],
)
def test_cut_through_a_patch_test(cube: RunResult, normal: tuple[float, ...], area: float):
    """The section has the area of pure geometry and everywhere the uniform stress."""
    section = section_of(scenery_of(cube).blocks, Plane("p", (0.5, 0.5, 0.5), normal))
    assert area_of(section) == pytest.approx(area, rel=1e-5)
    np.testing.assert_allclose(section.point_data[fields.VON_MISES], 1e6, rtol=1e-8)
    np.testing.assert_allclose(section.point_data[fields.STRESS][:, 2], -1e6, rtol=1e-8)
    np.testing.assert_allclose(section.point_data[fields.PRINCIPAL][:, 2], -1e6, rtol=1e-8)


def test_a_cut_along_joints_shows_the_blocks_behind():
    """Four bricks side by side, cut along their common faces: one pair, whole."""
    blocks = tuple(
        BlockStructure(
            name=f"b{i}{j}", material="stone", size=(1.0, 1.0, 1.0), position=(float(i), float(j), 0.0),
            support=True,
        )
        for i in (0, 1) for j in (0, 1)
    )  # fmt: skip
    free = BlockStructure(name="free", material="stone", size=(1.0, 1.0, 1.0), position=(0.0, 0.0, 1.0))
    result = solved(dimension=3, fidelity="rigid", structures=(*blocks, free), analysis=Statics(load_steps=1))
    grid = scenery_of(result).blocks
    names = [block.name for block in result.march.model.assembly.blocks]
    for towards, expected in ((-1.0, {"b01", "b11"}), (1.0, {"b00", "b10", "free"})):
        section = section_of(grid, Plane("p", (0.0, 1.0, 0.0), (0.0, towards, 0.0)))
        assert {names[n] for n in section.cell_data[fields.BLOCK]} == expected
        assert area_of(section) == pytest.approx(len(expected), rel=1e-5)


@pytest.mark.slow
@draws
def test_pictures_of_cuts(cube: RunResult, tmp_path):
    plane = Plane("mid", (0.5, 0.5, 0.5), (0.0, -1.0, 0.0), ("von_mises", "vertical", "greatest", "least"))
    paths = cut.draw_cut(scenery_of(cube), plane, tmp_path)
    assert [path.name for path in paths] == [f"cut_mid_{field}.png" for field in plane.show]
    for path in paths:
        assert_whole(path)


@draws
@pytest.mark.parametrize("wall", [3], indirect=True)
def test_cut_of_rigid_blocks_is_an_outline(wall: RunResult, tmp_path):
    recorder = Pictures(tmp_path, cuts=[Plane("side", (0.7, 0.1, 0.0), (1.0, 0.0, 0.0))])
    recorder.record(wall.march.model, wall.march.state, wall.march.report)
    path = recorder.close(ended())[-1]
    assert path.name == "cut_side_von_mises.png"
    assert_whole(path)


def test_a_cut_beside_the_structure_is_told(cube: RunResult, tmp_path, caplog):
    with caplog.at_level(logging.WARNING):
        assert cut.draw_cut(scenery_of(cube), Plane("far", (5.0, 0.0, 0.0), (1.0, 0.0, 0.0)), tmp_path) == []
    assert "'far'" in caplog.text
    assert "[1.0, 1.0, 1.0]" in caplog.text


def test_cuts_that_make_no_sense_are_refused():
    scene = Scene(
        dimension=3, materials={"stone": STONE}, fidelity="rigid",
        structures=(StackStructure(name="s", material="stone", size=(1.0, 1.0, 1.0), count=1),),
        output=Output(cuts=(Cut(name="a", point=(0.0, 0.0, 0.0), normal=(0.0, 0.0, 0.0)),)),
    )  # fmt: skip
    with pytest.raises(SceneError, match=r"normal.*not zero"):
        check(scene)
    twice = Cut(name="a", point=(0.0, 0.0, 0.0), normal=(0.0, 0.0, 1.0))
    with pytest.raises(SceneError, match="name of its own"):
        build(check(msgspec.structs.replace(scene, output=Output(cuts=(twice, twice)))))
    flat = StackStructure(name="s", material="stone", size=(1.0, 1.0), count=1)
    two = Cut(name="a", point=(0.0, 0.0), normal=(0.0, 0.0, 1.0))
    with pytest.raises(SceneError, match="no cut in a 2D scene"):
        check(Scene(dimension=2, materials={"stone": STONE}, fidelity="rigid", structures=(flat,),
                    output=Output(cuts=(two,))))  # fmt: skip


# --- the page ---------------------------------------------------------------------------------


@draws
def test_an_axis_that_points_at_the_eye_is_left_out(tmp_path):
    points = np.array([[0.0, 0, 0], [1, 1, 1]])
    view = View.along(points, np.array([0.0, -1.0, 0.0]), np.array([0.0, 0.0, 1.0]))
    np.testing.assert_allclose(view.axes, [[1, 0, 0], [0, 0, 1], [0, -1, 0]], atol=1e-12)
    stage = Stage(view, 600)
    stage.surface(pv.Box((0, 1, 0, 1, 0, 1)), color=principal_picture.COMPRESSION)
    page = sheet.Sheet("Title", "Caption")
    page.bar = sheet.ColourBar("three\nlines\nof words", "viridis", (0.0, 1.0), over=True)
    assert_whole(page.save(tmp_path / "page.png", stage))


@pytest.mark.parametrize("seed", range(40))
def test_letters_of_the_axes_keep_clear_of_each_other_and_of_arrows(seed):
    rng = np.random.default_rng(seed)
    axes = np.linalg.qr(rng.normal(size=(3, 3)))[0][:2].T
    if seed % 4 == 0:  # two axes one behind the other
        axes[1] = 0.6 * axes[0]
    ends, letters = sheet.triad_of(axes)
    shown = np.flatnonzero(ends.any(axis=1))
    assert len(shown) >= 2
    for one in shown:
        for other in set(shown) - {one}:
            assert np.linalg.norm(letters[one] - letters[other]) > 15
            along = np.clip(letters[one] @ ends[other] / (ends[other] @ ends[other]), 0, 1)
            assert np.linalg.norm(letters[one] - along * ends[other]) > 8


@draws
def test_pictures_have_the_same_bits_whatever_was_drawn_before(tmp_path):
    def draw(name: str) -> bytes:
        stage = Stage(View.of(np.array([[0.0, 0, 0], [1, 1, 1]]), 3), 500)
        stage.surface(pv.Box((0, 1, 0, 1, 0, 1)), color=principal_picture.COMPRESSION, opacity=0.3)
        return sheet.Sheet("Title", "Caption").save(tmp_path / name, stage).read_bytes()

    first = draw("first.png")
    other = Stage(View.of(np.array([[0.0, 0, 0], [3, 1, 0]]), 2), 900)
    other.surface(pv.Box((0, 3, 0, 1, 0, 0)), color=principal_picture.TENSION)
    other.image()
    Stage(View.of(np.array([[0.0, 0, 0], [3, 1, 0]]), 2), 900).surface(pv.Sphere())  # given up half-drawn
    assert draw("second.png") == first


@draws
def test_only_the_pictures_asked_for_are_drawn(arch, tmp_path):
    scenery = Scenery.of(arch.march.model, arch.march.state, joints=True)
    every = {path.stem for path in picture.draw_all(scenery, tmp_path / "all")}
    assert {"deformed", "thrust", "reactions"} < every
    assert every <= set(get_args(PictureName))
    paths = picture.draw_all(scenery, tmp_path / "two", only={"thrust", "deformed"})
    assert sorted(path.name for path in paths) == ["deformed.png", "thrust.png"]
    assert sorted(path.name for path in (tmp_path / "two").iterdir()) == ["deformed.png", "thrust.png"]


def test_a_scene_names_its_pictures_and_thrust_needs_no_other_key(tmp_path):
    output = Output(pictures=("thrust",))
    request = Request(tmp_path, "", output, statics=True, materials=())
    made = recorder(request)
    assert made._joints
    assert made._only == {"thrust"}


@draws
def test_light_comes_from_the_upper_right():
    """Of a cube seen from its front, left and above, the top is lit most, and the left side least."""
    stage = Stage(View.of(np.array([[0.0, 0, 0], [1, 1, 1]]), 3), 500)
    cube = pv.Box((0, 1, 0, 1, 0, 1))
    stage.surface(cube, color="white")
    image = stage.image().astype(int)[..., 0]
    shades, counts = np.unique(image, return_counts=True)
    faces = shades[counts > 0.04 * image.size]
    assert len(faces) == 4  # and the white around it
    assert 140 < faces[0] < faces[1] < faces[2] < 255


def test_lines_below_a_title_fit_into_their_figure():
    for words in ("few words", "many words " * 30):
        figure = chart.blank(6.0, 4.0)
        chart.head(figure, "title", words)
        assert figure.texts[-1].get_window_extent().x1 <= figure.bbox.x1
