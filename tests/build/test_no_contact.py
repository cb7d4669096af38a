"""Joints without contact: blocks that do not touch, chosen by label or by name."""

import msgspec
import numpy as np
import pytest

from masonry_fem.analyses.run import solve_scene
from masonry_fem.build import build
from masonry_fem.scene import check, loads, specs
from masonry_fem.scene.checks import doubts

WALL = """
dimension = 2
fidelity = "{fidelity}"
materials = {{ stone = {{ young = 10e9, poisson = 0.2, density = 2400 }} }}
loads = {{ gravity = [{push}, -9.81] }}
analysis = {{ {analysis} }}
[[structures]]
kind = "wall"
name = "wall"
material = "stone"
brick = [0.4, 0.2]
columns = 3
courses = 3
[[joints]]
friction = 0.6
[[joints]]
interface = "head"
contact = "none"
"""
STATICS = 'kind = "statics"'


def scene(fidelity="rigid", push=0.0, analysis=STATICS):
    return check(loads(WALL.format(fidelity=fidelity, push=push, analysis=analysis)))


def test_open_heads_carry_nothing(tmp_path):
    model = build(scene(), tmp_path).model
    assert {one.label for one in model.interfaces} == {"bed"}


@pytest.mark.parametrize("fidelity", ["rigid", "elastic"])
def test_a_wall_with_open_heads_is_held_by_its_beds(fidelity):
    """A pull of .3 g would also press bricks of a course on each other, and does not here."""
    result = solve_scene(scene(fidelity, push=0.3 * 9.81))
    assert result.outcome == "equilibrium"
    weight = 3 * 3 * 0.4 * 0.2 * 2400 * 9.81
    force = result.summary.supports["wall.ground"].force
    np.testing.assert_allclose(force, [-0.3 * weight, weight], rtol=1e-8)


def test_blocks_that_come_near_later_do_not_touch_either():
    """Contacts found anew, or as blocks meet: the same joints say the same."""
    slides = scene(push=0.8 * 9.81, analysis='kind = "dynamics", step = 0.01, duration = 0.1')
    for update in ("redetect", "moving"):
        contact = specs.Contact(update=update, every=2) if update == "redetect" else specs.Contact()
        result = solve_scene(msgspec.structs.replace(slides, contact=contact))
        labels = {one.label for one in result.march.model.interfaces}
        assert labels == {"bed"}


ON_POST = """
dimension = 2
fidelity = "rigid"
materials = {{ stone = {{ density = 2400 }} }}
loads = {{ gravity = [0.0, -9.81] }}
analysis = {{ kind = "dynamics", step = 0.01, duration = 0.1, theta = 0.5 }}
[[structures]]
kind = "stack"
name = "post"
material = "stone"
size = [0.2, 1.0]
count = 1
[[structures]]
kind = "stack"
name = "block"
material = "stone"
size = [0.2, 0.2]
count = 1
position = [0.0, 1.0]
ground = false
[[joints]]
friction = 0.6
[[joints]]
between = ["block*", "post*"]
contact = "{contact}"
[[probes]]
name = "top"
block = "block*"
point = [0.0, 1.2]
"""


@pytest.mark.parametrize(("contact", "sinks"), [("unilateral", 0.0), ("none", 0.5 * 9.81 * 0.1**2)])
def test_a_block_falls_through_what_it_does_not_touch(contact, sinks):
    result = solve_scene(check(loads(ON_POST.format(contact=contact))))
    assert result.outcome == "finished"
    assert result.summary.probes["top"][1] == pytest.approx(-sinks, abs=1e-9)


def test_what_has_no_effect_is_doubted():
    mortar = specs.Mortar(thickness=0.01, young=1e9)
    joints = (specs.Joint(), specs.Joint(interface="head", contact="none", mortar=mortar))
    told = list(doubts(msgspec.structs.replace(scene(), joints=joints)))
    assert any("joints.1.mortar has no effect where contact = 'none'" in sentence for sentence in told)
