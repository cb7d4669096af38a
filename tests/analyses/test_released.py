"""Supports that come and go from stage to stage: what they gave goes evenly, and motions go on."""

from __future__ import annotations

import csv

import numpy as np
import pytest

from masonry_fem.analyses.run import run
from masonry_fem.analyses.run.resume import resume
from masonry_fem.errors import MasonryError
from masonry_fem.scene import loads
from tests.analyses.test_resume import bits, cut, files

YOUNG, WEIGHT, LENGTH, DEEP = 1e9, 2000.0 * 9.81 * 0.25, 4.0, 0.25
BEAM = f"""
dimension = 2
plane = "stress"
fidelity = "elastic"
mesh = {{ element = "Q2", divisions = [16, 2] }}
loads.gravity = [0.0, -9.81]
materials.stone = {{ density = 2000.0, young = {YOUNG}, poisson = 0.0 }}
structures = [{{ kind = "block", name = "beam", material = "stone", size = [{LENGTH}, {DEEP}] }}]
probes = [{{ name = "tip", block = "beam", point = [{LENGTH}, {DEEP / 2}] }}]
analysis = {{ kind = "statics", load_steps = 5 }}
output = {{ pictures = false, fields = false, checkpoint_steps = 2 }}
supports = [{{ on = "beam/left" }}, {{ on = "beam/right" }}]

[[stages]]
name = "built"

[[stages]]
name = "struck"
supports = [{{ on = "beam/left" }}]

[[stages]]
name = "propped"
supports = [{{ on = "beam/left" }}, {{ on = "beam/right" }}]

[[stages]]
name = "lifted"
supports = [{{ on = "beam/left" }}, {{ on = "beam/right", motion = {{ displacement = [0.0, 0.01] }} }}]

[[stages]]
name = "again"
"""
STACK = """
dimension = 2
fidelity = "{fidelity}"
mesh = {{ element = "Q2", divisions = [2, 4] }}
loads.gravity = [0.0, -9.81]
materials.stone = {{ density = 2000.0, young = 1e9, poisson = 0.2, inelastic = {{ \
law = "mohr_coulomb", cohesion = 1e7, friction_angle = 30 }} }}
structures = [{{ kind = "stack", name = "pier", material = "stone", size = [1.0, 1.0], count = 2 }}]
probes = [{{ name = "top", block = "pier.b2", point = [1.0, 2.0] }}]
joints = [{{ friction = {friction} }}]
analysis = {{ kind = "statics", load_steps = 4 }}
output = {{ pictures = false, fields = false }}
supports = [{{ on = "{held}" }}]

[[stages]]
name = "held"

[[stages]]
name = "free"
supports = []
"""


