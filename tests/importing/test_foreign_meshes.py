"""Meshes of other programs: .inp of Abaqus and CalculiX, .unv and .med through gmsh."""

from pathlib import Path

import gmsh
import numpy as np
import pytest

from masonry_fem.contact.detection import detect
from masonry_fem.errors import GeometryError
from masonry_fem.importing.abaqus import read_abaqus
from masonry_fem.importing.mesh_files import read
from masonry_fem.scene.specs import MeshSettings
from masonry_fem.structures.file import FileStructure
from tests.importing.test_mesh_files import two_boxes
from tests.meshing.test_meshing import check

BOX = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))
EDGES = ((0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7))
SQUARE = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0))


def reading(path: Path, dimension: int = 3, **keys):
    return read(
        FileStructure(name="f", material="s", path=path.name, **keys), dimension, path.parent, MeshSettings()
    )


def lines_of(points, start=1):
    return [
        f"{start + i}, {x:g}, {y:g}, {z:g}" for i, (x, y, z) in enumerate(np.asarray(points, float).tolist())
    ]


def stack(tmp_path: Path, *, kind="C3D8", more="", element="") -> Path:
    """Two unit cubes, one on the other, that share four nodes; each element on two lines."""
    points = [*BOX, *((x, y, 2) for x, y, _ in BOX[:4])]
    cells = [(1, range(1, 9)), (2, [5, 6, 7, 8, 9, 10, 11, 12])]
    text = [
        "*Heading",
        "** a comment",
        "*Node, nset=Nall",
        *lines_of(points),
        f"*Element, type={kind}{element}",
    ]
    for number, nodes in cells:
        first, last = list(nodes)[:4], list(nodes)[4:]
        text += [f"{number}, {', '.join(map(str, first))},", ", ".join(map(str, last))]
    path = tmp_path / "stack.inp"
    path.write_text("\n".join([*text, more, ""]))
    return path


@pytest.mark.parametrize("kind", ["C3D8", "C3D8R", "c3d8i"])
def test_sets_of_elements_are_blocks_and_surfaces_name_faces(tmp_path, kind):
    more = (
        "*ELSET, ELSET=Eall, GENERATE\n1, 2, 1\n*ELSET, ELSET=lower\n1,\n*ELSET, ELSET=upper\n2\n"
        "*SURFACE, NAME=crown, TYPE=ELEMENT\nupper, S2\n*MATERIAL, NAME=stone\n*ELASTIC\n1e10, 0.2\n"
    )
    made = reading(stack(tmp_path, kind=kind, more=more), supports=("low*",))
    assert [block.name for block in made.blocks] == ["f.lower", "f.upper"]
    assert [block.support for block in made.blocks] == [True, False]
    for shape in made.shapes:
        check(shape.mesh, shape.solid)
    solid = made.shapes[1].solid
    (named,) = [i for i, name in enumerate(solid.names) if name == "crown"]
    np.testing.assert_allclose(solid.vertices[list(solid.faces[named])][:, 2], 2.0)
    (joint,) = detect(made)
    assert joint.area == pytest.approx(1.0)


def test_without_sets_that_part_the_solids_those_of_the_elements_are_blocks(tmp_path):
    overlapping = "*ELSET, ELSET=Eall, GENERATE\n1, 2\n*ELSET, ELSET=some\n1\n"
    made = reading(stack(tmp_path, element=", ELSET=Wall/A", more=overlapping))
    assert [block.name for block in made.blocks] == ["f.Wall_A"], "what is one in the file stays one"
    made = reading(stack(tmp_path))
    assert [block.name for block in made.blocks] == ["f.b1"]


def test_sets_of_sets(tmp_path):
    more = "*ELSET, ELSET=a\n1\n*ELSET, ELSET=b\n2\n*ELSET, ELSET=all\na, b\n"
    assert [block.name for block in reading(stack(tmp_path, more=more)).blocks] == ["f.a", "f.b"]
    with pytest.raises(GeometryError, match="holds itself"):
        reading(stack(tmp_path, more="*ELSET, ELSET=a\nb\n*ELSET, ELSET=b\na\n"))


@pytest.mark.parametrize("kind", ["C3D20", "C3D20R"])
def test_serendipity_elements_get_their_missing_nodes(tmp_path, kind):
    """A face bulges by a parabola: nodes in its middle are where the 20-node functions put them."""

    def bulging(points):
        points = np.array(points, float)
        points[:, 2] += 0.2 * (points[:, 2] > 0.9) * (1 - (2 * points[:, 0] - 1) ** 2)
        return points

    middles = [0.5 * (np.array(BOX[a]) + BOX[b]) for a, b in EDGES]
    points = bulging([*BOX, *middles])
    right = points + np.array([1.0, 0, 0])
    text = ["*NODE", *lines_of(points), *lines_of(right, 21), f"*ELEMENT, TYPE={kind}, ELSET=E"]
    rows = [np.arange(1, 21), np.arange(21, 41)]
    same = {i + 1: j + 21 for i, p in enumerate(points) for j, q in enumerate(right) if np.allclose(p, q)}
    assert len(same) == 8
    rows[0] = np.array([same.get(n, n) for n in rows[0]])
    text += [
        f"{1 + i}, {', '.join(map(str, row[:10]))},\n{', '.join(map(str, row[10:]))}"
        for i, row in enumerate(rows)
    ]
    (tmp_path / "two.inp").write_text("\n".join(text))
    found = read_abaqus(tmp_path / "two.inp", 3, "two.inp")
    ((_, elements),) = found.parts
    assert elements.kind == "hexahedron27"
    assert len(np.unique(elements.nodes)) == 27 + 18, "nine nodes are shared, the one in the face among them"
    top = found.points[elements.nodes[:, 25]]
    np.testing.assert_allclose(top, [[0.5, 0.5, 1.2], [1.5, 0.5, 1.2]], atol=1e-12)
    np.testing.assert_allclose(found.points[elements.nodes[:, 24]][:, 2], 0.0, atol=1e-12)
    np.testing.assert_allclose(found.points[elements.nodes[:, 26]][:, 2], 0.6, atol=1e-12)
    assert reading(tmp_path / "two.inp").shapes[0].mesh.cell == "hexahedron27"


