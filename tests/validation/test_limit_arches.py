"""A3, A8.1 by limit analysis: semicircular arches, R = 1, to the digits of the expected figures."""

from __future__ import annotations

import numpy as np
import pytest

from masonry_fem.limit import (
    LimitProblem,
    admissible,
    collapse_multiplier,
    interval,
    support_resultant,
)
from tests.limit.scenes import GAMMA, accelerated, arch, number, problem, pushed, weight

NO_SLIP = 100.0
DIGIT = 6e-6  # half of the last digit of figures with five of them, and a little

T_MIN = {
    5: 0.09661, 7: 0.09625, 8: 0.10086, 9: 0.10213, 10: 0.10746, 11: 0.10491, 13: 0.10284, 15: 0.10627,
    16: 0.10724, 20: 0.10746, 21: 0.10679, 25: 0.10703, 27: 0.10678, 31: 0.10718, 41: 0.10731, 51: 0.10737,
    101: 0.10745,
}  # fmt: skip
THRUST = {
    (20, 0.11): (0.067803, 0.068969), (20, 0.12): (0.071890, 0.078149), (20, 0.15): (0.082526, 0.106975),
    (20, 0.2): (0.096589, 0.159958), (20, 0.3): (0.110973, 0.281970), (11, 0.12): (0.070801, 0.078700),
    (11, 0.15): (0.081382, 0.107058), (11, 0.2): (0.094247, 0.160027), (11, 0.3): (0.105572, 0.282367),
}  # fmt: skip


def stands(thickness: float, voussoirs: int, friction: float = NO_SLIP, **keys) -> bool:
    return admissible(problem(arch(thickness, voussoirs, friction, **keys))).holds


def thrust(made: LimitProblem) -> tuple[float, float]:
    """Interval of the left springing's horizontal force over γR²."""
    found = interval(made, support_resultant(made, number(made, "arch.springing_left"), axis=0))
    return found.low / GAMMA, found.high / GAMMA


@pytest.mark.parametrize("voussoirs", T_MIN)
def test_a3_2_least_thickness(voussoirs: int) -> None:
    assert stands(T_MIN[voussoirs] + DIGIT, voussoirs)
    assert not stands(T_MIN[voussoirs] - DIGIT, voussoirs)


@pytest.mark.parametrize("voussoirs", [30, 40, 61, 101])
def test_a3_8_no_cut_needs_more_than_the_continuous_arch(voussoirs: int) -> None:
    assert stands(0.10749, voussoirs)


@pytest.mark.parametrize(("voussoirs", "thickness"), THRUST)
def test_a3_3_thrust(voussoirs: int, thickness: float) -> None:
    made = problem(arch(thickness, voussoirs, NO_SLIP))
    assert thrust(made) == pytest.approx(THRUST[voussoirs, thickness], abs=0.6e-6)


def test_a3_3_thrust_in_newtons() -> None:
    """The public example of R = 1, t = .2, 11 voussoirs, depth .3 m, ρg = 23 544 N/m³."""
    low, high = thrust(problem(arch(0.2, 11, NO_SLIP)))
    assert (low * 0.3 * 23544, high * 0.3 * 23544) == pytest.approx((665.7, 1130.3), abs=0.06)


@pytest.mark.parametrize(
    ("thickness", "voussoirs", "least"),
    [
        (0.2, 27, 0.30899), (0.4, 27, 0.30899), (0.15, 27, 0.35057), (0.12, 27, 0.38058),
        (0.1095, 27, 0.39168), (0.2, 11, 0.30703),
    ],
)  # fmt: skip
def test_a3_4_least_friction(thickness: float, voussoirs: int, least: float) -> None:
    assert stands(thickness, voussoirs, least + DIGIT)
    assert not stands(thickness, voussoirs, least - DIGIT)


@pytest.mark.parametrize(
    ("friction", "least"),
    [(0.395, 0.10678), (0.39, 0.11107), (0.38, 0.12055), (0.36, 0.14030), (0.34, 0.16116), (0.32, 0.18322)],
)
def test_a3_4_least_thickness_with_friction(friction: float, least: float) -> None:
    assert stands(least + DIGIT, 27, friction)
    assert not stands(least - DIGIT, 27, friction)


@pytest.mark.parametrize(
    ("friction", "high"), [(0.6, 0.160027), (0.4, 0.125664), (0.35, 0.109956), (0.32, 0.100531)]
)
def test_a3_4_sliding_at_the_springing_bounds_the_thrust(friction: float, high: float) -> None:
    """H ≤ μ W/2 where that is less than the upper bound without sliding."""
    made = problem(arch(0.2, 11, friction))
    assert thrust(made) == pytest.approx((0.094247, high), abs=0.6e-6)
    assert high == pytest.approx(min(0.160027, friction * weight(made) / GAMMA / 2), abs=0.6e-6)


