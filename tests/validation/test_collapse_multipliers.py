"""A1.4, A3.5, A3.6, A4.5, A4.6, A6.2 by search: multiplier and mechanism of collapse, found by simulation.

No case is told where to look: limit analysis is asked afterwards, and says the same.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from masonry_fem.analyses.collapse import CollapseResult, collapse
from masonry_fem.analyses.limit import posed
from masonry_fem.build import build
from masonry_fem.limit import Collapse, collapse_multiplier
from masonry_fem.scene.specs import (
    Equilibrium,
    Joint,
    Loads,
    MeshSettings,
    PointForce,
    Scene,
    Statics,
)
from masonry_fem.structures.arch import ArchStructure
from masonry_fem.structures.portal import PortalStructure
from masonry_fem.structures.stack import StackStructure
from masonry_fem.structures.wall import WallStructure
from tests.validation.scenes import STONE, G

ONE_STEP = Equilibrium(strategy="large_step", step=0.01, max_steps=3, tolerance=1e-6)
TOLERANCE = 0.01


def scene(*structures, friction: float, **keys) -> Scene:
    given = {
        "dimension": 2,
        "fidelity": "rigid",
        "materials": {"stone": STONE},
        "structures": structures,
        "joints": (Joint(friction=friction),),
        "loads": Loads(gravity=(0.0, -G)),
    } | keys
    return Scene(**given)


def arch(thickness: float, voussoirs: int) -> ArchStructure:
    return ArchStructure(name="arch", material="stone", radius=1.0, thickness=thickness, voussoirs=voussoirs)


def assert_found(found: CollapseResult, limit: float) -> None:
    """The bracket holds the limit, itself known to five digits, and is narrow."""
    assert found.summary.outcome == "bracketed"
    assert found.summary.stands * (1 - 1e-4) <= limit <= found.summary.falls * (1 + 1e-4)
    assert found.summary.falls - found.summary.stands <= TOLERANCE * found.summary.falls


def hinges(found: CollapseResult | Collapse) -> dict[frozenset[str], np.ndarray]:
    """Joint blocks → place of the hinges."""
    return {frozenset(joint.between): joint.at for joint in found.mechanism.of("hinge")}


@pytest.mark.slow
@pytest.mark.parametrize("friction", [5.0, 0.6])
@pytest.mark.parametrize(
    ("thickness", "voussoirs", "limit"),
    [(0.2, 11, 0.29556), (0.2, 20, 0.28520), (0.15, 15, 0.14975), (0.12, 27, 0.04818)],
)
@pytest.mark.parametrize("analysis", [Statics(), ONE_STEP], ids=["statics", "steps"])
def test_a3_5_arch_under_acceleration(thickness, voussoirs, limit, friction, analysis) -> None:
    """Four hinges, at the joints and the edges where limit analysis has them."""
    made = scene(arch(thickness, voussoirs), friction=friction, analysis=analysis)
    found = collapse(made, acceleration="x", limit=False, tolerance=TOLERANCE)
    assert_found(found, limit)
    assert len(found.mechanism.joints) == 4
    assert len(found.mechanism.parts) == 3
    mine, theirs = hinges(found), hinges(expected(made))
    assert mine.keys() == theirs.keys()
    for joint, place in mine.items():
        np.testing.assert_allclose(place, theirs[joint], atol=1e-3)


def expected(made: Scene) -> Collapse:
    """What limit analysis says of the same acceleration."""
    problem, _ = posed(made, build(made, Path()), tilt="x")
    return collapse_multiplier(problem)


def test_a3_5_elastic_arch_has_the_same_hinges() -> None:
    made = scene(arch(0.2, 11), friction=0.6, fidelity="elastic", mesh=MeshSettings(divisions=(4, 2)))
    found = collapse(made, tilt="x", limit=False, tolerance=TOLERANCE)
    assert_found(found, 0.29556)
    assert hinges(found).keys() == hinges(expected(made)).keys()
    assert len(found.mechanism.joints) == 4


def test_a3_6_point_load() -> None:
    push = PointForce(block="arch.v05", vector=(0.0, -0.2 * np.pi * STONE.density * G))
    made = scene(arch(0.2, 11), friction=5.0, loads=Loads(gravity=(0.0, -G), points=(push,)))
    found = collapse(made, limit=False, tolerance=TOLERANCE)
    assert_found(found, 0.40189)
    assert len(found.mechanism.of("hinge")) == len(found.mechanism.joints) == 4


@pytest.mark.parametrize(("friction", "limit", "how"), [(0.4, 0.25, "hinge"), (0.2, 0.2, "slides")])
@pytest.mark.parametrize("tilted", [True, False])
def test_a1_4_block_tips_or_slides(friction: float, limit: float, how: str, tilted: bool) -> None:
    """B = 0.5, H = 2: it tips at 14.036° where μ > B/H, and slides first where μ is less."""
    block = StackStructure(name="block", material="stone", size=(0.5, 2.0), count=1)
    keys = {"tilt": "x"} if tilted else {"acceleration": "x"}
    found = collapse(scene(block, friction=friction), limit=False, tolerance=TOLERANCE, **keys)
    assert_found(found, limit)
    (joint,) = found.mechanism.joints
    assert joint.how == how


@pytest.mark.parametrize(("height", "friction"), [(0.5, 0.3), (1.5, 0.5)])
def test_a1_4_force_at_a_height(height: float, friction: float) -> None:
    """F = min(μ, B/2z) W."""
    weight = 0.5 * 2.0 * STONE.density * G
    block = StackStructure(name="block", material="stone", size=(0.5, 2.0), count=1)
    push = PointForce(block="block.b1", point=(0.25, height), vector=(weight, 0.0))
    made = scene(block, friction=friction, loads=Loads(gravity=(0.0, -G), points=(push,)))
    found = collapse(made, limit=False, tolerance=TOLERANCE)
    assert_found(found, min(friction, 0.5 / (2 * height)))


@pytest.mark.parametrize("analysis", [Statics(), ONE_STEP], ids=["statics", "steps"])
def test_a4_5_column(analysis) -> None:
    column = StackStructure(name="column", material="stone", size=(0.5, 0.3), count=6)
    found = collapse(
        scene(column, friction=0.65, analysis=analysis), acceleration="x", limit=False, tolerance=TOLERANCE
    )
    assert_found(found, 0.277778)
    (part,) = found.mechanism.parts
    assert len(part.blocks) == 6
    np.testing.assert_allclose(part.pole, [0.5, 0.0], atol=1e-3)


def test_a4_6_column_of_single_bricks() -> None:
    wall = WallStructure(
        name="wall", material="stone", brick=(0.4, 0.2), columns=1, courses=10, half_bricks="even"
    )
    found = collapse(scene(wall, friction=0.65), acceleration="x", limit=False, tolerance=TOLERANCE)
    assert_found(found, 0.2)


def test_a4_1_wall_of_five_by_six() -> None:
    """Statics rests up to the multiplier of limit analysis, which shows where to look here."""
    wall = WallStructure(
        name="wall", material="stone", brick=(0.4, 0.175), columns=5, courses=6, half_bricks="odd"
    )
    found = collapse(scene(wall, friction=0.65), acceleration="x", tolerance=TOLERANCE)
    assert_found(found, 0.64286)
    assert found.summary.limit_multiplier == pytest.approx(0.64286, abs=1e-5)


@pytest.mark.parametrize(
    ("height", "stands"), [pytest.param(1.30, True, marks=pytest.mark.slow), (1.35, False)]
)
def test_a6_2_portal(height: float, stands: bool) -> None:
    """Piers of 0.3 carry the arch up to 1.3227 R: at 1.35 it falls without any push, about the outer toes."""
    portal = PortalStructure(
        name="portal", material="stone", span=2.0, thickness=0.15, voussoirs=20, pier_width=0.3,
        pier_height=height,
    )  # fmt: skip
    found = collapse(scene(portal, friction=0.6), acceleration="x", tolerance=TOLERANCE)
    if stands:
        assert found.summary.outcome == "bracketed"
        assert found.summary.falls == pytest.approx(found.summary.limit_multiplier, rel=0.01)
    else:
        assert found.summary.outcome == "falls at the start"
        toes = [joint.at for joint in found.mechanism.of("hinge") if abs(joint.at[1]) < 1e-6]
        assert toes
