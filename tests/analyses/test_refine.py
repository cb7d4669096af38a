"""``run --refine-to``: the error asked for is reached, with fewer unknowns than finer elements everywhere."""

import json
import shutil
from types import SimpleNamespace

import msgspec
import numpy as np
import pytest

from masonry_fem.analyses import refine as refinement
from masonry_fem.analyses.refine import refine
from masonry_fem.analyses.refine_limits import Limits, Round
from masonry_fem.analyses.run import run, solve_scene
from masonry_fem.build import build
from masonry_fem.cli import main
from masonry_fem.errors import MasonryError
from masonry_fem.output.stress_error import block_errors
from masonry_fem.output.told_words import finer_elements
from masonry_fem.records.told import plain
from masonry_fem.scene import load, save
from masonry_fem.scene.specs import (
    Joint,
    Loads,
    Material,
    MeshSettings,
    Output,
    Record,
    Scene,
    Traction,
)
from masonry_fem.scene.writing import moved
from masonry_fem.structures.file import FileStructure
from masonry_fem.structures.wall import WallStructure
from tests.importing.test_mesh_files import two_boxes
from tests.validation.true_error import true_squares


def wall(size=0.125, courses=4, **keys) -> Scene:
    """Plane wall with a load on one brick of its top."""
    load = Traction(on=f"wall.c{courses}.b{courses // 2}/top", vector=(0.0, -2e6))
    bricks = WallStructure(name="wall", material="stone", brick=(0.5, 0.25), columns=courses, courses=courses)
    given = {
        "dimension": 2,
        "plane": "stress",
        "materials": {"stone": Material(density=2400.0, young=10e9)},
        "structures": (bricks,),
        "mesh": MeshSettings(size=size),
        "joints": (Joint(friction=0.6),),
        "loads": Loads(gravity=(0.0, -9.81), tractions=(load,)),
        "output": Output(fields=False, pictures=False),
    }
    return Scene(**(given | keys))


def seen(folder):
    return sorted(path.name for path in folder.glob("[!.]*"))


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    out = tmp_path_factory.mktemp("refined")
    return refine(wall(), out, target=0.08), out


@pytest.mark.slow
def test_the_error_asked_for_is_reached(found):
    result, out = found
    assert result.reached
    assert result.result.outcome == "equilibrium"
    errors = [one.error for one in result.rounds]
    assert errors[-1] <= 0.08 < errors[-2]
    assert errors == sorted(errors, reverse=True)
    assert result.result.summary.stress.error.relative == errors[-1]
    assert result.result.summary.certificate.natural_map <= 1e-9
    assert seen(out) == ["as_run.toml", "history.csv", "refined.toml", "summary.json"]
    assert all(path.exists() for path in result.files)


@pytest.mark.slow
def test_summary_has_the_table_of_rounds(found):
    result, out = found
    told = json.loads((out / "summary.json").read_text(encoding="utf-8"))["refinement"]
    assert told["reached"]
    assert told["message"] == result.message
    assert [one["unknowns"] for one in told["rounds"]] == [one.unknowns for one in result.rounds]
    assert set(told["rounds"][0]) == {"round", "unknowns", "meshes", "made", "error", "refined", "seconds"}


@pytest.mark.slow
def test_report_tells_the_rounds_and_how_to_run_it_again(tmp_path):
    out = tmp_path / "fine"
    refine(wall(output=Output(fields=False, pictures=False, report=True)), out, target=0.115)
    page = (out / "report.html").read_text(encoding="utf-8")
    rounds = json.loads((out / "summary.json").read_text(encoding="utf-8"))["refinement"]["rounds"]
    assert len(rounds) > 1
    assert all(f">round {one['round']}</th>" in page for one in rounds)
    assert "as_run.toml --out fine<" in page


@pytest.mark.slow
def test_refined_scene_runs_again_to_the_same_answer(found, tmp_path):
    result, out = found
    again = run(load(out / "refined.toml"), tmp_path, base=out)
    assert again.summary.unknowns == result.rounds[-1].unknowns
    assert again.summary.stress.error.relative == pytest.approx(result.rounds[-1].error, rel=1e-6)


@pytest.mark.slow
def test_fewer_unknowns_than_uniform_elements_for_the_same_error(tmp_path):
    """By the estimate, and by the true error against elements half as large again.

    0.45 by either; 0.66 where the last round refines more than the target needs.
    """
    found = refine(wall(courses=6), tmp_path, target=0.08)
    coarse, middle, fine = (solve_scene(wall(size, courses=6)) for size in (0.0625, 0.03125, 0.015625))
    estimates = [one.summary.stress.error.relative for one in (coarse, middle)]
    errors = [_true(one, fine) for one in (coarse, middle)]
    unknowns = np.log([coarse.summary.unknowns, middle.summary.unknowns])
    for known, own in ((estimates, found.rounds[-1].error), (errors, _true(found.result, fine))):
        rate = np.diff(unknowns)[0] / np.diff(np.log(known))[0]
        uniform = np.exp(unknowns[1] + rate * (np.log(own) - np.log(known[1])))
        assert found.rounds[-1].unknowns <= 0.5 * uniform


