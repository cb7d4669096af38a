"""Collapse by simulation: what grows, what is told, and the command."""

from __future__ import annotations

import csv
import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import masonry_fem.analyses.trials as module
from masonry_fem import cli
from masonry_fem.analyses.collapse import collapse
from masonry_fem.errors import MasonryError
from masonry_fem.output.render import can_render
from masonry_fem.scene import load

PIER = """
title = "block on a plane"
dimension = 2
fidelity = "rigid"
[materials.stone]
density = 2400
young = "10 GPa"
[[structures]]
kind = "stack"
name = "pier"
material = "stone"
size = [1.0, 1.0]
count = 1
[mesh]
divisions = [4, 4]
[[joints]]
friction = 0.4
[loads]
gravity = [0, -9.81]
"""
FORCE = '\n[[loads.points]]\nblock = "pier.b1"\nvector = [1000.0, 0]\n'
WEIGHT = 2400 * 9.81
ARCH = """
title = "arch"
dimension = 2
fidelity = "rigid"
[materials.stone]
density = 2400
[[structures]]
kind = "arch"
name = "arch"
material = "stone"
radius = 1.0
thickness = 0.2
voussoirs = 11
[[joints]]
friction = 0.6
[loads]
gravity = [0, -9.81]
"""


@pytest.fixture
def pier(tmp_path: Path) -> Path:
    path = tmp_path / "pier.toml"
    path.write_text(PIER)
    return path


def within(found, limit: float, tolerance: float = 0.01) -> bool:
    """Whether the bracket holds a limit and is as narrow as it should be."""
    stands, falls = found.summary.stands, found.summary.falls
    return stands <= limit <= falls and falls - stands <= tolerance * falls


@pytest.mark.parametrize("fidelity", ["rigid", "elastic"])
def test_a_block_slides_at_its_friction(pier: Path, fidelity: str) -> None:
    found = collapse(load(pier, [f"fidelity={fidelity}"]), acceleration="x")
    assert found.summary.outcome == "bracketed"
    assert within(found, 0.4)
    assert found.summary.limit_multiplier == pytest.approx(0.4, rel=1e-6)
    (joint,) = found.mechanism.joints
    assert (joint.how, set(joint.between), joint.label) == ("slides", {"pier.b1", "pier.ground"}, "bed")
    direction = joint.slip if joint.between[0] == "pier.b1" else -joint.slip
    np.testing.assert_allclose(direction, [1.0, 0.0], atol=0.02)
    assert found.mechanism.sentence().startswith("pier.b1 moves; 1 sliding joint: ")


@pytest.mark.parametrize("fidelity", ["rigid", "elastic"])
def test_a_slender_block_tips_about_its_edge(pier: Path, fidelity: str) -> None:
    changes = ["structures.pier.size=[0.5, 2.0]", f"fidelity={fidelity}", "joints.0.friction=0.6"]
    found = collapse(load(pier, changes), tilt="x", limit=False)
    assert within(found, 0.25)
    (joint,) = found.mechanism.joints
    assert joint.how == "hinge"
    np.testing.assert_allclose(joint.at, [0.5, 0.0], atol=1e-3)
    (part,) = found.mechanism.parts
    np.testing.assert_allclose(part.pole, [0.5, 0.0], atol=0.01)
    assert "turns clockwise about (0.5, 0) m" in found.mechanism.words()[0]
    assert f"{math.degrees(math.atan(found.summary.falls)):.5g} degrees" in found.summary.message


def test_the_tilt_turns_gravity_and_no_other_load(pier: Path) -> None:
    """Pressed by P from above a block slides at sin α = μ (cos α + P/W), or at a = μ (1 + P/W) g."""
    pier.write_text(PIER + FORCE.replace("[1000.0, 0]", f"[0, {-0.5 * WEIGHT}]"))
    level = collapse(load(pier), acceleration="x")
    assert within(level, 0.6)
    assert level.summary.limit_multiplier == pytest.approx(0.6, rel=1e-6)
    tilted = collapse(load(pier), tilt="x")
    assert tilted.summary.limit_multiplier is None
    assert any("limit analysis is left out" in note for note in tilted.summary.notes)
    angle = math.atan(tilted.multiplier)
    assert math.sin(angle) == pytest.approx(0.4 * (math.cos(angle) + 0.5), rel=0.01)


@pytest.mark.parametrize("kind", ["statics", "steps", "large_step"])
def test_loads_of_the_scene_grow_but_gravity(pier: Path, kind: str) -> None:
    pier.write_text(PIER + FORCE)
    analysis = {
        "statics": "analysis={kind='statics'}",
        "steps": "analysis={kind='statics', load_steps=3}",
        "large_step": "analysis={kind='equilibrium', strategy='large_step', step=0.01, max_steps=4}",
    }[kind]
    found = collapse(load(pier, [analysis]), limit=False, tolerance=2e-3)
    assert within(found, 0.4 * WEIGHT / 1000, 2e-3)
    assert found.summary.unit == "times"
    assert "points.0" in found.summary.action


