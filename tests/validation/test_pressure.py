"""Pressure that turns with the faces it acts on: closed forms, and tractions where nothing turns."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from msgspec import structs

from masonry_fem.analyses.run import solve_scene
from masonry_fem.build.model import build
from masonry_fem.errors import SceneError
from masonry_fem.scene import loads, specs
from masonry_fem.scene.combinations import combination_scenes

SIDE, THICK, RHO, PRESSURE = 1.0, 0.5, 2000.0, 3000.0
FREE = """
dimension = {d}
fidelity = "{fidelity}"
materials.stone = {{ density = 2000.0, young = {young}, poisson = 0.2 }}
mesh = {{ element = "Q1", divisions = {divisions} }}
structures = [{{ kind = "block", name = "plate", material = "stone", size = {size} }}]
initial = [{{ blocks = "plate", spin = {spin} }}]
loads.pressures = [{{ on = "plate/bottom", pressure = 3000.0 }}]
analysis = {{ kind = "dynamics", step = 1e-3, duration = 0.5, theta = 0.5 }}
output = {{ pictures = false, fields = false }}
"""


def spinning(d: int, fidelity: str):
    size, divisions = ([SIDE, THICK], [2, 1]) if d == 2 else ([SIDE, SIDE, THICK], [2, 2, 1])
    spin = 3.0 if d == 2 else [0.0, 3.0, 0.0]
    text = FREE.format(d=d, fidelity=fidelity, young=1e11, divisions=divisions, size=size, spin=spin)
    return loads(text)


@pytest.mark.parametrize("fidelity", ["rigid", "elastic"])
@pytest.mark.parametrize("d", [2, 3])
def test_a_spinning_plate_is_driven_round(d, fidelity):
    """The push f = p / (ρ t) turns with the plate at ω: its centre moves by f/ω² (1 − cos, ωt − sin)."""
    made = solve_scene(spinning(d, fidelity))
    f, w, t = PRESSURE / (RHO * THICK), 3.0, 0.5
    turn, way = w * t, f / w**2
    sign = -1.0 if d == 2 else 1.0  # about z the plate turns from x to y, about y from z to x
    exact = np.zeros(d)
    exact[0], exact[-1] = sign * way * (turn - math.sin(turn)), way * (1 - math.cos(turn))
    (group,) = made.built.model.groups
    rotation, shift = group.motion(made.march.state.bodies[0])
    middle = 0.5 * np.array([SIDE, THICK] if d == 2 else [SIDE, SIDE, THICK])
    gone = rotation[0] @ middle + shift[0] - middle
    assert gone == pytest.approx(exact, abs=3e-3 * way)
    assert made.outcome == "finished"


GATE = """
dimension = 2
fidelity = "{fidelity}"
materials.stone = {{ density = 2000.0, young = 1e11, poisson = 0.2 }}
mesh = {{ element = "Q1", divisions = [2, 4] }}
structures = [
  {{ kind = "block", name = "ground", material = "stone", size = [3.0, 0.5], position = [-1.5, -0.5] }},
  {{ kind = "block", name = "gate", material = "stone", size = [0.6, 2.0] }},
]
overrides = [{{ blocks = "ground", fidelity = "rigid" }}]
supports = [{{ on = "ground", motion = {{ rotation = -0.2, pivot = [0.0, 0.0] }} }}]
joints = [{{ friction = 0.9 }}]
loads.gravity = [0.0, -10.0]
loads.pressures = [{{ on = "gate/left", pressure = {pressure} }}]
analysis = {{ kind = "statics", load_steps = 4 }}
output = {{ pictures = false, fields = false }}
"""


@pytest.mark.parametrize("fidelity", ["rigid", "elastic"])
def test_a_gate_on_tilting_ground_is_pressed_along_its_own_normal(fidelity):
    """The ground turns by 0.2 rad, and the gate with it: the push on its face has turned by as much."""
    pressure = -1500.0  # it sucks: up the slope, so that the gate stands
    made = solve_scene(loads(GATE.format(fidelity=fidelity, pressure=pressure)))
    assert made.outcome == "equilibrium"
    push = pressure * 2.0 * np.array([math.cos(0.2), -math.sin(0.2)])
    weight = np.array([0.0, -2000.0 * 10.0 * 1.2])
    support = made.summary.supports["ground"]
    assert support.force == pytest.approx(-(push + weight), rel=1e-5 if fidelity == "elastic" else 1e-9)
    assert made.summary.applied == pytest.approx(push + weight, rel=1e-5 if fidelity == "elastic" else 1e-9)
    turn = np.array([[math.cos(0.2), math.sin(0.2)], [-math.sin(0.2), math.cos(0.2)]])
    at, centre = turn @ [0.0, 1.0], turn @ [0.3, 1.0]
    moment = at[0] * push[1] - at[1] * push[0] + centre[0] * weight[1]
    assert support.moment == pytest.approx([-moment], rel=1e-4 if fidelity == "elastic" else 1e-8)


def test_where_nothing_turns_it_is_a_traction():
    fixed = ["contact.update='fixed'", "supports=[{on='ground'}]"]
    pressed = loads(GATE.format(fidelity="elastic", pressure=1500.0), fixed)
    pulled = loads(
        GATE.format(fidelity="elastic", pressure=1500.0),
        [*fixed, "loads.pressures=[]", "loads.tractions=[{on='gate/left', vector=[1500.0, 0.0]}]"],
    )
    one, other = (solve_scene(scene).summary for scene in (pressed, pulled))
    assert one.supports["ground"].force == pytest.approx(other.supports["ground"].force, rel=1e-12)
    assert one.supports["ground"].force == pytest.approx([-3000.0, 24000.0], rel=1e-8)


def test_a_ring_under_pressure_from_outside_is_pressed_evenly():
    """Each springing bears p times the outer radius."""
    text = """
