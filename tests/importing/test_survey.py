"""Survey: measured faces become stones that touch; what was moved is told, what is wrong is named."""

from __future__ import annotations

import logging
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace
from scipy.spatial.transform import Rotation

from masonry_fem.analyses.run import solve_scene
from masonry_fem.contact.depth import overlapping
from masonry_fem.contact.detection import detect
from masonry_fem.errors import GeometryError, SceneError
from masonry_fem.importing.snapping import snapped, straightened
from masonry_fem.importing.trimming import outside, trimmed
from masonry_fem.importing.wall_plane import WallPlane
from masonry_fem.meshing.extrusion import prism_of
from masonry_fem.meshing.mesher import mesh_shape
from masonry_fem.records.remark import gathered
from masonry_fem.scene import check
from masonry_fem.scene.specs import Joint, Loads, Material, MeshSettings, Scene, Statics
from masonry_fem.solid.assembly import Assembly, Shape
from masonry_fem.solid.polytope import Polytope
from masonry_fem.solid.prism import prism
from masonry_fem.structures import build_structure
from masonry_fem.structures.survey import SurveyStructure
from masonry_fem.structures.wall import WallStructure
from meshes.window_bay import measured, settled, stones, write
from tests.meshing.test_meshing import check as check_mesh

WALL = WallStructure(name="w", material="s", brick=(0.4, 0.3, 0.2), columns=4, courses=5)
PLANE = replace(WALL, brick=(0.4, 0.2))


def faces() -> tuple[Assembly, dict[str, np.ndarray]]:
    """A wall of bricks and the fronts of its stones."""
    made = build_structure(WALL, 3, Path(), MeshSettings())
    fronts = {}
    for number, block in enumerate(made.blocks):
        solid = made.solid(number)
        if not block.support:
            fronts[block.name.replace(".", "_")] = solid.face_points(solid.names.index("front"))
    return made, fronts


def surveyed(folder: Path, corners: dict[str, np.ndarray], dimension: int = 3, **keys) -> Assembly:
    lines = ["stone,vertex,x,y,z"]
    for name, face in corners.items():
        lines += [f"{name},{at},{x:.12g},{y:.12g},{z:.12g}" for at, (x, y, z) in enumerate(face, start=1)]
    return read(folder, "\n".join(lines), dimension, **keys)


def read(folder: Path, text: str, dimension: int = 3, name: str = "a.csv", **keys) -> Assembly:
    (folder / name).write_text(text, encoding="utf-8")
    spec = SurveyStructure(**({"name": "f", "material": "s", "path": name, "depth": 0.3} | keys))
    return build_structure(spec, dimension, folder, MeshSettings())


def volume(made: Assembly) -> float:
    return sum(
        made.solid(number).mass_properties().volume
        for number, block in enumerate(made.blocks)
        if not block.support
    )


def brick(made: Assembly, block: int) -> str:
    return made.blocks[block].name.split(".", 1)[1].replace(".", "_").removeprefix("w_")


def areas(made: Assembly) -> np.ndarray:
    """Joint areas between stones, those on the ground left out (it is wider here than there)."""
    return np.array([one.area for one in detect(made) if not any(made.blocks[b].support for b in one.blocks)])


@pytest.mark.parametrize("turn", [0.0, 33.0, 200.0])
def test_a_perfect_wall_comes_back(tmp_path: Path, turn: float) -> None:
    """Exactly, wherever it stands."""
    wall, fronts = faces()
    move = Rotation.from_euler("z", turn, degrees=True)
    shift = np.array([12.0, -7.0, 3.0])
    made = surveyed(tmp_path, {name: move.apply(face) + shift for name, face in fronts.items()})
    assert len(made.blocks) == len(wall.blocks)
    for number, block in enumerate(wall.blocks):
        if block.support:
            continue
        twin = next(i for i, one in enumerate(made.blocks) if one.name == f"f.{block.name.replace('.', '_')}")
        expected = move.apply(wall.solid(number).vertices) + shift
        found = made.solid(twin).vertices
        distance = np.linalg.norm(found[:, None] - expected[None], axis=2)
        assert distance.min(axis=0).max() < 1e-9
        assert distance.min(axis=1).max() < 1e-9
    assert areas(made) == pytest.approx(areas(wall), rel=1e-8)
    assert volume(made) == pytest.approx(volume(wall), rel=1e-9)
    labels = sorted(one.label for one in detect(made))
    assert labels == sorted(one.label for one in detect(wall))


