"""Reopening: a scene that starts where another run ended."""

from __future__ import annotations

import numpy as np
import pytest

from masonry_fem.analyses.run import run, solve_scene
from masonry_fem.analyses.run.resume import resume
from masonry_fem.errors import MasonryError
from masonry_fem.output.checkpoint import CheckpointError
from masonry_fem.scene import loads
from tests.analyses.test_resume import assert_same, cut, scene_of

KINDS = ("rigid statics", "elastic statics", "reduced statics", "inelastic", "promoted", "cohesive statics")
FROM = "analysis.start='first'"
PRESSED = ("inelastic", "promoted")  # by a support that moves
SETTLED = """
dimension = 2
fidelity = "elastic"
mesh = { element = "Q1", size = 0.25 }
loads.gravity = [0.0, -10.0]
materials.stone = { density = 2000.0, young = 1e9, poisson = 0.2 }
structures = [
  { kind = "block", name = "left", material = "stone", size = [0.5, 0.5], support = true },
  { kind = "block", name = "right", material = "stone", size = [0.5, 0.5], position = [1.5, 0.0] },
  { kind = "block", name = "beam", material = "stone", size = [2.0, 0.5], position = [0.0, 0.5] },
]
joints = [{ friction = 0.6 }]
supports = [{ on = "right", motion = { displacement = [0.0, -0.01], rotation = -0.02 } }]
analysis = { kind = "statics", load_steps = 4 }
output = { pictures = false, fields = false, checkpoint_steps = 1 }
"""


class Watch:
    """Keeps the state of each step."""

    def __init__(self):
        self.states = []

    def record(self, model, state, report):
        self.states.append(state)


def largest(vectors):
    return np.abs(vectors).max()


@pytest.mark.parametrize("name", KINDS)
def test_the_same_loads_change_nothing_in_any_step(name, tmp_path):
    left = run(scene_of(name), tmp_path / "first").march.state
    keys = ["analysis.load_steps=3", FROM]
    if name in PRESSED:  # the motion goes on from where it ended
        keys.append("supports.1.motion.displacement=[0.0, 0.0]")
    watch = Watch()
    made = solve_scene(scene_of(name, *keys), tmp_path, (watch,))
    assert made.outcome == "equilibrium"
    assert len(watch.states) >= 3
    for state in watch.states:
        assert largest(state.force - left.force) <= 1e-6 * largest(left.force)
        assert largest(state.points - left.points) <= 1e-9


def test_a_load_that_is_gone_goes_evenly(tmp_path):
    name = "elastic statics"
    push = run(scene_of(name), tmp_path / "first")
    watch = Watch()
    still = "loads.accelerations=[]"
    made = solve_scene(scene_of(name, still, "analysis.load_steps=4", FROM), tmp_path, (watch,))
    assert made.outcome == "equilibrium"
    across, up = push.march.report.applied[:2]
    for share, state in zip((0.75, 0.5, 0.25, 0.0), watch.states, strict=True):
        ground = state.force[np.isin(made.built.model.contacts.blocks[:, 1], 0)].sum(axis=0)
        assert ground == pytest.approx([-share * across, -up], abs=1e-6 * abs(up))
    never = solve_scene(scene_of(name, still), tmp_path)
    # friction remembers what slid under the load
    assert largest(watch.states[-1].force - never.march.state.force) > 1e-3 * largest(never.march.state.force)


def test_a_wall_that_stands_by_statics_stays_at_rest_in_time(tmp_path):
    first = run(scene_of("elastic statics", "loads.accelerations=[]"), tmp_path / "first")
    time = "analysis={kind='dynamics', step=1e-3, duration=0.02, start='first'}"
    made = solve_scene(scene_of("elastic statics", "loads.accelerations=[]", time), tmp_path)
    assert made.march.report.speed < 1e-8
    assert largest(made.march.state.points - first.march.state.points) < 1e-10


@pytest.mark.parametrize("fidelity", ["rigid", "elastic"])
def test_supports_stay_where_they_have_gone(fidelity, tmp_path):
    fix = f"fidelity={fidelity}"
    first = run(loads(SETTLED, [fix]), tmp_path / "first").march.state
    again = solve_scene(loads(SETTLED, [fix, "supports=[{ on = 'right' }]", FROM]), tmp_path)
    assert largest(again.march.state.points - first.points) < 1e-9
    assert largest(again.march.state.force - first.force) <= 1e-6 * largest(first.force)


def test_motions_add_up(tmp_path):
    double = ["supports.0.motion.displacement=[0.0, -0.02]", "supports.0.motion.rotation=-0.04"]
    once = solve_scene(loads(SETTLED, ["fidelity=rigid", *double]))
    run(loads(SETTLED, ["fidelity=rigid"]), tmp_path / "first")
    twice = solve_scene(loads(SETTLED, ["fidelity=rigid", FROM]), tmp_path)
    for one, other in zip(once.march.state.bodies, twice.march.state.bodies, strict=True):
        assert other.shift == pytest.approx(one.shift, abs=1e-6)
        assert other.turned == pytest.approx(one.turned, abs=1e-6)


