"""Marches to an equilibrium in which nothing loads stones but each other: ties, warmth."""

from __future__ import annotations

import pytest

from masonry_fem.analyses.run import solve_scene
from masonry_fem.scene import loads

SCENE = """
dimension = 2
mesh = { size = 0.25 }
materials.stone = { density = 2400.0, young = 1e9, poisson = 0.2, thermal_expansion = 8e-6 }
structures = [{ kind = "stack", name = "w", material = "stone", size = [0.5, 0.25], count = 2 }]
joints = [{ friction = 0.5 }]
output = { pictures = false }
"""
TIED = "ties=[{name='t', points=[{block='w.b1'}, {block='w.b2'}], section=1e-4, young=2e11, pretension=100}]"
WARMED = "loads.temperatures=[{on='w.*', change=20}]"
STRATEGIES = (
    "strategy='brutal_damping', step=0.01",
    "strategy='large_step', step=100",
    "strategy='numerical_viscosity', step=1",
)


@pytest.mark.parametrize("fidelity", ["rigid", "elastic"])
@pytest.mark.parametrize("strategy", STRATEGIES)
def test_stones_that_a_tie_squeezes_come_to_rest(fidelity, strategy):
    """The speed that counts as rest is relative to what the tie gave; it bears its pretension."""
    made = solve_scene(
        loads(
            SCENE,
            [f"fidelity={fidelity}", TIED, f"analysis={{kind='equilibrium', max_steps=50, {strategy}}}"],
        )
    )
    assert made.outcome == "equilibrium"
    certificate = made.summary.certificate
    assert certificate.global_balance < 1e-9
    assert made.summary.ties["t"].force == pytest.approx(100.0, rel=1e-9 if fidelity == "rigid" else 0.1)


def test_stones_that_are_warm_come_to_rest():
    """They grow freely: at the end no force is left to hold a speed against."""
    made = solve_scene(
        loads(
            SCENE,
            [
                "fidelity=elastic",
                WARMED,
                f"analysis={{kind='equilibrium', max_steps=200, {STRATEGIES[0]}}}",
                "probes=[{name='top', block='w.b2', point=[0.25, 0.5]}]",
            ],
        )
    )
    assert made.outcome == "equilibrium"
    assert made.summary.probes["top"][1] == pytest.approx(
        (1 + 0.2) * 8e-6 * 20 * 0.5, rel=1e-6
    )  # plane strain