def test_a_plane_wall_comes_back_in_the_plane(tmp_path: Path) -> None:
    wall = build_structure(PLANE, 2, Path(), MeshSettings())
    made = surveyed(tmp_path, faces()[1], dimension=2)
    assert areas(made) == pytest.approx(areas(wall), rel=1e-9)
    assert volume(made) == pytest.approx(volume(wall), rel=1e-12)


@pytest.mark.slow
@given(seed=st.integers(0, 10**6))
@settings(max_examples=15, deadline=None)
def test_noise_moves_joints_but_opens_none(tmp_path_factory: pytest.TempPathFactory, seed: int) -> None:
    """2 mm of noise: the contacts of the drawn wall, of its areas, and no overlap; weight to the noise."""
    wall, fronts = faces()
    rng = np.random.default_rng(seed)
    noisy = {name: face + rng.normal(scale=0.002, size=face.shape) for name, face in fronts.items()}
    made = surveyed(tmp_path_factory.mktemp("a"), noisy)
    assert overlapping(made) == []
    whole, drawn = detect(made), detect(wall)
    assert max(float(np.abs(one.gap).max()) for one in whole) < 1e-9
    assert areas(made).sum() == pytest.approx(areas(wall).sum(), rel=0.02)
    pairs = [
        {frozenset(brick(assembly, block) for block in one.blocks) for one in found if one.area > 2e-3}
        for assembly, found in ((made, whole), (wall, drawn))
    ]
    assert pairs[0] == pairs[1]
    assert volume(made) == pytest.approx(volume(wall), rel=0.01)


