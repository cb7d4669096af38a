"""Materials that change from stage to stage do so evenly over the steps, in statics and in time."""

import csv

import numpy as np
import pytest

import masonry_fem
from masonry_fem.build.ageing import between
from masonry_fem.errors import MasonryError
from masonry_fem.scene import loads, specs

STACK = """
dimension = 2
plane = "stress"
fidelity = "{fidelity}"
mesh = {{ divisions = [1, 1] }}
contact.update = "fixed"
materials.stone = {{ density = 2000.0, young = 1e9, poisson = 0.0, inelastic = {law} }}
materials.good = {{ density = 2000.0, young = 1e9, poisson = 0.0, inelastic = {law} }}
structures = [
  {{ kind = "stack", name = "stack", material = "stone", size = [1.0, 1.0], count = 2 }},
]
overrides = [{{ blocks = "stack.b1", material = "good" }}]
joints = [{{ friction = 0.0 }}]
loads.points = [{{ block = "stack.b2", vector = [0.0, -1e5], point = [0.5, 2.0] }}]
probes = [
  {{ name = "top", block = "stack.b2", point = [0.5, 1.5] }},
  {{ name = "joint", block = "stack.b1", point = [0.5, 0.5] }},
]
output = {{ pictures = false, fields = false }}

[[stages]]
name = "built"
analysis = {{ kind = "statics", load_steps = 1 }}

[[stages]]
name = "decayed"
analysis = {{ kind = "statics", load_steps = {steps} }}
materials.stone = {{ density = 2000.0, young = {young}, poisson = 0.0, inelastic = {weak} }}
"""
LAW = '{ law = "mohr_coulomb", cohesion = 1e5, friction_angle = 30.0 }'


def rows(path):
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def test_a_modulus_goes_evenly(tmp_path):
    scene = STACK.format(fidelity="elastic", law=LAW, steps=5, young=2e8, weak=LAW)
    made = masonry_fem.run(loads(scene), tmp_path)
    assert made.outcome == "equilibrium"
    history = rows(tmp_path / "decayed" / "history.csv")
    # the mean displacement of the block's middle is that of its own half, -σ h/2E, below it nothing changes
    below = float(history[-1]["probes.joint_y"])
    for row in history:
        young = 1e9 - float(row["time"]) * 8e8
        own = float(row["probes.top_y"]) - 2 * below
        assert own == pytest.approx(-1e5 * 0.5 / young, rel=1e-9)
        assert float(row["probes.joint_y"]) == pytest.approx(-1e5 * 0.5 / 1e9, rel=1e-9)
        assert abs(float(row["energy_error"])) < 1e-11 * float(row["strain_energy"])


def test_a_strength_that_decays_is_passed_at_its_step(tmp_path):
    # f_c = 2 c cos φ / (1 − sin φ); σ = 1e5 is reached by c = 28868 Pa, between steps 7 and 8 of 10
    weak = LAW.replace("1e5", "5e3")
    scene = STACK.format(fidelity="inelastic", law=LAW, steps=10, young=1e9, weak=weak)
    made = masonry_fem.run(loads(scene), tmp_path)
    assert made.outcome != "equilibrium"
    assert "load factor" in made.message
    reached = made.march.state.time
    cohesion = 1e5 - 0.95e5 * reached
    strength = 2 * cohesion * np.cos(np.pi / 6) / (1 - np.sin(np.pi / 6))
    assert strength > 1e5 * (1 - 1e-6)
    assert cohesion < 1e5 / (2 * np.sqrt(3)) * 1.2, "not far before it"


def test_two_materials_that_become_one(tmp_path):
    same = (
        STACK.replace("young = {young}", "young = 1e9").replace(
            "materials.good = {{ density = 2000.0, young = 1e9",
            "materials.good = {{ density = 2000.0, young = 5e8",
        )
        + "materials.good = {{ density = 2000.0, young = 1e9, poisson = 0.0, inelastic = {law} }}\n"
    )
    made = masonry_fem.run(loads(same.format(fidelity="elastic", law=LAW, steps=2, weak=LAW)), tmp_path)
    ends = [float(row["probes.joint_y"]) for row in rows(tmp_path / "decayed" / "history.csv")]
    assert made.outcome == "equilibrium"
    assert ends == pytest.approx([-0.5e5 / 7.5e8, -0.5e5 / 1e9], rel=1e-9)


def test_another_kind_of_law_begins_anew_where_none_has_yielded(tmp_path):
    brittle = '{ law = "brittle_damage", tensile_strength = 1e5, fracture_energy = 100.0 }'
    scene = STACK.format(fidelity="inelastic", law=LAW, steps=2, young=1e9, weak=brittle)
    made = masonry_fem.run(loads(scene), tmp_path / "one")
    assert made.outcome == "equilibrium"
    assert {group.material_name for group in made.march.model.groups if group.deforms} == {
        "mohr_coulomb", "brittle_damage",
    }  # fmt: skip
    first = made.march.state.bodies[-1].memory.internal.shape[-1]
    assert first == made.march.model.groups[-1].rest().memory.internal.shape[-1]


