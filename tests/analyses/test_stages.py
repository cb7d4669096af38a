"""Stages: histories of structures, stage after stage."""

from __future__ import annotations

import csv
import json

import numpy as np
import pytest

from masonry_fem.analyses.collapse import collapse
from masonry_fem.analyses.inspect import check_scene
from masonry_fem.analyses.limit import analyse
from masonry_fem.analyses.run import run, solve_scene
from masonry_fem.analyses.run.resume import resume
from masonry_fem.errors import MasonryError
from masonry_fem.output.history import History
from masonry_fem.output.report.stages import stages
from masonry_fem.scene import loads
from tests.analyses.test_resume import bits, files

COURSES = """
dimension = 2
fidelity = "elastic"
mesh = {{ element = "Q1", size = 0.25 }}
loads.gravity = [0.0, -10.0]
materials.stone = {{ density = 2000.0, young = 1e9, poisson = 0.2 }}
structures = [
  {{ kind = "wall", name = "wall", material = "stone", brick = [0.5, 0.25], columns = 3, courses = 4 }},
]
joints = [{{ friction = 0.6 }}]
output = {{ pictures = false }}
{stages}
"""
BUILT = "\n".join(
    f'[[stages]]\nname = "course{k}"\nwithout = [{", ".join(repr(f"wall.c{j}") for j in range(k + 1, 5))}]'
    for k in range(1, 5)
)


def rows(path):
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def course_stress(made):
    """Mean σ_yy of each course by its number, from equal elements [Pa]."""
    found = {}
    for group, own in zip(made.march.model.groups, made.march.state.bodies, strict=True):
        if group.deforms:
            for name, values in zip(group.names, group.stress(own).gauss, strict=True):
                found.setdefault(name.split(".")[1], []).append(values.reshape(-1, 6)[:, 1])
    return {course: float(np.concatenate(values).mean()) for course, values in found.items()}


def test_a_wall_built_in_courses_bears_the_weight(tmp_path):
    stiff = ["materials.stone.young=1e11"]  # strains of 1e-5 turn stresses by some 1e-8 of themselves
    made = run(loads(COURSES.format(stages=BUILT), stiff), tmp_path)
    assert made.outcome == "equilibrium"
    weight = 2000.0 * 10.0 * 0.5 * 0.25 * 3
    for number, stage in enumerate(made.summary.stages, 1):
        told = json.loads((tmp_path / stage.name / "summary.json").read_text(encoding="utf-8"))
        force = told["supports"]["wall.ground"]["force"]
        assert force == pytest.approx([0.0, number * weight], rel=1e-9, abs=1e-9 * weight)
    at_once = run(loads(COURSES.format(stages=""), stiff), tmp_path / "at once")
    ups = [one.summary.supports["wall.ground"] for one in (made, at_once)]
    assert ups[0].force == pytest.approx(ups[1].force, rel=1e-9, abs=1e-9 * weight)
    assert ups[0].moment == pytest.approx(ups[1].moment, rel=1e-9)
    for one in (made, at_once):
        # of the courses above and half its own, whatever the order
        above = {f"c{k}": -2000.0 * 10.0 * 0.25 * (4.5 - k) for k in range(1, 5)}
        assert course_stress(one) == pytest.approx(above, rel=1e-9)
    # while friction is not the same: it remembers how stones spread under those that came later
    first, second = (np.sort(one.march.state.reaction[:, 1]) for one in (made, at_once))
    assert np.abs(first - second).max() > 1e-3 * np.abs(second).max()


ARCH = """
dimension = 2
fidelity = "elastic"
mesh = { element = "Q1", divisions = [3, 3] }
loads.gravity = [0.0, -10.0]
materials.stone = { density = 2000.0, young = 1e9, poisson = 0.2 }
supports = [{ on = "centring.*" }]
joints = [{ friction = 0.7 }, { between = ["centring.*", "arch.*"], friction = 0.0 }]
output = { pictures = false, fields = false }

[[structures]]
kind = "arch"
name = "arch"
material = "stone"
radius = 2.0
thickness = 0.4
voussoirs = 9
straight = true
embrace = 150

[[structures]]
kind = "arch"
name = "centring"
material = "stone"
radius = 1.75
thickness = 0.1
voussoirs = 9
straight = true
embrace = 150
springings = false
"""
STRUCK = """
[[stages]]
name = "built"

[[stages]]
name = "struck"
without = ["centring.*"]
analysis = { kind = "statics", load_steps = 5 }
"""
LEFT, RIGHT = "arch.springing_left", "arch.springing_right"


