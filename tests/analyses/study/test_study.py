"""A study from end to end: cells in processes of their own, what is kept, what fails, what is advised."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest

from masonry_fem import cli
from masonry_fem.analyses.study import study
from masonry_fem.analyses.study.target import Target
from masonry_fem.analyses.study.values import shown
from masonry_fem.errors import MasonryError
from masonry_fem.scene import load, loads

PIER = """
title = "pier"
dimension = 2
fidelity = "elastic"
mesh = { element = "Q1", size = 0.5 }
[materials.stone]
density = 2000
young = "1 GPa"
[[structures]]
kind = "stack"
name = "pier"
material = "stone"
size = [1.0, 1.0]
count = 2
[[joints]]
friction = 0.6
[loads]
gravity = [0, -10.0]
[[probes]]
name = "top"
block = "pier.b2"
point = [0.5, 2.0]
"""
WEIGHT = 40000.0


@pytest.fixture(scope="module")
def scene(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("study") / "pier.toml"
    path.write_text(PIER)
    return path


@pytest.fixture(scope="module")
def made(scene: Path):
    """Nine cells, of which one breaks a rule of scenes."""
    vary = {
        "mesh.size": [0.5, 0.25, -1.0],
        "solver.tolerance": [1e-3, 1e-8],
        "fidelity": ["rigid", "elastic"],
    }
    told: list[tuple[int, int, str]] = []
    result = study(scene, vary, out=scene.parent / "out", tell=lambda *one: told.append(one))
    return result, told


@pytest.mark.slow
def test_every_combination_is_a_row(made) -> None:
    result, told = made
    assert len(result.rows) == 12
    outcomes = [row.outcome for row in result.rows]
    assert outcomes.count("equilibrium") == 8
    assert outcomes.count("bad_scene") == 4
    assert "mesh.size is -1" in result.row(mesh__size="-1.0").message
    # two rigid cells serve both meshes
    assert told[-1][:2] == (6, 6)


@pytest.mark.slow
def test_a_row_tells_costs_and_certificate(made) -> None:
    row = made[0].row(mesh__size="0.25", fidelity="elastic", solver__tolerance="1e-08")
    assert row.cpu > 0
    assert row.start > row.cpu
    assert sum(row.seconds.values()) <= row.cpu + 0.02
    assert row.memory > 50
    assert row.size["unknowns"] > row.size["contacts"] > 4
    assert row.certificate["natural_map"] < 1e-8


@pytest.mark.slow
def test_resultants_need_no_elements(made) -> None:
    result = made[0]
    advice = {one.target: one for one in result.recommendations}
    assert advice["supports"].bound < 1e-5
    rigid = result.row(mesh__size="0.5", fidelity="rigid")
    assert rigid.quantities["supports.pier.ground"].values[1] == pytest.approx(WEIGHT, rel=1e-6)
    # rigid stones do not sink, and their stresses are not told
    assert result.comparisons[0].error["probes.top"][result.rows.index(rigid)] == pytest.approx(1, rel=1e-3)
    assert "stress.means" not in rigid.quantities


@pytest.mark.slow
def test_two_meshes_do_not_tell_an_order(made) -> None:
    result = made[0]
    advice = next(one for one in result.recommendations if one.target == "stress.max")
    assert advice.settings is None
    assert "no limit of it is seen here" in advice.words
    seen = result.comparisons[0].orders["probes.top"]["mesh.size"]
    assert (seen.order, seen.words) == (None, "2 levels")


@pytest.mark.slow
def test_a_second_call_computes_what_is_missing(made, scene: Path) -> None:
    folder = scene.parent / "out"
    files = sorted((folder / "cells").glob("*.json"))
    assert len(files) == 6
    stamps = {file: file.stat().st_mtime_ns for file in files[1:]}
    files[0].unlink()
    again = study(
        scene,
        ["mesh.size=0.5,0.25", "solver.tolerance=1e-3,1e-8", "fidelity=rigid,elastic"],
        out=folder,
    )
    assert all(row.solved for row in again.rows)
    assert files[0].exists()
    assert {file: file.stat().st_mtime_ns for file in stamps} == stamps


@pytest.mark.slow
def test_files(made, tmp_path: Path) -> None:
    result = made[0]
    table, told, picture = result.write(tmp_path)
    with table.open(newline="") as file:
        lines = list(csv.DictReader(file))
    assert len(lines) == 12
    errors = [float(line["error.probes.top"]) for line in lines if line["outcome"] == "equilibrium"]
    assert len(errors) == 8
    assert min(errors) == 0.0
    assert json.loads(told.read_text())["outcome"] == "finished"
    assert json.loads(told.read_text())["recommendations"][0]["words"]
    assert picture.read_bytes()[:4] == b"\x89PNG"


@pytest.mark.slow
def test_command(scene: Path, capsys) -> None:
    line = ["study", str(scene), "--vary", "solver.tolerance=1e-3,1e-8", "--vary", "fidelity=rigid,elastic"]
    folder = scene.parent / "out"  # its cells are known
    assert cli.main([*line, "--set", "mesh.size=0.5", "--out", str(folder), "--quantity", "supports"]) == 0
    said = capsys.readouterr().out
    assert "for 1 % on the forces of the supports use" in said
    assert f"wrote {folder / 'study.csv'}" in said
    assert cli.main([*line, "--vary", "mesh.sice=1,2", "--out", str(folder)]) == 1
    assert "did you mean 'size'" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("vary", "words"),
    [
        ([], "at least one key"),
        (["mesh.size"], "expected key=value"),
        (["mesh.size=1,,2"], "expected key=value"),
        (["mesh.size=1", "mesh.size=2"], "given twice"),
        (["mesh.size=0.1,0.1"], "given twice"),
        ([f"{key}=" + ",".join(map(str, range(1, 101))) for key in ("mesh.size", "a.b")], "10000 cells"),
        (["mesh.sise=0.1"], "did you mean 'size'"),
    ],
)  # fmt: skip
def test_nonsense_is_refused(scene: Path, vary: list[str], words: str, tmp_path: Path) -> None:
    with pytest.raises(MasonryError, match=words):
        study(scene, vary, out=tmp_path)
    assert not list(tmp_path.glob("*"))


@pytest.mark.slow
def test_what_is_not_varied_is_said(scene: Path) -> None:
    made = study(scene, {"fidelity": ["rigid", "elastic"]}, out=scene.parent / "out", quantities=["supports"])
    (advice,) = made.recommendations
    # whichever of the two was quicker, each in hundredths of a second
    assert "what the mesh " in advice.words
    assert "not varied" in advice.words


@pytest.mark.slow
def test_a_scene_of_python_against_a_folder_of_results(scene: Path, tmp_path: Path) -> None:
    small = ["fidelity=rigid", "output.pictures=false", "output.fields=false"]
    folder = tmp_path / "run"
    assert (
        cli.main(["run", str(scene), "--out", str(folder), "--quiet", *(f"--set={one}" for one in small)])
        == 0
    )
    made = study(
        load(scene, small),
        {"joints.0.friction": [0.3, 0.6], "solver.tolerance": [1e-2, 1e-8]},
        base=scene.parent,
        out=tmp_path / "study",
        reference=folder,
        quantities=["supports.*.y"],
    )
    assert all(row.solved for row in made.rows)
    # with a reference from outside another friction is a setting like any other
    assert len(made.comparisons) == 1
    (advice,) = made.recommendations
    assert advice.bound < 0.01
    assert "the reference comes from outside" in made.notes[0]


@pytest.mark.slow
def test_cases_have_references_of_their_own(scene: Path, tmp_path: Path) -> None:
    made = study(
        scene,
        {"structures.pier.count": [2, 3], "solver.tolerance": [1e-2, 1e-8]},
        overrides=["fidelity=rigid"],
        out=tmp_path,
        quantities=["supports"],
    )
    weights = [case.values["supports.pier.ground"].values[1] for case in made.comparisons]
    assert weights == pytest.approx([WEIGHT, 1.5 * WEIGHT])
    assert "each is compared with its own finest cell" in made.notes[0]
    assert made.recommendations[0].settings.keys() == {"solver.tolerance"}


@pytest.mark.slow
def test_cells_left_alone_have_no_picture_and_no_advice(scene: Path, tmp_path: Path) -> None:
    """The picture of a study before is taken away: it shows what is not in these files."""
    (tmp_path / "pareto.png").write_bytes(b"of before")
    made = study(scene, {"mesh.size": [0.5, -1.0], "fidelity": ["rigid", "elastic"]}, out=tmp_path)
    assert [advice.settings for advice in made.recommendations] == [None] * len(made.recommendations)
    made.write()
    assert not (tmp_path / "pareto.png").exists()
    assert json.loads((tmp_path / "study.json").read_text())["recommendations"][0]["bound"] is None


@pytest.mark.slow
def test_where_each_cell_is_a_problem_of_its_own_values_are_told(scene: Path, tmp_path: Path, capsys) -> None:
    """As in a study of a dimension: no errors, no advice, but what each cell comes to, and curves."""
    (tmp_path / "pareto.png").write_bytes(b"of before")
    words = ["study", str(scene), "--vary", "structures.pier.count=2,3", "--set", "fidelity=rigid"]
    assert cli.main([*words, "--quantity", "supports", "--out", str(tmp_path)]) == 0
    printed = capsys.readouterr().out
    assert "40 kN/m" in printed
    assert "60 kN/m" in printed
    assert "Advice" not in printed
    assert "different problem" in printed
    assert (tmp_path / "values.png").stat().st_size > 5000
    assert not (tmp_path / "pareto.png").exists()
    assert json.loads((tmp_path / "study.json").read_text())["recommendations"] == []


def test_columns_are_the_first_of_each_target() -> None:
    aims = [
        Target("energy", "", ("e",)),
        Target("probes", "", ("p1", "p2", "p3")),
        Target("stress.max", "", ("s",)),
    ]
    assert shown(aims) == ["p1", "s", "p2", "p3"]
    assert shown(aims[:1]) == ["e"]


@pytest.mark.slow
def test_a_key_of_the_last_stage(tmp_path: Path) -> None:
    """The stage before is run once; each value goes on from there, and the last one pushes stones apart."""
    path = tmp_path / "pier.toml"
    path.write_text(
        PIER
        + """
