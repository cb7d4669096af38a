"""Cohesion across a gap that is open at the start: springs are pressed until the faces touch."""

import numpy as np
import pytest

import masonry_fem
from masonry_fem.scene import loads

STIFFNESS, WEIGHT = 1e11, 0.5 * 2000.0 * 9.81  # of the joint [N/m³]; of the upper block [N/m]

SCENE = """
dimension = 2
fidelity = "{fidelity}"
materials.stone = {{ density = 2000.0, young = 7e8 }}
mesh = {{ divisions = [1, 1] }}
structures = [{{ kind = "stack", name = "w", material = "stone", size = [1.0, 0.5], count = 2, gap = {gap} }}]
contact = {{ reach = 1e-3 }}
loads = {{ gravity = [0.0, -9.81] }}
analysis = {{ kind = "statics", load_steps = {steps} }}

[[joints]]
friction = 0.9

[joints.law]
kind = "bilinear"
normal_stiffness = 1e11
tangential_stiffness = 1e11
normal_strength = 1e7
tangential_strength = 1e7
normal_energy = 1e4
tangential_energy = 1e4
"""


def settled(gap: float, steps: int, fidelity: str = "elastic") -> tuple[np.ndarray, float]:
    """Jumps of the joint between the blocks [m], and energy that is missing at the end over the work done."""
    scene = loads(SCENE.format(gap=gap, steps=steps, fidelity=fidelity))
    *_, (model, state, report) = masonry_fem.steps(scene)
    joint = model.contacts.blocks.max(axis=1) == 2
    return state.jump[joint, 0], report.energy_error


@pytest.mark.parametrize("fidelity", ["elastic", "rigid"])
@pytest.mark.parametrize("steps", [1, 4, 20])
def test_springs_keep_their_compression(steps, fidelity):
    jump, missing = settled(1e-5, steps, fidelity)
    assert jump == pytest.approx(np.full(2, -WEIGHT / STIFFNESS), rel=1e-9)
    assert missing < 1e-9


@pytest.mark.parametrize("steps", [1, 4])
def test_faces_that_come_to_touch_bear_the_rest(steps):
    jump, _ = settled(5e-8, steps)
    assert jump == pytest.approx(np.full(2, -5e-8), rel=1e-6)