def thrust(made):
    return made.summary.supports[LEFT].force[0]


@pytest.mark.parametrize("fidelity", ["rigid", "elastic"])
def test_struck_centring_leaves_a_thrust_that_limit_analysis_allows(fidelity, tmp_path):
    own = f"fidelity={fidelity}"
    found = [
        run(loads(ARCH + STRUCK, [own, f"stages.1.analysis.load_steps={n}"]), tmp_path / str(n))
        for n in (5, 20, 80)
    ]
    thrusts = [thrust(made) for made in found]
    assert thrusts == pytest.approx([thrusts[0]] * 3, rel=2e-2)
    alone = ["without=['centring.*']", "output.limit_analysis=true", "fidelity=rigid"]
    told = run(loads(ARCH, alone), tmp_path / "limit").summary.limit_analysis
    least, greatest = told.supports[LEFT]["x"]
    assert least < min(thrusts)
    assert max(thrusts) < greatest
    before = json.loads((tmp_path / "5" / "built" / "summary.json").read_text(encoding="utf-8"))
    assert before["supports"][LEFT]["force"][1] < 0.7 * found[0].summary.supports[LEFT].force[1]


def test_a_push_that_struck_centring_leaves_falls_and_is_told(tmp_path):
    thin = ["structures.0.thickness=0.15", "structures.1.radius=1.875", "structures.0.embrace=180"]
    thin += ["structures.1.embrace=180", "fidelity=rigid"]
    made = run(loads(ARCH + STRUCK, thin), tmp_path)
    assert made.outcome == "no_equilibrium"
    assert [stage.outcome for stage in made.summary.stages] == ["equilibrium", "no_equilibrium"]
    assert made.message.startswith("Stage 'struck': No equilibrium")
    assert made.summary.mechanism is not None


def test_histories_and_series_are_those_of_all_stages(tmp_path):
    made = run(loads(ARCH + STRUCK, ["output.fields=true"]), tmp_path)
    names = [row["stage"] for row in rows(tmp_path / "history.csv")]
    assert names == ["built"] + ["struck"] * 5
    series = (tmp_path / "blocks.pvd").read_text(encoding="utf-8")
    assert series.count("<DataSet") == 6
    assert 'timestep="2" part="0" file="struck/fields/blocks_000005.vtu"' in series
    assert (tmp_path / "history.csv") in made.files


@pytest.mark.parametrize(("stage", "step"), [("built", 1), ("struck", 3)])
def test_a_history_that_is_cut_goes_on_with_the_same_bits(stage, step, tmp_path, monkeypatch):
    scene = loads(ARCH + STRUCK, ["output.fields=true", "output.checkpoint_steps=2"])
    whole = run(scene, tmp_path / "whole")
    record = History.record

    def ended(self, model, state, report):
        if report.step == step and self.path.parent.name == stage:
            raise KeyboardInterrupt
        record(self, model, state, report)

    with monkeypatch.context() as patched:
        patched.setattr(History, "record", ended)
        with pytest.raises(KeyboardInterrupt):
            run(scene, tmp_path / "cut")
    told = json.loads((tmp_path / "cut" / "summary.json").read_text(encoding="utf-8"))
    assert told["outcome"] == "interrupted"
    again = resume(tmp_path / "cut")
    assert bits(again) == bits(whole)
    first, second = (files(tmp_path / one) for one in ("whole", "cut"))
    stated = {name for name in first if name.endswith(("summary.json", ".npz"))}
    assert {name: first[name] for name in first.keys() - stated} == {
        name: second[name] for name in second.keys() - stated
    }


def test_a_stage_may_be_the_start_of_several(tmp_path):
    branches = STRUCK + '[[stages]]\nname = "pushed"\nafter = "built"\nloads = {}\nwithout = ["centring.*"]\n'
    made = run(loads(ARCH + branches), tmp_path)
    assert [stage.after for stage in made.summary.stages] == [None, "built", "built"]
    assert made.summary.supports[LEFT].force == pytest.approx([0.0, 0.0], abs=1e-3)