def test_another_kind_of_law_is_refused_where_one_has_yielded(tmp_path):
    brittle = '{ law = "brittle_damage", tensile_strength = 1e5, fracture_energy = 100.0 }'
    pressed = """
    [[stages.supports]]
    on = "stack.b2/top"
    motion = { displacement = [0.0, -1e-3] }

    """
    scene = STACK.format(fidelity="inelastic", law=LAW, steps=2, young=1e9, weak=brittle).replace(
        '[[stages]]\nname = "decayed"', f'{pressed}[[stages]]\nname = "decayed"'
    )
    with pytest.raises(MasonryError, match="has yielded by the law mohr_coulomb, whose memory is none of"):
        masonry_fem.run(loads(scene), tmp_path)


def test_numbers_of_a_material_go_linearly():
    one = specs.Material(density=2000.0, young=1e9, poisson=0.2, thermal_expansion=1e-5)
    other = specs.Material(density=2000.0, young=2e9, poisson=0.3, thermal_expansion=2e-5, degree=2)
    half = between(one, other, 0.5)
    assert (half.young, half.poisson, half.degree) == (1.5e9, 0.25, 2)
    assert half.thermal_expansion == 2e-5, "strains are what warms stones, and begin as they were"
    assert between(one, other, 1.0) == other


LAYERS = """
dimension = 2
fidelity = "{fidelity}"
mesh = {{ divisions = [2, 2] }}
materials.stone = {{ density = 2000.0, young = 5e7 }}

joints = [{{ {before}friction = 0.825 }}]
loads = {{ gravity = [0.0, -9.81], accelerations = [{{ vector = [0.835, 0.0] }}] }}
output = {{ pictures = false, fields = false, every = 1 }}

[[structures]]
kind = "arch"
name = "w"
material = "stone"
radius = 2.0
thickness = 0.255
voussoirs = 5
straight = true

[[stages]]
name = "built"
analysis = {{ kind = "statics", load_steps = 2 }}

[[stages]]
name = "changed"
analysis = {{ {analysis} }}
{after}
"""
STIFFER = "materials.stone = { density = 2000.0, young = 8e7 }"
SOFTER = "materials.stone = { density = 2000.0, young = 2e7 }"
MORTAR = "mortar = {{ thickness = 0.01, young = {} }}, "
CLOSURE = "closure = {{ normal_stiffness = {}, greatest = 1e-3 }}, "
ANALYSES = {
    "statics": 'kind = "statics", load_steps = 2',
    "dynamics": 'kind = "dynamics", duration = 5e-3, step = 1e-3',
    "equilibrium": 'kind = "equilibrium", strategy = "large_step", step = 5e-3, max_steps = 5',
}

TERMS = ("strain_energy", "joint_energy", "external_work", "kinetic_energy")


def repointed(layer):
    return f"joints = [{{ {layer}friction = 0.825 }}]"


@pytest.mark.parametrize("analysis", ANALYSES)
@pytest.mark.parametrize(
    ("fidelity", "before", "after"),
    [
        ("reduced", "", STIFFER),
        ("reduced", "", SOFTER),
        ("elastic", MORTAR.format("2e7"), repointed(MORTAR.format("4e7"))),
        ("elastic", MORTAR.format("4e7"), repointed(MORTAR.format("2e7"))),
        ("elastic", CLOSURE.format("1e9"), repointed(CLOSURE.format("2e9"))),
        ("rigid", CLOSURE.format("2e9"), repointed(CLOSURE.format("1e9"))),
        ("reduced", CLOSURE.format("1e9"), f"{STIFFER}\n{repointed(CLOSURE.format('2e9'))}"),
    ],
)
def test_layers_that_change_keep_the_energy(tmp_path, fidelity, before, after, analysis):
    scene = LAYERS.format(fidelity=fidelity, before=before, after=after, analysis=ANALYSES[analysis])
    masonry_fem.run(loads(scene), tmp_path)
    history = rows(tmp_path / "changed" / "history.csv")
    assert history
    for row in history:
        largest = max(abs(float(row[name])) for name in TERMS)
        assert abs(float(row["energy_error"])) < 1e-10 * largest
        assert float(row["joint_dissipation"]) >= 0


def test_the_layer_of_a_reduced_stone_follows_its_modulus(tmp_path):
    scene = STACK.replace(", inelastic = {law}", "").replace(", inelastic = {weak}", "")
    scene = scene.replace('overrides = [{{ blocks = "stack.b1", material = "good" }}]', "")
    scene = scene.format(fidelity="reduced", steps=5, young=2e8)
    made = masonry_fem.run(loads(scene), tmp_path)
    assert made.outcome == "equilibrium"
    history = rows(tmp_path / "decayed" / "history.csv")
    # all of it is of one modulus in each step: stones and what their joints give way
    way = [float(row["probes.top_y"]) * (1e9 - float(row["time"]) * 8e8) for row in history]
    assert way == pytest.approx([way[0]] * 5, rel=1e-9)
