"""Files: msh 2.2 and 4.1, geo, step; groups, names, bodies without groups, errors."""

from __future__ import annotations

from pathlib import Path

import gmsh
import numpy as np
import pytest

from masonry_fem.contact.detection import detect
from masonry_fem.errors import GeometryError, SceneError
from masonry_fem.fem.lagrange import lagrange, quadrature
from masonry_fem.importing.mesh_files import read
from masonry_fem.meshing.cells import turned
from masonry_fem.meshing.session import session
from masonry_fem.records.remark import gathered
from masonry_fem.scene.specs import MeshSettings
from masonry_fem.structures.file import FileStructure
from tests.meshing.test_meshing import check


def reading(path: Path, dimension: int = 3, element: str | None = "Q1", size: float | None = None, **keys):
    spec = FileStructure(name="f", material="s", path=path.name, **{"trusted": True} | keys)
    return read(spec, dimension, path.parent, MeshSettings(element=element, size=size))


def two_boxes(
    path: Path, *, groups: bool = True, order: int = 1, hexahedra: bool = False, version: float = 4.1
) -> Path:
    """Two unit boxes that share their nodes in the file, written by gmsh."""
    gmsh.initialize(interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.option.setNumber("Mesh.MshFileVersion", version)
    gmsh.option.setNumber("Mesh.MeshSizeMax", 0.6)
    gmsh.model.occ.addBox(0, 0, 0, 1, 1, 1)
    gmsh.model.occ.addBox(0, 0, 1, 1, 1, 1)
    if path.suffix == ".msh":
        gmsh.model.occ.fragment([(3, 1)], [(3, 2)])
    gmsh.model.occ.synchronize()
    if groups:
        gmsh.model.addPhysicalGroup(3, [1], name="lower")
        gmsh.model.addPhysicalGroup(3, [2], name="upper")
        top = [s for _, s in gmsh.model.getEntities(2) if gmsh.model.occ.getCenterOfMass(2, s)[2] > 1.99]
        gmsh.model.addPhysicalGroup(2, top, name="crown")
    if path.suffix == ".msh":
        if hexahedra:
            for dimension in (1, 2, 3):
                for _, tag in gmsh.model.getEntities(dimension):
                    if dimension == 1:
                        gmsh.model.mesh.setTransfiniteCurve(tag, 3)
                    elif dimension == 2:
                        gmsh.model.mesh.setTransfiniteSurface(tag)
                        gmsh.model.mesh.setRecombine(2, tag)
                    else:
                        gmsh.model.mesh.setTransfiniteVolume(tag)
        gmsh.model.mesh.generate(3)
        gmsh.model.mesh.setOrder(order)
    gmsh.write(str(path))
    gmsh.finalize()
    return path


@pytest.mark.parametrize("version", [2.2, 4.1])
@pytest.mark.parametrize("hexahedra", [False, True])
@pytest.mark.parametrize("order", [1, 2])
def test_msh_with_groups(tmp_path: Path, version: float, hexahedra: bool, order: int) -> None:
    path = two_boxes(tmp_path / "two.msh", version=version, hexahedra=hexahedra, order=order)
    made = reading(path, supports=("low*",))
    assert [block.name for block in made.blocks] == ["f.lower", "f.upper"]
    assert [block.support for block in made.blocks] == [True, False]
    for shape in made.shapes:
        assert shape.mesh is not None
        assert len(shape.solid.faces) == 6
        check(shape.mesh, shape.solid)
    assert "crown" in made.shapes[1].solid.names
    # nodes shared in the file are doubled: the blocks meet in one joint
    (joint,) = detect(made)
    assert joint.area == pytest.approx(1.0)
    assert joint.label == "joint"


def test_bodies_without_groups(tmp_path: Path) -> None:
    path = tmp_path / "apart.geo"
    path.write_text(
        'SetFactory("OpenCASCADE");\nBox(1) = {0, 0, 0, 1, 1, 1};\nBox(2) = {2, 0, 0, 1, 2, 1};\n'
    )
    made = reading(path, element="P1", size=0.7)
    assert [block.name for block in made.blocks] == ["f.b1", "f.b2"]
    volumes = [shape.solid.mass_properties().volume for shape in made.shapes]
    assert sorted(volumes) == pytest.approx([1.0, 2.0])


def test_volumes_that_share_nodes_are_blocks_of_their_own(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    made = reading(two_boxes(tmp_path / "two.msh", groups=False, version=4.1))
    assert [block.name for block in made.blocks] == ["f.b1", "f.b2"]
    (joint,) = detect(made)
    assert joint.area == pytest.approx(1.0)
    (warned,) = caplog.records
    assert "some of its 2 volumes share nodes" in warned.getMessage()
    assert "physical group" in warned.getMessage()


def test_step_is_read_in_metres(tmp_path: Path) -> None:
    """gmsh writes STEP in millimetres, so its unit boxes are cubes of 1 mm."""
    made = reading(two_boxes(tmp_path / "two.step", groups=False), element="P2", size=0.6e-3)
    assert len(made.blocks) == 2
    assert made.shapes[0].solid.mass_properties().volume == pytest.approx(1e-9, rel=1e-9)
    assert made.shapes[0].mesh is not None
    assert made.shapes[0].mesh.cell == "tetra10"


def test_scale(tmp_path: Path) -> None:
    made = reading(two_boxes(tmp_path / "two.msh"), scale=1e-3)
    assert made.shapes[0].solid.mass_properties().volume == pytest.approx(1e-9)


def test_groups_whose_names_selectors_would_misread(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    path = tmp_path / "a.geo"
    path.write_text(MILLIMETRES.replace('"stone"', '"left/[right] one"'))
    assert reading(path, scale=1e-3).blocks[0].name == "f.left__right_ one"
    assert "'left/[right] one' is 'left__right_ one'" in caplog.text


MILLIMETRES = """
SetFactory("OpenCASCADE");
Box(1) = {0, 0, 0, 400, 300, 200};
Physical Volume("stone") = {1};
Mesh.ElementOrder = 2;
"""


def test_size_is_in_metres_whatever_the_unit_of_the_file(tmp_path: Path) -> None:
    """Half the size has some eight times as many tetrahedra; a size larger than the box changes nothing."""
    path = tmp_path / "millimetres.geo"
    path.write_text(MILLIMETRES)
    count = {
        size: len(reading(path, element="P1", size=size, scale=1e-3).shapes[0].mesh.cells)
        for size in (None, 1.0, 0.04, 0.02)
    }
    assert count[None] == count[1.0]
    assert 5 < count[0.02] / count[0.04] < 12


@pytest.mark.parametrize(
    ("element", "cell"), [(None, "tetra10"), ("Q1", "tetra"), ("P1", "tetra"), ("P2", "tetra10")]
)
def test_order_of_the_file_is_kept_unless_the_scene_names_one(
    tmp_path: Path, element: str | None, cell: str
) -> None:
    path = tmp_path / "quadratic.geo"
    path.write_text(MILLIMETRES)
    assert reading(path, element=element, scale=1e-3).shapes[0].mesh.cell == cell


def test_plane_figure(tmp_path: Path) -> None:
    path = tmp_path / "plane.geo"
    path.write_text(
        "Point(1) = {0,0,0}; Point(2) = {2,0,0}; Point(3) = {1,1,0};\n"
        "Line(1) = {1,2}; Line(2) = {2,3}; Line(3) = {3,1};\n"
        "Curve Loop(1) = {1,2,3}; Plane Surface(1) = {1};\n"
        'Physical Surface("gable") = {1}; Physical Curve("base") = {1};\n'
    )
    made = reading(path, dimension=2, element="P1", size=0.5)
    solid = made.shapes[0].solid
    assert len(solid.faces) == 3
    assert solid.normal(solid.names.index("base")) == pytest.approx([0.0, -1.0])
    assert made.shapes[0].mesh is not None
    check(made.shapes[0].mesh, solid)


def test_keystone_arch(repository: Path) -> None:
    """The project's own mesh: 13 blocks, 12 joints, the keystone's top named; geo and msh agree."""
    for suffix in ("msh", "geo"):
        made = reading(repository / "meshes" / f"keystone_arch.{suffix}", supports=("footing_*",))
        assert len(made.blocks) == 13
        assert sum(block.support for block in made.blocks) == 2
        assert len(detect(made)) == 12
        key = next(i for i, block in enumerate(made.blocks) if block.name == "f.keystone")
        top = made.shapes[key].solid.names.index("keystone_top")
        assert made.shapes[key].solid.normal(top) @ [0, 0, 1] > 0.9
        for shape in made.shapes:
            assert shape.mesh is not None
            check(shape.mesh, shape.solid)


def test_errors_say_what_to_do(tmp_path: Path) -> None:
    with pytest.raises(GeometryError, match="no file"):
        reading(tmp_path / "missing.msh")
    strange = tmp_path / "a.dwg"
    strange.write_text("solid\n")
    with pytest.raises(GeometryError, match=r"\.msh, \.unv, \.med, \.geo"):
        reading(strange)
    broken = tmp_path / "broken.msh"
    broken.write_text("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\nnonsense\n")
    with pytest.raises(GeometryError):
        reading(broken)
    flat = tmp_path / "flat.geo"
    flat.write_text("Point(1) = {0,0,0};\n")
    with pytest.raises(GeometryError, match="no volume elements"):
        reading(flat)
    path = two_boxes(tmp_path / "two.msh")
    with pytest.raises(GeometryError, match="selects no block"):
        reading(path, supports=("bottom",))


def test_mirrored_block_is_turned(tmp_path: Path) -> None:
    """A block meshed inside out (negative volumes) is read with positive ones."""
    path = tmp_path / "mirrored.msh"
    nodes = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$Nodes", "4"]
    lines += [f"{i + 1} {x} {y} {z}" for i, (x, y, z) in enumerate(nodes)]
    lines += ["$EndNodes", "$Elements", "1", "1 4 2 1 1 1 3 2 4", "$EndElements", ""]
    path.write_text("\n".join(lines))
    made = reading(path)
    assert made.shapes[0].solid.mass_properties().volume == pytest.approx(1 / 6)


def test_named_facets_that_no_block_has_outside_are_told(tmp_path: Path) -> None:
    """A square is named by two triangles along one diagonal; its tetrahedra may part it by the other."""
    nodes = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 0.5, -1]])
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat"]
    lines += ["$PhysicalNames", "2", '2 7 "top"', '3 8 "stone"', "$EndPhysicalNames", "$Nodes", "5"]
    lines += [f"{i + 1} {x} {y} {z}" for i, (x, y, z) in enumerate(nodes)]
    lines += ["$EndNodes", "$Elements", "4", "1 4 2 8 1 1 3 2 5", "2 4 2 8 1 1 4 3 5"]
    for diagonal, lost in ((("1 2 3", "1 3 4"), False), (("1 2 4", "2 3 4"), True)):
        path = tmp_path / "pyramid.msh"
        named = [f"{3 + i} 2 2 7 2 {row}" for i, row in enumerate(diagonal)]
        path.write_text("\n".join([*lines, *named, "$EndElements", ""]))
        with gathered() as remarks:
            solid = reading(path).shapes[0].solid
        assert [one.code for one in remarks] == ["names_inside"] * lost
        assert ("top" in solid.labels) == (not lost)
    assert "(of 'top' 2)" in remarks[0].sentence