def test_the_first_state_keeps_the_loads_that_stay(pier: Path) -> None:
    """A force that is dead takes a part of the friction."""
    second = FORCE.replace("1000.0", "2000.0")
    pier.write_text(PIER + FORCE + second)
    found = collapse(load(pier), dead=["points.1"])
    assert within(found, 0.4 * WEIGHT / 1000 - 2)
    again = collapse(load(pier), dead=["points.1"], at_once=True, limit=False)
    assert within(again, 0.4 * WEIGHT / 1000 - 2)


@pytest.mark.slow
def test_motions_of_supports_are_made_before_loads_grow(tmp_path: Path) -> None:
    """An arch whose springings have parted falls earlier: less than a rigid one, by some per cent."""
    path = tmp_path / "arch.toml"
    path.write_text(ARCH)
    whole = collapse(load(path), acceleration="x", tolerance=2e-3)
    path.write_text(
        ARCH + '[[supports]]\non = "arch.springing_right"\nmotion = { displacement = [0.1, 0] }\n'
    )
    parted = collapse(
        load(path, ["analysis={kind='statics', load_steps=5}"]), acceleration="x", tolerance=2e-3
    )
    assert parted.summary.outcome == "bracketed"
    assert 0.5 * whole.summary.stands < parted.summary.falls < 0.97 * whole.summary.stands
    assert any("falls below" in note for note in parted.summary.notes)


def test_each_trial_goes_on_from_the_last_that_stood(pier: Path, monkeypatch) -> None:
    made = []
    real = module.march

    def spy(*given, start=None, **keys):
        made.append(start)
        return real(*given, start=start, **keys)

    monkeypatch.setattr(module, "march", spy)
    scene = load(pier, ["joints.0.friction=0.43"])
    found = collapse(scene, acceleration="x", limit=False)
    assert made[0] is None
    times = [state.time for state in made[1:]]
    stood = [trial.verdict == "stands" for trial in found.summary.trials]
    # a static trial lasts from one whole load factor to the next
    expected = [sum(stood[:number]) for number in range(1, len(stood))]
    assert times == pytest.approx(expected)
    made.clear()
    collapse(scene, acceleration="x", limit=False, at_once=True)
    assert {state.time for state in made[1:]} == {1.0}


def test_what_was_not_solved_is_no_fall(pier: Path) -> None:
    """A solver that may not iterate decides nothing: the bracket stays open and says so."""
    pier.write_text(PIER)
    starved = ["solver.method='newton'", "solver.max_iterations=1", "structures.pier.count=3"]
    found = collapse(load(pier, starved), acceleration="x", limit=False)
    assert {trial.verdict for trial in found.summary.trials} == {"undecided"}
    assert (found.summary.outcome, found.summary.stands, found.summary.falls) == ("undecided", None, None)
    assert any("undecided" in note for note in found.summary.notes)


def test_it_does_without_a_first_trial_that_is_not_solved(pier: Path, monkeypatch) -> None:
    """What grows may be what lets a structure be solved: a wall without weight, before it is pressed."""
    real, count = module.march, []

    def starved(model, strategy, settings, **keys):
        count.append(keys)
        if len(count) == 1:
            settings = replace(settings, method="newton", max_iterations=1, tolerance=1e-15)
        return real(model, strategy, settings, **keys)

    monkeypatch.setattr(module, "march", starved)
    found = collapse(load(pier, ["structures.pier.count=3"]), acceleration="x")
    assert found.summary.trials[0].multiplier == 0
    assert found.summary.trials[0].verdict == "undecided"
    assert found.summary.outcome == "bracketed"
    assert within(found, 1 / 3)  # it tips


def test_warnings_of_trials_are_told_once(pier: Path, caplog) -> None:
    """Mortar that breaks under the block warns in each trial."""
    law = "joints.0.law={kind='mohr_coulomb', cohesion=500.0, tensile_strength=100.0}"
    found = collapse(load(pier, [law]), acceleration="x", tolerance=0.1)
    assert any("in " in note and "gave way abruptly" in note for note in found.summary.notes)
    # it falls near the multiplier of limit analysis, as if strength were kept: nothing to note
    assert found.summary.falls > 0.8 * found.summary.limit_multiplier
    assert not any("keep their strength" in note for note in found.summary.notes)
    assert "gave way" not in caplog.text
    assert sum("gave way" in note for note in found.summary.notes) == 1


