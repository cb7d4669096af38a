"""A3: semicircular arches of rigid voussoirs; A8: contact points moved inwards. By simulation.

A structure stands where one step from rest leaves it at rest: with v = 0 every statically
admissible set of reactions solves Signorini-Coulomb, so the step is a limit analysis.
"""

from __future__ import annotations

import numpy as np
import pytest

from masonry_fem.analyses.run import RunResult
from masonry_fem.limit import group_forces, interval, limit_problem, support_resultant
from masonry_fem.scene.specs import (
    Equilibrium,
    Loads,
    Motion,
    PointForce,
    Solver,
    Statics,
    Support,
    Table,
)
from tests.validation.scenes import STONE, G, rigid_arch, stands

ONE_STEP = Equilibrium(strategy="large_step", step=0.01, max_steps=3, tolerance=1e-6)
T_MIN = {
    5: 0.09661, 7: 0.09625, 8: 0.10086, 9: 0.10213, 10: 0.10746, 11: 0.10491, 13: 0.10284, 15: 0.10627,
    20: 0.10746, 27: 0.10678, 41: 0.10731, 101: 0.10745,
}  # fmt: skip
THRUST = {
    (20, 0.12): (0.071890, 0.078149),
    (20, 0.2): (0.096589, 0.159958),
    (20, 0.15): (0.082526, 0.106975),
    (20, 0.3): (0.110973, 0.281970),
    (11, 0.12): (0.070801, 0.078700),
    (11, 0.2): (0.094247, 0.160027),
}
SPREAD = {0.12: 0.0335, 0.15: 0.1079, 0.2: 0.3052, 0.3: 0.5223}  # of the supports at collapse, over R
ACCELERATION = {(0.2, 11): 0.29556, (0.2, 20): 0.28520, (0.15, 15): 0.14975, (0.12, 27): 0.04818}


def arch(**keys) -> RunResult:
    return rigid_arch(**({"friction": 5.0, "analysis": ONE_STEP} | keys))


def arch_stands(**keys) -> bool:
    return stands(arch(**keys))


def thrust(result: RunResult) -> float:
    """Horizontal force of the left springing over γR² (R = 1 m)."""
    return float(np.abs(result.summary.supports["arch.springing_left"].force[0])) / (STONE.density * G)


@pytest.mark.parametrize("voussoirs", T_MIN)
def test_a3_2_least_thickness(voussoirs: int) -> None:
    t = T_MIN[voussoirs]
    assert arch_stands(thickness=1.01 * t, voussoirs=voussoirs)
    assert not arch_stands(thickness=0.99 * t, voussoirs=voussoirs)


@pytest.mark.parametrize(("voussoirs", "thickness"), THRUST)
def test_a3_3_thrust_lies_in_its_interval(voussoirs: int, thickness: float) -> None:
    low, high = THRUST[voussoirs, thickness]
    result = arch(thickness=thickness, voussoirs=voussoirs)
    assert result.outcome == "equilibrium"
    assert low * 0.999 <= thrust(result) <= high * 1.001


@pytest.mark.parametrize(("voussoirs", "thickness"), THRUST)
@pytest.mark.parametrize("spread", [1e-4, -1e-4])
def test_a3_3_moving_springings_lead_to_the_bounds(voussoirs: int, thickness: float, spread: float) -> None:
    """Springings that part by 1e-4 R leave the least thrust, that close the greatest, to 1 %."""
    moved = Support(on="arch.springing_right", motion=Motion(displacement=(spread, 0.0)))
    result = arch(thickness=thickness, voussoirs=voussoirs, analysis=Statics(load_steps=2), supports=(moved,))
    assert result.outcome == "equilibrium"
    bound = THRUST[voussoirs, thickness][0 if spread > 0 else 1]
    assert thrust(result) == pytest.approx(bound, rel=0.01)


@pytest.mark.parametrize(
    ("thickness", "voussoirs", "least"),
    [
        (0.2, 27, 0.30899), (0.15, 27, 0.35057), (0.12, 27, 0.38058), (0.1095, 27, 0.39168),
        (0.2, 11, 0.30703),
    ],
)  # fmt: skip
def test_a3_4_least_friction(thickness: float, voussoirs: int, least: float) -> None:
    assert arch_stands(thickness=thickness, voussoirs=voussoirs, friction=1.02 * least)
    assert not arch_stands(thickness=thickness, voussoirs=voussoirs, friction=0.98 * least)


@pytest.mark.parametrize(
    ("friction", "least"),
    [(0.39, 0.11107), (0.38, 0.12055), (0.36, 0.14030), (0.34, 0.16116), (0.32, 0.18322)],
)
def test_a3_4_least_thickness_with_friction(friction: float, least: float) -> None:
    assert arch_stands(thickness=1.02 * least, voussoirs=27, friction=friction)
    assert not arch_stands(thickness=0.98 * least, voussoirs=27, friction=friction)