def _true(coarse, fine) -> float:
    errors = block_errors(fine.march.model, fine.march.state)
    missing = sum(true_squares(coarse, fine).values()) + errors.square.sum()
    return float(np.sqrt(missing / errors.total))


@pytest.mark.slow
def test_what_is_not_refined_is_not_made_again(tmp_path):
    rounds = []
    seen = refine(wall(), tmp_path, target=0.115, tell=rounds.append)
    assert [one.round for one in rounds] == list(range(1, len(rounds) + 1))
    for one in rounds[1:]:
        assert one.made < one.meshes
    groups = [group for group in seen.result.built.model.groups if not group.prescribed]
    kept = [group for group in groups if group.factorisations == 0]
    assert len(kept) >= 2  # bricks and half bricks as they were at first
    assert seen.result.summary.factorisations == len(groups) - len(kept)


@pytest.mark.slow
def test_refinement_follows_the_load(found):
    result, _ = found
    sizes = {one.blocks: one.mesh.size for one in result.scene.overrides}
    assert sizes["wall.c4.b2"] <= 0.0625
    assert "wall.c4.b4" not in sizes


@pytest.mark.parametrize(
    ("limits", "said"), [({"most_rounds": 2}, "2 rounds"), ({"most_unknowns": 2000}, "unknowns")]
)
def test_what_stops_it_is_said(tmp_path, limits, said):
    result = refine(wall(), tmp_path, target=0.01, **limits)
    assert not result.reached
    assert said in result.message
    assert (tmp_path / "summary.json").exists()


def test_interruption_leaves_the_last_whole_round(tmp_path, monkeypatch):
    calls = []
    (tmp_path / "round").mkdir()  # of the user
    (tmp_path / "round" / "notes").write_text("keep", encoding="utf-8")

    def interrupted(scene, out, **keys):
        calls.append(out)
        if len(calls) < 3:
            return run(scene, out, **keys)
        out.mkdir()
        (out / "history.csv").write_text("half a line", encoding="utf-8")
        raise KeyboardInterrupt

    monkeypatch.setattr(refinement, "run", interrupted)
    with pytest.raises(KeyboardInterrupt):
        refine(wall(), tmp_path, target=0.05)
    summary = json.loads((tmp_path / "summary.json").read_text(encoding="utf-8"))
    assert summary["outcome"] == "equilibrium"
    assert len(summary["refinement"]["rounds"]) == 2
    assert not summary["refinement"]["reached"]
    assert "half" not in (tmp_path / "history.csv").read_text(encoding="utf-8")
    assert seen(tmp_path) == [
        "as_run.toml", "history.csv", "refined.toml", "round", "summary.json",
    ]  # fmt: skip
    assert (tmp_path / "round" / "notes").read_text(encoding="utf-8") == "keep"


@pytest.mark.slow
def test_pictures_are_of_the_last_round_only(tmp_path, monkeypatch):
    from masonry_fem.output.asked.pictures import Pictures

    drawn = []
    monkeypatch.setattr(Pictures, "close", lambda self, summary: drawn.append(summary.unknowns) or [])
    scene = wall(output=Output(fields=False))
    result = refine(scene, tmp_path, target=0.13)
    assert len(result.rounds) > 1
    assert drawn == [result.rounds[-1].unknowns]


def test_rigid_blocks_have_nothing_to_refine(tmp_path):
    with pytest.raises(MasonryError, match="no block is elastic"):
        refine(wall(fidelity="rigid"), tmp_path)
    with pytest.raises(MasonryError, match="between 0 and 1"):
        refine(wall(), tmp_path, target=5.0)


def test_finer_elements_change_nothing_of_reduced_blocks(tmp_path):
    given = wall(fidelity="reduced", loads=Loads(gravity=(0.0, -9.81)))
    with pytest.raises(MasonryError, match="degree"):
        refine(given, tmp_path)
    told = plain(solve_scene(given).summary)
    assert told["stress"]["error"]["reduced"] == pytest.approx(1.0)
    assert "degree" in finer_elements(told)
    assert "--refine-to" in finer_elements(plain(solve_scene(wall()).summary))


