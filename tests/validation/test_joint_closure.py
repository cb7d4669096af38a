"""Stacks of stones whose dry joints close: against the hyperbola, stones and joints in series."""

import numpy as np
import pytest

from masonry_fem.analyses.run import solve_scene
from masonry_fem.errors import LawError
from masonry_fem.joints import fit_closure
from masonry_fem.scene import check, loads

STACK = """
dimension = {dimension}
fidelity = "{fidelity}"
mesh = {{ element = "Q1", divisions = {divisions} }}
materials = {{ stone = {{ young = {young}, poisson = 0.0, density = 2700 }} }}
analysis = {{ kind = "statics", load_steps = 3 }}
loads = {{ tractions = [{{ on = "stack.b{count}/top", vector = {traction}{time} }}] }}
probes = [{{ name = "top", block = "stack.b{count}", point = {point} }}]
[[structures]]
kind = "stack"
name = "stack"
material = "stone"
size = {size}
count = {count}
[[joints]]
friction = 0.6
closure = {{ normal_stiffness = {stiffness}, greatest = {greatest} }}
"""
COUNT, HEIGHT = 8, 0.15
# granite walls with eight joints in 1.2 m: tangent moduli at three pressures, and the stone's own
MEASURED = np.array([0.5e6, 0.875e6, 1.25e6]), np.array([3.3e9, 4.1e9, 4.7e9])
STONE = 20.2e9


def sinking(pressure, joint, fidelity="elastic", dimension=2, time=""):
    """How far the top of the stack goes down [m]."""
    *aside, across = [0.0] * dimension
    text = STACK.format(
        dimension=dimension, fidelity=fidelity, divisions=[2] + [1] * (dimension - 1), young=STONE,
        count=COUNT, traction=[*aside, float(across - pressure)], time=time,
        point=[0.1, *[0.1] * (dimension - 2), COUNT * HEIGHT], size=[0.3, *[0.2] * (dimension - 2), HEIGHT],
        stiffness=joint[0], greatest=joint[1],
    )  # fmt: skip
    result = solve_scene(check(loads(text)))
    assert result.outcome == "equilibrium"
    assert result.summary.certificate.energy_balance < 1e-9
    return -result.summary.probes["top"][-1]


def hyperbola(pressure, joint):
    return COUNT * pressure * joint[1] / (joint[0] * joint[1] + pressure)


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("fidelity", ["rigid", "elastic"])
def test_a_stack_sinks_by_its_joints_and_its_stones(fidelity, dimension):
    joint, pressure = (18e9, 1e-4), 1e6
    stones = 0.0 if fidelity == "rigid" else COUNT * HEIGHT * pressure / STONE
    expected = hyperbola(pressure, joint) + stones
    assert sinking(pressure, joint, fidelity, dimension) == pytest.approx(expected, rel=1e-8)


def test_unloaded_it_stays_closed_by_its_set():
    """Up in the first third, half of it in the next; a thousandth in the last keeps the faces closed."""
    joint, pressure = (18e9, 1e-4), 1e6
    points = [[0.0, 0.0], [1 / 3, 1.0], [2 / 3, 0.5], [1.0, 1e-3]]
    time = f', time = {{ kind = "table", points = {points} }}'
    share = pressure / (joint[0] * joint[1] + pressure)
    left = COUNT * (joint[1] * share**2 + 1e-3 * pressure / joint[0] * (1 - share) ** 2)
    assert sinking(pressure, joint, "rigid", time=time) == pytest.approx(left, rel=1e-8)


def test_a_wall_has_the_moduli_that_its_joints_were_fitted_to():
    joint = fit_closure(*MEASURED, STONE, HEIGHT)
    assert joint[0] == pytest.approx(18e9, rel=0.05)
    for pressure, modulus in zip(*MEASURED, strict=True):
        step = 1e-3 * pressure
        way = sinking(pressure + step, joint) - sinking(pressure - step, joint)
        found = 2 * step * COUNT * HEIGHT / way
        closed = HEIGHT * joint[0] * (1 + pressure / (joint[0] * joint[1])) ** 2
        assert found == pytest.approx(1 / (1 / STONE + 1 / closed), rel=1e-4)
        assert found == pytest.approx(modulus, rel=0.02)


def test_what_cannot_be_fitted_is_told():
    with pytest.raises(
        LawError, match="2 pressures and 2 moduli, expected one modulus for each of two or more"
    ):
        fit_closure([1e6, 1e6], [3e9, 3e9], STONE, HEIGHT)
    with pytest.raises(
        LawError, match=r"modulus is 2.1e\+10 Pa, expected more than 0 and less than the 2.02e\+10"
    ):
        fit_closure([0.5e6, 1e6], [3e9, 21e9], STONE, HEIGHT)
    with pytest.raises(LawError, match="soft at first and stiffen"):
        fit_closure([0.5e6, 1e6], [4e9, 3e9], STONE, HEIGHT)


WALL = """
fidelity = "rigid"
materials = {{ stone = {{ density = 2700 }} }}
analysis = {{ kind = "statics" }}
solver = {{ method = "{method}" }}
[[structures]]
kind = "wall"
name = "wall"
material = "stone"
brick = [0.3, 0.2, 0.2]
columns = 3
courses = 3
[[joints]]
friction = 0.6
{closure}
[loads]
gravity = [0.0, 0.0, -9.81]
points = [{{ block = "wall.c3.b2", point = [0.45, 0.1, 0.6], vector = [300.0, 0.0, -1e4] }}]
"""


@pytest.mark.parametrize("closes", [False, True])
def test_reactions_of_rigid_stones_are_unique_where_joints_close(closes):
    """Rigid joints leave them to the method: two find impulses that differ by a half."""
    closure = "closure = { normal_stiffness = 18e9, greatest = 1e-4 }" if closes else ""
    found = []
    for method in ("auto", "interior_point"):
        result = solve_scene(check(loads(WALL.format(method=method, closure=closure))))
        assert result.outcome == "equilibrium"
        found.append(result.march.state.reaction)
    difference = np.abs(found[1] - found[0]).max() / np.abs(found[0]).max()
    assert (difference < 1e-9) == closes