[[stages]]
name = "built"
[[stages]]
name = "pushed"
[stages.loads]
gravity = [0, -10.0]
accelerations = [{ vector = [1.0, 0.0] }]
"""
    )
    key = "stages.pushed.loads.accelerations.0.vector"
    made = study(path, {key: [[1.0, 0.0], [2.0, 0.0], [7.0, 0.0]]}, out=tmp_path / "out")
    assert [row.outcome for row in made.rows] == ["equilibrium", "equilibrium", "no_equilibrium"]
    for row, push in zip(made.rows, (1.0, 2.0), strict=False):
        force = row.quantities["supports.pier.ground"].values[0]
        assert force == pytest.approx(-push / 10 * WEIGHT, rel=1e-6)
    assert len(list((tmp_path / "out" / "stages").iterdir())) == 1


def test_combinations_are_refused_before_any_cell(tmp_path: Path) -> None:
    own = loads(
        """
        dimension = 2
        fidelity = "rigid"
        materials.stone = { density = 2000.0 }
        structures = [{ kind = "stack", name = "s", material = "stone", size = [1.0, 1.0], count = 1 }]
        joints = [{ friction = 0.7 }]
        loads.gravity = [0.0, -10.0]
        combinations = [{ name = "heavy", factors = { gravity = 1.35 } }]
        """
    )
    with pytest.raises(MasonryError, match="load combinations 'heavy', and a cell of a study is one run"):
        study(own, ["joints.0.friction=0.5,0.6"], out=tmp_path / "out")
    assert not (tmp_path / "out").exists()