@pytest.mark.parametrize("kind", ["CPS4", "CPE4R", "CPS8"])
def test_plane_elements(tmp_path, kind):
    middles = [0.5 * (np.array(SQUARE[i]) + SQUARE[(i + 1) % 4]) for i in range(4)]
    points = [*SQUARE, *middles] if "8" in kind else SQUARE
    text = [
        "*NODE",
        *lines_of(points),
        f"*ELEMENT, TYPE={kind}",
        f"1, {', '.join(str(i + 1) for i in range(len(points)))}",
    ]
    text += ["*SURFACE, NAME=top", "1, S3"]
    path = tmp_path / "one.inp"
    path.write_text("\n".join(text))
    made = reading(path, 2)
    assert made.shapes[0].mesh.cell == ("quad9" if "8" in kind else "quad")
    assert "top" in made.shapes[0].solid.names
    with pytest.raises(GeometryError, match=r"no solid \(C3D\) elements"):
        reading(path, 3)


def test_instances_are_moved_and_turned(tmp_path):
    part = [
        "*Part, name=brick",
        "*Node",
        *lines_of(BOX),
        "*Element, type=C3D8",
        "1,1,2,3,4,5,6,7,8",
        "*End Part",
    ]
    text = [
        "*Heading", *part, "*Assembly, name=A", "*Instance, name=left, part=brick", "*End Instance",
        "*Instance, name=right, part=brick", "3., 0., 0.", "3., 0., 0., 3., 0., 1., 90.", "*End Instance",
        "*Nset, nset=x, instance=left", "1,", "*End Assembly",
    ]  # fmt: skip
    path = tmp_path / "two.inp"
    path.write_text("\n".join(text))
    made = reading(path)
    assert [block.name for block in made.blocks] == ["f.left", "f.right"]
    np.testing.assert_allclose(made.shapes[1].mesh.points.min(axis=0), [2, 0, 0], atol=1e-12)
    np.testing.assert_allclose(made.shapes[1].mesh.points.max(axis=0), [3, 1, 1], atol=1e-12)
    path.write_text("\n".join(text).replace("right, part=brick", "right, part=stone"))
    with pytest.raises(GeometryError, match="part 'STONE', expected one of BRICK"):
        reading(path)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("*Node, nset=Nall", "*Include, input=nodes.inp\n*Node"), "put them together"),
        (("5, 6, 7, 8", "5, 6, 7, 99"), "the node 99"),
        (("1, 0, 0, 0", "1, 0, 0, O"), "are no numbers"),
        (("5, 6, 7, 8", "5, 6, 7"), "cut off or damaged"),
        (("type=C3D8", "type=C3D6"), "no solid"),
        (("*Element, type=C3D8", "*ELSET, ELSET=a\na\n*Element, type=C3D6"), "no solid"),
        (("*Element, type=C3D8", "*Element"), "no TYPE="),
    ],
)  # fmt: skip
def test_damaged_files_are_told(tmp_path, change, said):
    path = stack(tmp_path)
    text = path.read_text()
    assert change[0] in text
    path.write_text(text.replace(*change, 1))
    with pytest.raises(GeometryError, match=said):
        reading(path)


def test_what_gmsh_writes_as_inp(tmp_path):
    path = two_boxes(tmp_path / "two.msh")
    gmsh.initialize(interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.open(str(path))
    gmsh.option.setNumber("Mesh.SaveGroupsOfElements", 1)
    gmsh.write(str(tmp_path / "two.inp"))
    gmsh.finalize()
    ours, theirs = reading(tmp_path / "two.inp"), reading(path)
    assert [block.name for block in ours.blocks] == [block.name for block in theirs.blocks]
    for one, other in zip(ours.shapes, theirs.shapes, strict=True):
        assert len(one.mesh.cells) == len(other.mesh.cells)
        np.testing.assert_allclose(one.mesh.points.max(axis=0), other.mesh.points.max(axis=0), atol=1e-9)


@pytest.mark.parametrize("ending", [".unv", ".med"])
def test_salome_and_ideas_through_gmsh(tmp_path, ending, caplog):
    two_boxes(tmp_path / "two.msh")
    gmsh.initialize(interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.open(str(tmp_path / "two.msh"))
    gmsh.option.setNumber("Mesh.SaveGroupsOfElements", 1)
    path = tmp_path / f"two{ending}"
    gmsh.write(str(path))
    gmsh.finalize()
    made = reading(path)
    assert [block.name for block in made.blocks] == ["f.lower", "f.upper"]
    assert "crown" in made.shapes[1].solid.names
    for shape in made.shapes:
        check(shape.mesh, shape.solid)
    (joint,) = detect(made)
    assert joint.area == pytest.approx(1.0)
    assert not caplog.records
    path.write_text('SystemCall "touch ran";\n')
    with pytest.raises(GeometryError, match="begins with"):
        reading(path)
