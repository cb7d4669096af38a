"""COMPAS: the forms in which compas, compas_assembly, compas_cra and compas_dem have written blocks."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from masonry_fem.contact.detection import detect
from masonry_fem.errors import GeometryError
from masonry_fem.scene.specs import MeshSettings
from masonry_fem.solid.assembly import Assembly
from masonry_fem.solid.polytope import Polytope
from masonry_fem.structures import build_structure
from masonry_fem.structures.file import FileStructure

OLD = {"dva": {"x": 0.0, "y": 0.0, "z": 0.0}, "dea": {}, "dfa": {}}
NEW = {"default_vertex_attributes": {"x": 0.0, "y": 0.0, "z": 0.0}, "default_edge_attributes": {},
       "default_face_attributes": {}}  # fmt: skip
BOXES = [
    Polytope.box((0.0, 0.0, 0.0), (1.0, 1.0, 0.5)),
    Polytope.box((0.2, 0.0, 0.5), (1.2, 1.0, 1.0)),
    Polytope.box((0.0, 0.0, 1.0), (1.0, 1.0, 1.5)),
]


def data(solid: Polytope, words: bool = False, defaults: dict[str, Any] = NEW) -> dict[str, Any]:
    """A half-edge mesh; corners are called by words in old files, zeros were left to the defaults."""
    key = str if words else int
    return defaults | {
        "attributes": {"name": None, "node": None},
        "vertex": {
            str(i): {axis: x for axis, x in zip("xyz", p, strict=True) if x or i}
            for i, p in enumerate(solid.vertices.tolist())
        },
        "face": {str(i): [key(v) for v in loop] for i, loop in enumerate(solid.faces)},
        "facedata": {str(i): {} for i in range(6)},
        "edgedata": {},
    }


def mesh(solid: Polytope) -> dict[str, Any]:
    return {"dtype": "compas.datastructures/Mesh", "data": data(solid), "name": "Box", "guid": "1"}


def mesh_of_compas_1(solid: Polytope) -> dict[str, Any]:
    inner = {"compas": "0.17.3", "datatype": "compas.datastructures/Mesh", "data": data(solid, defaults=OLD)}
    return {"dtype": "compas.datastructures/Mesh", "value": inner}


def interface() -> dict[str, Any]:
    """What an edge of the graph holds: its mesh is no block."""
    return {
        "interfaces": [
            {"dtype": "compas_assembly.datastructures/Interface", "data": {"mesh": mesh(BOXES[0])}}
        ]
    }


def assembly(slot: str = "block", inner: str = "data", nested: bool = True) -> dict[str, Any]:
    nodes = {
        str(key): {slot: {"dtype": "compas_assembly.datastructures/Block", inner: data(solid), "guid": "2"}}
        for key, solid in zip((3, 1, 0), BOXES, strict=True)
    }
    nodes["3"]["is_support"] = True
    graph = {"attributes": {}, "node": nodes, "edge": {"3": {"1": interface()}}, "max_node": 3}
    wrapped = {"dtype": "compas.datastructures/Graph", inner: graph} if nested else graph
    return {"dtype": "compas_assembly.datastructures/Assembly", inner: {"attributes": {}, "graph": wrapped}}


def oldest() -> dict[str, Any]:
    """compas_assembly before it had dtypes: a network of centroids, and the blocks beside it."""
    vertex = {str(i): {"x": 0.0, "y": 0.0, "z": 0.0, "is_support": i == 0} for i in range(3)}
    blocks = {str(i): data(solid, words=True, defaults=OLD) for i, solid in enumerate(BOXES)}
    return {"assembly": {"attributes": {}, "vertex": vertex, "edge": {}, "halfedge": {}}, "blocks": blocks}


def model(matrix: Any = None) -> dict[str, Any]:
    """compas_dem: elements by guid, numbered by the nodes of a graph."""
    turn = None if matrix is None else {"dtype": "compas.geometry/Transformation", "data": {"matrix": matrix}}
    elements = {
        f"guid{i}": {
            "dtype": "compas_dem.elements/Block",
            "data": {"transformation": turn, "features": [], "name": "Block", "geometry": mesh(solid),
                     "is_support": i == 0},
        }
        for i, solid in enumerate(BOXES)
    }  # fmt: skip
    graph = {"attributes": {}, "node": {str(7 + i): {"element": f"guid{i}"} for i in range(3)},
             "edge": {"7": {"8": interface()}}}  # fmt: skip
    inner = {"transformation": None, "elements": elements, "materials": {}, "tree": {}, "graph": graph}
    return {"dtype": "compas_dem.models/BlockModel", "data": inner, "guid": "3"}


def reading(folder: Path, record: Any, **keys) -> Assembly:
    (folder / "a.json").write_text(record if isinstance(record, str) else json.dumps(record))
    spec = FileStructure(name="f", material="s", path="a.json", **keys)
    return build_structure(spec, 3, folder, MeshSettings())


@pytest.mark.parametrize(
    ("record", "names", "held"),
    [
        (assembly(), ("f.b3", "f.b1", "f.b0"), (True, False, False)),
        (assembly("part", "value"), ("f.b3", "f.b1", "f.b0"), (True, False, False)),
        (assembly("part", nested=False), ("f.b3", "f.b1", "f.b0"), (True, False, False)),
        (oldest(), ("f.b0", "f.b1", "f.b2"), (True, False, False)),
        (model(), ("f.b7", "f.b8", "f.b9"), (True, False, False)),
        ([mesh(one) for one in BOXES], ("f.b1", "f.b2", "f.b3"), (False,) * 3),
        ([[mesh_of_compas_1(one)] for one in BOXES], ("f.b1", "f.b2", "f.b3"), (False,) * 3),
    ],
    ids=["assembly", "compas 1", "flat graph", "oldest", "model", "list", "list of lists"],
)
def test_blocks_of_all_forms(
    tmp_path: Path, record: Any, names: tuple[str, ...], held: tuple[bool, ...]
) -> None:
    made = reading(tmp_path, record)
    assert tuple(block.name for block in made.blocks) == names
    assert tuple(block.support for block in made.blocks) == held
    for number, solid in enumerate(BOXES):
        found = made.solid(number)
        assert len(found.faces) == 6
        assert found.mass_properties().centroid == pytest.approx(solid.mass_properties().centroid)
        assert found.mass_properties().volume == pytest.approx(0.5)
    assert [one.area for one in detect(made)] == pytest.approx([0.8, 0.8])


@pytest.mark.parametrize("record", [mesh(BOXES[1]), mesh_of_compas_1(BOXES[1]), data(BOXES[1], defaults=OLD)])
def test_a_single_mesh(tmp_path: Path, record: Any) -> None:
    made = reading(tmp_path, record, supports=("b1",), scale=1e-3)
    assert made.solid(0).mass_properties().volume == pytest.approx(0.5e-9)
    assert made.blocks[0].support


def test_elements_are_moved_as_they_say(tmp_path: Path) -> None:
    """A quarter turn about z and a shift."""
    matrix = [[0, -1, 0, 5], [1, 0, 0, 0], [0, 0, 1, 2], [0, 0, 0, 1]]
    made = reading(tmp_path, model(matrix))
    for number, solid in enumerate(BOXES):
        x, y, z = solid.mass_properties().centroid
        assert made.solid(number).mass_properties().centroid == pytest.approx([5 - y, x, z + 2])


def test_coplanar_faces_become_one_and_float32_is_flat_enough(tmp_path: Path) -> None:
    """As Rhino writes them: rounded to single precision, faces cut in pieces."""
    box = Polytope.box((0.3, -0.7, 11.1), (1.9, 0.7, 12.4))
    turned = box.vertices @ np.linalg.qr(np.random.default_rng(2).normal(size=(3, 3)))[0]
    sign = np.sign(Polytope(turned, box.faces).mass_properties().volume)
    loops = [(a, b, c) for a, b, c, d in box.faces] + [(a, c, d) for a, b, c, d in box.faces]
    if sign < 0:
        loops = [loop[::-1] for loop in loops]
    record = data(Polytope(turned.astype(np.float32).astype(float), tuple(loops)))
    (shape,) = reading(tmp_path, record).shapes
    assert [len(face) for face in shape.solid.faces] == [4] * 6
    assert shape.solid.mass_properties().volume == pytest.approx(1.6 * 1.4 * 1.3, rel=1e-5)


@pytest.mark.parametrize(
    ("record", "said"),
    [
        ("{", "is no JSON"),
        ({"dtype": "compas.geometry/Point", "data": [0, 0, 0]}, "is compas.geometry/Point without blocks"),
        ([1, 2], "is a list without blocks"),
        (None, "is a single value without blocks"),
        (data(BOXES[0]) | {"face": {"0": [0, 1, 99]}}, "block 'b1': its mesh has the corner '99'"),
        (data(BOXES[0]) | {"vertex": {"0": {"x": "wide"}}}, "could not convert"),
        (data(BOXES[0]) | {"face": {str(i): loop for i, loop in enumerate(BOXES[0].faces[:5])}},
         "block 'b1' is not closed: 4 edges"),
    ],
)  # fmt: skip
def test_what_is_no_block_is_said(tmp_path: Path, record: Any, said: str) -> None:
    with pytest.raises(GeometryError, match=said):
        reading(tmp_path, record)


@pytest.mark.parametrize("depth", [950, 100_000])
def test_a_file_that_nests_without_end(tmp_path: Path, depth: int) -> None:
    with pytest.raises(GeometryError, match=r"hundreds deep|without blocks"):
        reading(tmp_path, "[" * depth + "]" * depth)
