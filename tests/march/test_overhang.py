"""Blocks that slide off what they lie on: what bears is the end of the face, and past it nothing does."""

from __future__ import annotations

from typing import Any

import pytest

from masonry_fem.analyses.run import RunResult, solve_scene
from masonry_fem.scene import check
from masonry_fem.scene.specs import Joint, Loads, Material, Motion, Scene, Statics, Support, Table
from masonry_fem.structures.block import BlockStructure

STONE = Material(density=2000.0, young=1e9, poisson=0.2)
STAY = Table(points=((0.0, 1.0),))


def moved(
    fidelity: str, blocks: dict[str, tuple[Any, Any]], moves: dict[str, float], **keys: Any
) -> RunResult:
    """Blocks (size, position) of which some are held, and moved to the right by so much [m]."""
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
                supports=tuple(
                    Support(on=name, motion=Motion(displacement=(way, 0.0))) if way else Support(on=name)
                    for name, way in moves.items()
                ),
                loads=Loads(gravity=(0.0, -9.81), gravity_time=STAY),
                **keys,
            )
        )
    )


@pytest.mark.parametrize("fidelity", ["rigid", "elastic"])
def test_a_stone_that_is_pushed_over_an_edge_tips(fidelity):
    """Pushed with N = μ R at height y it tips where its centre is o past the edge: W o + N y = μ N b.

    b is how far behind the edge its back is. It overhangs more than if nothing rubbed on its back.
    """
    friction, height, length, way, steps = 0.3, 0.05, 1.0, 0.6, 24
    push = friction / (1 - friction**2)  # of the weight
    over = (friction * push * length / 2 - push * height) / (1 + friction * push)
    result = moved(
        fidelity,
        {
            "ground": ((2.0, 0.5), (-2.0, -0.5)),
            "stone": ((length, 0.4), (-1.0, 0.0)),
            "jack": ((0.2, 0.01), (-1.2, height)),
        },
        {"ground": 0.0, "jack": way},
        joints=(Joint(friction=friction),),
        analysis=Statics(load_steps=steps),
    )
    assert result.outcome == "no_equilibrium"
    falls = (length / 2 + over) / way
    assert falls <= result.march.state.time <= falls + 1 / steps


@pytest.mark.parametrize("fidelity", ["rigid", "elastic"])
def test_a_beam_falls_from_a_bearing_that_is_pulled_away(fidelity):
    """It stays where friction is high, and bears as long as there is something below it."""
    bearing, way, steps = 0.15, 0.2, 8
    result = moved(
        fidelity,
        {
            "left": ((1.0, 0.5), (-1.0, -0.5)),
            "right": ((1.0, 0.5), (2.0, -0.5)),
            "beam": ((2.0 + 2 * bearing, 0.3), (-bearing, 0.0)),
        },
        {"left": 0.0, "right": way},
        joints=(Joint(friction=0.1), Joint(between=("left", "beam"), friction=0.8)),
        analysis=Statics(load_steps=steps),
    )
    assert result.outcome == "no_equilibrium"
    assert bearing / way <= result.march.state.time <= bearing / way + 1 / steps
