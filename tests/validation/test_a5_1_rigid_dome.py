"""A5.1, A5.3: domes of rigid stones without cohesion against limit analysis.

No tension, no sliding: the least thickness is t/R = .04266 for 18 rings. As the base spreads the dome cracks
along its meridians, and its thrust falls to .011693, .019469 and .024265 γ R³ a radian for t/R .05, .1, .15.
"""

from __future__ import annotations

import pytest

from masonry_fem.analyses.run import solve_scene
from masonry_fem.scene.specs import Joint, Loads, Material, Scene
from masonry_fem.structures.dome import DomeStructure
from tests.validation.domes import GAMMA, RADIUS, G, lune, meridian_points, thrust


@pytest.mark.slow
@pytest.mark.parametrize(
    ("thickness", "least"), [(0.25, 0.011693), (0.5, 0.019469), (0.75, 0.024265)], ids=["t5", "t10", "t15"]
)
def test_a5_3_a_spreading_base_leaves_the_least_thrust(thickness: float, least: float) -> None:
    """Rigid stones, without cohesion; the lune of 5 degrees is cut by chords, which takes 0.1 % off."""
    result = lune(
        thickness=thickness, meridian=None, base_friction=0.8, spread=1e-3, steps=4, sweep=5.0, friction=5.0,
        fidelity="rigid", tolerance=1e-9,
    )  # fmt: skip
    assert result.outcome == "equilibrium"
    horizontal, _ = thrust(result, 5.0)
    assert horizontal == pytest.approx(least * GAMMA * RADIUS**3, rel=0.005)
    mine, angle = meridian_points(result)
    opened = result.march.state.gap[mine] > 1e-9
    assert angle[~opened].max() < 30  # cut into lunes but for a cap


@pytest.mark.parametrize(("share", "outcome"), [(0.98, "no_equilibrium"), (1.02, "equilibrium")])
def test_a5_1_least_thickness(share: float, outcome: str) -> None:
    """18 rings without tension, whatever their friction: t/R = .04266."""
    result = lune(
        thickness=share * 0.04266 * RADIUS, meridian=None, base_friction=5.0, sweep=5.0, friction=5.0,
        fidelity="rigid",
    )  # fmt: skip
    assert result.outcome == outcome


@pytest.mark.parametrize(
    ("staggered", "friction", "outcome"),
    [(False, 0.6, "no_equilibrium"), (True, 0.6, "equilibrium"), (True, 0.05, "no_equilibrium")],
)
def test_stones_in_bond_are_ties(staggered: bool, friction: float, outcome: str) -> None:
    """On rollers, without cohesion: friction in the beds of staggered rings pulls along the parallels."""
    scene = Scene(
        fidelity="rigid",
        materials={"stone": Material(density=GAMMA / G)},
        structures=(
            DomeStructure(
                name="dome", material="stone", radius=RADIUS, thickness=0.5, rings=6, slices=12,
                staggered=staggered,
            ),
        ),
        joints=(
            Joint(friction=friction),
            Joint(friction=0.0, between=("dome.base.*", "dome.r1.*"), interface="bed"),
        ),
        loads=Loads(gravity=(0.0, 0.0, -G)),
    )  # fmt: skip
    assert solve_scene(scene).outcome == outcome
