"""Stones that are heated and cool again from stage to stage, and scenes that start with warm stones."""

from __future__ import annotations

import numpy as np
import pytest

from masonry_fem.analyses.run import run, solve_scene
from masonry_fem.analyses.run.resume import resume
from masonry_fem.output.checkpoint import CheckpointError
from masonry_fem.scene import loads
from tests.analyses.test_reopening import Watch
from tests.analyses.test_resume import bits, cut, files

YOUNG, EXPANSION, CHANGE, DENSITY, PUSH = 1e10, 8e-6, 25.0, 2000.0, 3.0
LENGTH, HEIGHT = 2.0, 0.5
HELD = YOUNG * EXPANSION * CHANGE  # pressure of a bar that may not expand
CRUSHED = 1.5e6  # stress at which one yields whose material does

BAR = f"""
dimension = 2
plane = "stress"
fidelity = "elastic"
materials.m = {{ density = {DENSITY}, young = {YOUNG}, poisson = 0.2, thermal_expansion = {EXPANSION} }}
mesh = {{ divisions = [4, 2] }}
structures = [{{ kind = "block", name = "bar", material = "m", size = [{LENGTH}, {HEIGHT}] }}]
supports = [
  {{ on = "bar/left", components = ["x"] }},
  {{ on = "bar/right", components = ["x"] }},
  {{ on = "bar/bottom", components = ["y"] }},
]
analysis = {{ kind = "statics", load_steps = 4 }}
output = {{ pictures = false, fields = false, checkpoint_steps = 1 }}
"""
LOADED = f"accelerations = [{{ vector = [{PUSH}, 0.0] }}]"
WARM = f"temperatures = [{{ on = 'bar', change = {CHANGE} }}]"
HISTORY = f"""
[[stages]]
name = "loaded"
loads = {{ {LOADED} }}

[[stages]]
name = "warmed"
loads = {{ {LOADED}, {WARM} }}

[[stages]]
name = "kept"

[[stages]]
name = "cooled"
loads = {{ {LOADED} }}
"""


def warm(*overrides: str, start: str | None = None, heated: bool = True):
    """The bar on its own, heated or not."""
    keys = [f"loads={{ {WARM} }}"] if heated else ["loads={}"]
    keys += [] if start is None else [f"analysis.start='{start}'"]
    return loads(BAR, [*keys, *overrides])


def stresses(model, state) -> np.ndarray:
    """Along the bar at Gauss points, shape (q,) [Pa]."""
    (found,) = [
        group.stress(own).gauss
        for group, own in zip(model.groups, state.bodies, strict=True)
        if group.deforms
    ]
    return found.reshape(-1, 6)[:, 0]


class Stresses:
    """Mean stress along the bar in each step."""

    def __init__(self):
        self.means = []

    def record(self, model, state, report):
        self.means.append(stresses(model, state).mean())


YIELDS = "materials.m.inelastic={law='mohr_coulomb', cohesion=%g, friction_angle=0}"


@pytest.mark.parametrize("fidelity", ["elastic", "inelastic"])
def test_a_bar_between_walls_is_loaded_warmed_and_cools(fidelity, tmp_path):
    """Its walls bear m a/2 each of the load, and E α ΔT A of the heat, as much of it as is there by then."""
    watch = Stresses()
    told = [f"fidelity={fidelity}", *([YIELDS % 1e8] if fidelity == "inelastic" else [])]
    result = run(loads(BAR + HISTORY, told), tmp_path, observers=(watch,))
    assert [one.outcome for one in result.summary.stages] == ["equilibrium"] * 4
    quarter = HELD / 4
    shares = [0, 0, 0, 0, 1, 2, 3, 4, 4, 4, 4, 4, 3, 2, 1, 0]
    np.testing.assert_allclose(watch.means, [-quarter * share for share in shares], atol=1e-9 * HELD)
    half = 0.5 * DENSITY * LENGTH * HEIGHT * PUSH
    for stage, heat in (("loaded", 0.0), ("warmed", HELD), ("kept", HELD), ("cooled", 0.0)):
        again = warm("analysis.load_steps=1", f"loads={{ {LOADED} }}", *told, start=stage)
        if heat:
            again = warm("analysis.load_steps=1", f"loads={{ {LOADED}, {WARM} }}", *told, start=stage)
        reaction = solve_scene(again, tmp_path).march.report.support_resultants
        pushed = [reaction[f"bar/{side}"][0] for side in ("left", "right")]
        expected = [-half + heat * HEIGHT, -half - heat * HEIGHT]
        np.testing.assert_allclose(pushed, expected, atol=1e-9 * HELD)


KINDS = {
    "statics": "analysis={kind='statics', load_steps=3, start='first'}",
    "dynamics": "analysis={kind='dynamics', step=1e-4, duration=5e-3, start='first'}",
    "equilibrium": "analysis={kind='equilibrium', strategy='large_step', step=9, max_steps=40, "
    "start='first'}",
}


@pytest.mark.parametrize("kind", KINDS)
def test_the_same_temperature_changes_nothing_in_any_step(kind, tmp_path):
    left = run(warm(), tmp_path / "first").march.state
    watch = Watch()
    made = solve_scene(warm(KINDS[kind]), tmp_path, (watch,))
    assert made.outcome in ("equilibrium", "finished")
    grown = EXPANSION * CHANGE * HEIGHT
    for state in watch.states:
        (own,), (before,) = state.bodies, left.bodies
        assert np.abs(own.displacement - before.displacement).max() <= 1e-9 * grown
    assert stresses(made.built.model, made.march.state) == pytest.approx(-HELD, rel=1e-9)


