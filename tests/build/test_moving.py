"""Loads that move: what they give to blocks wherever they stand, and which faces take them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from masonry_fem.build import build
from masonry_fem.march.loads import external_forces, resultant
from masonry_fem.scene import loads

ARCH = """
dimension = 2
materials.stone = { density = 2000.0, young = 1e9, poisson = 0.2 }
mesh = { element = "Q2", divisions = [3, 2] }
structures = [
  { kind = "arch", name = "arch", material = "stone", radius = 2.0, thickness = 0.5, voussoirs = 11 },
]
joints = [{ friction = 0.7 }]
"""
WALL = """
dimension = 3
materials.stone = { density = 2000.0, young = 1e9, poisson = 0.2 }
mesh = { element = "Q1", size = 0.25 }
structures = [
  { kind = "wall", name = "wall", material = "stone", brick = [0.5, 0.4, 0.25], columns = 4, courses = 2 },
]
joints = [{ friction = 0.7 }]
"""
ROLLS = """
[[loads.moving]]
on = "arch.v*/extrados"
path = [[-1.8, 2.5], [0.3, 2.9], [1.8, 2.5]]
vector = [150.0, -5000.0]
axles = [0.0, "40 cm"]
spread = "25 cm"
begin = 0.6
"""
WHEEL = """
[[loads.moving]]
on = "wall.*/top"
path = [[0.5, 0.2, 0.5], [1.5, 0.23, 0.5]]
vector = [10.0, -30.0, -5000.0]
spread = 0.2
width = "16 cm"
"""
LAW = 'degree = 2, inelastic = { law = "mohr_coulomb", cohesion = 1e6, friction_angle = "30 deg" }'
CROSSING = "[analysis]\nkind = 'crossing'\nplaces = 9\n"


def cross(one, other):
    """One number in the plane."""
    if len(one) == 2:
        return np.array([one[0] * other[1] - one[1] * other[0]])
    return np.cross(one, other)


def middle_of(travel, place):
    """Middle of the part of the path that an axle is spread over, which may go round a corner."""
    low, high = place - travel.spread / 2, place + travel.spread / 2
    corners = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(travel.path, axis=0), axis=1)))
    ends = np.array([low, *corners[(corners > low) & (corners < high)], high])
    middles = [travel.position(at) for at in (ends[1:] + ends[:-1]) / 2]
    return np.diff(ends) @ np.array(middles) / travel.spread


def given(text):
    """What a load that moves gives in all at each place, and what it is."""
    model = build(loads(text), Path()).model
    (load,) = model.loads
    travel = load.travel
    for time in np.linspace(1.0, 2.0, 41):
        place = travel.place(time)
        points = [middle_of(travel, place - axle) for axle in travel.axles]
        force, turn = travel.force * len(points), sum(cross(point, travel.force) for point in points)
        yield resultant(model, external_forces(model, time)), np.concatenate([force, turn])


@pytest.mark.parametrize("fidelity", ["rigid", "elastic", "reduced", "inelastic"])
@pytest.mark.parametrize("scene", [ARCH + ROLLS, WALL + WHEEL], ids=["arch", "wall"])
def test_force_and_moment_are_those_of_the_load_wherever_it_is(scene, fidelity):
    text = (
        f'fidelity = "{fidelity}"\n' + scene.replace("poisson = 0.2 }", f"poisson = 0.2, {LAW} }}") + CROSSING
    )
    pairs = list(given(text))
    largest = np.abs([wanted for _, wanted in pairs]).max(axis=0)
    for made, wanted in pairs:
        assert np.abs(made - wanted).max() <= 1e-12 * largest.max()


def test_a_point_load_goes_from_stone_to_stone():
    """At the joint of two bricks it stands on one of them, and never on both or none."""
    text = WALL + WHEEL.replace('spread = 0.2\nwidth = "16 cm"', "").replace("wall.*", "wall.c2.*")
    built = build(loads('fidelity = "rigid"\n' + text + CROSSING), Path())
    model, names = built.model, [block.name for block in built.model.assembly.blocks]
    (load,) = model.loads
    seen = []
    for place in np.linspace(0.0, load.travel.place(2.0), 101):
        forces = load.travel.forces(model.groups, place)
        hit = [
            names[group.blocks[body]]
            for group, force in zip(model.groups, forces, strict=True)
            if force is not None
            for body in np.flatnonzero(np.abs(force).max(axis=1))
        ]
        (one,) = hit
        seen.append(one)
    assert [name for name, before in zip(seen, ["", *seen], strict=False) if name != before] == [
        "wall.c2.b2", "wall.c2.b3", "wall.c2.b4"
    ]  # fmt: skip


def test_the_face_that_the_force_meets_first_takes_it():
    """The tops of all courses are named, and only the upper one is loaded."""
    built = build(loads('fidelity = "rigid"\n' + WALL + WHEEL + CROSSING), Path())
    (load,) = built.model.loads
    for time in (1.0, 1.4, 2.0):
        for group, force in zip(built.model.groups, load.pattern(built.model.groups, time), strict=True):
            if force is not None:
                loaded = group.blocks[np.abs(force).max(axis=1) > 0]
                names = [built.model.assembly.blocks[block].name for block in loaded]
                assert all(name.startswith("wall.c2.") for name in names)


def test_what_stands_beside_the_faces_acts_on_nothing():
    text = WALL + WHEEL.replace("[0.5, 0.2, 0.5]", "[0.0, 0.2, 0.5]").replace("0.23", "0.2").replace(
        "wall.*", "wall.c2.*"
    )
    model = build(loads('fidelity = "rigid"\n' + text + CROSSING), Path()).model
    half = resultant(model, external_forces(model, 1.0))
    assert half[:3] == pytest.approx(0.5 * np.array([10.0, -30.0, -5000.0]), rel=1e-12)
    travel = model.loads[0].travel
    assert all(force is None for force in travel.forces(model.groups, -1.0))
