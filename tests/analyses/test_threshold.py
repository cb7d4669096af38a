"""Thresholds of keys: which end stands, what is tried, told and kept, and the command."""

from __future__ import annotations

import csv
import json
import math
from pathlib import Path

import pytest

import masonry_fem.analyses.threshold as module
from masonry_fem import cli
from masonry_fem.analyses.bracket import Bracket
from masonry_fem.analyses.swept_key import SweptKey
from masonry_fem.analyses.threshold import threshold
from masonry_fem.errors import MasonryError
from masonry_fem.output.render import can_render

PIER = """
title = "block on a plane"
dimension = 2
fidelity = "rigid"
materials.stone = { density = 2400, young = "10 GPa" }
structures = [{ kind = "stack", name = "pier", material = "stone", size = [0.5, 2.0], count = 1 }]
mesh.divisions = [4, 4]
joints = [{ friction = 0.4 }]
loads = { gravity = [0, -9.81], accelerations = [{ vector = [1.0, 0.0] }] }
"""
FRICTION = 1.0 / 9.81


@pytest.fixture
def pier(tmp_path: Path) -> Path:
    path = tmp_path / "pier.toml"
    path.write_text(PIER)
    return path


def holds(found, limit: float, tolerance: float = 0.01) -> None:
    """The bracket of both ways of asking holds a limit, and is narrow."""
    for one in (found.summary.simulation, found.summary.limit_analysis):
        low, high = sorted((one.stands, one.falls))
        assert one.outcome == "bracketed"
        assert low <= limit <= high
        assert high - low <= tolerance * high


def test_a_probe_that_a_smaller_stone_has_left_stops_no_search(pier: Path, tmp_path: Path) -> None:
    """The block tips where its height is more than B g/a."""
    pier.write_text(PIER + 'probes = [{ name = "top", block = "pier.b1", point = [0.5, 6.0] }]\n')
    found = threshold(pier, "structures.pier.size.1", (4.0, 6.0), out=tmp_path / "out")
    holds(found, 0.5 * 9.81)


def test_ends_that_both_stand_are_to_be_taken_further_apart(pier: Path, tmp_path: Path) -> None:
    found = threshold(pier, "joints.0.friction", (0.8, 0.9), out=tmp_path / "out")
    assert found.summary.outcome == "stands at both ends"
    assert "take ends further apart" in found.summary.message


@pytest.mark.parametrize("ends", [(0.01, 0.9), (0.9, 0.01)])
def test_either_end_may_be_the_one_that_stands(pier: Path, tmp_path: Path, ends: tuple[float, float]) -> None:
    """A block slides where μ is less than a/g; a push slides it where a is more than μ g."""
    found = threshold(pier, "joints.0.friction", ends, out=tmp_path / "out")
    holds(found, FRICTION)
    assert found.summary.simulation.falls < found.summary.simulation.stands
    assert found.value == pytest.approx(FRICTION, rel=0.01)
    key, changes = "loads.accelerations.0.vector.0", ["joints.0.friction=0.05"]
    pushed = threshold(pier, key, ends, overrides=changes, out=tmp_path / "pushed")
    holds(pushed, 0.05 * 9.81)
    assert pushed.summary.simulation.stands < pushed.summary.simulation.falls
    (joint,) = pushed.fall.mechanism.joints
    assert (joint.how, set(joint.between)) == ("slides", {"pier.b1", "pier.ground"})


def test_values_have_units_and_directions(pier: Path, tmp_path: Path) -> None:
    """Pushed down at 45° a block tips where √½ a h = (g + √½ a) b, whatever the sign."""
    found = threshold(
        pier,
        "loads.accelerations.0.vector",
        ("1 mm/s^2", "9000 mm/s^2"),
        along=(-2.0, -2.0),
        out=tmp_path / "out",
    )
    holds(found, 1e3 * 9.81 * 0.25 / (1.0 - 0.25) * math.sqrt(2))
    assert "mm/s^2" in found.summary.message
    assert found.summary.along == pytest.approx([-math.sqrt(0.5)] * 2)


