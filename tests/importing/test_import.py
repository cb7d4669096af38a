"""Surfaces and elements of other programs: what is written is read back; what is broken is named."""

from __future__ import annotations

import struct
from pathlib import Path

import meshio
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from masonry_fem.contact.detection import detect
from masonry_fem.errors import GeometryError
from masonry_fem.importing.sewing import bodies_of
from masonry_fem.importing.triangles import area_vector, ears, triangles_of
from masonry_fem.meshing.mesher import mesh_shape
from masonry_fem.records.remark import gathered
from masonry_fem.scene.specs import MeshSettings, Structure
from masonry_fem.solid.assembly import Assembly, Shape
from masonry_fem.solid.polytope import Polytope
from masonry_fem.solid.pose import Pose
from masonry_fem.structures import build_structure
from masonry_fem.structures.arch import ArchStructure
from masonry_fem.structures.file import FileStructure
from masonry_fem.structures.rubble import RubbleStructure
from masonry_fem.structures.wall import WallStructure
from tests.meshing.test_meshing import check

WALL = WallStructure(name="w", material="s", brick=(0.4, 0.2, 0.2), columns=3, courses=4, ground=False)
ARCH = ArchStructure(
    name="w", material="s", radius=2.0, thickness=0.3, voussoirs=7, embrace=150, depth=0.5,
    springings=False, straight=True,
)  # fmt: skip
CUBE = Polytope.box((0.0, 0.0, 0.0), (1.0, 1.0, 1.0))
RUBBLE = RubbleStructure(name="w", material="s", size=(1.0, 0.5, 0.8), stones=15, seed=3, ground=False)


def built(spec: Structure) -> list[Polytope]:
    made = build_structure(spec, 3, Path(), MeshSettings())
    return [made.solid(number) for number in range(len(made.blocks))]


def reading(path: Path, dimension: int = 3, **keys) -> Assembly:
    spec = FileStructure(name="f", material="s", path=path.name, **keys)
    return build_structure(spec, dimension, path.parent, MeshSettings())


def triangles(solid: Polytope) -> np.ndarray:
    return np.array([one for loop in solid.faces for one in triangles_of(solid.vertices, loop)])


def soup(solids: list[Polytope]) -> tuple[np.ndarray, np.ndarray]:
    """All triangles of all blocks, with no tie between blocks but their places."""
    first = np.cumsum([0, *(len(one.vertices) for one in solids)])
    return (
        np.concatenate([one.vertices for one in solids]),
        np.concatenate([triangles(one) + at for one, at in zip(solids, first, strict=False)]),
    )


def write_stl(path: Path, solids: list[Polytope]) -> None:
    lines = []
    for number, solid in enumerate(solids):
        lines.append(f"solid stone {number}")
        for row in triangles(solid):
            lines += ["facet normal 0 0 0", "outer loop"]
            lines += [f"vertex {x:.17g} {y:.17g} {z:.17g}" for x, y, z in solid.vertices[row]]
            lines += ["endloop", "endfacet"]
        lines.append(f"endsolid stone {number}")
    path.write_text("\n".join(lines))


def write_obj(path: Path, solids: list[Polytope], key: str = "o") -> None:
    lines, first = ["# by hand", "mtllib none.mtl"], 1
    for number, solid in enumerate(solids):
        lines += [f"v {x:.17g} {y:.17g} {z:.17g}" for x, y, z in solid.vertices]
        lines.append(f"{key} stone {number}")
        for loop, name in zip(solid.faces, solid.names, strict=True):
            lines.append(f"usemtl {name}")
            lines.append("f " + " ".join(f"{v + first}//1" for v in loop))
        first += len(solid.vertices)
    path.write_text("\n".join(lines))