def test_mortar_that_hardens_begins_without_stress(tmp_path):
    law = "{ kind = 'bilinear', normal_stiffness = 1e10, tangential_stiffness = 1e10, normal_strength = 1e5, "
    law += "tangential_strength = 1e5, normal_energy = 10.0, tangential_energy = 20.0 }"
    stages = (
        f"[[stages]]\nname = 'dry'\n[[stages]]\nname = 'hard'\njoints = [{{ friction = 0.7, law = {law} }}]\n"
    )
    made = run(loads(ARCH + stages, ["without=['centring.*']"]), tmp_path)
    dry = json.loads((tmp_path / "dry" / "summary.json").read_text(encoding="utf-8"))
    assert made.outcome == "equilibrium"
    # the same loads, carried on: the bond takes nothing over
    assert thrust(made) == pytest.approx(dry["supports"][LEFT]["force"][0], rel=1e-6)
    assert np.abs(made.march.state.jump).max() < 1e-9


@pytest.mark.parametrize(
    ("extra", "sentence"),
    [
        ("stages.1.name='built'", r"stages\.1\.name.*a name of its own"),
        ("stages.1.after='struck'", r"stages\.1\.after.*none in the first|an earlier stage"),
        ("stages.1.without=['vault.*']", r"stage 'struck': without\.0 = 'vault\.\*' selects no block"),
        ("stages.1.analysis.start='there'", r"stages\.1\.analysis\.start"),
        ("stages.1.joints=[{ friction = -1.0 }]", "friction"),
    ],
)
def test_what_is_wrong_with_stages_is_told(extra, sentence, tmp_path):
    with pytest.raises(MasonryError, match=sentence):
        run(loads(ARCH + STRUCK, [extra]), tmp_path)
    assert not list(tmp_path.iterdir())  # before the first stage takes its time


def test_what_is_wrong_is_told_with_its_stage_and_loads_of_stages_are_loads(tmp_path, caplog):
    """Here the scene itself has no loads, and the material of a load is known once blocks are made."""
    one = """
dimension = 2
fidelity = "rigid"
output.pictures = false

[materials.stone]
density = 2000.0

[[structures]]
kind = "stack"
name = "stack"
material = "stone"
size = [1.0, 1.0]
count = 2

[[joints]]
friction = 0.5

[[stages]]
name = "built"
loads.gravity = [0.0, -9.81]

[[stages]]
name = "warmed"

[[stages.loads.temperatures]]
material = "granite"
change = 5.0
"""
    with pytest.raises(MasonryError, match=r"stage 'warmed': .*'granite' is that of no free block"):
        run(loads(one), tmp_path)
    assert "nothing acts" not in caplog.text


def test_analyses_of_one_structure_refuse_stages(tmp_path):
    with pytest.raises(MasonryError, match="this one has stages"):
        collapse(loads(ARCH + STRUCK), tmp_path)
    with pytest.raises(MasonryError, match="this one has stages"):
        analyse(loads(ARCH + STRUCK))
    with pytest.raises(MasonryError, match="into a folder"):
        solve_scene(loads(ARCH + STRUCK))


def test_stages_are_checked_without_being_run(tmp_path):
    found = check_scene(loads(ARCH + STRUCK), tmp_path)
    assert found.blocks == 20
    assert found.most_steps == 6
    with pytest.raises(MasonryError, match=r"stage 'struck': without\.0 .* selects no block"):
        check_scene(loads(ARCH + STRUCK, ["stages.1.without=['vault.*']"]), tmp_path)


def test_report_of_a_history_tells_of_its_stages(tmp_path):
    import numpy as np

    from masonry_fem.output.report import page

    own = ["fidelity=rigid", "output.report=true", "output.pictures=false"]
    made = run(loads(ARCH + STRUCK, own), tmp_path)
    assert tmp_path / "report.html" in made.files
    told = page._content(tmp_path, tmp_path / "struck", json.loads((tmp_path / "summary.json").read_text()))
    built, struck = told["stages"]
    assert built["changes"] == []
    assert "blocks that are not there: centring.*" in struck["changes"]
    assert struck["after"] == "built"
    assert struck["message"] == made.summary.stages[1].message
    assert len(told["joints"]["rows"]) == made.summary.interfaces  # of the last stage
    np.testing.assert_allclose(page._history(tmp_path / "history.csv")["time"], [1, 1.2, 1.4, 1.6, 1.8, 2])
    text = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert '<section id="stages">' in text
    assert "centring.*" in text[text.index('<section id="stages">') :]