@pytest.mark.parametrize("kind", KINDS)
def test_a_temperature_that_is_gone_leaves_no_stress(kind, tmp_path):
    run(warm(), tmp_path / "first")
    slow = ["analysis.step=1e-3", "analysis.duration=1.0"] if kind == "dynamics" else []
    made = solve_scene(warm(KINDS[kind], *slow, heated=False), tmp_path)
    assert made.outcome in ("equilibrium", "finished")
    share = 1e-2 if kind == "dynamics" else 1e-9  # it swings a little
    assert np.abs(stresses(made.built.model, made.march.state)).max() <= share * HELD
    assert made.march.ledger.imbalance <= 1e-8


def test_a_temperature_with_a_time_of_its_own_goes_on_from_what_was_left(tmp_path):
    """There from the start on, it is what the stones have by then, whatever they had."""
    run(warm(), tmp_path / "first")
    constant = "time = { kind = 'table', points = [[0.0, 1.0], [1.0, 1.0]] }"
    keys = f"loads={{ temperatures = [{{ on = 'bar', change = {CHANGE / 5}, {constant} }}] }}"
    watch = Stresses()
    solve_scene(warm(keys, start="first"), tmp_path, (watch,))
    shares = np.array([0.8, 0.6, 0.4, 0.2])
    np.testing.assert_allclose(watch.means, -HELD * shares, rtol=1e-9)


def test_heat_that_crushed_a_bar_leaves_it_stretched(tmp_path):
    """It flows at f_c; as it cools it is pulled by E α ΔT − f_c, less than f_t = f_c."""
    told = ["fidelity=inelastic", YIELDS % (CRUSHED / 2)]
    run(warm(*told), tmp_path / "first")
    made = solve_scene(warm(*told, start="first", heated=False), tmp_path)
    np.testing.assert_allclose(stresses(made.built.model, made.march.state), HELD - CRUSHED, rtol=1e-8)


PAIR = """
[[stages]]
name = "one"
without = ["two"]

[[stages]]
name = "both"
without = []
"""


@pytest.mark.parametrize("fidelity", ["elastic", "inelastic"])
def test_a_stone_that_comes_into_a_warm_stage_begins_cold(fidelity, tmp_path):
    """It is heated over the steps of its stage, beside one of the same shape that is warm already."""
    faces = [("left", "x"), ("right", "x"), ("bottom", "y")]
    held = [f"{{on='{bar}/{face}', components=['{axis}']}}" for bar in ("one", "two") for face, axis in faces]
    bar = f"kind='block', material='m', size=[{LENGTH}, {HEIGHT}]"
    told = [
        f"structures=[{{name='two', {bar}, position=[0, 2]}}, {{name='one', {bar}}}]",
        f"supports=[{', '.join(held)}]",
        f"loads={{temperatures=[{{change={CHANGE}}}]}}",
        f"fidelity={fidelity}",
        YIELDS % 1e8,
    ]
    found = []

    class Both:
        def record(self, model, state, report):
            (group,), (own,) = model.groups, state.bodies
            means = group.stress(own).gauss[..., 0].reshape(len(group.names), -1).mean(axis=1)
            found.append(dict(zip(group.names, -means / HELD, strict=True)))

    run(loads(BAR + PAIR, told), tmp_path, observers=(Both(),))
    expected = [{"one": share} for share in (0.25, 0.5, 0.75, 1.0)]
    expected += [{"one": 1.0, "two": share} for share in (0.25, 0.5, 0.75, 1.0)]
    assert found == [pytest.approx(one, rel=1e-9) for one in expected]


def test_a_run_that_was_cut_while_stones_cooled_is_a_start_as_it_is(tmp_path, monkeypatch):
    run(warm(), tmp_path / "first")
    cut(
        warm(start="first", heated=False), tmp_path / "second", 3, monkeypatch, tmp_path
    )  # two steps are kept
    watch = Stresses()
    solve_scene(warm(start="second", heated=False), tmp_path, (watch,))
    np.testing.assert_allclose(watch.means, -HELD / 2 * np.array([0.75, 0.5, 0.25, 0.0]), atol=1e-9 * HELD)


@pytest.mark.parametrize("fidelity", ["elastic", "inelastic"])
def test_a_history_that_is_cut_goes_on_with_the_same_bits(fidelity, tmp_path, monkeypatch):
    scene = loads(BAR + HISTORY, [f"fidelity={fidelity}", YIELDS % (CRUSHED / 2)])
    whole = run(scene, tmp_path / "whole")
    cut(scene, tmp_path / "cut", 3, monkeypatch)
    result = resume(tmp_path / "cut")
    assert bits(result) == bits(whole)
    assert files(tmp_path / "cut") == files(tmp_path / "whole")
    run(warm(), tmp_path / "first")
    cut(warm(start="first", heated=False), tmp_path / "second", 3, monkeypatch, tmp_path)
    again = resume(tmp_path / "second")
    assert np.abs(stresses(again.march.model, again.march.state)).max() <= 1e-9 * HELD


def test_a_march_of_another_length_would_cool_otherwise(tmp_path):
    run(warm(), tmp_path / "first")
    run(warm(KINDS["dynamics"], heated=False), tmp_path / "second", base=tmp_path)
    with pytest.raises(CheckpointError, match=r"temperatures without a time function go on until t = 0\.005"):
        resume(tmp_path / "second", ("analysis.duration=0.01",))