@pytest.mark.slow
def test_elastic_blocks_and_steps_in_time(pier: Path, tmp_path: Path) -> None:
    changes = ["fidelity=elastic", "analysis={kind='equilibrium', strategy='brutal_damping', step=0.01}"]
    found = threshold(pier, "joints.0.friction", (0.01, 0.9), overrides=changes, out=tmp_path / "out")
    holds(found, FRICTION)
    assert "limit analysis counts elastic blocks as rigid" in found.summary.notes


@pytest.mark.slow
def test_a_march_in_time_falls_once_a_stone_has_toppled(pier: Path, tmp_path: Path) -> None:
    """A step of acceleration tips a block where a is more than g b/h; how long it lasts does not matter."""
    changes = ["joints.0.friction=2", "analysis={kind='dynamics', step=0.01, duration=4}"]
    found = threshold(
        pier, "loads.accelerations.0.vector.0", (1.0, 4.0), overrides=changes, out=tmp_path / "out"
    )
    known = found.summary.simulation
    assert known.stands <= 9.81 / 4 <= known.falls
    assert found.summary.limit_analysis is None
    fallen = next(trial for trial in found.summary.trials if trial.verdict == "falls")
    assert fallen.outcome == "toppled"
    assert "pier.b1 leans by more than 45°" in fallen.message
    assert fallen.steps < 400
    (joint,) = found.fall.mechanism.joints
    assert joint.how == "hinge"
    assert joint.at == pytest.approx([0.5, 0.0], abs=0.05)


def test_what_was_tried_is_not_tried_again(pier: Path, tmp_path: Path, monkeypatch) -> None:
    """A search that is ended at any moment goes on with all that it had found, to the same end."""
    tried: list[float] = []

    class Killed(BaseException):
        pass

    def run_once(scene, base):
        if len(tried) == allowed:
            raise Killed
        tried.append(scene.joints[0].friction)
        return real(scene, base)

    real = module.run_once
    monkeypatch.setattr(module, "run_once", run_once)
    ends, out, whole = (0.01, 0.9), tmp_path / "out", tmp_path / "whole"
    allowed = 1000
    expected = threshold(pier, "joints.0.friction", ends, out=whole, limit=False, tolerance=1e-3)
    once = list(tried)
    assert len(once) > 8
    tried.clear()
    for allowed in (1, 4):  # noqa: B007 - read by the stand-in
        with pytest.raises(Killed):
            threshold(pier, "joints.0.friction", ends, out=out, limit=False, tolerance=1e-3)
    allowed = 1000
    found = threshold(pier, "joints.0.friction", ends, out=out, limit=False, tolerance=1e-3)
    assert tried == once
    assert found.summary.simulation.stands == expected.summary.simulation.stands
    assert found.summary.simulation.falls == expected.summary.simulation.falls
    again = threshold(pier, "joints.0.friction", ends, out=out, limit=False, tolerance=1e-3)
    assert tried == [*once, found.summary.simulation.falls]  # for the mechanism, which is not kept
    assert again.summary.trials == found.summary.trials
    assert again.summary.simulation.mechanism.sentence == expected.summary.simulation.mechanism.sentence


def test_ctrl_c_keeps_what_is_known(pier: Path, tmp_path: Path, monkeypatch) -> None:
    count = 0

    def run_once(scene, base):
        nonlocal count
        count += 1
        if count == 4:
            raise KeyboardInterrupt
        return real(scene, base)

    real = module.run_once
    monkeypatch.setattr(module, "run_once", run_once)
    out = tmp_path / "out"
    given = ["threshold", str(pier), "joints.0.friction", "--between", "0.01", "0.9", "--no-limit"]
    assert cli.main([*given, "--out", str(out), "--quiet"]) == 130
    told = json.loads((out / "threshold.json").read_text())
    assert (told["outcome"], len(told["trials"])) == ("interrupted", 3)
    assert cli.main([*given, "--out", str(out), "--quiet"]) == 0


def test_no_threshold_between_the_values(pier: Path, tmp_path: Path, capsys) -> None:
    given = ["threshold", str(pier), "joints.0.friction", "--quiet", "--out", str(tmp_path / "out")]
    assert cli.main([*given, "--between", "0.2", "0.9"]) == 2
    assert "stands at both ends, 0.2 and 0.9" in capsys.readouterr().err
    assert cli.main([*given, "--between", "0.02", "0.09"]) == 3
    assert "falls at both ends, 0.02 and 0.09" in capsys.readouterr().err


