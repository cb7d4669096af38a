"""Ties in runs: files, stages, going on, contacts found anew, and what is refused."""

from __future__ import annotations

import csv
import json

import numpy as np
import pytest

from masonry_fem.analyses.run import run, solve_scene
from masonry_fem.analyses.run.resume import resume
from masonry_fem.errors import SceneError
from masonry_fem.scene import loads
from tests.analyses.test_resume import bits

SCENE = """
title = "tied"
dimension = 2
fidelity = "rigid"
loads.gravity = [0.0, -9.81]
joints = [{ friction = 0.6 }]
output = { pictures = false }
[materials.stone]
density = 2000.0
young = 1e9
poisson = 0.2
[[structures]]
kind = "block"
name = "ground"
material = "stone"
size = [8.0, 0.5]
position = [-2.0, -0.5]
support = true
[[structures]]
kind = "block"
name = "left"
material = "stone"
size = [0.5, 2.0]
[[structures]]
kind = "block"
name = "right"
material = "stone"
size = [0.5, 2.0]
position = [2.0, 0.0]
[[ties]]
name = "bar"
points = [{ block = "left", point = [0.5, 1.8] }, { block = "right", point = [2.0, 1.8] }]
section = 1e-4
pretension = 1e3
[[loads.points]]
block = "left"
vector = [-4e3, 0.0]
point = [0.0, 1.5]
"""
DYNAMICS = "analysis={kind='dynamics', step=0.002, duration=0.1, theta=0.6}"


def told(folder):
    return json.loads((folder / "summary.json").read_text(encoding="utf-8"))


def test_files_of_a_run(tmp_path):
    made = run(loads(SCENE, ["output.interfaces=true", "output.determinacy=true"]), tmp_path)
    assert made.outcome == "equilibrium"
    with (tmp_path / "ties.csv").open(encoding="utf-8", newline="") as file:
        (line,) = csv.DictReader(file)
    force = made.summary.ties["bar"].force
    assert force > 0
    assert (line["tie"], line["from"], line["to"]) == ("bar", "left", "right")
    assert float(line["force [N/m]"]) == force
    ends = np.array([[float(line[f"{end}_{axis} [m]"]) for axis in "xy"] for end in ("from", "to")])
    at_rest = 1.5 / (1 + 1e3 / (200e9 * 1e-4))
    assert np.linalg.norm(ends[1] - ends[0]) - at_rest == pytest.approx(
        made.summary.ties["bar"].elongation, rel=1e-6
    )
    assert told(tmp_path)["ties"]["bar"]["force"] == force
    with (tmp_path / "history.csv").open(encoding="utf-8", newline="") as file:
        assert float(list(csv.DictReader(file))[-1]["tie_forces.bar"]) == force
    with (tmp_path / "interfaces.csv").open(encoding="utf-8", newline="") as file:
        assert len(list(csv.DictReader(file))) == 2


def test_a_run_that_was_cut_goes_on_with_the_same_bits(tmp_path):
    keys = [
        DYNAMICS,
        "ties.bar.yield_stress=3e7",
        "loads.points.0.vector=[-8e3, 0.0]",
        "output.checkpoint_steps=3",
    ]
    whole, cut = tmp_path / "whole", tmp_path / "cut"
    uncut = run(loads(SCENE, keys), whole)
    assert uncut.summary.ties["bar"].plastic_strain > 0
    run(loads(SCENE, [*keys, "analysis.duration=0.04"]), cut)
    resumed = resume(cut, ["analysis.duration=0.1"])
    assert bits(resumed) == bits(uncut)
    assert told(cut)["ties"] == told(whole)["ties"]


STAGES = """
[[stages]]
name = "spread"
ties = []
supports = [{ on = "right", motion = { displacement = [0.01, 0.0] } }]

[[stages]]
name = "tied"
supports = [{ on = "right" }]
[[stages.ties]]
name = "bar"
points = [{ block = "left", point = [0.5, 1.8] }, { block = "right", point = [2.0, 1.8] }]
section = 1e-4
pretension = 1e3

[[stages]]
name = "kept"

[[stages]]
name = "drawn"
supports = [{ on = "right", motion = { displacement = [1e-5, 0.0] } }]

[[stages]]
name = "free"
ties = []
"""


def test_a_tie_comes_and_goes_with_stages(tmp_path):
    """It has its pretension where its ends have gone by then, and goes on from there."""
    made = run(loads(SCENE + STAGES, ["loads.points=[]"]), tmp_path)
    assert [stage.outcome for stage in made.summary.stages] == ["equilibrium"] * 5
    assert "ties" not in told(tmp_path / "spread")
    assert "ties" not in told(tmp_path / "free")
    tied, kept, drawn = (told(tmp_path / name)["ties"]["bar"] for name in ("tied", "kept", "drawn"))
    stiffness = 200e9 * 1e-4
    rest = 1.51 / (1 + 1e3 / stiffness)
    assert tied["force"] == pytest.approx(1e3, rel=1e-6)
    assert kept["force"] == pytest.approx(1e3, rel=1e-6)
    assert drawn["force"] == pytest.approx(1e3 + stiffness * 1e-5 / rest, rel=1e-6)
    assert tied["elongation"] == pytest.approx(1.51 - rest, rel=1e-6)


def test_contacts_found_anew_keep_the_tie():
    """Rigid stones whose contacts are detected in each step give the same force."""
    forces = [
        solve_scene(loads(SCENE, [DYNAMICS, f"contact.update='{update}'"])).summary.ties["bar"].force
        for update in ("moving", "redetect")
    ]
    assert forces[0] > 0
    assert forces[1] == pytest.approx(forces[0], rel=1e-6)


def test_a_far_tie_does_not_keep_blocks_from_meeting():
    """Two blocks that only a tie joins bump into each other as any do."""
    keys = ["loads.points=[]", "joints=[{friction=0.0}]", "ties.bar.pretension=0.0"]
    push = "initial=[{blocks='left', velocity=[3.0, 0.0]}]"
    march = "analysis={kind='dynamics', step=0.005, duration=0.7}"
    made = solve_scene(
        loads(SCENE, [*keys, push, march, "probes=[{name='p', block='left', point=[0.5, 0.1]}]"])
    )
    assert made.summary.probes["p"][0] < 1.5 + 0.7 * 3.0 - 0.3  # it would be through


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ("ties.bar.section=0.0", "ties.bar.section"),
        ("ties.bar.diameter=0.02", "diameter"),
        ("ties.bar.closed=true", "three points"),
        ("ties.bar.hardening=1e9", "yield_stress"),
        ("ties.bar.points=[{block='left'}]", "ties.bar.points"),
        ("ties.bar.points=[{block='left'}, {block='left'}]", "two blocks"),
        ("ties.bar.points=[{block='nobody'}, {block='left'}]", "nobody"),
        ("ties.bar.points=[{block='left', point=[5.0, 1.0]}, {block='right'}]", "outside 'left'"),
        (
            "ties.bar.points=[{block='left', point=[0.5, 0.0]}, {block='ground', point=[0.5, 0.0]}]",
            "one point",
        ),
        ("ties.bar.yield_stress=1e6", "at most yield_stress"),
        ("ties.bar.rupture_strain=1e-9", "pretension"),
    ],
)
def test_what_cannot_be_is_refused(change, words):
    with pytest.raises(SceneError, match=words):
        solve_scene(loads(SCENE, [change]))


def test_a_tie_between_supports_is_told():
    made = solve_scene(loads(SCENE, ["supports=[{on='left'}, {on='right'}]", "loads.points=[]"]))
    assert "idle_tie" in [one.code for one in made.summary.remarks]