def test_what_was_moved_is_told(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    rng = np.random.default_rng(1)
    noisy = {name: face + rng.normal(scale=0.002, size=face.shape) for name, face in faces()[1].items()}
    with caplog.at_level(logging.INFO, logger="masonry_fem"):
        surveyed(tmp_path, noisy)
    assert "corners moved by at most" in caplog.text
    assert "stay open" not in caplog.text
    assert "mm off the wall's plane in the mean square" in caplog.text


def test_moves_are_those_of_the_corners(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    outlines = [
        WallPlane.fit(face, np.array([0, -1.0, 0])).flat(face) + rng.normal(scale=0.002, size=(4, 2))
        for face in faces()[1].values()
    ]
    made, report = snapped(outlines, [str(i) for i in range(len(outlines))], 0.01, "a.csv")
    moves = np.concatenate([np.linalg.norm(a - b, axis=1) for a, b in zip(outlines, made, strict=True)])
    assert report.largest == pytest.approx(moves.max())
    assert report.rms == pytest.approx(np.sqrt(np.mean(moves**2)))
    assert 0.001 < report.rms < 0.004
    assert report.largest < 0.015
    assert report.gaps == report.cut == report.dropped == ()
    again, second = snapped(made, [str(i) for i in range(len(made))], 0.01, "a")
    assert second.largest < 1e-9  # what was snapped stays where it is
    assert np.abs(np.concatenate(again) - np.concatenate(made)).max() < 1e-9


@pytest.mark.parametrize(("width", "stays"), [(0.004, False), (0.03, True)])
def test_cracks_wider_than_the_tolerance_stay(
    tmp_path: Path, width: float, stays: bool, caplog: pytest.LogCaptureFixture
) -> None:
    boxes = {
        "left": np.array([[0, 0, 0], [1, 0, 0], [1, 0, 1], [0, 0, 1]], float),
        "right": np.array([[1 + width, 0, 0], [2, 0, 0], [2, 0, 1], [1 + width, 0, 1]], float),
    }
    with caplog.at_level(logging.INFO, logger="masonry_fem"), gathered() as remarks:
        made = surveyed(tmp_path, boxes)
    assert ("1 joints stay open: 'left' and 'right' by 30 mm" in caplog.text) == stays
    assert [one.blocks for one in remarks if one.code == "open_joints"] == [("f.left", "f.right")] * stays
    assert volume(made) == pytest.approx(0.3 * (2 - width * stays), rel=1e-9)
    assert len(detect(made)) == (2 if stays else 3)


def test_joints_of_thin_mortar_are_closed_half_by_each_neighbour(tmp_path: Path) -> None:
    fronts = faces()[1]
    shrunk = {
        name: face + 0.002 * np.sign(face.mean(axis=0) - face) * [1, 0, 1] for name, face in fronts.items()
    }
    made = surveyed(tmp_path, shrunk)
    assert areas(made).sum() == pytest.approx(areas(faces()[0]).sum(), rel=0.01)
    assert max(float(np.abs(one.gap).max()) for one in detect(made)) < 1e-9


@pytest.mark.parametrize("outlier", [None, 0.4])
def test_the_plane_heeds_no_outliers(outlier: float | None) -> None:
    rng = np.random.default_rng(5)
    normal = np.array([0.6, -0.8, 0.05]) / np.linalg.norm([0.6, -0.8, 0.05])
    base = np.linalg.svd(normal[None])[2][1:]
    points = rng.uniform(-3, 3, (400, 2)) @ base + 0.002 * rng.normal(size=(400, 1)) * normal + 5 * normal
    if outlier:
        points[:40] += outlier * rng.uniform(0.5, 1.0, (40, 1)) * normal
    plane = WallPlane.fit(points, normal)
    assert np.degrees(np.arccos(min(1.0, plane.outward @ normal))) < 0.03
    assert plane.height(points[40:]).mean() == pytest.approx(0.0, abs=5e-4)
    frame = np.stack([plane.along, plane.up, plane.outward])
    assert frame @ frame.T == pytest.approx(np.eye(3), abs=1e-12)
    assert np.linalg.det(frame) == pytest.approx(1.0)


def test_projecting_and_turned_stones_are_told(tmp_path: Path) -> None:
    fronts = faces()[1]
    names = list(fronts)
    fronts[names[3]] = fronts[names[3]][::-1]
    fronts[names[5]] = fronts[names[5]] + [0, -0.1, 0]
    with gathered() as remarks:
        made = surveyed(tmp_path, fronts)
    found = {one.code: one for one in remarks}
    said = f"1 stones run clockwise seen from outside and were turned round: '{names[3]}'"
    assert said in found["turned_stones"].sentence
    assert found["turned_stones"].blocks == (f"f.{names[3]}",)
    said = f"1 stones lie up to 0.1 m off the wall's plane and were laid into it: '{names[5]}'"
    assert said in found["projecting_stones"].sentence
    assert found["projecting_stones"].blocks == (f"f.{names[5]}",)
    assert volume(made) == pytest.approx(volume(faces()[0]), rel=1e-9)


def test_outward_tells_the_front(tmp_path: Path) -> None:
    """A wall whose polygons all run clockwise: as they are, its depth goes the other way."""
    fronts = {name: face[::-1] for name, face in faces()[1].items()}
    depths = [
        np.ptp(np.concatenate([made.solid(i).vertices for i in range(len(made.blocks) - 1)])[:, 1])
        for made in (surveyed(tmp_path, fronts), surveyed(tmp_path, fronts, outward=(0.0, -1.0, 0.0)))
    ]
    assert depths == pytest.approx([0.3, 0.3])
    lows = [
        np.concatenate([made.solid(i).vertices for i in range(len(made.blocks) - 1)])[:, 1].min()
        for made in (surveyed(tmp_path, fronts), surveyed(tmp_path, fronts, outward=(0.0, -1.0, 0.0)))
    ]
    assert lows == pytest.approx([-0.3, 0.0], abs=1e-9)


def test_supports_and_scale(tmp_path: Path) -> None:
    fronts = {name: 1000 * face for name, face in faces()[1].items()}
    made = surveyed(tmp_path, fronts, scale=1e-3, ground=False, supports=("w_c1_*",))
    assert [block.name for block in made.blocks if block.support] == [f"f.w_c1_b{i}" for i in range(1, 5)]
    assert made.solid(0).mass_properties().volume == pytest.approx(0.4 * 0.3 * 0.2)
    with pytest.raises(GeometryError, match="'roof' selects no stone"):
        surveyed(tmp_path, fronts, scale=1e-3, supports=("roof",))


def test_obj_of_polygons(tmp_path: Path) -> None:
    lines, first = [], 1
    for name, face in faces()[1].items():
        lines += [f"v {x} {y} {z}" for x, y, z in face.tolist()]
        lines += [f"o {name}", "f " + " ".join(str(first + i) for i in range(len(face)))]
        first += len(face)
    made = read(tmp_path, "\n".join(lines), name="a.obj")
    assert areas(made) == pytest.approx(areas(faces()[0]), rel=1e-9)
    lines += ["f 1 2 3"]
    with pytest.raises(GeometryError, match="has 2 faces, expected one polygon"):
        read(tmp_path, "\n".join(lines), name="a.obj")


def test_columns_in_any_order_and_separator(tmp_path: Path) -> None:
    text = "Z;X;Vertex;Stone;y;remark\n0;0;3;7;0;a\n0;1;10;7;0;b\n# a remark\n1;1;20;7;0;c\n\n1;0;30;7;0;d\n"
    made = read(tmp_path, text)
    assert [block.name for block in made.blocks] == ["f.s7", "f.ground"]
    assert made.solid(0).mass_properties().volume == pytest.approx(0.3)


SQUARE = "stone,vertex,x,y,z\na,1,0,0,0\na,2,1,0,0\na,3,1,0,1\na,4,0,0,1\n"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "holds no stone"),
        ("stone,vertex,x,y\n", "line 1: the column 'z' is not among stone, vertex, x, y"),
        ("stone,vertex,x,y,z\na,1,0,0,0\na,2,1,0,0\n", "stone 'a' has 2 corners, expected 3 or more"),
        (SQUARE + "a,4,0,0,2\n", r"line 6: stone 'a' has its corner 4 a second time \(first in line 5\)"),
        (SQUARE + "b,1,nan,0,0\n", "line 6: x is 'nan', expected a number; correct"),
        (SQUARE + "b,1,0,5,0,0\n", "line 6 has 6 columns, expected 5.*write decimal points for commas"),
        (SQUARE.replace(",", ";") + "b;1;0,5;0;0\n", "line 6: x is '0,5', expected a number; write decimal"),
        (SQUARE + "b,1.5,0,0,0\n", "line 6: vertex is 1.5, expected a whole number"),
        (SQUARE + "!,1,0,0,0\n", "line 6: stone is '!', expected a name"),
        (
            SQUARE + SQUARE[19:].replace("a,", "b,"),
            "stones 'a' and 'b' overlap by 1 m, expected no more than two",
        ),
        (SQUARE.replace("a,3,1,0,1", "a,3,0,0,2").replace("a,4,0,0,1", "a,4,2,0,1"), "its sides cross"),
        ("stone,vertex,x,y,z\na,1,0,0,0\na,2,1,0,0\na,3,1,0,.001\n", "thinner than the tolerance"),
    ],
)
def test_what_is_wrong_is_said_with_its_line(tmp_path: Path, text: str, said: str) -> None:
    with pytest.raises(GeometryError, match=said):
        read(tmp_path, text)