def test_a_motion_in_two_runs_is_that_of_one(tmp_path):
    whole = solve_scene(scene_of("rigid, redetected"))
    name, half = "rigid, redetected", "analysis.duration=0.06"
    first = run(scene_of(name, half), tmp_path / "first")
    assert first.march.standing.found is not None
    second = solve_scene(
        scene_of("rigid, redetected", "analysis.duration=0.06", "initial=[]", FROM), tmp_path
    )
    for one, other in zip(whole.march.state.bodies, second.march.state.bodies, strict=True):
        assert other.shift == pytest.approx(one.shift, abs=1e-6)


def test_a_run_that_started_elsewhere_goes_on_with_the_same_bits(tmp_path, monkeypatch):
    run(scene_of("elastic statics"), tmp_path / "first")
    scene = scene_of("elastic statics", "analysis.start='first'", "loads.accelerations=[]")
    whole = run(scene, tmp_path / "whole", base=tmp_path)
    cut(scene, tmp_path / "cut", 6, monkeypatch, base=tmp_path)
    assert_same(whole, resume(tmp_path / "cut"), tmp_path / "whole", tmp_path / "cut")
    cut(scene, tmp_path / "cut", 6, monkeypatch, base=tmp_path)
    run(scene_of("elastic statics", "loads.gravity=[0.0, -9.0]"), tmp_path / "first")
    with pytest.raises(CheckpointError, match=r"first, where the run started, has changed since"):
        resume(tmp_path / "cut")


def test_a_scene_of_other_stones_alone_is_refused(tmp_path):
    scene = """
    dimension = 2
    fidelity = "rigid"
    materials.stone = { density = 2400 }
    structures = [{ kind = "stack", name = "pile", material = "stone", size = [1.0, 0.5], count = 2 }]
    joints = [{ friction = 0.6 }]
    loads.gravity = [0.0, -9.81]
    analysis.kind = "statics"
    output = { pictures = false, checkpoint_steps = 1 }
    """
    run(loads(scene), tmp_path / "first")
    with pytest.raises(
        MasonryError, match=r"none of the stones there, 'pile\.ground', 'pile\.b1', 'pile\.b2'"
    ):
        solve_scene(loads(scene, ["structures.0.name=heap", "analysis.start=first"]), tmp_path)


@pytest.mark.parametrize(
    ("override", "sentence"),
    [
        ("materials.stone.density=2500", r"'pile\.b1' had a mass of 1200, and has 1250"),
        ("structures.0.size=[1.0, 0.4]", "had another shape or place"),
        ("fidelity=elastic", r"'pile\.b1' was rigid, and is elastic"),
        ("initial.0.spin=1.0", "initial gives velocities beside analysis.start"),
        ("analysis.start='nowhere'", r"nowhere has no checkpoint\.npz"),
    ],
)
def test_what_does_not_fit_is_refused_with_the_difference(override, sentence, tmp_path):
    run(scene_of("rigid, meeting", "analysis.duration=0.012"), tmp_path / "first")
    rest = [] if "initial" in override else ["initial=[]"]
    with pytest.raises(MasonryError, match=sentence):
        solve_scene(scene_of("rigid, meeting", FROM, override, *rest), tmp_path)


@pytest.mark.parametrize(
    ("override", "sentence"),
    [
        ("mesh.size=0.1", r"had \d+ elements with \d+ nodes, and has \d+ elements with \d+ nodes"),
        ("mesh.element=P1", r"had \d+ elements with \d+ nodes, and has \d+ elements with \d+ nodes"),
    ],
)
def test_stones_with_other_elements_are_refused(override, sentence, tmp_path):
    run(scene_of("elastic statics"), tmp_path / "first")
    with pytest.raises(MasonryError, match=sentence):
        solve_scene(scene_of("elastic statics", FROM, override), tmp_path)


def test_a_start_in_the_folder_of_all_stages_names_that_of_one(tmp_path):
    """Above the stages there is a checkpoint, too, that holds no state."""
    stages = """
    dimension = 2
    fidelity = "rigid"
    materials.stone = { density = 2400 }
    structures = [{ kind = "stack", name = "pile", material = "stone", size = [1.0, 0.5], count = 2 }]
    joints = [{ friction = 0.6 }]
    loads.gravity = [0.0, -9.81]
    analysis.kind = "statics"
    output = { pictures = false, fields = false }
    """
    more = "stages = [{ name = 'one' }, { name = 'two' }]"
    run(loads(stages + more), tmp_path / "first")
    with pytest.raises(CheckpointError, match=r"results of several runs; expected those of one.*first/two$"):
        solve_scene(loads(stages, ["analysis.start=first"]), tmp_path)
