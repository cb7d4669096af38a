"""Blocks that slide off what they lie on: contacts keep their points, and the run says so."""

from __future__ import annotations

from typing import Any

import pytest

from masonry_fem.analyses.run import RunResult, solve_scene
from masonry_fem.scene import check
from masonry_fem.scene.specs import Contact, Joint, Loads, Material, Motion, Scene, Statics, Support, Table
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