@pytest.mark.parametrize("element", ["P1", "P2"])
def test_clockwise_surface_is_turned(tmp_path: Path, element: str) -> None:
    """A plane surface drawn clockwise has negative elements of either order."""
    path = tmp_path / "clockwise.geo"
    path.write_text(
        "Point(1) = {0,0,0}; Point(2) = {0,1,0}; Point(3) = {1,1,0}; Point(4) = {1,0,0};\n"
        "Line(1) = {1,2}; Line(2) = {2,3}; Line(3) = {3,4}; Line(4) = {4,1};\n"
        "Curve Loop(1) = {1,2,3,4}; Plane Surface(1) = {1};\n"
    )
    shape = reading(path, dimension=2, element=element, size=0.4).shapes[0]
    assert shape.mesh is not None
    check(shape.mesh, shape.solid)


@pytest.mark.parametrize("cell", ["triangle6", "quad9", "tetra10", "hexahedron27"])
def test_turned_cell_of_order_two(cell: str) -> None:
    """Mirrored and turned, a cell has the volume that it had."""
    nodes = lagrange(cell).nodes
    mirrored = nodes * ([-1.0] + [1.0] * (nodes.shape[1] - 1))
    points, weights = quadrature(cell)
    gradients = lagrange(cell).gradients(points)
    jacobian = np.einsum("pkt,kd->pdt", gradients, mirrored[turned(cell)])
    assert np.linalg.det(jacobian) == pytest.approx(np.ones(len(weights)))