@pytest.mark.slow
def test_what_cannot_be_judged_is_refined_first(tmp_path):
    """One linear element a brick says nothing of its error, however small it looks."""
    rounds = []
    result = refine(wall(0.5), tmp_path, target=0.5, tell=rounds.append)
    assert rounds[0].error < 0.5
    assert result.reached
    assert len(rounds) == 3  # bricks of 2 elements in a row are one element thick, too
    summary = solve_scene(wall(0.5)).summary
    assert summary.stress.error.unjudged == 18
    assert result.result.summary.stress.error.unjudged == 0


@pytest.mark.slow
def test_elements_from_a_file_stay(tmp_path):
    structure = FileStructure(
        name="boxes", material="stone", path=two_boxes(tmp_path / "two.msh").name, supports=("lower",)
    )
    scene = wall(dimension=3, structures=(structure,), loads=Loads(gravity=(0.0, 0.0, -9.81)))
    result = refine(scene, tmp_path / "out", tmp_path, target=0.01)
    assert not result.reached
    assert "came with their elements, which stay" in result.message
    assert "order 2" in result.message
    saved = load(tmp_path / "out" / "refined.toml")
    assert saved.structures[0].path == "../two.msh"
    first = build(scene, tmp_path)
    again = build(scene, tmp_path, first)
    pairs = zip(first.stones.assembly.shapes, again.stones.assembly.shapes, strict=True)
    assert all(one.mesh is other.mesh for one, other in pairs)
    assert sum(group.factorisations for group in again.model.groups) == 0


def test_no_equilibrium_is_not_refined(tmp_path):
    result = refine(wall(loads=Loads(gravity=(9.81, -9.81))), tmp_path)
    assert result.result.outcome == "no_equilibrium"
    assert len(result.rounds) == 1
    assert not result.reached
    assert result.message.startswith("Not refined: No equilibrium")


def test_command(tmp_path, capsys):
    file, out = tmp_path / "wall.toml", tmp_path / "out"
    save(wall(0.25), file)
    assert main(["run", str(file), "--out", str(out), "--refine-to", "15%"]) == 0
    said = " ".join(capsys.readouterr().out.split())  # lines of a table may break anywhere
    assert "round 1:" in said
    assert "was asked for" in said
    shutil.rmtree(out)
    assert main(["run", str(file), "--out", str(out), "--refine-to", "much"]) == 1
    assert "--refine-to is 'much', expected" in capsys.readouterr().err
    assert (
        main(["run", str(file), "--out", str(out), "--refine-to", "1%", "--set", "solver.max_iterations=1"])
        == 2
    )
    told = capsys.readouterr()
    assert "Not refined" not in told.out  # said once, on standard error
    assert "iteration limit" in told.err


def test_files_of_a_scene_are_found_from_another_folder(tmp_path):
    here, there = tmp_path / "a", tmp_path / "b" / "c"
    structure = FileStructure(name="s", material="stone", path="meshes/s.msh")
    push = Traction(on="s.*/top", vector=(0.0, 1.0), time=Record(path="/data/quake.csv"))
    scene = wall(structures=(structure,), loads=Loads(tractions=(push,)))
    found = moved(scene, here, there)
    assert found.structures[0].path == "../../a/meshes/s.msh"
    assert found.loads.tractions[0].time.path == "/data/quake.csv"
    assert moved(found, there, here) == scene
    assert msgspec.structs.asdict(found)["title"] == ""


def test_stalling_is_told():
    """Two rounds with more than twice the unknowns and nearly the same error: there is no use in a third."""
    march = SimpleNamespace(outcome="equilibrium", message="")
    limits = Limits(target=0.01, rounds=10, unknowns=10**12, idle=0.0)

    def before(*errors):
        return [
            Round(round=i + 1, unknowns=1000 * 2**i, meshes=1, made=1, error=error, refined=1, seconds=0.0)
            for i, error in enumerate(errors)
        ]

    assert "hardly falls" in limits.why_last(before(0.30, 0.29), march, 0.28, True, 4000, 2.0)
    assert limits.why_last(before(0.30, 0.20), march, 0.19, True, 4000, 2.0) == ""
    assert limits.why_last(before(0.30), march, 0.29, True, 4000, 2.0) == ""
    assert "memory" in limits.why_last([], march, 0.3, True, 4000, 1e6)
    assert "which stay, bring 28 % alone" in limits.why_last([], march, 0.3, True, 4000, 2.0, 0.28)
    assert "came" not in limits.why_last([], march, 0.3, True, 4000, 2.0, 0.009)
    assert not limits.reached(march, 0.005, False)
    assert "one linear element thick: 10 rounds" in limits.why_last(
        before(*[0.9**i for i in range(9)]), march, 0.005, False, 100, 2.0
    )
