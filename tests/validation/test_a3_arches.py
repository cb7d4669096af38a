"""A3: semicircular arches of rigid voussoirs; A8: contact points moved inwards.

A structure stands where one step from rest leaves it at rest: with v = 0 every statically
admissible set of reactions solves Signorini-Coulomb, so the step is a limit analysis.
"""

from __future__ import annotations

import numpy as np
import pytest

from masonry_fem.run import RunResult
from masonry_fem.scene.specs import Equilibrium, Loads, Motion, Statics, Support
from tests.validation.scenes import STONE, G, rigid_arch

ONE_STEP = Equilibrium(strategy="large_step", step=0.01, max_steps=3, tolerance=1e-6)
T_MIN = {5: 0.09661, 7: 0.09625, 9: 0.10213, 11: 0.10491, 15: 0.10627, 20: 0.10746, 27: 0.10678, 101: 0.10745}
THRUST = {
    (20, 0.12): (0.071890, 0.078149),
    (20, 0.2): (0.096589, 0.159958),
    (11, 0.12): (0.070801, 0.078700),
    (11, 0.2): (0.094247, 0.160027),
}
ACCELERATION = {(0.2, 11): 0.29556, (0.2, 20): 0.28520, (0.15, 15): 0.14975}


def stands(**keys) -> bool:
    return arch(**keys).outcome == "equilibrium"


def arch(**keys) -> RunResult:
    return rigid_arch(**({"friction": 5.0, "analysis": ONE_STEP} | keys))


def thrust(result: RunResult) -> float:
    """Horizontal force of the left springing over γR² (R = 1 m)."""
    return float(np.abs(result.summary["supports"]["arch.springing_left"]["force"][0])) / (STONE.density * G)


@pytest.mark.parametrize("voussoirs", T_MIN)
def test_a3_2_least_thickness(voussoirs: int) -> None:
    t = T_MIN[voussoirs]
    assert stands(thickness=1.01 * t, voussoirs=voussoirs)
    assert not stands(thickness=0.99 * t, voussoirs=voussoirs)


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


@pytest.mark.parametrize(("thickness", "voussoirs"), ACCELERATION)
@pytest.mark.parametrize("friction", [5.0, 0.6])
def test_a3_5_horizontal_acceleration(thickness: float, voussoirs: int, friction: float) -> None:
    limit = ACCELERATION[thickness, voussoirs]

    def holds(share: float) -> bool:
        return stands(
            thickness=thickness,
            voussoirs=voussoirs,
            friction=friction,
            loads=Loads(gravity=(share * limit * G, -G)),
        )

    assert holds(0.98)
    assert not holds(1.02)


@pytest.mark.parametrize(
    ("inset", "expected"),
    [(1.0, True), (0.95, True), (0.75, True), (0.60, True), (0.57, False), (0.50, False)],
)
def test_a8_1_points_moved_inwards(inset: float, expected: bool) -> None:
    """The slides' ξ: 0.95 and 0.75 stand, 0.50 falls; the critical ξ of this arch is 0.5833."""
    assert stands(thickness=0.18, voussoirs=11, inset=inset) is expected


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
    assert not stands(thickness=0.3, voussoirs=voussoirs, friction=0.0)