def test_bodies_outside_the_groups_are_told(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    path = tmp_path / "partly.geo"
    path.write_text(
        'SetFactory("OpenCASCADE");\nBox(1) = {0, 0, 0, 1, 1, 1};\nBox(2) = {0, 0, 1, 1, 1, 1};\n'
        'Physical Volume("a") = {1};\n'
    )
    assert len(reading(path, element="P1", size=0.7).blocks) == 1
    assert "no physical group" in caplog.text


def test_each_file_is_blamed_for_its_own_errors(tmp_path: Path) -> None:
    for name in ("first", "second"):
        (tmp_path / f"{name}.geo").write_text("Point(1) = {0,0\nwrong\n")
    with pytest.raises(GeometryError, match=r"first\.geo', line"):
        reading(tmp_path / "first.geo")
    with pytest.raises(GeometryError, match=r"second\.geo', line"):
        reading(tmp_path / "second.geo")


@pytest.mark.parametrize("error", [SceneError("block 'a' lacks a name"), TypeError("ours"), KeyError("x")])
def test_only_the_errors_of_gmsh_are_its_own(error: Exception) -> None:
    with pytest.raises(type(error)) as caught, session("wall.geo"):
        raise error
    assert caught.value is error


def test_what_gmsh_refuses_is_told_with_its_words() -> None:
    said = r"^wall\.geo: gmsh stopped with: .+; open"
    with pytest.raises(GeometryError, match=said), session("wall.geo") as own:
        own.model.occ.addBox(0, 0, 0, 0, 0, 0)


def test_elements_that_stand_in_the_file_twice(tmp_path: Path) -> None:
    """They have no outer face: each is the other's neighbour all around."""
    path = tmp_path / "twice.msh"
    lines = [
        "$MeshFormat",
        "2.2 0 8",
        "$EndMeshFormat",
        "$Nodes",
        "4",
        "1 0 0 0",
        "2 1 0 0",
        "3 0 1 0",
        "4 0 0 1",
    ]
    lines += ["$EndNodes", "$Elements", "2", "1 4 2 1 1 1 2 3 4", "2 4 2 1 1 1 2 3 4", "$EndElements", ""]
    path.write_text("\n".join(lines))
    with pytest.raises(GeometryError, match="no outer face"):
        reading(path)


def test_names_that_are_not_in_utf8(tmp_path: Path) -> None:
    text = 'SetFactory("OpenCASCADE");\nBox(1) = {0, 0, 0, 1, 1, 1};\nPhysical Volume("Gewölbe") = {1};\n'
    (tmp_path / "latin.geo").write_bytes(text.encode("latin-1"))
    with pytest.raises(GeometryError, match=r"latin\.geo' holds a name that is not in UTF-8"):
        reading(tmp_path / "latin.geo", element="P1")
