"""Loads that move: against separate runs at each place, closed forms, and limit analysis."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest

from masonry_fem.analyses.limit import analyse
from masonry_fem.analyses.run import run, solve_scene
from masonry_fem.analyses.run.resume import resume
from masonry_fem.errors import SceneError
from masonry_fem.scene import loads
from tests.analyses.test_resume import bits, cut, files

BEAM = """
dimension = 2
fidelity = "{fidelity}"
materials.stone = {{ density = 2000.0, young = 1e9, poisson = 0.2, compressive_strength = 5e6{law} }}
mesh = {{ element = "Q2", divisions = [8, 2] }}
structures = [
  {{ kind = "block", name = "left", material = "stone", size = [0.4, 0.4], position = [-0.4, -0.4] }},
  {{ kind = "block", name = "right", material = "stone", size = [0.4, 0.4], position = [2.0, -0.4] }},
  {{ kind = "block", name = "lintel", material = "stone", size = [2.4, 0.4], position = [-0.2, 0.0] }},
]
overrides = [{{ blocks = "[lr][ei][fg]*", fidelity = "rigid" }}]
supports = [{{ on = "left" }}, {{ on = "right" }}]
joints = [{{ friction = 0.6 }}]
contact.update = "fixed"
loads.gravity = [0.0, -10.0]
loads.moving = [
  {{ on = "lintel/top", path = [[-0.1, 0.4], [2.1, 0.4]], vector = [0.0, -900.0], spread = 0.1 }},
]
analysis = {{ kind = "crossing", places = 12 }}
output = {{ pictures = false, fields = false, checkpoint_steps = 1 }}
"""
LAW = ', inelastic = { law = "mohr_coulomb", cohesion = 1e5, friction_angle = "30 deg" }'
ARCH = """
dimension = 2
fidelity = "{fidelity}"
materials.stone = {{ density = 2000.0, young = 1e9, poisson = 0.2 }}
mesh = {{ element = "Q2", divisions = [2, 2] }}
structures = [
  {{ kind = "arch", name = "arch", material = "stone", radius = 2.0, thickness = {thickness}, \
voussoirs = 13 }},
]
joints = [{{ friction = 0.7 }}]
contact.update = "fixed"
loads.gravity = [0.0, -10.0]
loads.moving = [
  {{ on = "arch.v*/extrados", path = [[-1.4, 2.3], [1.4, 2.3]], vector = [0.0, {weight}], spread = 0.1 }},
]
analysis = {{ kind = "crossing", places = 9 }}
output = {{ pictures = false, fields = false }}
"""


PILE = """
dimension = 2
fidelity = "{fidelity}"
materials.stone = {{ density = 2000.0, young = 1e9, poisson = 0.2, compressive_strength = 5e6{law} }}
mesh = {{ element = "Q2", divisions = [4, 2] }}
structures = [
  {{ kind = "stack", name = "pile", material = "stone", size = [2.0, 0.5], count = 3 }},
]
joints = [{{ friction = 2.0 }}]
probes = [{{ name = "top", block = "pile.b3", point = [0.0, 1.5] }}]
loads.gravity = [0.0, -10.0]
loads.moving = [
  {{ on = "pile.b3/top", path = [[0.3, 1.5], [1.6, 1.5]], vector = [50.0, -900.0], spread = 0.2, \
axles = [0.0, 0.4] }},
]
analysis = {{ kind = "crossing", places = 7 }}
output = {{ pictures = false, fields = false }}
"""


def rows(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def beam(fidelity: str, *overrides: str):
    law = "" if fidelity != "inelastic" else LAW
    return loads(BEAM.format(fidelity=fidelity, law=law), overrides)


@pytest.mark.parametrize("fidelity", ["rigid", "elastic", "inelastic"])
def test_supports_of_a_lintel_balance_the_axle_wherever_it_is(fidelity, tmp_path):
    run(beam(fidelity), tmp_path)
    table = rows(tmp_path / "places.csv")
    assert [float(row["place [m]"]) for row in table] == pytest.approx(np.linspace(0.0, 2.2, 12))
    assert [row["stands"] for row in table] == ["yes"] * 12
    weight, push = 2000.0 * 10.0 * 2.4 * 0.4, 900.0
    for row in table:
        up, turn = (
            sum(float(row[f"{side} {name}"]) for side in ("left", "right"))
            for name in ("force_y [N/m]", "moment [N]")
        )
        assert up == pytest.approx(weight + push, rel=1e-9)
        assert turn == pytest.approx(weight + push * float(row["x [m]"]), rel=1e-7)


@pytest.mark.parametrize("fidelity", ["rigid", "elastic", "inelastic"])
def test_each_place_is_that_of_a_separate_run(fidelity, tmp_path):
    """Joints that neither open nor slide remember nothing."""
    scene = PILE.format(fidelity=fidelity, law=LAW if fidelity == "inelastic" else "")
    run(loads(scene), tmp_path)
    history, table = rows(tmp_path / "history.csv"), rows(tmp_path / "places.csv")
    for line, row in list(zip(history, table, strict=True))[::3]:
        begin = f"loads.moving.0.begin={row['place [m]']}"
        run(loads(scene, [begin, "analysis={kind='statics'}"]), tmp_path / "alone")
        (alone,), (told,) = (rows(tmp_path / "alone" / name) for name in ("history.csv", "places.csv"))
        for key in ("probes.top_x", "probes.top_y", "support_resultants.pile.ground_mz"):
            assert float(line[key]) == pytest.approx(float(alone[key]), rel=1e-9, abs=1e-15)
        for key in ("mean_sigma_3 [Pa]", "utilisation [-]", "bed edge_share [-]"):
            assert float(row[key]) == pytest.approx(float(told[key]), rel=1e-7)


def test_the_envelope_has_the_extremes_of_the_places_and_where_they_are(tmp_path):
    run(beam("elastic"), tmp_path)
    table = rows(tmp_path / "places.csv")
    summary = json.loads((tmp_path / "summary.json").read_text(encoding="utf-8"))["places"]
    for row in rows(tmp_path / "envelope.csv"):
        if row["of"] == "support":
            end, _, quantity = row["quantity"].partition("_")
            every = [float(line[f"{row['name']} {quantity}"]) for line in table]
            most = min(every) if end == "least" else max(every)
            assert float(row["value"]) == most
            assert float(row["place [m]"]) == pytest.approx(float(table[every.index(most)]["place [m]"]))
    used = [float(line["utilisation [-]"]) for line in table]
    assert summary["count"] == 12
    assert summary["utilisation"]["value"] == max(used)
    assert summary["utilisation"]["of"] == "lintel"


def test_an_arch_stands_at_the_places_at_which_limit_analysis_says_so(tmp_path):
    scene = ARCH.format(fidelity="rigid", thickness=0.25, weight=-6000.0)
    made = run(loads(scene), tmp_path)
    table = rows(tmp_path / "places.csv")
    stands = [row["stands"] == "yes" for row in table]
    assert made.outcome == "no_equilibrium"
    assert any(stands)
    assert stands == [True] * (len(table) - 1) + [False]
    assert made.summary.places.fell_at == pytest.approx(float(table[-1]["place [m]"]))
    for row, stood in zip(table, stands, strict=True):
        found = analyse(loads(scene, [f"loads.moving.0.begin={row['place [m]']}"]))
        assert (found.multiplier is not None and found.multiplier >= 1) == stood


def test_a_wheel_in_time_is_where_its_speed_takes_it(tmp_path):
    """A rigid lintel on its piers gives back at each instant what the axle gives."""
    settings = [
        "analysis={kind='dynamics', step=0.01, duration=0.4, theta=1.0}",
        "loads.moving.0.speed=5.0",
        "loads.moving.0.begin=0.1",
    ]
    run(beam("rigid", *settings), tmp_path)
    history = rows(tmp_path / "history.csv")
    for line, row in zip(history, rows(tmp_path / "places.csv"), strict=True):
        place = 0.1 + 5.0 * float(line["time"])
        assert float(row["place [m]"]) == pytest.approx(place, rel=1e-12)
        weight, push = 2000.0 * 10.0 * 2.4 * 0.4, 900.0
        assert float(line["applied_mz"]) == pytest.approx(-weight - push * (place - 0.1), rel=1e-12)


def test_a_crossing_that_is_cut_goes_on_with_the_same_bits(tmp_path, monkeypatch):
    whole = run(beam("elastic"), tmp_path / "whole")
    cut(beam("elastic"), tmp_path / "parts", 5, monkeypatch)
    assert bits(resume(tmp_path / "parts")) == bits(whole)
    assert files(tmp_path / "parts") == files(tmp_path / "whole")


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        (["loads.moving=[]"], r"analysis.kind is 'crossing', expected 'statics' where no load moves"),
        (
            ["loads.moving.0.vector=[5.0, 0.0]"],
            r"moving.0.vector is \[5.0, 0.0\], expected a force that is not",
        ),
        (
            ["loads.moving.0.vector=[0.0, 0.0]"],
            r"moving.0.vector is \[0.0, 0.0\], expected a force that is not",
        ),
        (["loads.moving.0.path=[[0.0, 0.4]]"], r"moving.0.path is \[\[0.0, 0.4\]\], expected a list"),
        (["loads.moving.0.path=[[0.0, 0.4], [0.0, 0.4]]"], r"moving.0.path.1 is .* another point"),
        (["loads.moving.0.path=[[7.0, 0.4], [9.0, 0.4]]"], r"moving.0.path goes over none of the faces"),
        (["loads.moving.0.width=0.3"], r"moving.0.width is 0.3, expected none in 2D"),
        (["loads.moving.0.on='lintel/up'"], r"moving.0.on = 'up' .*lintel"),
        (["loads.moving.0.on='left/top'"], r"'left' is a support"),
    ],
)
def test_what_is_refused(settings, words):
    with pytest.raises(SceneError, match=words):
        solve_scene(beam("rigid", *settings))