def test_whole_numbers(pier: Path, tmp_path: Path) -> None:
    """A stack of n blocks under 1 m/s² tips where n H/B is more than g."""
    changes = ["structures.pier.size=[0.5, 0.5]", "joints.0.friction=2"]
    found = threshold(pier, "structures.pier.count", (1, 30), overrides=changes, out=tmp_path / "out")
    for one in (found.summary.simulation, found.summary.limit_analysis):
        assert (one.stands, one.falls) == (9, 10)


def test_the_command_tells_and_writes(pier: Path, tmp_path: Path, capsys) -> None:
    out = tmp_path / "out"
    given = ["threshold", str(pier), "joints.0.friction", "--between", "0.01", "0.9", "--out", str(out)]
    assert cli.main(given) == 0
    printed = capsys.readouterr().out
    assert "limit analysis" in printed
    assert "1 sliding joint" in printed
    told = json.loads((out / "threshold.json").read_text())
    assert told["schema"] == "threshold/1"
    assert {trial["by"] for trial in told["trials"]} == {"simulation", "limit analysis"}
    with (out / "trials.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [float(row["value"]) for row in rows] == [trial["value"] for trial in told["trials"]]
    assert (out / "mechanism.png").exists() == can_render()
    assert cli.main([*given, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["outcome"] == "bracketed"


@pytest.mark.parametrize(
    ("key", "between", "along", "said"),
    [
        ("joints.0.friction=1", (0.1, 0.9), (), "dotted key without value"),
        ("joints.0.friktion", (0.1, 0.9), (), "friktion"),
        ("joints.7.friction", (0.1, 0.9), (), "has 1 items"),
        ("joints.0.friction", ("0.1 m", "0.9 cm"), (), "units 'm' and 'cm' differ"),
        ("joints.0.friction", (0.1, 0.1), (), "ends are equal"),
        ("joints.0.friction", ("low", "high"), (), "'low', expected a number"),
        ("joints.0.friction", (-1.0, 0.9), (), "friction"),
        ("loads.accelerations.0.vector", (0.1, 0.9), (0.0, 0.0), "expected a direction"),
        ("loads.accelerations.0.vector", (0.1, 0.9), (1.0, 0.0, 0.0), "vector"),
        ("fidelity", (0.1, 0.9), (), "fidelity"),
    ],
)
def test_bad_input_is_named(pier: Path, tmp_path: Path, key: str, between, along, said: str) -> None:
    with pytest.raises(MasonryError, match=said):
        threshold(pier, key, between, along=along, out=tmp_path / "out")


STAGES = """
[[stages]]
name = "tilted"
analysis = { kind = "statics", load_steps = 5 }
loads = { gravity = [0, -9.81] }
supports = [{ on = "pier.ground", motion = { rotation = -0.1 } }]

[[stages]]
name = "pushed"
loads = { gravity = [0, -9.81], accelerations = [{ vector = [1.0, 0.0] }] }
supports = [{ on = "pier.ground" }]
"""


@pytest.mark.parametrize(
    ("key", "along", "ends", "limit"),
    [
        (
            "stages.pushed.loads.accelerations.0.vector",
            (1, 0),
            (0.5, 6.0),
            9.81 * math.tan(math.atan(0.25) - 0.1),
        ),
        # it falls in this stage or in the next one
        (
            "stages.tilted.supports.0.motion.rotation",
            (),
            (-0.05, -0.5),
            math.atan(1 / 9.81) - math.atan(0.25),
        ),
    ],
)
def test_stages(pier: Path, tmp_path: Path, key: str, along, ends: tuple[float, float], limit: float) -> None:
    """A block of 0.5 m × 2 m tips where what acts leads past its corner; common stages are run once."""
    pier.write_text(PIER + STAGES)
    found = threshold(pier, key, ends, along=along, out=tmp_path / "out")
    told = found.summary.simulation
    assert told.outcome == "bracketed"
    assert min(told.stands, told.falls) <= limit <= max(told.stands, told.falls)
    assert abs(told.falls - told.stands) <= 0.01 * abs(told.falls)
    assert told.mechanism.groups == (("pier.b1",),)  # and not the ground
    assert [joint.how for joint in told.mechanism.joints] == ["hinge"]
    assert "stages" in found.summary.notes[0]
    shared = list((tmp_path / "out" / "stages").iterdir())
    assert len(shared) == (1 if "pushed" in key else len(found.summary.trials))
    again = threshold(pier, key, ends, along=along, out=tmp_path / "out")
    assert again.summary.trials == found.summary.trials
    assert sorted((tmp_path / "out" / "stages").iterdir()) == sorted(shared)


@pytest.mark.slow
def test_a_stage_in_time_whose_stone_has_toppled_is_no_start(pier: Path, tmp_path: Path) -> None:
    """Lying on the ground it would stand in the next stage; a second search does not take it for a start."""
    pier.write_text(
        PIER
        + """
[[stages]]
name = "shaken"
analysis = { kind = "dynamics", step = 0.01, duration = 3.0 }
loads.gravity = [0, -9.81]
loads.accelerations = [{ vector = [1.0, 0.0], time = { kind = "pulse", duration = 0.6 } }]
joints = [{ friction = 0.8 }]

[[stages]]
name = "rests"
analysis.kind = "statics"
loads.gravity = [0, -9.81]
"""
    )
    key, ends = "stages.shaken.loads.accelerations.0.vector", (1.0, 8.0)
    found = threshold(pier, key, ends, along=(1, 0), out=tmp_path / "out", tolerance=0.3)
    assert found.summary.outcome == "bracketed"
    assert [one.outcome for one in found.summary.trials[:2]] == ["equilibrium", "toppled"]
    again = threshold(pier, key, ends, along=(1, 0), out=tmp_path / "out", tolerance=0.3)
    assert again.summary.simulation.mechanism is not None


def test_a_bracket_between_values_closes_in_on_zero() -> None:
    bracket = Bracket(lambda value: "stands" if value < 0 else "falls", tolerance=0.01, first=2.0, least=1e-5)
    bracket.between(-1.0, 1.0, None)
    assert bracket.ending == "bracketed"
    assert bracket.falls - bracket.stands <= 1e-5


def test_a_key_is_written_as_overrides_take_it() -> None:
    assert SweptKey.of("a.b", "5 cm", "20 cm").override(12.5) == "a.b=12.5 cm"
    assert SweptKey.of("a.b", 1, 2, (3.0, 4.0)).override(10.0) == "a.b=[6.0, 8.0]"
    assert SweptKey.of("a.b", "1 N", "2 N", (0.0, 2.0)).override(1.0) == 'a.b=["0.0 N", "1.0 N"]'


PUSHED = """
dimension = 2
fidelity = "rigid"
materials.stone = { density = 2000.0 }
structures = [{ kind = "stack", name = "stack", material = "stone", size = [0.5, 0.5], count = 4 }]
joints = [{ friction = 0.7 }]
loads.gravity = [0.0, -10.0]
loads.accelerations = [{ vector = [1.0, 0.0], case = "wind" }]
output = { pictures = false, fields = false }
combinations = [
  { name = "weight", factors = { gravity = 1.35 } },
  { name = "windward", factors = { gravity = 1.0, wind = 1.5 } },
  { name = "leeward", factors = { gravity = 1.35, wind = -1.5 } },
]
"""


def test_the_combination_that_falls_first_decides(tmp_path):
    scene = tmp_path / "pushed.toml"
    scene.write_text(PUSHED, encoding="utf-8")
    found = threshold(
        scene, "loads.accelerations.0.vector", (0.2, 4.0), along=(1.0, 0.0), out=tmp_path / "out"
    )
    tips = 10.0 * 0.5 / 2.0 / 1.5  # where 1.5 a H/2 = g B/2
    for told in (found.summary.simulation, found.summary.limit_analysis):
        assert told.stands < tips < told.falls < 1.01 * tips
    assert "Combination 'windward': No equilibrium" in found.summary.message