def test_report_of_a_single_analysis_has_no_stages(tmp_path):
    run(loads(ARCH, ["fidelity=rigid", "output.report=true", "output.pictures=false"]), tmp_path)
    assert '<section id="stages">' not in (tmp_path / "report.html").read_text(encoding="utf-8")


def test_a_support_that_a_stage_leaves_out_is_told(tmp_path):
    scene = """
    dimension = 2
    fidelity = "rigid"
    materials = { stone = { density = 2400 } }
    loads = { gravity = [0, -9.81] }
    output = { pictures = false, fields = false }
    structures = [
        { kind = "block", name = "left", material = "stone", size = [1, 1] },
        { kind = "block", name = "right", material = "stone", size = [1, 1], position = [1, 0] },
        { kind = "block", name = "top", material = "stone", size = [2, 1], position = [0, 1] },
    ]
    supports = [{ on = "left" }, { on = "right" }]
    stages = [
        { name = "built" },
        { name = "sunk", supports = [{ on = "right", motion = { displacement = [0, -0.01] } }] },
    ]
    """
    made = run(loads(scene), tmp_path)
    assert made.outcome == "no_equilibrium"
    (told,) = (one for one in made.summary.remarks if one.code == "let_go")
    assert told.sentence.startswith(
        "'left' was a support and is none now; supports of a stage take the place"
    )
    _, sunk = stages(tmp_path, json.loads((tmp_path / "summary.json").read_text(encoding="utf-8"))["stages"])
    # by name: 'right' stands first in the second stage
    assert sunk["changes"] == [
        "supports left on: no longer left",
        "supports right motion.displacement: 0, -0.01",
    ]


@pytest.mark.parametrize(
    ("given", "told"), [("", 0), ('joints = [{}, { between = ["b[1-3]", "b[1-3]"] }],', 1)]
)
def test_a_joint_that_is_gone_with_its_blocks_is_no_slip_of_the_pen(given, told, tmp_path):
    """Blocks in a row, of which the middle one goes: a rule of joints between them has none left."""
    scene = f"""
    dimension = 2
    fidelity = "rigid"
    materials.stone.density = 2400
    loads.gravity = [0, -9.81]
    output = {{ pictures = false, fields = false }}
    structures = [
        {{ kind = "block", name = "base", material = "stone", size = [3, 1], position = [0, -1] }},
        {{ kind = "block", name = "b1", material = "stone", size = [1, 1] }},
        {{ kind = "block", name = "b2", material = "stone", size = [1, 1], position = [1, 0] }},
        {{ kind = "block", name = "b3", material = "stone", size = [1, 1], position = [2, 0] }},
    ]
    joints = [{{ friction = 0.6 }}, {{ between = ["b[1-3]", "b[1-3]"], friction = 0.8 }}]
    supports = [{{ on = "base" }}]
    stages = [{{ name = "built" }}, {{ name = "dug", {given} without = ["b2"] }}]
    """
    made = run(loads(scene), tmp_path)
    assert made.outcome == "equilibrium"
    assert [one.code for one in made.summary.remarks].count("idle_joint") == told


DUG = """
dimension = 2
fidelity = "elastic"
mesh = { element = "Q1", size = 0.25 }
loads.gravity = [0.0, -9.81]
materials.stone = { density = 2000.0, young = 1e9, poisson = 0.2 }
output = { pictures = false, fields = false }
joints = [{ friction = 0.6 }, { between = ["soil*", "soil*"], contact = "none" }]
supports = [{ on = "soil*/bottom" }]
structures = [
  { kind = "block", name = "soil1", material = "stone", size = [1.0, 0.5] },
  { kind = "block", name = "soil2", material = "stone", size = [1.0, 0.5], position = [1.0, 0.0] },
  { kind = "block", name = "soil3", material = "stone", size = [1.0, 0.5], position = [2.0, 0.0] },
  { kind = "block", name = "beam", material = "stone", size = [3.0, 0.5], position = [0.0, 0.5] },
]
stages = [
  { name = "built" },
  { name = "dug", without = ["soil2"], analysis = { kind = "statics", load_steps = 4 } },
  { name = "removed", without = ["soil2", "soil3"], analysis = { kind = "statics", load_steps = 100 } },
]
"""