def test_dynamics_is_replaced_by_statics(pier: Path) -> None:
    found = collapse(load(pier, ["analysis={kind='dynamics', step=0.01, duration=1.0}"]), acceleration="x")
    assert within(found, 0.4)
    assert any("statics was taken" in note for note in found.summary.notes)


def test_a_structure_that_does_not_stand_says_so_at_once(tmp_path: Path) -> None:
    path = tmp_path / "arch.toml"
    path.write_text(ARCH)
    found = collapse(load(path, ["structures.arch.thickness=0.1"]), acceleration="x")
    assert (found.summary.outcome, found.summary.stands, found.summary.falls) == (
        "falls at the start",
        None,
        0.0,
    )
    assert len(found.mechanism.of("hinge")) >= 5


@pytest.mark.parametrize(
    ("keys", "match"),
    [
        ({}, "no load that may grow"),
        ({"tilt": "x", "acceleration": "x"}, "both"),
        ({"tilt": "y"}, "expected"),
        ({"acceleration": "x", "dead": ["points.0"]}, "all loads stay"),
        ({"acceleration": "x", "tolerance": 0.0}, "tolerance"),
    ],
)
def test_what_cannot_be_asked_is_named(pier: Path, keys: dict, match: str) -> None:
    with pytest.raises(MasonryError, match=match):
        collapse(load(pier), **keys)


def test_a_tilt_needs_gravity(pier: Path) -> None:
    pier.write_text(PIER.replace("[loads]\ngravity = [0, -9.81]", FORCE))
    with pytest.raises(MasonryError, match="gravity"):
        collapse(load(pier), tilt="x")


def test_trials_do_not_go_on_from_a_state_at_the_very_limit(pier: Path) -> None:
    """At λ = B/H statics may turn the block to anywhere: the next trials start where it stood before."""
    changes = ["structures.pier.size=[0.5, 2.0]", "joints.0.friction=0.6"]
    found = collapse(load(pier, changes), acceleration="x", limit=False)
    assert 0.25 in {trial.multiplier for trial in found.summary.trials}
    assert found.summary.stands == 0.25
    assert found.state.gap.max() < 1e-9


# --- the command ------------------------------------------------------------------------------------


def test_the_command_writes_and_prints(pier: Path, tmp_path: Path, capsys) -> None:
    out = tmp_path / "out"
    assert cli.main(["collapse", str(pier), "--acceleration", "x", "--out", str(out)]) == 0
    printed = capsys.readouterr()
    assert "multiplier [g]" in printed.out
    assert "pier.b1 moves along (1, 0)" in printed.out
    assert printed.err == ""
    told = json.loads((out / "collapse.json").read_text())
    assert told["outcome"] == "bracketed"
    assert told["mechanism"]["joints"][0]["how"] == "slides"
    with (out / "trials.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [float(row["multiplier"]) for row in rows] == [trial["multiplier"] for trial in told["trials"]]
    if can_render():
        assert (out / "mechanism.png").stat().st_size > 10_000


def test_json_and_exit_codes(pier: Path, tmp_path: Path, capsys) -> None:
    command = ["collapse", str(pier), "--tilt=-x", "--json", "--out", str(tmp_path / "out")]
    quick = ["--set", "output.pictures=false"]
    assert cli.main([*command, *quick]) == 0
    assert json.loads(capsys.readouterr().out)["unit"] == "tan"
    assert cli.main([*command, *quick, "--start", "0.5"]) == 3
    assert "falls at the start" in capsys.readouterr().err.lower()
    assert cli.main(["collapse", str(pier)]) == 1


def test_an_interrupted_search_keeps_what_it_knows(pier: Path, tmp_path: Path, capsys, monkeypatch) -> None:
    real, count = module.march, iter(range(3))

    def tired(*given, **keys):
        if next(count, None) is None:
            raise KeyboardInterrupt
        return real(*given, **keys)

    monkeypatch.setattr(module, "march", tired)
    out = tmp_path / "out"
    command = ["collapse", str(pier), "--acceleration", "x", "--no-limit", "--quiet", "--out", str(out)]
    assert cli.main(command) == cli.INTERRUPTED
    told = json.loads((out / "collapse.json").read_text())
    assert told["outcome"] == "interrupted"
    assert len(told["trials"]) == 3
    assert told["stands"] is not None
    assert "interrupted" in capsys.readouterr().err


def test_a_folder_that_cannot_be_made_is_told_before_the_search(
    pier: Path, tmp_path: Path, capsys, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("masonry_fem.analyses.collapse.collapse", lambda *_, **__: pytest.fail("searched"))
    taken = tmp_path / "taken"
    taken.touch()
    assert cli.main(["collapse", str(pier), "--tilt=x", "--out", str(taken)]) == 1
    assert "it is a file; choose another one" in capsys.readouterr().err