def same(made: Assembly, solids: list[Polytope], rel: float = 1e-9) -> None:
    """Blocks of the same volumes, numbers of faces and contacts."""
    found = [made.solid(number) for number in range(len(made.blocks))]
    assert len(found) == len(solids)
    key = [tuple(np.round(one.mass_properties().centroid, 4)) for one in found]
    for solid in solids:
        at = key.index(tuple(np.round(solid.mass_properties().centroid, 4)))
        twin = found[at]
        assert twin.mass_properties().volume == pytest.approx(solid.mass_properties().volume, rel=rel)
        assert sorted(map(len, twin.faces)) == sorted(map(len, solid.faces))
        assert np.abs(twin.mass_properties().inertia - solid.mass_properties().inertia).max() < rel
    areas = [sorted(one.area for one in detect(assembly)) for assembly in (made, assembled(solids))]
    assert areas[0] == pytest.approx(areas[1], rel=100 * rel)


def assembled(solids: list[Polytope]) -> Assembly:
    from masonry_fem.solid.assembly import Block
    from masonry_fem.solid.pose import Pose

    shapes = tuple(Shape(str(number), solid) for number, solid in enumerate(solids))
    blocks = tuple(Block(str(number), number, Pose.identity(3)) for number in range(len(solids)))
    return Assembly(3, shapes, blocks)


@pytest.mark.parametrize("spec", [WALL, ARCH, RUBBLE], ids=["wall", "arch", "rubble"])
def test_stl_of_many_solids(tmp_path: Path, spec: Structure) -> None:
    solids = built(spec)
    write_stl(tmp_path / "a.stl", solids)
    made = reading(tmp_path / "a.stl", supports=("stone_0",))
    same(made, solids)
    assert made.blocks[0].name == "f.stone_0"
    assert [block.support for block in made.blocks] == [True] + [False] * (len(solids) - 1)


@pytest.mark.parametrize("spec", [WALL, ARCH, RUBBLE], ids=["wall", "arch", "rubble"])
def test_binary_stl_of_blocks_that_touch(tmp_path: Path, spec: Structure) -> None:
    """Triangles without solids, in single precision: touching blocks share corners and edges."""
    solids = built(spec)
    points, corners = soup(solids)
    rng = np.random.default_rng(0)
    meshio.write(tmp_path / "a.stl", meshio.Mesh(points, {"triangle": rng.permutation(corners)}), binary=True)
    made = reading(tmp_path / "a.stl")
    same(made, solids, rel=1e-5)
    assert made.blocks[-1].name == f"f.b{len(solids)}"


@pytest.mark.parametrize("key", ["o", "g"])
def test_obj_of_objects_or_groups_with_named_faces(tmp_path: Path, key: str) -> None:
    solids = built(WALL)
    write_obj(tmp_path / "a.obj", solids, key)
    made = reading(tmp_path / "a.obj")
    same(made, solids)
    assert made.blocks[3].name == "f.stone_3"
    assert set(made.shapes[0].solid.names) == {"left", "right", "front", "back", "bottom", "top"}
    assert made.solid(0).normal(made.shapes[0].solid.names.index("top")) == pytest.approx([0, 0, 1])


def test_obj_counts_from_the_end_and_goes_on_in_the_next_line(tmp_path: Path) -> None:
    text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf -4 -2 \\\n-3\nf 1 2 4\nf 2 3 4\nf 1/5/6 4//2 3\n"
    (tmp_path / "a.obj").write_text(text)
    (block,) = reading(tmp_path / "a.obj").blocks
    assert block.name == "f.b1"


@pytest.mark.parametrize("binary", [True, False])
def test_ply_of_bodies(tmp_path: Path, binary: bool) -> None:
    solids = built(RUBBLE)
    points, corners = soup(solids)
    meshio.write(tmp_path / "a.ply", meshio.Mesh(points, {"triangle": corners}), binary=binary)
    same(reading(tmp_path / "a.ply"), solids)


@pytest.mark.parametrize("ending", ["vtu", "vtk"])
@pytest.mark.parametrize("element", ["Q1", "P2"])
@pytest.mark.parametrize("field", [None, "block", "stone"])
def test_elements_with_and_without_a_field(
    tmp_path: Path, ending: str, element: str, field: str | None
) -> None:
    solids = built(WALL)
    points, cells, owner = [], [], []
    first = 0
    for number, solid in enumerate(solids):
        mesh = mesh_shape(Shape("s", solid), MeshSettings(element=element, divisions=(2, 1, 1)), 3)
        points.append(mesh.points)
        cells.append(mesh.cells + first)
        owner += [number] * len(mesh.cells)
        first += len(mesh.points)
    data = {} if field is None else {field: [np.array(owner)]}
    whole = meshio.Mesh(np.concatenate(points), {mesh.cell: np.concatenate(cells)}, cell_data=data)
    meshio.write(tmp_path / f"a.{ending}", whole)
    made = reading(tmp_path / f"a.{ending}", field="stone" if field == "stone" else None)
    same(made, solids)
    assert made.blocks[0].name == ("f.b1" if field is None else "f.b0")
    for shape in made.shapes:
        assert shape.mesh is not None
        assert shape.mesh.cell == mesh.cell
        check(shape.mesh, shape.solid)


