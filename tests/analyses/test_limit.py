"""Limit analysis of scenes: which loads grow, what is told, and how the command prints it."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from masonry_fem import cli
from masonry_fem.analyses.limit import analyse
from masonry_fem.analyses.run import run, solve_scene
from masonry_fem.errors import LawError, MasonryError
from masonry_fem.results.limit import outside
from masonry_fem.results.limit_analysis import Outside
from masonry_fem.scene import load
from masonry_fem.scene.specs import Material, Scene
from masonry_fem.structures.stack import StackStructure

SCENE = """
title = "loaded arch"
dimension = 2
fidelity = "rigid"
[materials.stone]
density = 2400
young = "10 GPa"
[[structures]]
kind = "arch"
name = "arch"
material = "stone"
radius = 1.0
thickness = 0.2
voussoirs = 11
[[joints]]
friction = 5.0
[loads]
gravity = [0, -9.81]
[[loads.points]]
block = "arch.v05"
vector = [0, -1000.0]
[[loads.points]]
block = "arch.v06"
vector = [0, -1.0]
time = { kind = "table", points = [[0, 0], [1, 100]] }
"""
WEIGHT = 0.2 * np.pi * 2400 * 9.81
LIMIT = 0.40189 * WEIGHT / 1000  # A3.6


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    path = tmp_path / "arch.toml"
    path.write_text(SCENE)
    return path


def test_gravity_stays_and_other_loads_grow(scene: Path) -> None:
    told = analyse(load(scene))
    assert (told.dead, told.growing) == (("gravity",), ("points.0", "points.1"))
    assert told.admissible is True
    assert 0.8 * LIMIT < told.multiplier < LIMIT  # the second force brings a little more down
    assert "4 hinges" in told.message
    assert told.mechanism.joints[0].how == "hinge"
    assert max(told.certificate.values()) < 1e-8


def test_named_loads_stay(scene: Path) -> None:
    told = analyse(load(scene), dead=["points.1"])
    assert (told.dead, told.growing) == (("gravity", "points.1"), ("points.0",))
    small = analyse(load(scene, ["loads.points.1.vector=[0, -1e-6]"]), dead=["points.1"])
    assert small.multiplier == pytest.approx(LIMIT, rel=2e-5)
    assert told.multiplier != pytest.approx(small.multiplier, rel=1e-3)


def test_loads_count_as_at_the_end(scene: Path) -> None:
    """1 N with a factor of 100 at the end is 100 N."""
    as_ramp = analyse(load(scene))
    plain = SCENE.replace('[0, -1.0]\ntime = { kind = "table", points = [[0, 0], [1, 100]] }', "[0, -100.0]")
    scene.write_text(plain)
    assert analyse(load(scene)).multiplier == pytest.approx(as_ramp.multiplier, rel=1e-12)


def test_a_tilt_grows_an_acceleration_alone(scene: Path) -> None:
    overrides = ["loads.points=[]"]
    right = analyse(load(scene, overrides), tilt="x")
    left = analyse(load(scene, overrides), tilt="-x")
    assert right.growing == ("tilt x",)
    assert right.multiplier == pytest.approx(0.29556, abs=6e-6)
    assert left.multiplier == pytest.approx(right.multiplier, rel=1e-9)
    assert "16.47 degrees" in right.message
    loaded = analyse(load(scene), tilt="x")
    assert loaded.dead == (
        "gravity",
        "points.0",
        "points.1",
    )


@pytest.mark.parametrize(
    ("tilt", "dead"),
    [("y", ()), ("z", ()), ("up", ()), ("", ()), ("-", ()), (None, ("points.7",)), ("x", ("points.0",))],
)
def test_what_is_not_there_is_named(scene: Path, tilt: str | None, dead: tuple[str, ...]) -> None:
    with pytest.raises(MasonryError, match="expected"):
        analyse(load(scene), tilt=tilt, dead=dead)


def test_an_axis_is_one_of_space(scene: Path) -> None:
    """'xy' was taken for y."""
    block = StackStructure(name="s", material="stone", size=(1.0, 1.0, 1.0), count=1)
    stone = {"stone": Material(density=2000.0)}
    with pytest.raises(MasonryError, match="along 'xy', expected one of x, -x, y, -y"):
        analyse(Scene(fidelity="rigid", materials=stone, structures=(block,)), tilt="xy")


def test_without_weight_a_tilt_is_of_the_earths(scene: Path) -> None:
    """Nothing presses a joint whose only load is the tilt's."""
    told = analyse(load(scene, ["loads.points=[]", "loads.gravity=[0, 0]"]), tilt="x")
    assert told.multiplier == pytest.approx(0.0, abs=1e-9)


def test_supports_have_intervals_that_balance(scene: Path) -> None:
    told = analyse(load(scene, ["loads.points=[]"]))
    left, right = told.supports["arch.springing_left"], told.supports["arch.springing_right"]
    unit = 2400 * 9.81
    assert np.array(left["x"]) / unit == pytest.approx([0.094247, 0.160027], abs=0.6e-6)
    assert -np.array(right["x"])[::-1] == pytest.approx(np.array(left["x"]), rel=1e-9)
    assert told.multiplier is None
    assert told.growing == ()