def test_ground_that_is_dug_out_and_a_pier_that_is_taken_away(tmp_path):
    """Both piers bear the half of the beam each; it falls once too little is left of what the one bore."""
    made = run(loads(DUG), tmp_path)
    assert [stage.outcome for stage in made.summary.stages] == ["equilibrium"] * 2 + ["no_equilibrium"]
    dug = made.summary.stages[1].supports
    for name in ("soil1/bottom", "soil3/bottom"):
        assert dug[name].force[1] == pytest.approx(2000.0 * 9.81 * (0.5 + 0.75), rel=1e-9)
    # about the left pier's edge the rest of the right one's push balances the beam's weight
    pushed, across = 2000.0 * 9.81 * 0.75, dug["soil3/bottom"].force[0]
    at = (dug["soil3/bottom"].moment[0] - 2000.0 * 9.81 * 0.5 * 2.5 + 0.5 * across) / pushed
    falls = 1 - 2000.0 * 9.81 * 1.5 * 0.5 / (pushed * (at - 1.0))
    assert falls < made.march.report.time < falls + 0.01


DECAY = """
dimension = 2
fidelity = "inelastic"
mesh = { element = "Q2", size = 0.25 }
loads.gravity = [0.0, -9.81]
output = { pictures = false, fields = false }
structures = [{ kind = "block", name = "pier", material = "stone", size = [0.5, 2.0] }]
supports = [{ on = "pier/bottom" }]
probes = [{ name = "top", block = "pier", point = [0.25, 2.0] }]

[materials.stone]
density = 2000.0
young = 1e9
poisson = 0.0
inelastic = { law = "mohr_coulomb", cohesion = 1e6, friction_angle = 0 }

[[stages]]
name = "sound"

[[stages]]
name = "soft"
materials.stone = { density = 2000.0, young = 5e8, poisson = 0.0, inelastic = LAW }

[[stages]]
name = "rotten"
materials.stone = { density = 2000.0, young = 5e8, poisson = 0.0, inelastic = WEAK }
"""


def test_stones_decay(tmp_path):
    """With half of its modulus a pier sinks by twice as much; with less strength than its weight it goes."""
    law = '{ law = "mohr_coulomb", cohesion = 1e6, friction_angle = 0 }'
    text = DECAY.replace("LAW", law).replace("WEAK", law.replace("1e6", "1e4"))  # f_c 20 kPa, weight 39 kPa
    made = run(loads(text), tmp_path)
    assert [stage.outcome for stage in made.summary.stages[:2]] == ["equilibrium"] * 2
    assert made.outcome == "no_convergence"
    sunk = [float(row["probes.top_y"]) for row in rows(tmp_path / "history.csv")]
    exact = -2000.0 * 9.81 * 2.0**2 / 2 / 1e9
    assert sunk[:2] == pytest.approx([exact, 2 * exact], rel=1e-4)


REFERENCE = """
dimension = 2
fidelity = "rigid"
materials.stone = { density = 2400.0 }
structures = [
  { kind = "arch", name = "arch", material = "stone", radius = 2.0, thickness = 0.5, voussoirs = 7 },
]
joints = [{ friction = 0.6 }]
loads.gravity = [0.0, -9.81]
output = { pictures = false, limit_analysis = true }
stages = [{ name = "built" }, { name = "old" }]
"""


def test_what_is_of_the_reference_is_told_of_stages_that_begin_there(tmp_path):
    made = run(loads(REFERENCE), tmp_path)
    assert made.outcome == "equilibrium"
    limits = [
        json.loads((tmp_path / stage / "summary.json").read_text(encoding="utf-8")).get("limit_analysis")
        for stage in ("built", "old")
    ]
    assert limits[0]["schema"] == "limit/1"
    assert limits[1] is None
    assert any("ended: 'old'" in one.sentence for one in made.summary.remarks)


def test_a_motion_that_is_made_once_more_is_told(tmp_path):
    """Of stages that say nothing of supports, in the summary above all of them."""
    moved = 'supports = [{ on = "arch.springing_left", motion = { displacement = [0.0, -1e-3] } }]\nstages'
    made = run(loads(REFERENCE.replace(", limit_analysis = true", "").replace("stages", moved)), tmp_path)
    assert [one.code for one in made.summary.remarks] == ["repeated_motion"]
    told = json.loads((tmp_path / "summary.json").read_text(encoding="utf-8"))["remarks"]
    assert "arch.springing_left" in told[0]["sentence"]
