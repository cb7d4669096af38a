"""A6.5: a floor whose far support gives way turns on the wall that carries its other end.

The slab rests on a wall of width B and is lowered at its far end by δ: it turns by θ = δ/(L − B) about the
wall's inner edge, where all of its reaction goes (eccentricity B/2), and opens at the outer edge by B sin θ.
Moments about the far end: the wall carries W L/(2 (L − B)). A joint that could hold the slab as a
cantilever needs the strength f = W (L/2 − B)/(B · B/2) at two points of half the width each; with less it
cracks and all is as if dry.
"""

from __future__ import annotations

import numpy as np
import pytest

from masonry_fem.analyses.run import RunResult, solve_scene
from masonry_fem.scene.specs import (
    AnyLaw,
    Joint,
    Loads,
    Material,
    MeshSettings,
    Motion,
    Probe,
    Scene,
    Solver,
    Statics,
    Support,
    Table,
    law_record,
)
from masonry_fem.structures.block import BlockStructure

B, SPAN, DEPTH, HEIGHT = 0.4, 4.0, 0.2, 1.0
DENSITY, G = 2400.0, 9.81
WEIGHT = DENSITY * G * SPAN * DEPTH
CARRIED = WEIGHT * SPAN / (2 * (SPAN - B))
STRENGTH = WEIGHT * (SPAN / 2 - B) / (B * B / 2)
THETA = 1e-3
DROP = (SPAN - B) * np.tan(THETA)
YOUNG = 100e9  # stiff stone: the slab's own sag turns its end by a tenth of θ


def lowered(fidelity: str, law: AnyLaw | None = None) -> RunResult:
    """Weight first, then the far support sinks; two steps each."""
    sinking = Motion(displacement=(0.0, -DROP), time=Table(points=((0.5, 0.0), (1.0, 1.0))))
    scene = Scene(
        dimension=2,
        fidelity=fidelity,
        materials={"stone": Material(density=DENSITY, young=YOUNG, poisson=0.2)},
        structures=(
            BlockStructure(name="wall", material="stone", size=(B, HEIGHT), support=fidelity == "rigid"),
            BlockStructure(
                name="far",
                material="stone",
                size=(B, HEIGHT),
                position=(SPAN - B / 2, 0.0),
                fidelity="rigid",
            ),
            BlockStructure(
                name="slab",
                material="stone",
                size=(SPAN, DEPTH),
                position=(0.0, HEIGHT),
                mesh=MeshSettings(divisions=(40, 2), element="Q2"),
            ),
        ),
        mesh=MeshSettings(divisions=(8, 10)),
        joints=(Joint(friction=0.6), Joint(friction=0.6, law=law, between=("wall", "slab"))),
        supports=(
            Support(on="far", motion=sinking),
            *((Support(on="wall/bottom"),) if fidelity == "elastic" else ()),
        ),
        loads=Loads(gravity=(0.0, -G), gravity_time=Table(points=((0.0, 0.0), (0.5, 1.0)))),
        analysis=Statics(load_steps=4),
        solver=Solver(tolerance=1e-11),
        probes=(
            Probe(name="low", block="slab", point=(0.0, HEIGHT)),
            Probe(name="high", block="slab", point=(0.0, HEIGHT + DEPTH)),
        ),
    )
    return solve_scene(scene)


def on_wall(result: RunResult) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """x [m], gap [m] and normal reaction [N] of the points between wall and slab, from outside inwards."""
    model, state = result.built.model, result.march.state
    wall = {block.name: number for number, block in enumerate(model.assembly.blocks)}["wall"]
    mine = np.flatnonzero((model.contacts.blocks == wall).any(axis=1))
    mine = mine[np.argsort(state.points[mine, 0])]
    return state.points[mine, 0], state.gap[mine], state.reaction[mine, 0]


def assert_on_edge(result: RunResult) -> None:
    """The rigid slab turns on the inner edge."""
    assert result.outcome == "equilibrium"
    x, gap, pressed = on_wall(result)
    assert x == pytest.approx([0.0, B], abs=1e-6)
    assert gap[0] == pytest.approx(B * THETA, rel=1e-4)  # a step is linear in its turn, θ/2 here
    # friction at both supports, which stand θ apart in height, may shift μ θ of the load between them
    assert pressed == pytest.approx([0.0, CARRIED], rel=0.6 * THETA, abs=1e-6 * WEIGHT)
    assert (x * pressed).sum() / pressed.sum() - B / 2 == pytest.approx(B / 2, rel=1e-5)


@pytest.mark.parametrize(
    "law",
    [
        None,
        law_record("constant_threshold", strength=0.98 * STRENGTH),
        law_record(
            "elastic_brittle",
            normal_stiffness=1e13,
            tangential_stiffness=1e13,
            normal_strength=0.9 * STRENGTH,
            tangential_strength=1e9,
        ),
    ],
    ids=["dry", "threshold", "brittle springs"],
)
def test_a6_5_rigid_slab_turns_on_the_edge(law: AnyLaw | None) -> None:
    assert_on_edge(lowered("rigid", law))


def test_a6_5_a_strong_joint_holds_the_slab_as_a_cantilever() -> None:
    result = lowered("rigid", law_record("constant_threshold", strength=1.02 * STRENGTH))
    assert result.outcome == "equilibrium"
    _, gap, _ = on_wall(result)
    assert gap == pytest.approx([0.0, 0.0], abs=1e-10)
    assert result.summary.supports["far"].force == pytest.approx([0.0, 0.0], abs=1e-6 * WEIGHT)
    assert result.summary.supports["wall"].force[1] == pytest.approx(WEIGHT, rel=1e-9)


def test_a6_5_the_joint_opens_where_it_is_broken() -> None:
    result = lowered("rigid", law_record("constant_threshold", strength=0.98 * STRENGTH))
    gap, broken = result.march.state.gap, result.march.state.joints.broken
    np.testing.assert_array_equal(broken[gap > 1e-6], True)
    assert (gap > 1e-6).sum() >= 1


@pytest.mark.parametrize(
    "law",
    [
        None,
        law_record(
            "elastic_brittle",
            normal_stiffness=1e13,
            tangential_stiffness=1e13,
            normal_strength=1e5,
            tangential_strength=1e9,
        ),
    ],
    ids=["dry", "brittle springs"],
)
def test_a6_5_elastic_slab_on_an_elastic_wall(law: AnyLaw | None) -> None:
    """Contact shrinks to the last elements; the opening is the turn of the slab's end times B."""
    result = lowered("elastic", law)
    assert result.outcome == "equilibrium"
    x, gap, pressed = on_wall(result)
    low, high = (np.array(result.summary.probes[name]) for name in ("low", "high"))
    turn = (high - low)[0] / DEPTH
    assert turn == pytest.approx(THETA, rel=0.2)
    assert gap[0] == pytest.approx(B * turn, rel=0.01)
    assert pressed[x < 0.85 * B] == pytest.approx(0.0, abs=1e-6 * WEIGHT)
    assert pressed.sum() == pytest.approx(CARRIED, rel=0.01)
    assert (x * pressed).sum() / pressed.sum() - B / 2 == pytest.approx(B / 2, rel=0.03)