dimension = 2
fidelity = "elastic"
materials.stone = { density = 2000.0, young = 1e9, poisson = 0.0 }
mesh = { element = "Q1", divisions = [2, 2] }
structures = [
  { kind = "arch", name = "arch", material = "stone", radius = 2.0, thickness = 0.4, voussoirs = 12 },
]
joints = [{ friction = 0.7 }]
loads.pressures = [{ on = "arch.v*/extrados", pressure = 1e4 }]
output = { pictures = false, fields = false }
"""
    made = solve_scene(loads(text))
    assert made.outcome == "equilibrium"
    for name in ("arch.springing_left", "arch.springing_right"):
        across, up = made.summary.supports[name].force
        assert up == pytest.approx(1e4 * 2.2, rel=3e-3)
        assert abs(across) < 0.05 * up  # as the ring grows shorter it bends


DAM = """
dimension = {d}
fidelity = "{fidelity}"
materials.stone = {{ density = 2400.0, young = 1e10, poisson = 0.2 }}
mesh = {{ element = "{element}", {mesh} }}
structures = [{{ kind = "stack", name = "dam", material = "stone", size = {size}, count = 3 }}]
joints = [{{ friction = 0.9 }}]
loads.gravity = {gravity}
loads.pressures = [{{ on = "dam.*/left", level = {level}, unit_weight = "9.81 kN/m^3", pressure = {even} }}]
contact = {{ update = "fixed" }}
output = {{ pictures = false, fields = false }}
"""
HEIGHT, WIDTH, DEPTH = 3.0, 2.5, 0.8


def dam(d, fidelity, level, even=0.0, element="Q1", keys=()):
    thickness, lift = WIDTH, HEIGHT / 3
    mesh = "size = 0.7" if element[0] == "P" else f"divisions = {[2, 2, 3] if d == 3 else [2, 3]}"
    return loads(
        DAM.format(
            d=d, fidelity=fidelity, element=element, mesh=mesh,
            size=[thickness, lift] if d == 2 else [thickness, DEPTH, lift],
            gravity=[0.0, -9.81] if d == 2 else [0.0, 0.0, -9.81], level=level, even=even,
        ),
        list(keys),
    )  # fmt: skip


def resultant(scene):
    """Force and moment about the origin of what loads.pressures give."""
    model = build(scene, Path()).model
    load = next(load for load in model.loads if load.name.startswith("loads.pressures"))
    return sum(
        group.resultant(force).sum(axis=0)
        for group, force in zip(model.groups, load.forces, strict=True)
        if force is not None
    )


@pytest.mark.parametrize(
    ("d", "fidelity", "element"),
    [(2, "rigid", "Q1"), (2, "elastic", "Q1"), (2, "elastic", "Q2"), (2, "elastic", "P2"),
     (3, "rigid", "Q1"), (3, "elastic", "Q1"), (3, "elastic", "P1"), (3, "elastic", "Q2"),
     (3, "elastic", "P2")],
)  # fmt: skip
@pytest.mark.parametrize(
    ("level", "even"), [(3.0, 0.0), (1.7, 0.0), (1.7, 5e3), (4.0, -2e4), (2.0, 0.0), (0.0, 1e3)]
)
def test_water_pushes_as_it_does(d, fidelity, element, level, even):
    """On h of depth below a level, wherever that cuts stones and elements: (p + γh/2) h at its own height."""
    found = resultant(dam(d, fidelity, level, even, element))
    wide = 1.0 if d == 2 else DEPTH
    top = min(level, HEIGHT)
    weight, deepest = 9810.0, level - top
    high = even + weight * deepest  # at the top of what is wet
    push = wide * (high * top + weight * top**2 / 2)
    turning = wide * (high * top**2 / 2 + weight * top**3 / 6)
    force = np.zeros(d)
    force[0] = push
    moment = [-turning] if d == 2 else [0.0, turning, -push * DEPTH / 2]
    scale = wide * (abs(even) + weight * 4.0) * HEIGHT
    np.testing.assert_allclose(found, [*force, *moment], atol=1e-12 * scale * HEIGHT, rtol=1e-10)


@pytest.mark.parametrize("d", [2, 3])
def test_water_is_what_many_thin_courses_of_even_pressure_tend_to(d):
    level, courses = 2.35, 60
    one = resultant(dam(d, "rigid", level))
    heights = (np.arange(courses) + 0.5) * HEIGHT / courses
    pressures = 9810.0 * np.maximum(level - heights, 0.0)
    wide = 1.0 if d == 2 else DEPTH
    assert one[0] == pytest.approx(wide * pressures.sum() * HEIGHT / courses, rel=2e-3)


@pytest.mark.parametrize("fidelity", ["rigid", "elastic"])
def test_the_ground_bears_what_water_gives(fidelity):
    made = solve_scene(dam(2, fidelity, 2.5, keys=["contact.update='moving'"]))
    assert made.outcome == "equilibrium"
    support = made.summary.supports["dam.ground"]
    weight = 2400.0 * 9.81 * WIDTH * HEIGHT
    push = 9810.0 * 2.5**2 / 2
    assert support.force == pytest.approx([-push, weight], rel=1e-5 if fidelity == "elastic" else 1e-9)
    moment = weight * WIDTH / 2 + push * 2.5 / 3
    assert support.moment == pytest.approx([moment], rel=1e-4 if fidelity == "elastic" else 1e-8)


def test_combinations_multiply_all_of_a_pressure():
    scene = dam(2, "rigid", 2.0, 3e3, keys=["loads.pressures.0.case='water'"])
    scene = structs.replace(
        scene, combinations=(specs.Combination(name="high", factors={"gravity": 1.0, "water": 1.5}),)
    )
    ((_, combined),) = combination_scenes(scene)
    np.testing.assert_allclose(resultant(combined), 1.5 * resultant(scene), rtol=1e-12)


@pytest.mark.parametrize(
    ("keys", "said"), [("", "pressure"), ("unit_weight = 9810.0", "level"), ("level = 2.0", "pressure")]
)
def test_half_a_pressure_is_refused(keys, said):
    with pytest.raises(SceneError, match=rf"loads\.pressures\.0.*{said}"):
        loads(GATE.format(fidelity="rigid", pressure="1.0").replace("pressure = 1.0", keys or 'case = "a"'))