def test_the_simulation_lies_within_the_intervals(scene: Path, tmp_path: Path) -> None:
    result = run(load(scene, ["output.limit_analysis=true", "output.pictures=false"]), tmp_path / "out")
    told = json.loads((tmp_path / "out" / "summary.json").read_text())["limit_analysis"]
    assert told["admissible"] is True
    assert told["outside"] == []
    for name, axes in told["supports"].items():
        force = result.summary.supports[name].force
        for (low, high), value in zip(axes.values(), force, strict=True):
            assert low - 1e-6 * WEIGHT <= value <= high + 1e-6 * WEIGHT


def test_forces_outside_their_intervals_are_named() -> None:
    told = SimpleNamespace(supports={"foot": {"x": (0.0, None), "y": (1.0, 2.0)}}, inexact={})

    def found(up: float) -> tuple[Outside, ...]:
        force = SimpleNamespace(force=np.array([7.0, up]))
        return outside(told, {"foot": force}, np.array([0.0, -2.0]))

    assert found(2.5) == (Outside(support="foot", axis="y", force=2.5),)
    assert found(2.001) == ()


def test_an_equilibrium_that_it_denies_is_explained(tmp_path: Path) -> None:
    """A block that hangs 5 mm above the ground rests on it in the end, and nothing carries it at first."""
    path = tmp_path / "hanging.toml"
    path.write_text(
        """
dimension = 2
fidelity = "rigid"
[materials.stone]
density = 2400
[[structures]]
kind = "block"
name = "stone"
material = "stone"
size = [1.0, 1.0]
position = [0.0, 0.005]
[[structures]]
kind = "block"
name = "ground"
material = "stone"
size = [3.0, 1.0]
position = [-1.0, -1.0]
[[supports]]
on = "ground"
[contact]
reach = 0.01
[loads]
gravity = [0, -9.81]
[output]
limit_analysis = true
"""
    )
    found = solve_scene(load(path))
    assert found.outcome == "equilibrium"
    told = found.summary.limit_analysis
    assert told.admissible is False
    assert any("equilibrium all the same" in note for note in told.notes)


def test_it_is_told_where_asked_for_only(scene: Path) -> None:
    assert solve_scene(load(scene)).summary.limit_analysis is None


def test_a_law_without_strength_is_refused_before_the_march(scene: Path) -> None:
    law = 'joints.0.law={kind="elastic", normal_stiffness=1e12, tangential_stiffness=1e12}'
    with pytest.raises(LawError, match="elastic"):
        solve_scene(load(scene, [law, "output.limit_analysis=true"]))


def test_elastic_blocks_count_as_rigid_and_clamps_hold(tmp_path: Path) -> None:
    """A clamped stone under another one: the upper slides at μ, the clamp gives all that is asked."""
    path = tmp_path / "pier.toml"
    path.write_text("""
dimension = 2
[materials.stone]
density = 2400
young = "10 GPa"
[[structures]]
kind = "stack"
name = "pier"
material = "stone"
size = [1.0, 0.5]
count = 2
ground = false
[mesh]
divisions = [2, 1]
[[joints]]
friction = 0.4
[[supports]]
on = "pier.b1/bottom"
[loads]
gravity = [0, -9.81]
""")
    told = analyse(load(path), tilt="x")
    assert told.multiplier == pytest.approx(0.4, rel=1e-8)
    assert "elastic blocks count as rigid" in told.notes
    own = 2400 * 9.81 * 1.0
    held = told.supports["pier.b1/bottom"]
    assert held["y"] == pytest.approx([own, own], rel=1e-8)
    assert held["x"] == pytest.approx([0.0, 0.0], abs=1e-8 * own)


def test_what_may_yield_is_named(tmp_path: Path) -> None:
    path = tmp_path / "pier.toml"
    path.write_text("""
dimension = 2
materials.stone.density = 2400
materials.stone.young = "10 GPa"
materials.stone.inelastic = { law = "drucker_prager", cohesion = "2 MPa", friction_angle = 35 }
structures = [{ kind = "stack", name = "pier", material = "stone", size = [1.0, 0.5], count = 2 }]
joints = [{ friction = 0.4 }]
loads.gravity = [0, -9.81]
[[overrides]]
blocks = "pier.b2"
fidelity = "inelastic"
""")
    (note,) = (note for note in analyse(load(path), tilt="x").notes if "inelastic" in note)
    assert note.startswith("inelastic blocks (1, first 'pier.b2') count as rigid")


# --- the command ------------------------------------------------------------------------------------


def test_the_command_prints_a_table(scene: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["limit", str(scene)]) == 0
    printed = capsys.readouterr().out
    assert "collapse multiplier" in printed
    assert "kN/m to" in printed
    assert "4 hinges" in printed.replace("\n", " ")


def test_the_command_prints_json(scene: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["limit", str(scene), "--tilt=-x", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["growing"] == ["tilt -x"]
    assert told["multiplier"] > 0


def test_loads_that_cannot_be_carried_end_with_three(scene: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["limit", str(scene), "--set", "structures.arch.thickness=0.05"]) == 3
    assert "cannot be carried" in capsys.readouterr().out


def test_unlimited_loads_are_told(scene: Path, capsys: pytest.CaptureFixture[str]) -> None:
    asked = ["limit", str(scene), "--dead", "points.1", "--set", "loads.points.0.block=arch.v01"]
    assert cli.main(asked) == 0
    assert "without limit" in capsys.readouterr().out.replace("\n", " ")


def test_bad_wishes_are_one_line(scene: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["limit", str(scene), "--dead", "snow"]) == 1
    assert capsys.readouterr().err.startswith("masonry-fem: --dead 'snow' names no load")