@pytest.mark.parametrize(("thickness", "voussoirs"), ACCELERATION)
@pytest.mark.parametrize("friction", [5.0, 0.6])
def test_a3_5_horizontal_acceleration(thickness: float, voussoirs: int, friction: float) -> None:
    limit = ACCELERATION[thickness, voussoirs]

    def holds(share: float) -> bool:
        return arch_stands(
            thickness=thickness,
            voussoirs=voussoirs,
            friction=friction,
            loads=Loads(gravity=(share * limit * G, -G)),
        )

    assert holds(0.98)
    assert not holds(1.02)


POINT = {(11, 2): 1.32869, (11, 3): 0.53642, (11, 4): 0.40189, (11, 5): 0.83880,
         (20, 3): 4.27375, (20, 6): 0.47996, (20, 8): 0.35273}  # fmt: skip


def loaded(voussoirs: int, k: int, factor: float) -> bool:
    """Whether the arch of t = .2 R stands under a force at the centroid of a voussoir, over its weight."""
    weight = 0.2 * np.pi * STONE.density * G
    force = PointForce(block=f"arch.v{k + 1:02d}", vector=(0.0, -factor * weight))
    return arch_stands(thickness=0.2, voussoirs=voussoirs, loads=Loads(gravity=(0.0, -G), points=(force,)))


@pytest.mark.parametrize(("voussoirs", "k"), POINT)
def test_a3_6_point_load(voussoirs: int, k: int) -> None:
    limit = POINT[voussoirs, k]
    assert loaded(voussoirs, k, 0.98 * limit)
    assert not loaded(voussoirs, k, 1.02 * limit)


@pytest.mark.parametrize(("voussoirs", "k"), [(11, 0), (11, 1), (20, 2)])
def test_a3_6_loads_over_the_haunches_have_no_limit(voussoirs: int, k: int) -> None:
    assert loaded(voussoirs, k, 100.0)


def spread(thickness: float, share: float) -> RunResult:
    """Supports drawn apart to ``share`` of the spread at collapse, the last tenth in small steps."""
    slowly = Table(points=((0.0, 0.0), (0.5, share - 0.1), (1.0, share)))
    supports = tuple(
        Support(
            on=f"arch.springing_{side}",
            motion=Motion(displacement=(sign * SPREAD[thickness] / 2, 0.0), time=slowly),
        )
        for side, sign in (("left", -1.0), ("right", 1.0))
    )
    return arch(
        thickness=thickness,
        voussoirs=20,
        analysis=Statics(load_steps=20),
        loads=Loads(gravity=(0.0, -G), gravity_time=Table(points=((0.0, 1.0),))),
        supports=supports,
        solver=Solver(),
    )


@pytest.mark.slow
@pytest.mark.parametrize("thickness", SPREAD)
def test_a3_7_supports_that_spread(thickness: float) -> None:
    """Three hinges until the thrust reaches the springings: collapse within 1 % of the expected spread.

    Where it stands the displaced arch is statically determinate: limit analysis on the joints that are
    closed leaves no interval, and gives the thrust of the last step (at whose end its forces balance).
    """
    result = spread(thickness, 0.99)
    assert result.outcome == "equilibrium"
    model = result.built.model
    problem = limit_problem(model, group_forces(model, {"gravity": 1.0}), bodies=result.march.state.bodies)
    left = [block.name for block in model.assembly.blocks].index("arch.springing_left")
    found = interval(problem, support_resultant(problem, left, axis=0))
    assert found.high == pytest.approx(found.low, rel=1e-6)
    assert thrust(result) * STONE.density * G == pytest.approx(found.low, rel=1e-6)
    assert spread(thickness, 1.01).outcome == "no_equilibrium"


@pytest.mark.parametrize(
    ("inset", "expected"),
    [(1.0, True), (0.95, True), (0.75, True), (0.60, True), (0.57, False), (0.50, False)],
)
def test_a8_1_points_moved_inwards(inset: float, expected: bool) -> None:
    """The slides' ξ: 0.95 and 0.75 stand, 0.50 falls; the critical ξ of this arch is 0.5833."""
    assert arch_stands(thickness=0.18, voussoirs=11, inset=inset) is expected


@pytest.mark.parametrize("friction", [0.6, 0.4])
def test_a8_1_critical_inset_hangs_on_no_friction(friction: float) -> None:
    assert arch_stands(thickness=0.18, voussoirs=11, inset=0.60, friction=friction)
    assert not arch_stands(thickness=0.18, voussoirs=11, inset=0.57, friction=friction)


@pytest.mark.parametrize(
    ("inset", "low", "high"),
    [
        (1.0, 0.089763, 0.138426),
        (0.95, 0.092031, 0.135356),
        (0.75, 0.101671, 0.123372),
        (0.60, 0.109556, 0.111923),
    ],
)
def test_a8_1_thrust_intervals(inset: float, low: float, high: float) -> None:
    result = arch(thickness=0.18, voussoirs=11, inset=inset)
    assert low * 0.999 <= thrust(result) <= high * 1.001


@pytest.mark.parametrize("voussoirs", [7, 20])
def test_a9_6_no_friction_no_arch(voussoirs: int) -> None:
    assert not arch_stands(thickness=0.3, voussoirs=voussoirs, friction=0.0)
