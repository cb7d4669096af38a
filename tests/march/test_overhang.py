"""Blocks that slide off what they lie on: in statics contacts keep their points, and the run says so."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from masonry_fem.analyses.run import RunResult, solve_scene
from masonry_fem.march.motion import nearest_motions
from masonry_fem.scene import check
from masonry_fem.scene.specs import (
    Contact,
    Dynamics,
    Initial,
    Joint,
    Loads,
    Material,
    MeshSettings,
    Motion,
    Scene,
    Statics,
    Support,
    Table,
)
from masonry_fem.structures.block import BlockStructure

STONE = Material(density=2000.0, young=1e9, poisson=0.2)
STAY = Table(points=((0.0, 1.0),))


def pushed(way: float, fidelity: str, **keys: Any) -> RunResult:
    """A stone of 1 m, its front 1 cm before the edge of the ground, pushed by so much [m] over that edge."""
    blocks = {
        "ground": ((2.0, 0.5), (-2.0, -0.5)),
        "stone": ((1.0, 0.4), (-1.01, 0.0)),
        "jack": ((0.2, 0.01), (-1.21, 0.05)),
    }
    return solve_scene(
        check(
            Scene(
                dimension=2,
                fidelity=fidelity,
                materials={"stone": STONE},
                structures=tuple(
                    BlockStructure(name=name, material="stone", size=size, position=position)
                    for name, (size, position) in blocks.items()
                ),
                supports=(Support(on="ground"), Support(on="jack", motion=Motion(displacement=(way, 0.0)))),
                loads=Loads(gravity=(0.0, -9.81), gravity_time=STAY),
                joints=(Joint(friction=0.3),),
                analysis=Statics(load_steps=24),
                **keys,
            )
        )
    )


def told(result: RunResult) -> list[str]:
    return [one.sentence for one in result.summary.remarks if one.code == "overhang"]


@pytest.mark.parametrize("fidelity", ["rigid", "elastic"])
def test_a_stone_that_stands_in_the_air_is_told(fidelity):
    """Its centre is o = 9 cm past the edge; with its back r = 41 cm behind the edge and the push at h = 5 cm,

    H = μ N, which rubs upwards by μ H, the force below it is at o (1 + μ²) + h μ + r μ² = 0.15 m.
    """
    result = pushed(0.6, fidelity)
    assert result.outcome == "equilibrium"
    (sentence,) = told(result)
    assert "'stone' on 'ground' by 0.15 m" in sentence
    assert "contact.update = 'redetect'" in sentence


def test_a_stone_that_overhangs_and_stands_is_not_told():
    """Its centre is 21 cm behind the edge, its front 29 cm past it."""
    result = pushed(0.3, "rigid")
    assert result.outcome == "equilibrium"
    assert not told(result)


def test_contacts_found_anew_let_it_tip():
    result = pushed(0.6, "rigid", contact=Contact(update="redetect"))
    assert result.outcome == "no_equilibrium"
    assert not told(result)


LENGTH, HEIGHT, SPEED, G = 1.0, 0.2, 5.0, 9.81


def shot(duration: float, *, dimension: int = 2, **keys: Any) -> RunResult:
    """A stone that slides without friction off a table which ends 1 cm before its front."""
    across = (0.5,) * (dimension - 2)
    blocks = {
        "table": ((2.0, *across, 0.5), (-2.0, *(0.0 for _ in across), -0.5)),
        "stone": ((LENGTH, *across, HEIGHT), (-LENGTH - 0.01, *(0.0 for _ in across), 0.0)),
    }
    return solve_scene(
        check(
            Scene(
                dimension=dimension,
                materials={"stone": STONE},
                structures=tuple(
                    BlockStructure(name=name, material="stone", size=size, position=position)
                    for name, (size, position) in blocks.items()
                ),
                supports=(Support(on="table"),),
                loads=Loads(gravity=(0.0,) * (dimension - 1) + (-G,)),
                joints=(Joint(friction=0.0),),
                initial=(Initial(blocks="stone", velocity=(SPEED,) + (0.0,) * (dimension - 1)),),
                analysis=Dynamics(step=1e-3, duration=duration),
                **keys,
            )
        )
    )


@pytest.mark.parametrize(("fidelity", "dimension"), [("rigid", 2), ("elastic", 2), ("rigid", 3)])
def test_in_time_a_stone_tips_over_the_edge_that_it_slides_off(fidelity, dimension):
    """Its centre is s past the edge and s φ lower: (k² + s²) ω' = s (g − 2 ω v) with k² = I/m, so

    ω = g/2v s²/(k² + s²), φ = g/2v² (s − k arctan s/k); when its back leaves the edge, s = L/2, it turns on.
    Contacts may bear up to a hundredth of it past the edge.
    """
    time = 0.25
    mesh = MeshSettings(divisions=(4, 2, 2)[:dimension])
    result = shot(time, fidelity=fidelity, dimension=dimension, mesh=mesh)
    assert result.outcome == "finished"
    assert not told(result)
    assert result.march.model.contacts.count == 0
    k, s = math.sqrt((LENGTH**2 + HEIGHT**2) / 12), LENGTH / 2
    spin = G / (2 * SPEED) * s**2 / (k**2 + s**2)
    left = (LENGTH + 0.01) / SPEED
    angle = G / (2 * SPEED**2) * (s - k * math.atan(s / k)) + spin * (time - left)
    rotation, _ = nearest_motions(result.march.model, result.march.state.bodies)
    turned = np.arcsin(np.abs(rotation[:, -1, 0]).max())
    assert turned == pytest.approx(angle, rel=0.05)


def test_contacts_that_stay_in_time_are_told():
    """Fixed ones hold it in the air; its centre is 25 cm past the edge as the last step begins."""
    result = shot(0.153, contact=Contact(update="fixed"))
    (sentence,) = told(result)
    assert "'stone' on 'table' by 0.25 m" in sentence
