"""Anything that can be typed or handed over is answered by a sentence: no "unexpected", no long wait."""

from __future__ import annotations

import contextlib
import json
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest

from masonry_fem.analyses.run import solve_scene
from masonry_fem.errors import MasonryError
from masonry_fem.scene import loads, specs
from masonry_fem.structures import build_structure
from masonry_fem.structures.file import FileStructure
from masonry_fem.structures.survey import SurveyStructure

PIER = """
dimension = 2
fidelity = "rigid"
[materials.stone]
density = 2400
[[structures]]
kind = "stack"
name = "pier"
material = "stone"
size = [1.0, 0.5]
count = 2
[loads]
gravity = [0, -9.81]
"""
DIGITS = "9" * 5000


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("a = " + "[" * 50000 + "]" * 50000, "within one another"),
        ("a = " + "{a=" * 5000 + "1" + "}" * 5000, "within one another"),
        ("a" + ".a" * 20000 + " = 1", "within one another"),
        ("[" + "a." * 20000 + "a]\nb = 1", "within one another"),
        ("materials" + " . a" * 2000 + " = 1", "within one another"),
        (PIER.replace("2\n[loads]", DIGITS + "\n[loads]"), "not valid TOML: Exceeds the limit"),
        (PIER.replace("2\n[loads]", "9" * 4000 + "\n[loads]"), "count is a number of 4000 digits"),
        (PIER.replace("2\n[loads]", "0x" + "f" * 9000 + "\n[loads]"), "count is a number of 10837 digits"),
        (PIER.replace("2400", "0x" + "f" * 9000), "density is a number of 10837 digits"),
        (PIER.replace("2400", '"1 kg**(10**10**10)"'), "is no known unit"),
        (PIER.replace("2400", '"1 ' + "(" * 3000 + '"'), "is no known unit"),
        (PIER.replace("2400", '"1 m^9999999999"'), "is no known unit"),
        (PIER.replace("2400", "1.7e308"), r"density is 1.7e\+308, expected .* to 1e\+100 in size"),
        (PIER + 'gravity_time = { kind = "sine", frequency = 1.7e308 }', "frequency is 1.7e"),
        (PIER + '[analysis]\nkind = "dynamics"\nstep = 1e-30\nduration = 1.0', r"at most 1e\+09 steps"),
        (PIER.replace('"pier"', '"pi\\u0000er"'), "is 'pi.x00er', expected a name"),
        (PIER.replace("2400", "1979-05-27"), r"density is datetime.date\(1979, 5, 27\), expected a density"),
    ],
    ids=range(17),
)
def test_texts_of_scenes(text: str, said: str) -> None:
    with pytest.raises(MasonryError, match=said):
        loads(text)


@pytest.mark.parametrize(
    "override", ["title=" + "[" * 50000, "structures.².count=1", "a=" + DIGITS, ".".join("a" * 500) + "=1"]
)
def test_overrides(override: str) -> None:
    with pytest.raises(MasonryError):
        loads(PIER, [override])


@pytest.mark.slow
@pytest.mark.parametrize(
    "key", ["structures.pier.size.0", "structures.pier.gap", "materials.stone.density", "loads.gravity.1"]
)
@pytest.mark.parametrize(
    "value", ["nan", "inf", "-inf", "1e-300", "5e-324", "1e101", "1e300", "true", "[]", '""']
)
def test_absurd_numbers(key: str, value: str) -> None:
    """An answer or an error of ours; NumPy's warnings are errors here."""
    with contextlib.suppress(MasonryError):
        assert solve_scene(loads(PIER, [f"{key}={value}"])).outcome


CUBE = np.array([[x, y, z] for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))], dtype=float)
CELL = np.arange(8)[None]
TETRA = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=float)
LOOPS = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]


def blocks_of(path: Path, **keys: Any) -> None:
    """Read a file as a structure."""
    kind = SurveyStructure if path.suffix == ".csv" else FileStructure
    build_structure(
        kind(name="f", material="s", path=path.name, **keys), 3, path.parent, specs.MeshSettings()
    )


@pytest.mark.parametrize("ending", ["vtu", "vtk"])
@pytest.mark.parametrize(
    ("points", "cells", "field", "said"),
    [
        (CUBE, np.array([[0, 1, 2, 3, 4, 5, 6, 99]]), 0, "the corner 99, expected"),
        (CUBE, np.array([[0, 1, 2, 3, 4, 5, 6, -1]]), 0, "the corner -1, expected"),
        (CUBE * np.nan, CELL, 0, r"no number, \(nan, nan, nan\), 1 of 8"),
        (np.where(CUBE == 1, np.inf, CUBE), CELL, 0, "a point that is no number"),
        (CUBE * 1e300, CELL, 0, "is 1e.300 m large"),
        (CUBE * 1e-300, CELL, 0, "is 1e-300 m large"),
        (CUBE, CELL * 0, 0, "inverted, flat or folded"),
        (CUBE, np.array([[0, 1, 2, 3, 4, 4, 6, 1]]), 0, "1 of 1 elements are inverted, flat or folded"),
        (CUBE, np.concatenate([CELL, CELL]), 0, "stands in the file twice"),
        (CUBE, CELL, np.inf, "is not one whole number a cell"),
        (CUBE, CELL, np.nan, "is not one whole number a cell"),
        (CUBE, CELL, 1e300, "is not one whole number a cell"),
    ],
    ids=range(12),
)
def test_elements(
    tmp_path: Path, ending: str, points: np.ndarray, cells: np.ndarray, field: float, said: str
) -> None:
    path = tmp_path / f"a.{ending}"
    data = {"block": [np.full(len(cells), field)]}
    meshio.write(path, meshio.Mesh(points, [("hexahedron", cells)], cell_data=data))
    with pytest.raises(MasonryError, match=said):
        blocks_of(path)