def test_plane_elements(tmp_path: Path) -> None:
    points = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    meshio.write(tmp_path / "a.vtu", meshio.Mesh(points, {"triangle": np.array([[0, 1, 2], [0, 2, 3]])}))
    made = reading(tmp_path / "a.vtu", 2)
    assert made.solid(0).mass_properties().volume == pytest.approx(1.0)


@pytest.mark.parametrize("element", ["Q1", "P1"])
def test_closed_surfaces_are_meshed(tmp_path: Path, element: str) -> None:
    """Boxes get hexahedra, stones of rubble tetrahedra, from the faces that were put together."""
    for spec in (WALL, RUBBLE):
        write_stl(tmp_path / "a.stl", built(spec))
        made = reading(tmp_path / "a.stl")
        for shape in made.shapes[:4]:
            mesh = mesh_shape(shape, MeshSettings(element=element, size=0.2), 3)
            assert mesh.cell == ("hexahedron" if element == "Q1" and spec is WALL else "tetra")
            check(mesh, shape.solid)


def test_a_face_that_goes_straight_on_where_others_bend_is_meshed(tmp_path: Path) -> None:
    """Two slopes of a roof begin at one eave: the wall below it keeps the corner between them."""
    points = np.array([[0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [2, 0, 1],
                       [2, 1, 2], [1, 1, 2], [1, 1, 1.5], [0, 1, 1.5]])  # fmt: skip
    loops = ((3, 2, 1, 0), (0, 1, 6, 5, 4), (1, 2, 7, 6), (2, 3, 10, 9, 8, 7), (3, 0, 4, 10), (4, 5, 9, 10),
             (5, 6, 7, 8), (5, 8, 9))  # fmt: skip
    solid = Polytope(points.astype(float), loops)
    write_stl(tmp_path / "a.stl", [solid])
    shape = reading(tmp_path / "a.stl").shapes[0]
    assert sorted(map(len, shape.solid.faces)) == [3, 4, 4, 4, 4, 4, 5, 6]
    mesh = mesh_shape(shape, MeshSettings(element="P1", size=0.5), 3)
    check(mesh, shape.solid)


def test_scale_and_a_surface_turned_inside_out(tmp_path: Path) -> None:
    solids = built(WALL)
    inside_out = [
        Polytope(1000 * one.vertices, tuple(loop[::-1] for loop in one.faces), one.names) for one in solids
    ]
    write_obj(tmp_path / "a.obj", inside_out)
    same(reading(tmp_path / "a.obj", scale=1e-3), solids)


def test_faces_written_twice_count_once(tmp_path: Path) -> None:
    """From another corner on they are the same faces; turned round they are not (see below)."""
    path = tmp_path / "a.obj"
    write_obj(path, [CUBE, CUBE.moved(Pose(np.eye(3), np.array([2.0, 0.0, 0.0])))])
    lines = path.read_text().splitlines()
    face = next(line.split() for line in lines if line.startswith("f "))
    lines.insert(lines.index(" ".join(face)), " ".join(["f", *face[2:], face[1]]))
    path.write_text("\n".join(lines))
    with gathered() as remarks:
        made = reading(path)
    assert [len(shape.solid.faces) for shape in made.shapes] == [6, 6]
    assert [shape.solid.mass_properties().volume for shape in made.shapes] == pytest.approx([1.0, 1.0])
    assert [(one.code, one.blocks) for one in remarks] == [("renamed", ()), ("doubled_faces", ("f.stone_0",))]
    assert "has 1 faces a second time (in 1 blocks, 'stone_0' the first)" in remarks[1].sentence


def test_dome_of_compas_with_every_face_twice(shared_data: Path, caplog: pytest.LogCaptureFixture) -> None:
    made = reading(shared_data / "compas" / "dem_dome.obj")
    assert len(made.blocks) == 90
    assert "has 720 faces a second time (in 90 blocks" in caplog.text


def test_names_that_were_changed_are_told(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    """Names that the file tells apart stay apart, though selectors know them as the same."""
    path = tmp_path / "a.obj"
    write_obj(path, [CUBE.moved(Pose(np.eye(3), np.array([2.0 * k, 0.0, 0.0]))) for k in range(3)])
    text = path.read_text().replace("stone 1", "stone*0").replace("stone 2", "plinth")
    path.write_text(text)
    made = reading(path)
    assert [block.name for block in made.blocks] == ["f.stone_0", "f.stone_0_2", "f.plinth"]
    assert (
        "structures.f.path 'a.obj': 2 names were changed for selectors, or to tell them apart: "
        "'stone 0' is 'stone_0', 'stone*0' is 'stone_0_2'" in caplog.text
    )


# --- what is broken ---------------------------------------------------------------------------


def broken(tmp_path: Path, name: str) -> Path:
    path = tmp_path / "a.obj"
    write_obj(path, [CUBE])
    lines = path.read_text().splitlines()
    faces = [at for at, line in enumerate(lines) if line.startswith("f ")]
    corner = next(at for at, line in enumerate(lines) if line.startswith("v "))
    match name:
        case "open":
            del lines[faces[2]]
        case "flipped":
            lines[faces[2]] = "f " + " ".join(lines[faces[2]].split()[:0:-1])
        case "twice":
            lines.append(" ".join(lines[faces[2]].split()[:4]))  # a part of it, as a triangle
        case "nan":
            lines[corner] = "v nan 0 0"
        case "comma":
            lines[corner] = "v 0,5 0 0"
        case "unknown corner":
            lines[faces[2]] = "f 1 2 99"
        case "two corners":
            lines[faces[2]] = "f 1 2"
        case "flat":
            lines = [
                line if not line.startswith("v ") else " ".join([*line.split()[:3], "0"]) for line in lines
            ]
        case "empty":
            lines = ["# nothing"]
    path.write_text("\n".join(lines))
    return path


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("open", r"block 'stone_0' is not closed: 4 edges have one face, the first at \(.*fill the holes"),
        ("flipped", r"block 'stone_0': the faces on the two sides of 4 edges.*turned against each other"),
        ("twice", r"block 'stone_0(_2)?'(: more than two faces meet|.* no mere lines, expected a closed)"),
        ("nan", r"block 'stone_0' has a point that is no number, .nan, 0, 0., 1 of 8"),
        ("comma", r"line 3: '0,5 0 0' are no coordinates, expected 3 numbers; write decimal points"),
        (
            "unknown corner",
            r"line 17: a face has the corner '99', expected the number of one of the 8 points",
        ),
        ("two corners", r"line 17: a face has 2 corners, expected 3 or more"),
        ("flat", r"block 'stone_0' has 2 faces that are no mere lines|bounds a volume|more than two faces"),
        ("empty", r"holds no face"),
    ],
)
def test_broken_surfaces_are_named(tmp_path: Path, name: str, said: str) -> None:
    with pytest.raises(GeometryError, match=said):
        reading(broken(tmp_path, name))


