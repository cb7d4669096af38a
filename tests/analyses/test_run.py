"""Run: what a scene leaves on disk, and what is said where it cannot."""

import json
import logging
from pathlib import Path
from types import SimpleNamespace

import msgspec
import numpy as np
import psutil
import pytest

from masonry_fem.analyses.inspect import check_scene, write_mesh
from masonry_fem.analyses.run import run, solve_scene, steps
from masonry_fem.errors import MasonryError, SceneError
from masonry_fem.scene.specs import (
    Dynamics,
    Equilibrium,
    Joint,
    Loads,
    Material,
    MeshSettings,
    Output,
    Probe,
    Scene,
    Statics,
)
from masonry_fem.structures.block import BlockStructure
from masonry_fem.structures.stack import StackStructure
from masonry_fem.structures.wall import WallStructure

STONE = {"stone": Material(density=2000.0, young=1e9)}
STACK = StackStructure(name="pile", material="stone", size=(1.0, 1.0), count=2)


def scene(**keys):
    given = {
        "dimension": 2,
        "fidelity": "rigid",
        "materials": STONE,
        "structures": (STACK,),
        "joints": (Joint(friction=0.6),),
        "loads": Loads(gravity=(0.0, -10.0)),
        "analysis": Dynamics(step=0.1, duration=0.5, theta=1.0),
        "output": Output(pictures=False),
    } | keys
    return Scene(**given)


def test_run_writes_what_it_names(tmp_path):
    result = run(scene(), tmp_path, save_contact=2)
    assert result.outcome == "finished"
    assert {file.name for file in result.files} >= {
        "summary.json",
        "history.csv",
        "blocks.pvd",
        "contact_2.npz",
    }
    assert all(file.exists() for file in result.files)
    kept = json.loads((tmp_path / "summary.json").read_text(encoding="utf-8"))
    assert kept["supports"]["pile.ground"]["force"] == pytest.approx([0, 40e3], abs=1e-6)
    assert kept["certificate"]["block_balance"] < 1e-9


def test_folders_may_be_texts(tmp_path):
    out = tmp_path / "out"
    assert out / "summary.json" in run(scene(), str(out), base=str(tmp_path)).files
    assert solve_scene(scene(), str(tmp_path)).outcome == "finished"
    found = check_scene(scene(), str(tmp_path))
    assert found.blocks == len(found.names) == 3
    assert "pile.ground" in found.names
    assert all(file.parent == out for file in write_mesh(scene(), str(out), str(tmp_path)))


def test_steps_are_made_when_they_are_asked_for_and_are_those_of_a_run():
    walked = steps(scene())
    first = next(walked)
    assert first.report.step == first.state.index == 1
    rest = list(walked)
    made = solve_scene(scene())
    assert len(rest) == made.summary.steps - 1
    np.testing.assert_array_equal(rest[-1].state.reaction, made.march.state.reaction)
    assert rest[-1].report.time == made.summary.time


def test_what_is_no_scene_is_refused(tmp_path):
    with pytest.raises(SceneError, match=r"scene is 'arch.toml', expected a Scene; .*masonry_fem\.load"):
        run("arch.toml", tmp_path)


@pytest.mark.parametrize("step", [0, -1, 6])
def test_a_step_that_there_is_not_cannot_be_saved(tmp_path, step):
    with pytest.raises(MasonryError, match=f"step to save is {step}, expected a step from 1 to 5"):
        run(scene(), tmp_path / "out", save_contact=step)
    assert not (tmp_path / "out").exists()


def test_a_step_that_was_not_reached_is_told(tmp_path, caplog):
    march = Equilibrium(strategy="large_step", step=0.1)
    result = run(scene(analysis=march), tmp_path, save_contact=900)
    assert result.outcome == "equilibrium"
    assert "step 900 was not reached" in caplog.text


def test_check_counts_the_steps():
    assert check_scene(scene()).most_steps == 5


def test_check_tells_what_this_machine_cannot_hold(monkeypatch, caplog):
    check_scene(scene())
    assert caplog.text == ""
    monkeypatch.setattr(psutil, "virtual_memory", lambda: SimpleNamespace(total=1e6))
    check_scene(msgspec.structs.replace(scene(), large=True))
    assert "this machine has 1 MB" in caplog.text


def test_observers_see_every_step():
    class Times(list):
        def record(self, model, state, report):
            self.append(report.time)

    seen = Times()
    solve_scene(scene(), observers=(seen,))
    assert seen == pytest.approx([0.1, 0.2, 0.3, 0.4, 0.5])


def test_an_interrupted_run_leaves_a_summary(tmp_path, monkeypatch):
    def interrupted(*arguments, **keys):
        raise KeyboardInterrupt

    monkeypatch.setattr("masonry_fem.analyses.run.writing.march", interrupted)
    with pytest.raises(KeyboardInterrupt):
        run(scene(), tmp_path)
    kept = json.loads((tmp_path / "summary.json").read_text(encoding="utf-8"))
    assert kept["outcome"] == "interrupted"


@pytest.mark.parametrize("write", [run, write_mesh])
def test_results_folder_that_is_a_file(write, tmp_path):
    taken = tmp_path / "taken"
    taken.write_text("")
    with pytest.raises(MasonryError, match=r"taken' cannot be made: it is a file; choose another"):
        write(scene(), taken)


def test_probe_outside_an_elastic_block_is_refused_before_the_run():
    probe = Probe(name="top", block="pile.b2", point=(0.5, 7.0))
    with pytest.raises(SceneError, match=r"probes\.0 \('top'\): block 'pile.b2'.*outside the block"):
        check_scene(scene(fidelity="elastic", mesh=MeshSettings(size=0.5), probes=(probe,)))


def test_bricks_of_decimal_sizes_touch():
    """0.4 and 0.2 are no binary fractions: their joints have gaps of rounding, which must not count."""
    wall = WallStructure(name="wall", material="stone", brick=(0.4, 0.2), columns=3, courses=4)
    keys = {"fidelity": "elastic", "mesh": MeshSettings(divisions=(4, 2)), "structures": (wall,)}
    result = solve_scene(scene(**keys, analysis=Statics()))
    assert result.outcome == "equilibrium"
    assert result.summary.solver.linear_solves <= 8
    assert result.march.state.gap.min() >= -1e-18


def test_blocks_that_nothing_holds_are_named(caplog):
    flying = BlockStructure(name="flying", material="stone", size=(1.0, 1.0), position=(5.0, 5.0))
    with caplog.at_level(logging.WARNING):
        check_scene(scene(structures=(STACK, flying)), Path())
    assert [m for m in caplog.messages if "no support holds 'flying'," in m]
    caplog.clear()
    with caplog.at_level(logging.WARNING):
        check_scene(scene(), Path())
    assert not caplog.messages