def column(folder, key):
    with (folder / "history.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    return np.array([float(row[key] or "nan") for row in rows])


def test_the_prop_of_a_cantilever_goes_evenly_and_comes_back_without_force(tmp_path):
    """Its tip sinks by equal parts of w L⁴/8EI and of shear, the wall takes over what the prop gave."""
    assert run(loads(BEAM), tmp_path).outcome == "equilibrium"
    whole, parts = WEIGHT * LENGTH, np.arange(1, 6) / 5
    sunk = WEIGHT * LENGTH**4 / (8 * YOUNG * DEEP**3 / 12) + WEIGHT * LENGTH**2 / (5 / 6 * YOUNG * DEEP)
    tip, prop = column(tmp_path, "probes.tip_y"), column(tmp_path, "support_resultants.beam/right_fy")
    wall = column(tmp_path, "support_resultants.beam/left_fy")
    np.testing.assert_allclose(wall[5:10], 0.5 * whole * (1 + parts), rtol=1e-9)
    np.testing.assert_allclose(tip[5:10], parts * tip[9], rtol=1e-9)
    assert -tip[9] == pytest.approx(sunk, rel=1e-3)
    # set under it where it is, the prop bears nothing, and then what lifts a clamped end: 12 EI/L³ and shear
    np.testing.assert_allclose(tip[10:15], tip[9], rtol=1e-9)
    np.testing.assert_allclose(prop[10:15], 0.0, atol=1e-9 * whole)
    bent = LENGTH**3 / (YOUNG * DEEP**3) + 2 * LENGTH / (5 / 6 * YOUNG * DEEP)
    np.testing.assert_allclose(prop[15:20], parts * prop[19], rtol=1e-6)
    assert prop[19] == pytest.approx(0.01 / bent, rel=1e-3)
    # the same motion once more goes on from where the first has ended
    np.testing.assert_allclose(tip[20:25], tip[19] + 0.01 * parts, rtol=1e-9)
    np.testing.assert_allclose(prop[20:25], prop[19] * (1 + parts), rtol=1e-6)


def test_a_history_in_which_faces_move_goes_on_with_the_same_bits(tmp_path, monkeypatch):
    scene = loads(BEAM)
    whole = run(scene, tmp_path / "whole")
    cut(scene, tmp_path / "cut", 3, monkeypatch)
    again = resume(tmp_path / "cut")
    assert bits(again) == bits(whole)
    assert files(tmp_path / "cut") == files(tmp_path / "whole")


@pytest.mark.parametrize(
    ("fidelity", "held", "friction"),
    [
        ("rigid", "pier.b2", 0.0),
        ("elastic", "pier.b2", 0.0),
        ("elastic", "pier.b2/left", 5.0),
        ("inelastic", "pier.b2/left", 5.0),
    ],
)
def test_a_stone_that_is_let_go_comes_onto_what_is_below_it_evenly(fidelity, held, friction, tmp_path):
    """Held as a whole or by a face, and then by nothing: it ends as one that never was held."""
    scene = STACK.format(fidelity=fidelity, friction=friction, held=held)
    made = run(loads(scene), tmp_path)
    assert [stage.outcome for stage in made.summary.stages] == ["equilibrium"] * 2
    ground, whole = column(tmp_path, "support_resultants.pier.ground_fy"), 2 * 2000.0 * 9.81
    assert ground[3] < 0.8 * whole
    shares = np.arange(1, 5) / 4
    np.testing.assert_allclose(ground[4:], ground[3] + (whole - ground[3]) * shares, rtol=1e-9)
    never = run(loads(scene, ["stages=[]", "supports=[]"]), tmp_path / "never")
    top, own = (one.march.report.probes["top"] for one in (made, never))
    # joints that opened while a face was held have stuck elsewhere: sideways that stays
    assert top[1] == pytest.approx(own[1], rel=1e-3, abs=1e-12)
    told = [one.sentence for one in made.summary.remarks]
    assert any("'pier.b2' was a support and is none now" in one for one in told) is ("/" not in held)


@pytest.mark.parametrize(
    ("named", "outcome"), [("pier.*", "equilibrium"), ("pier.[gb][r1]*", "no_equilibrium")]
)
def test_a_rigid_stone_that_was_carried_aside_is_held_where_it_is(named, outcome, tmp_path):
    """One below carries it; as a support it stays under a push that slides it off where it is none."""
    text = STACK.format(fidelity="rigid", friction=0.5, held="pier.b1")
    moves = '[{ on = "pier.ground" }, { on = "pier.b1", motion = { displacement = [0.05, 0.0] } }]'
    holds = f'[{{ on = "{named}" }}]\nloads = {{ gravity = [0.0, -9.81], '
    holds += "accelerations = [{ vector = [9.0, 0.0] }] }"
    text = text.replace('[{ on = "pier.b1" }]', moves).replace("supports = []", f"supports = {holds}")
    made = run(loads(text), tmp_path)
    assert [stage.outcome for stage in made.summary.stages] == ["equilibrium", outcome]
    if outcome == "equilibrium":
        assert column(tmp_path, "probes.top_x")[3:] == pytest.approx(0.05, abs=1e-6)


HELD = """
dimension = 2
fidelity = "elastic"
mesh = {{ divisions = {divisions} }}
materials.stone = {{ density = 2000.0, young = 1e8, poisson = 0.2 }}
structures = [{{ kind = "stack", name = "stack", material = "stone", size = [1.0, 1.0], count = 3 }}]
joints = [{{ friction = 0.5 }}]
loads.gravity = [0.0, -10.0]
probes = [{{ name = "top", block = "stack.b3", point = [0.5, 3.0] }}]
output = {{ pictures = false, fields = false }}

[[stages]]
name = "built"
analysis = {{ kind = "statics", load_steps = 1 }}

[[stages]]
name = "held"
analysis = {{ kind = "statics", load_steps = 2 }}
supports = [{{ on = "{on}" }}]
"""


@pytest.mark.parametrize("divisions", [[2, 2], [1, 1]])  # of the second all nodes are held
def test_a_stone_that_deforms_is_held_where_it_is(divisions, tmp_path):
    made = run(loads(HELD.format(divisions=divisions, on="stack.b2/*")), tmp_path)
    assert made.outcome == "equilibrium"
    with (tmp_path / "history.csv").open(encoding="utf-8", newline="") as file:
        places = [float(row["probes.top_y"]) for row in csv.DictReader(file)]
    assert places == pytest.approx(3 * places[:1], rel=1e-9)
    weight = 2000.0 * 10.0
    assert made.summary.supports["stack.ground"].force == pytest.approx([0.0, 3 * weight], abs=1e-6 * weight)


def test_a_stone_that_deforms_is_no_support_as_a_whole(tmp_path):
    with pytest.raises(MasonryError, match=r"'stack.b2' was elastic, and is a support.* on = 'stack.b2/\*'"):
        run(loads(HELD.format(divisions=[2, 2], on="stack.b2")), tmp_path)