def test_a_triangle_that_is_missing_or_turned_in_a_binary_file(tmp_path: Path) -> None:
    points, corners = soup([CUBE])
    meshio.write(tmp_path / "a.stl", meshio.Mesh(points, {"triangle": corners[1:]}), binary=True)
    with pytest.raises(GeometryError, match="not closed: 3 edges"):
        reading(tmp_path / "a.stl")
    corners[0] = corners[0, ::-1]
    meshio.write(tmp_path / "a.stl", meshio.Mesh(points, {"triangle": corners}), binary=True)
    with pytest.raises(GeometryError, match="sides of 3 edges"):
        reading(tmp_path / "a.stl")


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("a.stl", b"\0" * 80 + struct.pack("<I", 5) + b"\0" * 60, "has 144 bytes, expected .* 334 bytes"),
        ("a.stl", b"", "has 0 bytes, expected .* 84 bytes"),
        ("a.stl", b"solid a\nfacet\nouter loop\nvertex 0 0 0\n", "ends within solid 'a'"),
        ("a.stl", b"solid a\nfacet\nouter loop\nvertex 0 0 0\nendloop\n", "not three corners"),
        ("a.ply", b"ply\nformat nonsense\n", r"has no line .end_header"),
        ("a.vtu", b"<VTKFile>", "meshio cannot read it"),
        ("a.json", b"{", "is no JSON"),
    ],
)
def test_damaged_files_are_named(tmp_path: Path, name: str, content: bytes, said: str) -> None:
    (tmp_path / name).write_bytes(content)
    with pytest.raises(GeometryError, match=said):
        reading(tmp_path / name)


