"""Blocks that slide off what they lie on: in statics contacts keep their points, and the run says so."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from masonry_fem.analyses.run import RunResult, solve_scene
from masonry_fem.build import build
from masonry_fem.march.coupling import connect
from masonry_fem.march.motion import nearest_motions
from masonry_fem.march.overhang import Ends, slid_off
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
BEFORE, ABOVE = 0.3, 0.005  # of the table's edge, and above the table, a stone begins


def shot(duration: float, **keys: Any) -> RunResult:
    """A stone that falls on a table and slides off it without friction."""
    return solve_scene(check(scene(analysis=Dynamics(step=1e-3, duration=duration), **keys)))


def scene(*, dimension: int = 2, above: float = ABOVE, fidelity: str = "rigid", **keys: Any) -> Scene:
    """A stone above a table, or on it, that moves towards its edge."""
    across = (0.5,) * (dimension - 2)
    blocks = {
        "table": ((2.0, *across, 0.5), (-2.0, *(0.0 for _ in across), -0.5)),
        "stone": ((LENGTH, *across, HEIGHT), (-LENGTH - BEFORE, *(0.0 for _ in across), above)),
    }
    return Scene(
        dimension=dimension,
        fidelity=fidelity,
        materials={"stone": STONE},
        structures=tuple(
            BlockStructure(name=name, material="stone", size=size, position=position)
            for name, (size, position) in blocks.items()
        ),
        supports=(Support(on="table"),),
        loads=Loads(gravity=(0.0,) * (dimension - 1) + (-G,)),
        joints=(Joint(friction=0.0),),
        initial=(Initial(blocks="stone", velocity=(SPEED,) + (0.0,) * (dimension - 1)),),
        **{"analysis": Dynamics(step=1e-3, duration=1.0), **keys},
    )


@pytest.mark.parametrize(("fidelity", "dimension"), [("rigid", 2), ("elastic", 2), ("rigid", 3)])
def test_in_time_a_stone_tips_over_the_edge_that_it_slides_off(fidelity, dimension):
    """Its centre is s past the edge and s φ lower: (k² + s²) ω' = s (g − 2 ω v) with k² = I/m, so

    ω = g/2v s²/(k² + s²), φ = g/2v² (s − k arctan s/k); when its back leaves the edge, s = L/2, it turns on.
    Contacts may bear up to a hundredth of it past the edge.
    """
    time = 0.3
    mesh = MeshSettings(divisions=(4, 2, 2)[:dimension])
    result = shot(time, fidelity=fidelity, dimension=dimension, mesh=mesh)
    assert result.outcome == "finished"
    assert not told(result)
    assert result.march.model.contacts.count == 0
    k, s = math.sqrt((LENGTH**2 + HEIGHT**2) / 12), LENGTH / 2
    spin = G / (2 * SPEED) * s**2 / (k**2 + s**2)
    left = (LENGTH + BEFORE) / SPEED
    angle = G / (2 * SPEED**2) * (s - k * math.atan(s / k)) + spin * (time - left)
    rotation, _ = nearest_motions(result.march.model, result.march.state.bodies)
    turned = np.arcsin(np.abs(rotation[:, -1, 0]).max())
    assert turned == pytest.approx(angle, rel=0.05)


def test_along_a_joint_of_the_scene_it_slides_on():
    """A ground may be shorter than the way: joints of the start have no end as long as blocks do not turn."""
    result = shot(0.3, above=0.0, fidelity="rigid")
    assert result.outcome == "finished"
    rotation, translation = nearest_motions(result.march.model, result.march.state.bodies)
    assert np.abs(rotation[:, -1, 0]).max() < 1e-9
    assert translation[1] == pytest.approx([0.3 * SPEED, 0.0], abs=1e-9)


@pytest.mark.parametrize(("turn", "goes"), [(0.0, False), (4.0, False), (6.0, True)])
def test_a_joint_is_one_no_more_where_blocks_have_turned(turn, goes):
    """Half a stone past the edge: its contacts go where it has turned by more than ``contact.angle``."""
    model = build(check(scene(above=0.0)), Path()).model
    sine, cosine = math.sin(math.radians(turn)), math.cos(math.radians(turn))
    bodies = tuple(
        group.rest()
        if group.prescribed
        else replace(
            group.rest(),
            shift=np.array([[0.5 * LENGTH + BEFORE, 0.0]]),
            turned=np.array([[[cosine - 1, sine], [-sine, cosine - 1]]]),
        )
        for group in model.groups
    )
    here, held = connect(model).placement(bodies), np.zeros(model.contacts.count, dtype=bool)
    found = slid_off(model, here, bodies, held, Ends.of(model.assembly))
    assert found.tolist() == ([[0, 1]] if goes else [])
