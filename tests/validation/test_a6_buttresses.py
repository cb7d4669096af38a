"""A6.1 to A6.3: buttresses, portals and straight flyers of rigid stones, against closed forms.

Each stands a little below its known limit and falls a little above it.
"""

from __future__ import annotations

from pathlib import Path

import msgspec
import numpy as np
import pytest

from masonry_fem.analyses.run import RunResult
from masonry_fem.scene.specs import (
    Equilibrium,
    Joint,
    Loads,
    MeshSettings,
    Motion,
    PointForce,
    Statics,
    Support,
)
from masonry_fem.structures import build_structure
from masonry_fem.structures.block import BlockStructure
from masonry_fem.structures.flying_buttress import FlyingButtressStructure
from masonry_fem.structures.portal import PortalStructure
from masonry_fem.structures.stack import StackStructure
from tests.structures.test_arches import thrust_bounds
from tests.validation.scenes import STONE, G, solved

ONE_STEP = Equilibrium(strategy="large_step", step=0.01, max_steps=3, tolerance=1e-6)
GAMMA = STONE.density * G


def buttress(height: float, push: float, courses: int, friction: float, width: float = 1.0) -> RunResult:
    """A pier pushed at the top of its left face by ``push`` [N/m]."""
    size = (width, height / courses)
    top = f"pier.b{courses}"
    push_at = PointForce(block=top, point=(0.0, height), vector=(push, 0.0))
    return solved(
        dimension=2,
        fidelity="rigid",
        structures=(StackStructure(name="pier", material="stone", size=size, count=courses),),
        joints=(Joint(friction=friction),),
        loads=Loads(gravity=(0.0, -G), points=(push_at,)),
        analysis=ONE_STEP,
    )


@pytest.mark.parametrize("courses", [1, 4])
@pytest.mark.parametrize("height", [2.0, 6.0])
def test_a6_1_a_buttress_overturns_whatever_its_height(height: float, courses: int) -> None:
    """H = γ b² / 2: weight and overturning moment both grow with the height."""
    limit = GAMMA / 2
    assert buttress(height, 0.99 * limit, courses, 5.0).outcome == "equilibrium"
    assert buttress(height, 1.01 * limit, courses, 5.0).outcome == "no_equilibrium"


def test_a6_1_a_buttress_slides_on_its_base() -> None:
    """H = μ γ b h at the base of one block, where that is less."""
    limit = 0.3 * GAMMA * 1.0
    assert limit < GAMMA / 2
    assert buttress(1.0, 0.99 * limit, 1, 0.3).outcome == "equilibrium"
    assert buttress(1.0, 1.01 * limit, 1, 0.3).outcome == "no_equilibrium"


def portal(height: float, width: float = 0.3, courses: int = 1) -> RunResult:
    structure = PortalStructure(
        name="portal",
        material="stone",
        span=2.0,
        thickness=0.15,
        voussoirs=20,
        pier_width=width,
        pier_height=height,
        courses=courses,
    )
    return solved(
        dimension=2,
        fidelity="rigid",
        structures=(structure,),
        joints=(Joint(friction=0.6),),
        analysis=ONE_STEP,
    )


@pytest.mark.parametrize("courses", [1, 8])
def test_a6_2_piers_of_a_portal_have_a_greatest_height(courses: int) -> None:
    """1.32272 R, where both piers rock about their outer toes."""
    assert portal(1.30, courses=courses).outcome == "equilibrium"
    assert portal(1.35, courses=courses).outcome == "no_equilibrium"


def test_a6_2_to_half_a_per_cent() -> None:
    assert portal(0.996 * 1.32272).outcome == "equilibrium"
    assert portal(1.004 * 1.32272).outcome == "no_equilibrium"