def test_what_elements_must_be(tmp_path: Path) -> None:
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [0, 1, 1]])
    path = tmp_path / "a.vtu"
    meshio.write(path, meshio.Mesh(points, {"wedge": np.arange(6)[None]}))
    with pytest.raises(GeometryError, match="has elements 'wedge', expected tetra, hexahedron"):
        reading(path)
    meshio.write(path, meshio.Mesh(points, {"triangle": np.array([[0, 1, 2]])}))
    with pytest.raises(GeometryError, match=r"has no volume elements.*surface as \.stl"):
        reading(path)
    tetra = meshio.Mesh(points, {"tetra": np.array([[0, 1, 2, 3]])}, cell_data={"part": [np.array([0.5])]})
    meshio.write(path, tetra)
    with pytest.raises(GeometryError, match=r"no cell field 'stone', expected one of its own \('part'\)"):
        reading(path, field="stone")
    with pytest.raises(GeometryError, match="'part' is not one whole number a cell"):
        reading(path, field="part")
    assert len(reading(path).blocks) == 1


def test_surfaces_need_space(tmp_path: Path) -> None:
    write_obj(tmp_path / "a.obj", [CUBE])
    with pytest.raises(GeometryError, match="dimension = 3"):
        reading(tmp_path / "a.obj", 2)


# --- polygons ---------------------------------------------------------------------------------


@given(st.integers(0, 10**6), st.integers(4, 14))
@settings(max_examples=60)
def test_polygons_are_cut_into_triangles_of_their_area(seed: int, count: int) -> None:
    """Star-shaped polygons, mostly concave."""
    rng = np.random.default_rng(seed)
    angles = np.sort(rng.uniform(0, 2 * np.pi, count))
    assume(np.diff(angles, append=angles[0] + 2 * np.pi).max() <= 3.0)
    assume(np.diff(angles).min() >= 0.02)
    flat = rng.uniform(0.3, 1.0, count)[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])
    points = np.column_stack([flat, np.zeros(count)])
    pieces = [area_vector(points[list(one)])[2] for one in triangles_of(points, tuple(range(count)))]
    assert len(pieces) == count - 2
    assert min(pieces) >= 0
    assert sum(pieces) == pytest.approx(area_vector(points)[2], rel=1e-12)
    assert len(ears(flat)) == count - 2


def test_a_warped_face_is_cut_alike_from_both_sides() -> None:
    points = np.array([[0, 0, 0], [1, 0, 0.1], [1, 1, 0], [0, 1, 0.1]], float)
    for shift in range(4):
        loop = tuple((i + shift) % 4 for i in range(4))
        cuts = {frozenset(one) for one in triangles_of(points, loop)}
        assert cuts == {frozenset(one) for one in triangles_of(points, loop[::-1])}
        assert cuts == {frozenset(one) for one in triangles_of(points, (0, 1, 2, 3))}


