"""Marches to an equilibrium in which forces balance, but nothing brakes what moves."""

from __future__ import annotations

import pytest

from masonry_fem.analyses.run import solve_scene
from masonry_fem.scene import loads

SCENE = """
dimension = 2
fidelity = "{fidelity}"
mesh = {{ size = 0.25 }}
materials.stone = {{ density = 2400.0, young = 1e9, poisson = 0.2 }}
structures = [{{ kind = "stack", name = "w", material = "stone", size = [0.5, 0.25], count = 2 }}]
joints = [{{ friction = 0.0 }}]
initial = [{{ blocks = "w.*", velocity = [1e-3, 0.0] }}]
loads.gravity = [0.0, -9.81]
analysis = {{ kind = "equilibrium", step = {step}, max_steps = 40, strategy = "{strategy}" }}
output = {{ pictures = false }}
"""
both = pytest.mark.parametrize("fidelity", ["rigid", "elastic"])


def ended(fidelity, strategy, *more, step=0.1):
    return solve_scene(loads(SCENE.format(fidelity=fidelity, strategy=strategy, step=step), more))


@both
@pytest.mark.parametrize("step", [0.01, 1.0])
def test_stones_that_drift_evenly_are_told_so(fidelity, step):
    """No friction stops them, and more steps would not either; forces balance however far they go."""
    made = ended(fidelity, "numerical_viscosity", step=step)
    assert made.outcome == "no_convergence"
    assert made.march.report.static_balance < 1e-6
    assert made.march.report.speed == pytest.approx(1e-3, rel=1e-6)
    assert "drift on evenly, at up to 1.0e-03 m/s" in made.message
    assert "More steps do not help" in made.message


@both
@pytest.mark.parametrize(
    ("strategy", "more"),
    [
        ("brutal_damping", ()),
        ("large_step", ()),
        ("numerical_viscosity", ("materials.stone.damping={ mass = 9.0 }",)),
    ],
)
def test_what_the_sentence_proposes_brings_them_to_rest(fidelity, strategy, more):
    assert ended(fidelity, strategy, *more).outcome == "equilibrium"


@both
def test_what_linear_damping_has_not_stopped_yet_may_still_rest(fidelity):
    made = ended(fidelity, "linear_damping")
    assert made.outcome == "no_convergence"
    assert "Allow more steps" in made.message
    assert ended(fidelity, "linear_damping", "analysis.max_steps=200").outcome == "equilibrium"


@both
def test_stones_that_gather_speed_are_no_drift(fidelity):
    made = ended(fidelity, "numerical_viscosity", "loads.accelerations=[{ vector = [0.01, 0.0] }]")
    assert made.outcome == "no_equilibrium"
    assert "slide" in made.message
