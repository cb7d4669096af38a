"""Keys, values, and which of them is the finest."""

from __future__ import annotations

from pathlib import Path

import pytest

from masonry_fem.analyses.cells.source import Source
from masonry_fem.analyses.study.plan import plan, room
from masonry_fem.analyses.study.reference import Reference
from masonry_fem.analyses.study.setting import setting_of
from masonry_fem.analyses.study.variation import Variation, variations
from masonry_fem.errors import MasonryError
from masonry_fem.importing.program_files import read_by

RIGID = """
dimension = 2
fidelity = "rigid"
[materials.stone]
density = 2000
young = 1e9
[[structures]]
kind = "stack"
name = "pier"
material = "stone"
size = [1.0, 1.0]
count = 2
[mesh]
size = 0.5
"""


def source(text: str, base: Path, *overrides: str) -> Source:
    return Source(text, "s", base, "s", overrides)


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("mesh.size=0.2,0.1", (0.2, 0.1)),
        ("mesh.divisions=[4,2,2],[8,4,4]", ([4, 2, 2], [8, 4, 4])),
        ("fidelity=rigid,elastic", ("rigid", "elastic")),
        ('joints.0.friction=0.5,"no slip"', (0.5, "no slip")),
        ("mesh={ element = 'Q1' },{ size = 0.2 }", ({"element": "Q1"}, {"size": 0.2})),
        ("analysis.step=10 ms,1e-3", ("10 ms", 1e-3)),
        ("title='a,b',c", ("a,b", "c")),
    ],
)  # fmt: skip
def test_values_are_parted_by_commas_outside_of_brackets(text: str, values: tuple) -> None:
    assert Variation.parse(text).values == values


@pytest.mark.parametrize(
    ("text", "finest"),
    [
        ("mesh.size=0.1,20 mm,0.05", 1),
        ("mesh.divisions=[8,4],[4,2]", 0),
        ("mesh.element=P2,Q1", 0),
        ("mesh.element=Q1,P1", 1),
        ("fidelity=elastic,rigid", 0),
        ("solver.tolerance=1e-9,1e-3", 0),
        ("analysis.step=1 ms,2 ms", 0),
        ("analysis.theta=0.5,1.0", 0),
        ("joints.0.density=3,1", 0),
        ("joints.0.placement=nodes,gauss", 1),
        ("structures.arch.mesh.size=0.2,0.1", 1),
        ("analysis.load_steps=10,5", 0),
        ("mesh.size=oops,0.1", 1),
    ],
)
def test_the_finest_value(text: str, finest: int) -> None:
    assert Variation.parse(text).finest == finest


def test_a_key_that_changes_the_problem_is_a_case() -> None:
    assert setting_of("structures.arch.voussoirs").role == "case"
    assert setting_of("materials.stone.density").role == "case"
    assert Variation.parse("joints.0.friction=0.3,0.6").is_case
    assert not Variation.parse("joints.0.density=1,2").is_case


def test_tables_from_python() -> None:
    one, other = variations({"mesh.size": [0.2, 0.1], "mesh.divisions": [(4, 2), (8, 4)]})
    assert one.override(1) == "mesh.size=0.1"
    assert other.override(0) == "mesh.divisions=[4, 2]"
    with pytest.raises(MasonryError, match="expected a list of values"):
        variations({"mesh.size": 0.1})


def test_rigid_blocks_are_computed_once_for_all_meshes(tmp_path) -> None:
    vary = variations(["mesh.size=0.5,0.25", "fidelity=rigid,elastic"])
    cells = plan(source(RIGID, tmp_path), vary)
    assert cells[0].settings == {"mesh.size": "0.5", "fidelity": "rigid"}
    rigid = {cell.key for cell in cells if cell.settings["fidelity"] == "rigid"}
    assert len(rigid) == 1
    assert len({cell.key for cell in cells}) == 3


def test_a_file_that_a_scene_names_counts(tmp_path) -> None:
    text = RIGID.replace(
        "[mesh]", '[[joints]]\nlaw = { kind = "python", file = "law.py", law = "A", trusted = true }\n[mesh]'
    )
    keys = []
    for words in ("x = 1", "x = 2"):
        (tmp_path / "law.py").write_text(words)
        keys += [cell.key for cell in plan(source(text, tmp_path), variations(["solver.tolerance=1e-3"]))]
    assert keys[0] != keys[1]