def test_bodies_that_share_an_edge_or_a_face_are_told_apart() -> None:
    corners = np.array([[x, y, z] for z in range(2) for y in range(3) for x in range(3)], float)
    number = {tuple(p): i for i, p in enumerate(corners.astype(int).tolist())}
    loops = []
    for x, y in ((0, 0), (1, 0), (1, 1)):  # the second touches both in faces; the others share an edge
        box = Polytope.box((x, y, 0.0), (x + 1.0, y + 1.0, 1.0))
        loops += [tuple(number[tuple(p)] for p in box.face_points(f).astype(int).tolist()) for f in range(6)]
    order = np.random.default_rng(1).permutation(18)
    found = bodies_of(corners, [loops[i] for i in order])
    assert len(set(found)) == 3
    assert {frozenset(order[found == body] // 6) for body in range(3)} == {frozenset({i}) for i in range(3)}


def test_ply_with_corners_that_are_not_there(tmp_path: Path) -> None:
    head = (
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty double x\nproperty double y\nproperty double z\n"
    )
    head += "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n"
    (tmp_path / "bad.ply").write_text(head + "3 0 1 7\n")
    with pytest.raises(GeometryError, match="has the corner 7, expected the number of one of the 3 points"):
        reading(tmp_path / "bad.ply")


@pytest.mark.parametrize("word", ["nan", "inf", "1e400"])
def test_ply_with_coordinates_that_are_none(tmp_path: Path, word: str) -> None:
    points = ["0 0 0", "1 0 0", "0 1 0", f"0 0 {word}"]
    head = (
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty double x\nproperty double y\nproperty double z\n"
    )
    head += "element face 4\nproperty list uchar int vertex_indices\nend_header\n"
    faces = ["3 0 2 1", "3 0 1 3", "3 1 2 3", "3 0 3 2"]
    (tmp_path / "bad.ply").write_text("\n".join([head.strip(), *points, *faces, ""]))
    with pytest.raises(GeometryError, match="a point that is no number"):
        reading(tmp_path / "bad.ply")


@pytest.mark.parametrize(
    "text", ["", "ply\nformat ascii 1.0\nelement vertex 8\nproperty list uchar int vertex_ind"]
)
def test_ply_whose_header_has_no_end(tmp_path: Path, text: str) -> None:
    """It would be looked for without end."""
    (tmp_path / "cut.ply").write_text(text)
    with pytest.raises(GeometryError, match="has no line 'end_header'"):
        reading(tmp_path / "cut.ply")


def test_a_block_of_a_field_has_one_kind_of_elements(tmp_path: Path) -> None:
    """Each kind became a block of its own, and all blocks other numbers than the field's."""
    square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    cube = np.concatenate([square, square + np.array([0.0, 0.0, 1.0])])
    points = np.concatenate([cube, cube + 5.0, np.eye(4, 3) + 9.0])
    cells = [("hexahedron", np.arange(16).reshape(2, 8)), ("tetra", np.arange(16, 20)[None])]
    path = tmp_path / "a.vtu"
    meshio.Mesh(points, cells, cell_data={"block": [np.array([5, 7]), np.array([5])]}).write(path)
    with pytest.raises(GeometryError, match=r"block 5 of the cell field 'block' .*\(hexahedron, tetra\)"):
        reading(path)


@pytest.mark.parametrize("ending", ["obj", "stl"])
def test_parts_of_a_solid_have_names_that_no_other_has(
    tmp_path: Path, ending: str, caplog: pytest.LogCaptureFixture
) -> None:
    lines = []
    corner = 0
    for name, places in (("a", (0.0, 3.0)), ("a_1", (6.0,))):
        lines.append(f"o {name}" if ending == "obj" else f"solid {name}")
        for place in places:
            vertices = CUBE.vertices + np.array([place, 0.0, 0.0])
            if ending == "obj":
                lines += ["v " + " ".join(map(str, row)) for row in vertices]
                lines += ["f " + " ".join(str(1 + corner + i) for i in loop) for loop in CUBE.faces]
                corner += len(vertices)
            else:
                for one in triangles(CUBE):
                    lines += ["vertex " + " ".join(map(str, vertices[i])) for i in one] + ["endloop"]
        lines += ["endsolid"] * (ending == "stl")
    path = tmp_path / f"a.{ending}"
    path.write_text("\n".join(lines))
    assert [one.name for one in reading(path).blocks] == ["f.a_1", "f.a_2", "f.a_1_2"]
    assert "'a_1' is 'a_1_2'" in caplog.text