def test_a_survey_in_another_encoding_is_told(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_bytes(SQUARE.replace("a,", "é,").encode("latin-1"))
    spec = SurveyStructure(name="f", material="s", path="a.csv", depth=0.3)
    with pytest.raises(
        GeometryError, match=r"'a\.csv' is no text in UTF-8 .* at byte 19\); save it as UTF-8"
    ):
        build_structure(spec, 3, tmp_path, MeshSettings())


def test_the_scene_is_checked_before_the_file_is_read(tmp_path: Path) -> None:
    def scene(**keys) -> Scene:
        spec = SurveyStructure(**({"name": "f", "material": "s", "path": "a.csv", "depth": 0.3} | keys))
        return Scene(
            dimension=3, fidelity="rigid", structures=(spec,), materials={"s": Material(density=2e3)}
        )

    with pytest.raises(SceneError, match=r"path is 'a\.csv', expected an existing file"):
        check(scene(), base=tmp_path)
    (tmp_path / "a.csv").write_text(SQUARE)
    check(scene(), base=tmp_path)
    with pytest.raises(SceneError, match=r"path is 'a\.txt', expected a file that ends in '\.csv', '\.obj'"):
        check(scene(path="a.txt"), base=tmp_path)
    with pytest.raises(SceneError, match=r"tolerance is 0\.2, expected less than half the depth"):
        check(scene(tolerance=0.2), base=tmp_path)
    with pytest.raises(SceneError, match="outward"):
        check(scene(outward=(0.0, 0.0, 0.0)), base=tmp_path)


# --- snapping by itself -----------------------------------------------------------------------


def test_corners_on_straight_sides_are_left_out() -> None:
    outline = np.array([[0, 0], [0.5, 0.003], [1, 0], [1, 1], [0.2, 1.05], [0, 1]])
    assert len(straightened(outline, 0.01)) == 5
    assert len(straightened(outline, 0.001)) == 6


def test_overlaps_are_cut_along_the_neighbours_side() -> None:
    lower = np.array([[0, 0], [1, 0], [1, 1], [0, 1.0]])
    upper = np.array([[0, 0.995], [0.8, 0.995], [0.8, 2], [0, 2.0]])
    made, cut = trimmed([lower, upper], ["a", "b"], 0.01, "t")
    assert cut == (("a", "b", pytest.approx(0.005)),)
    spans = [np.ptp(one, axis=0) for one in made]
    assert sum(span[1] for span in spans) == pytest.approx(2.0)
    with pytest.raises(GeometryError, match=r"'a' and 'b' overlap by 0\.005 m"):
        trimmed([lower, upper], ["a", "b"], 0.002, "t")


def test_the_part_in_front_of_a_line() -> None:
    square = np.array([[0, 0], [1, 0], [1, 1], [0, 1.0]])
    left = outside(square, np.array([0.25, 0.0]), np.array([1.0, 0.0]))
    assert np.ptp(left, axis=0) == pytest.approx([0.75, 1.0])
    assert len(outside(square, np.array([2.0, 0.0]), np.array([1.0, 0.0]))) == 0


def test_concave_stones_are_kept_as_they_are(tmp_path: Path) -> None:
    """An L and the stone in its corner fill a square."""
    text = "stone,vertex,x,y,z\n" + "".join(
        f"{name},{at},{x},0,{z}\n"
        for name, corners in (
            ("ell", [(0, 0), (1, 0), (1, 0.4), (0.4, 0.4), (0.4, 1), (0, 1)]),
            ("rest", [(0.403, 0.398), (1, 0.401), (1, 1), (0.4, 1)]),
        )
        for at, (x, z) in enumerate(corners)
    )
    made = read(tmp_path, text)
    assert len(made.solid(0).faces) == 8
    assert overlapping(made) == []
    assert sorted(one.area for one in detect(made)) == pytest.approx([0.18, 0.18, 0.3], rel=0.02)
    assert volume(made) == pytest.approx(0.3, rel=0.01)


# --- the window bay ---------------------------------------------------------------------------


def test_the_window_bay_is_what_its_script_writes(tmp_path: Path, repository: Path) -> None:
    write(tmp_path / "bay.csv", measured(settled(stones())))
    assert (tmp_path / "bay.csv").read_text() == (repository / "meshes/window_bay.csv").read_text()
    assert (repository / "meshes/window_bay.csv").stat().st_size < 60_000


def test_the_window_bay_has_full_joints_but_for_its_crack(
    repository: Path, caplog: pytest.LogCaptureFixture
) -> None:
    def bay(path: Path, **keys) -> Assembly:
        spec = SurveyStructure(name="bay", material="s", path=path.name, depth=0.5, **keys)
        return build_structure(spec, 3, path.parent, MeshSettings())

    with caplog.at_level(logging.INFO, logger="masonry_fem"):
        made = bay(repository / "meshes/window_bay.csv")
    assert len(made.blocks) == 285
    assert overlapping(made) == []
    assert all(len(shape.solid.faces) == 6 for shape in made.shapes)
    assert "3 joints stay open: 'c24s09' and 'c24s10' by 17 mm" in caplog.text
    whole = sum(
        0.5 * abs(np.sum(f[:, 0] * np.roll(f[:, 1], -1) - np.roll(f[:, 0], -1) * f[:, 1])) / 2
        for f in stones().values()
    )
    assert volume(made) == pytest.approx(whole, rel=2e-3)


# --- elastic stones ---------------------------------------------------------------------------

PENTAGON = [(0, 0), (1, 0), (1, 0.6), (0.5, 0.9), (0, 0.6)]
ELL = [(0, 0), (1, 0), (1, 0.4), (0.4, 0.4), (0.4, 1), (0, 1)]
DART = [(0, 0), (1, 0.2), (0, 1), (0.3, 0.3)]
QUAD = [(0, 0), (1, 0.05), (1.1, 0.9), (0, 0.8)]


@pytest.mark.parametrize("outline", [PENTAGON, ELL, DART, QUAD], ids=["pentagon", "ell", "dart", "quad"])
@pytest.mark.parametrize("element", ["Q1", "Q2"])
@pytest.mark.parametrize("keys", [{}, {"size": 0.2}, {"divisions": (2, 3, 2)}], ids=str)
def test_stones_are_meshed_with_hexahedra(tmp_path: Path, outline: list, element: str, keys: dict) -> None:
    text = "stone,vertex,x,y,z\n" + "".join(f"a,{i},{x},0,{z}\n" for i, (x, z) in enumerate(outline))
    shape = read(tmp_path, text, ground=False, supports=("a",)).shapes[0]
    mesh = mesh_shape(shape, MeshSettings(element=element, **keys), 3)
    assert mesh.cell == ("hexahedron" if element == "Q1" else "hexahedron27")
    check_mesh(mesh, shape.solid)
    if "divisions" in keys:
        levels = np.unique(np.round(mesh.points[:, 1], 9))
        assert len(levels) == 3 * int(element[1]) + 1


def test_prisms_are_found_in_any_order_of_their_corners() -> None:
    rng = np.random.default_rng(7)
    outline = np.array(PENTAGON)
    made = prism(outline, [""] * 5, [""] * 5, 0.4, 3)
    order = rng.permutation(10)
    place = np.argsort(order)
    solid = Polytope(made.vertices[order], tuple(tuple(int(place[v]) for v in loop) for loop in made.faces))
    body = prism_of(solid)
    assert body is not None
    assert np.linalg.norm(body.sweep) == pytest.approx(0.4)
    check_mesh(mesh_shape(Shape("p", solid), MeshSettings(element="Q1"), 3), solid)
    solid.vertices[0] += [0.0, 0.01, 0.0]
    assert prism_of(solid) is None
    assert prism_of(Polytope.box((0.0, 0.0), (1.0, 1.0))) is None


@pytest.mark.slow
def test_elastic_stones_of_a_survey_carry_their_weight(tmp_path: Path) -> None:
    """An L with a stone in its corner, on the ground."""
    text = "stone,vertex,x,y,z\n" + "".join(
        f"{name},{at},{x},0,{z}\n"
        for name, corners in (("ell", ELL), ("rest", [(0.402, 0.398), (1, 0.401), (1, 1), (0.4, 1)]))
        for at, (x, z) in enumerate(corners)
    )
    (tmp_path / "a.csv").write_text(text)
    spec = SurveyStructure(name="f", material="stone", path="a.csv", depth=0.3)
    scene = Scene(
        dimension=3, fidelity="elastic", structures=(spec,), joints=(Joint(friction=0.6),),
        materials={"stone": Material(density=2000.0, young=1e9, poisson=0.2)},
        mesh=MeshSettings(divisions=(2, 1, 2)), loads=Loads(gravity=(0.0, 0.0, -10.0)), analysis=Statics(),
    )  # fmt: skip
    result = solve_scene(check(scene, base=tmp_path), tmp_path)
    assert result.outcome == "equilibrium"
    made = build_structure(spec, 3, tmp_path, MeshSettings())
    force = result.summary.supports["f.ground"].force
    assert force == pytest.approx([0.0, 0.0, 20e3 * volume(made)], abs=1e-6)
    assert result.summary.certificate.natural_map < 1e-9