@pytest.mark.parametrize(
    ("first", "element", "said"),
    [
        ("1 0 0 0", "1 2 3 4 5 6 7 99", "99"),
        ("1 0 0 0", "1 2 3 4 5 6 7 -1", "-1"),
        ("1 nan 0 0", "1 2 3 4 5 6 7 8", "no number"),
        ("1 0 0 -1e300", "1 2 3 4 5 6 7 8", "1e.300 m"),
        ("1 0 0 0", "1 1 1 1 1 1 1 1", "expected"),
    ],
)
def test_meshes_of_gmsh(tmp_path: Path, first: str, element: str, said: str) -> None:
    nodes = [first] + [f"{number} {x} {y} {z}" for number, (x, y, z) in enumerate(CUBE[1:], start=2)]
    path = tmp_path / "a.msh"
    path.write_text("\n".join([
        "$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$Nodes", "8", *nodes, "$EndNodes",
        "$Elements", "1", f"1 5 2 0 1 {element}", "$EndElements", "",
    ]))  # fmt: skip
    with pytest.raises(MasonryError, match=said):
        blocks_of(path)


@pytest.mark.parametrize("size", [1e300, 1e155, 1e31, 1e-31, 1e-160, 1e-300])
def test_surfaces_of_any_size(tmp_path: Path, size: float) -> None:
    lines = [f"v {x} {y} {z}" for x, y, z in size * TETRA]
    lines += ["f " + " ".join(str(v + 1) for v in loop) for loop in LOOPS]
    (tmp_path / "a.obj").write_text("\n".join(lines))
    with pytest.raises(MasonryError, match=r"m large and reaches to"):
        blocks_of(tmp_path / "a.obj")


@pytest.mark.parametrize("corner", [99, -2])
def test_polygons_of_points_that_are_not_there(tmp_path: Path, corner: int) -> None:
    loops = [*LOOPS[:3], [0, 3, corner]]
    head = ["ply", "format ascii 1.0", "element vertex 4", *(f"property float {axis}" for axis in "xyz")]
    head += ["element face 4", "property list uchar int vertex_indices", "end_header"]
    body = [" ".join(map(str, row)) for row in TETRA.tolist()] + [f"3 {a} {b} {c}" for a, b, c in loops]
    (tmp_path / "a.ply").write_text("\n".join([*head, *body, ""]))
    with pytest.raises(MasonryError, match=f"the corner {corner}"):
        blocks_of(tmp_path / "a.ply")


MESH: dict[str, Any] = {
    "vertex": {str(i): dict(zip("xyz", place, strict=True)) for i, place in enumerate(TETRA.tolist())},
    "face": dict(enumerate(LOOPS)),
}


@pytest.mark.parametrize(
    "record",
    [
        "[" * 50000 + "]" * 50000,
        '{"dtype": "a", "data": ' * 3000 + "{}" + "}" * 3000,
        '{"graph": {"node": {"0": ' + '{"block": ' * 900 + "{}" + "}" * 900 + "}}}",
        json.dumps(MESH).replace("1.0", "NaN"),
        json.dumps(MESH).replace("1.0", "Infinity"),
        json.dumps(MESH).replace("1.0", DIGITS),
        json.dumps(MESH).replace("1.0", "9" * 4000),
        "5",
        '"text"',
        "null",
        *(
            json.dumps(one)
            for one in (
                MESH | {"face": 7},
                MESH | {"face": None},
                MESH | {"face": {"0": []}},
                MESH | {"face": {"0": [[1], 2, 3]}},
                MESH | {"vertex": {}},
                MESH | {"vertex": {"0": "abc"}},
                MESH | {"default_vertex_attributes": 3},
                {"blocks": {"0": 3}, "assembly": 4},
                {"blocks": {"0": MESH}, "assembly": [4]},
                {"blocks": {"0": MESH}, "assembly": {"vertex": [3]}},
                {"elements": [None, 3, "a", MESH]},
                {"elements": [{"geometry": MESH, "attributes": 3}]},
                {"elements": [{"geometry": MESH, "transformation": {"matrix": [[1]]}}]},
                {"elements": [{"geometry": MESH, "transformation": {"matrix": "abc"}}]},
                {"elements": [{"geometry": MESH}], "graph": {"node": [1]}},
                {"elements": [{"geometry": MESH}], "graph": [1]},
                {"graph": {"node": [1]}},
                {"graph": 5},
            )
        ),
    ],
    ids=range(28),
)
def test_records_of_compas(tmp_path: Path, record: str) -> None:
    (tmp_path / "a.json").write_text(record)
    with pytest.raises(MasonryError, match=r"path 'a\.json'.*(expected|save it again)"):
        blocks_of(tmp_path / "a.json")


SQUARE = "stone,vertex,x,y,z\na,1,0,0,0\na,2,1,0,0\na,3,1,0,1\na,4,0,0,1\n"


@pytest.mark.parametrize(
    "survey",
    [
        SQUARE.encode("utf-16"),
        SQUARE.replace("a,", "é,").encode("latin-1"),
        SQUARE.replace("1,0,1", "1e300,0,1").encode(),
        SQUARE.replace("1,0,1", "-inf,0,1").encode(),
        SQUARE.replace("a,4", "a,1e300").encode() + b"\0",
        b"",
    ],
    ids=range(6),
)
def test_surveys(tmp_path: Path, survey: bytes) -> None:
    (tmp_path / "a.csv").write_bytes(survey)
    with pytest.raises(MasonryError, match=r"path 'a\.csv'"):
        blocks_of(tmp_path / "a.csv", depth=0.3)
