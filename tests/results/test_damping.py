"""Damping: a run in time states which acted, a static one has none."""

from __future__ import annotations

from masonry_fem.analyses.run import solve_scene
from masonry_fem.output.report.scene_words import assumptions
from masonry_fem.output.terminal import print_summary
from masonry_fem.records.told import plain
from masonry_fem.scene import loads

SCENE = """
dimension = 2
fidelity = "rigid"
mesh = { divisions = [1, 1] }
overrides = [{ blocks = "top", fidelity = "elastic" }]
materials.hard = { density = 2000.0, damping = { mass = 0.5, stiffness = 1e-3 } }
materials.soft = { density = 2000.0, young = 1e8, damping = { stiffness = 2e-3 } }
materials.unused = { density = 2000.0, damping = { mass = 9.0 } }
joints = [{ friction = 0.5, form = "velocity", restitution = 0.25 }]
loads.gravity = [0.0, -10.0]
[[structures]]
kind = "block"
name = "ground"
material = "unused"
size = [3.0, 0.5]
position = [-1.0, -0.5]
support = true
[[structures]]
kind = "block"
name = "low"
material = "hard"
size = [1.0, 1.0]
[[structures]]
kind = "block"
name = "top"
material = "soft"
size = [1.0, 1.0]
position = [0.0, 1.0]
"""
DYNAMICS = "analysis={kind='dynamics', step=0.002, duration=0.01, theta=0.6}"


def test_a_run_in_time_states_which_damping_acted(capsys):
    """β does nothing in rigid stones; supports have no damping; a law for impacts has its coefficient."""
    summary = solve_scene(loads(SCENE, [DYNAMICS])).summary
    told = summary.damping
    assert (told.theta, told.velocity_factor, told.restitution) == (0.6, 1.0, (0.25, 0.25))
    assert {name: (one.mass, one.stiffness) for name, one in told.rayleigh.items()} == {
        "hard": (0.5, 0.0),
        "soft": (0.0, 2e-3),
    }
    told = plain(summary)
    words = "Rayleigh in hard (α = 0.5 1/s), Kelvin–Voigt in soft (β = 0.002 s) took "
    assert any(one.startswith(f"Damping: {words}") for one in assumptions({}, told))
    print_summary(summary)
    printed = " ".join(capsys.readouterr().out.split())
    assert f"damping {words}" in printed


def test_a_march_to_rest_states_by_what_velocities_are_multiplied():
    rest = "analysis={kind='equilibrium', strategy='linear_damping', step=0.01, max_steps=2}"
    told = solve_scene(loads(SCENE, [rest])).summary.damping
    assert (told.theta, told.velocity_factor) == (1.0, 0.9)


def test_statics_has_no_rates_to_damp():
    assert solve_scene(loads(SCENE, ["joints.0={friction=0.5}"])).summary.damping is None