def test_a6_2_wide_piers_stand_at_any_height() -> None:
    result = portal(20.0, width=0.5)
    assert result.outcome == "equilibrium"
    grounds = [result.summary.supports[f"portal.ground_{side}"].force for side in ("left", "right")]
    weight = GAMMA * (2 * 0.5 * 20.0 + np.pi * 0.15)
    assert sum(force[1] for force in grounds) == pytest.approx(weight, rel=1e-6)
    # H_min h = (W/2)(lever of the springing reaction) + γ b² h / 2 cannot be exceeded
    assert abs(grounds[0][0]) < GAMMA * 0.5**2 / 2 * 1.1


FLYER = FlyingButtressStructure(
    name="flyer",
    material="stone",
    span=3 * np.cos(np.pi / 6),
    inclination=30.0,
    thickness=0.5,
    voussoirs=10,
    side="left",
)


def flyer(friction: float, **keys) -> RunResult:
    """A6.3's flyer, 3 m long, between two rigid walls."""
    return solved(
        dimension=2, fidelity="rigid", structures=(FLYER,), joints=(Joint(friction=friction),), **keys
    )


def thrust(result: RunResult) -> float:
    """Horizontal force on the head over the flyer's weight."""
    supports = result.summary.supports
    weight = supports["flyer.foot"].force[1] + supports["flyer.head"].force[1]
    assert weight == pytest.approx(GAMMA * 1.5, rel=1e-6)
    assert supports["flyer.foot"].force[0] == pytest.approx(-supports["flyer.head"].force[0], rel=1e-6)
    return abs(supports["flyer.head"].force[0]) / weight


@pytest.mark.parametrize(("friction", "least"), [(5.0, 0.56247), (0.6, 0.67614)])
def test_a6_3_a_yielding_wall_leaves_the_least_thrust(friction: float, least: float) -> None:
    """The wall gives way by 0.1 mm: what remains is the least thrust that carries the flyer."""
    away = Support(on="flyer.head", motion=Motion(displacement=(1e-4, 0.0)))
    result = flyer(friction, supports=(away,), analysis=Statics(load_steps=2))
    assert result.outcome == "equilibrium"
    assert thrust(result) == pytest.approx(least, rel=0.01)


@pytest.mark.parametrize(("friction", "least"), [(5.0, 0.56247), (0.6, 0.67614)])
def test_a6_3_between_rigid_walls(friction: float, least: float) -> None:
    result = flyer(friction, analysis=ONE_STEP)
    assert result.outcome == "equilibrium"
    assert thrust(result) >= least * 0.999


def propped(share: float) -> RunResult:
    """The flyer with vertical ends against a wall on rollers that pushes it with a share of its weight."""
    flyer = msgspec.structs.replace(FLYER, ends="vertical", head=False)
    wall = BlockStructure(name="wall", material="stone", size=(1.0, 1.0), position=(0.0, -0.5))
    rails = tuple(
        BlockStructure(name=name, material="stone", size=(3.0, 0.5), position=(0.1, low), support=True)
        for name, low in (("floor", -1.0), ("ceiling", 0.5))
    )
    weight = GAMMA * 3 * np.cos(np.pi / 6) * 0.5 / np.cos(np.pi / 6)
    push = PointForce(block="wall", point=(1.0, 0.0), vector=(-share * weight, 0.0))
    return solved(
        dimension=2,
        fidelity="rigid",
        structures=(flyer, wall, *rails),
        joints=(Joint(friction=5.0), *(Joint(friction=0.0, between=("wall", rail.name)) for rail in rails)),
        loads=Loads(gravity=(0.0, -G), points=(push,)),
        analysis=ONE_STEP,
    )


def test_a6_3_a_flyer_carries_any_thrust_above_the_least() -> None:
    """Against a vertical wall limit analysis asks for .564236 of its weight; there is no upper bound."""
    made = build_structure(msgspec.structs.replace(FLYER, ends="vertical"), 2, Path(), MeshSettings())
    least, most = thrust_bounds(made)
    assert least == pytest.approx(0.564236, rel=1e-5)
    assert most == np.inf
    assert propped(0.99 * least).outcome == "no_equilibrium"
    for share in (1.01 * least, 2.0, 50.0):
        assert propped(share).outcome == "equilibrium"