@pytest.mark.parametrize(
    ("thickness", "voussoirs", "limit", "weak"),
    [
        (0.2, 11, 0.29556, 0.10173), (0.2, 20, 0.28520, 0.10021), (0.15, 15, 0.14975, 0.05444),
        (0.12, 27, 0.04818, 0.02092),
    ],
)  # fmt: skip
def test_a3_5_horizontal_acceleration(thickness: float, voussoirs: int, limit: float, weak: float) -> None:
    for friction, expected in ((NO_SLIP, limit), (0.6, limit), (0.4, weak)):
        found = collapse_multiplier(problem(arch(thickness, voussoirs, friction), accelerated(1.0, 0.0)))
        assert found.multiplier == pytest.approx(expected, abs=DIGIT)
        assert found.gap < 1e-9


POINT = {
    11: {2: 1.32869, 3: 0.53642, 4: 0.40189, 5: 0.83880},
    20: {3: 4.27375, 4: 1.30967, 5: 0.70897, 6: 0.47996, 7: 0.37820, 8: 0.35273, 9: 0.41700},
}  # fmt: skip


@pytest.mark.parametrize(("voussoirs", "k"), [(n, k) for n, limits in POINT.items() for k in limits])
def test_a3_6_point_load(voussoirs: int, k: int) -> None:
    """A vertical force at the centroid of one voussoir, over the weight of the arch."""
    made = _loaded(voussoirs, k)
    found = collapse_multiplier(made)
    assert found.multiplier == pytest.approx(POINT[voussoirs][k], abs=DIGIT)
    assert found.mechanism is not None
    if 2 * k + 1 != voussoirs:  # a load on the crown turns both halves alike
        assert [joint.how for joint in found.mechanism.joints] == ["hinge"] * 4
        assert len(found.mechanism.groups) == 3


@pytest.mark.parametrize(("voussoirs", "k"), [(11, 0), (11, 1), (20, 0), (20, 2)])
def test_a3_6_loads_over_the_haunches_have_no_limit(voussoirs: int, k: int) -> None:
    assert collapse_multiplier(_loaded(voussoirs, k)).multiplier == np.inf


def _loaded(voussoirs: int, k: int) -> LimitProblem:
    made = arch(0.2, voussoirs, NO_SLIP)
    own = weight(problem(made))
    return problem(made, pushed(f"arch.v{k + 1:02d}", (0.0, -own)))


CRITICAL = {
    0.15: {7: 0.64187, 11: 0.69970, 15: 0.70878, 20: 0.71673, 27: 0.71215},
    0.18: {7: 0.53504, 11: 0.58330, 15: 0.59089, 20: 0.59753, 27: 0.59368},
    0.2: {7: 0.48164, 11: 0.52512, 15: 0.53198, 20: 0.53795, 27: 0.53447},
    0.25: {7: 0.38555, 11: 0.42045, 15: 0.42599, 20: 0.43077, 27: 0.42794},
}


@pytest.mark.parametrize(("thickness", "voussoirs"), [(t, n) for t, row in CRITICAL.items() for n in row])
def test_a8_critical_inset(thickness: float, voussoirs: int) -> None:
    critical = CRITICAL[thickness][voussoirs]
    assert stands(thickness, voussoirs, inset=critical + DIGIT)
    assert not stands(thickness, voussoirs, inset=critical - DIGIT)


@pytest.mark.parametrize(
    ("inset", "expected"),
    [
        (1.0, (0.089763, 0.138426)), (0.95, (0.092031, 0.135356)), (0.75, (0.101671, 0.123372)),
        (0.60, (0.109556, 0.111923)),
    ],
)  # fmt: skip
def test_a8_1_thrust_of_the_slides(inset: float, expected: tuple[float, float]) -> None:
    found = thrust(problem(arch(0.18, 11, NO_SLIP, inset=inset)))
    assert found == pytest.approx(expected, abs=0.6e-6)


@pytest.mark.parametrize("friction", [NO_SLIP, 0.6, 0.4])
def test_a8_1_critical_inset_hangs_on_no_friction(friction: float) -> None:
    assert stands(0.18, 11, friction, inset=0.58330 + DIGIT)
    assert not stands(0.18, 11, friction, inset=0.58330 - DIGIT)
    assert not stands(0.18, 11, friction, inset=0.5)