def test_files_that_a_mesh_includes_count(tmp_path) -> None:
    text = """
dimension = 3
fidelity = "rigid"
[materials.stone]
density = 2000
[[structures]]
kind = "file"
name = "pier"
material = "stone"
path = "pier.inp"
"""
    (tmp_path / "pier.inp").write_text("*INCLUDE, INPUT=inner.inp\n")
    (tmp_path / "inner.inp").write_text("*NODE\n*INCLUDE, INPUT=nodes.txt\n")
    keys = []
    for words in ("1, 0, 0, 0", "1, 0, 0, 1"):
        (tmp_path / "nodes.txt").write_text(words)
        keys += [cell.key for cell in plan(source(text, tmp_path), variations(["solver.tolerance=1e-3"]))]
    (tmp_path / "nodes.txt").unlink()
    keys += [cell.key for cell in plan(source(text, tmp_path), variations(["solver.tolerance=1e-3"]))]
    assert len(set(keys)) == 3


def test_files_that_a_program_includes_count(tmp_path) -> None:
    """Found by reading it: no program is run before it is trusted."""
    text = """
dimension = 3
fidelity = "rigid"
[materials.stone]
density = 2000
[[structures]]
kind = "file"
name = "pier"
material = "stone"
path = "pier.geo"
trusted = true
"""
    (tmp_path / "parts").mkdir()
    (tmp_path / "pier.geo").write_text(
        'name = "http://none"; Include "parts/sizes.geo"; // Include "notes.geo";\n'
    )
    (tmp_path / "parts" / "sizes.geo").write_text('Merge "stone.step"; /* Include "notes.geo"; */')
    for name in ("notes.geo", "parts/stone.step"):
        (tmp_path / name).write_text("first")
    assert [path.name for path in read_by(tmp_path / "pier.geo")] == ["sizes.geo", "stone.step"]

    def key() -> str:
        return plan(source(text, tmp_path), variations(["solver.tolerance=1e-3"]))[0].key

    before = key()
    (tmp_path / "notes.geo").write_text("then")
    assert key() == before
    (tmp_path / "parts" / "stone.step").write_text("then")
    assert key() != before


def test_divisions_take_the_place_of_a_size(tmp_path) -> None:
    vary = variations(["mesh.divisions=[1,1],[2,2]", "fidelity=elastic"])
    assert room(source(RIGID, tmp_path), vary) == ["mesh={}"]
    assert all(cell.scene for cell in plan(source(RIGID, tmp_path), vary))
    with pytest.raises(MasonryError, match="both varied and set"):
        plan(source(RIGID, tmp_path, "fidelity=rigid"), vary)


def test_references(tmp_path) -> None:
    vary = variations(["mesh.size=0.2,0.1", "fidelity=rigid,elastic", "joints.0.friction=0.3,0.6"])
    assert Reference.parse([], vary).places == (None, None, None)
    assert Reference.parse(["mesh.size=0.2,fidelity=elastic"], vary).places == (0, 1, None)
    numbers = Reference.parse(["probes.top.z=-1.77e-6,supports.ground=[0, 0, 3]"], vary).given
    assert numbers["probes.top.z"].values == (-1.77e-6,)
    assert numbers["supports.ground"].axes == ("x", "y", "z")
    (tmp_path / "known.toml").write_text("[probes]\ntop = [0.0, -2e-6]\n[thrust]\nleft.x = 5.0\n")
    told = Reference.of(tmp_path / "known.toml", vary)
    assert told.given["probes.top"].values == (0.0, -2e-6)
    assert told.given["thrust.left.x"].values == (5.0,)
    # with one reference for all of them friction is a setting like the others
    assert not any(one.is_case for one in told.gather(vary))
    assert [one.is_case for one in Reference.parse([], vary).gather(vary)] == [False, False, True]
    for wrong, words in (
        ("mesh.size=0.3", "one of the values varied"),
        ("nowhere", "cannot be read"),
        ("a=1", "begins with one of"),
        ("probes.top=b", "a number"),
    ):
        with pytest.raises(MasonryError, match=words):
            Reference.parse([wrong], vary)
