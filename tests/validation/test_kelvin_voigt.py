"""Stiffness damping is the solid of Kelvin and Voigt, σ = C : (ε + β ε̇): a bar creeps, and resists its rate.

The bar is so light that its inertia does not count: it is a spring E A/L beside a dashpot β E A/L.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from masonry_fem.analyses.run import RunResult, solve_scene
from masonry_fem.march.equilibrium.dynamics import Dynamics
from masonry_fem.scene.reading import check
from masonry_fem.scene.specs import (
    Damping,
    Loads,
    Material,
    MeshSettings,
    Motion,
    Probe,
    Scene,
    Support,
    Table,
    Traction,
)
from masonry_fem.structures.block import BlockStructure

YOUNG, BETA, LENGTH, DEPTH = 1e6, 0.5, 2.0, 0.5
PULL, STEP = 1e3, 0.05


def bar(duration: float, theta: float, right: Motion | None = None) -> RunResult:
    """A bar whose end is pulled by a traction from the start on, or moved."""
    keys: dict[str, Any] = {}
    supports = [Support(on="bar/left", components=("x",)), Support(on="bar/bottom", components=("y",))]
    if right is None:
        keys["loads"] = Loads(tractions=(Traction(on="bar/right", vector=(PULL, 0.0)),))
    else:
        supports.append(Support(on="bar/right", components=("x",), motion=right))
    mesh = MeshSettings(divisions=(2, 1))
    stone = Material(density=1e-6, young=YOUNG, poisson=0.2, damping=Damping(stiffness=BETA))
    return solve_scene(
        check(
            Scene(
                dimension=2, plane="stress", fidelity="elastic", materials={"m": stone},
                structures=(BlockStructure(name="bar", material="m", size=(LENGTH, DEPTH), mesh=mesh),),
                supports=tuple(supports), probes=(Probe(name="end", block="bar", point=(LENGTH, DEPTH)),),
                analysis=Dynamics(step=STEP, duration=duration, theta=theta), **keys,
            )
        )
    )  # fmt: skip


@pytest.mark.parametrize("duration", [0.25, 1.0, 3.0])
def test_a_bar_creeps_to_its_elastic_length(duration):
    """ε = σ/E (1 − e^(−t/β)); steps of θ = 1 have (1 + h/β)^(−n) for the exponential, exactly."""
    result = bar(duration, theta=1.0)
    count, elastic = round(duration / STEP), PULL / YOUNG
    stretched = result.march.report.probes["end"] / [LENGTH, -0.2 * DEPTH]
    np.testing.assert_allclose(stretched, elastic * (1 - (1 + STEP / BETA) ** -count), rtol=1e-6)
    np.testing.assert_allclose(stretched, elastic * (1 - np.exp(-duration / BETA)), rtol=0.05)
    ledger = result.march.ledger
    assert ledger.imbalance <= 1e-9
    spent = ledger.damping_dissipation + ledger.numerical_dissipation + ledger.strain
    assert ledger.external_work == pytest.approx(spent, rel=1e-6)


@pytest.mark.parametrize(("duration", "moving"), [(0.5, True), (1.5, False)])
def test_it_bears_more_while_it_is_strained_and_relaxes_at_once(duration, moving):
    """σ = E (ε + β ε̇) at a constant rate, and E ε as soon as the end is at rest."""
    rate = 1e-3
    motion = Motion(displacement=(1.0, 0.0), time=Table(points=((0.0, 0.0), (1.0, rate * LENGTH))))
    result = bar(duration, theta=1.0, right=motion)
    strain = rate * min(duration, 1.0)
    expected = YOUNG * (strain + BETA * rate * moving) * DEPTH
    assert result.march.report.support_resultants["bar/right"][0] == pytest.approx(expected, rel=1e-6)
