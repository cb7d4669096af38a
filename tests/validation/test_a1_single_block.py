"""A1: one rigid block against closed forms (validation cases A1.1 to A1.5, A1.7, A1.8)."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from masonry_fem.build import build
from masonry_fem.march.march import march
from masonry_fem.nscd import SolverSettings
from masonry_fem.scene import check
from masonry_fem.scene.specs import Contact as Reach
from masonry_fem.scene.specs import Dynamics, Initial, Joint, Loads, PointForce, Probe, Scene
from masonry_fem.structures.stack import StackStructure
from tests.validation.scenes import STONE, G, cube_on_slope, solved

CRITICAL = {0.5: 26.56505, 0.6: 30.96376, 0.7: 34.99202}


@pytest.mark.parametrize("friction", CRITICAL)
def test_a1_1_stick_or_slip(friction: float) -> None:
    plan = Dynamics(step=0.1, duration=1.0, theta=1.0)
    sticks = cube_on_slope(CRITICAL[friction] - 0.05, friction, analysis=plan)
    slips = cube_on_slope(CRITICAL[friction] + 0.05, friction, analysis=plan)
    assert sticks.march.report.speed < 1e-10
    assert slips.march.report.speed > 1e-3
    assert slips.summary.status["slip"] > 0


@pytest.mark.parametrize(("theta", "expected"), [(1.0, 0.331858), (0.5, 0.328573)])
def test_a1_2_sliding_distance(theta: float, expected: float) -> None:
    """s_n = a h² n(n−1+2θ)/2 is algebra: the scheme meets it to rounding."""
    h, n = 0.01, 100
    result = cube_on_slope(
        30.0,
        0.5,
        analysis=Dynamics(step=h, duration=1.0, theta=theta),
        probes=(Probe(name="cube", block="cube.b1", point=(0.5, 0.5, 0.5)),),
    )
    a = G * (np.sin(np.pi / 6) - 0.5 * np.cos(np.pi / 6))
    exact = a * h**2 * n * (n - 1 + 2 * theta) / 2
    assert exact == pytest.approx(expected, abs=1e-6)
    assert result.summary.probes["cube"][0] == pytest.approx(exact, rel=1e-8)
    ground = result.summary.supports["cube.ground"].force
    weight = 2400 * G
    assert ground[2] == pytest.approx(weight * np.cos(np.pi / 6), rel=1e-8)
    assert ground[0] == pytest.approx(-0.5 * weight * np.cos(np.pi / 6), rel=1e-8)


def test_a1_3_pushed_block_stops() -> None:
    """v0 = 2, µ = 0.3: the θ = 1 sum of max(v0 − µ g h k, 0) h, then rest without reversal."""
    h = 0.01
    result = solved(
        fidelity="rigid",
        structures=(StackStructure(name="cube", material="stone", size=(1, 1, 1), count=1),),
        joints=(Joint(friction=0.3),),
        initial=(Initial(blocks="cube.b1", velocity=(2.0, 0, 0)),),
        analysis=Dynamics(step=h, duration=1.0, theta=1.0),
        probes=(Probe(name="cube", block="cube.b1", point=(0.5, 0.5, 0.5)),),
    )
    steps = np.arange(1, 101)
    expected = h * np.maximum(2 - 0.3 * G * h * steps, 0).sum()
    assert expected == pytest.approx(0.669585, abs=1e-6)
    assert result.summary.probes["cube"][0] == pytest.approx(expected, rel=1e-8)
    assert result.march.report.speed < 1e-12


@pytest.mark.parametrize(
    ("height", "friction", "moves"), [(0.5, 0.2, "slides"), (1.8, 0.1, "slides"), (1.8, 0.5, "tips")]
)
def test_a1_4_force_at_a_height(height: float, friction: float, moves: str) -> None:
    """B = 0.5, H = 2: slides at µW if µ < B/(2z), tips at W B/(2z) otherwise."""
    width, tall, z = 0.5, 2.0, height
    weight = 2400 * width * width * tall * G
    critical = {"slides": friction, "tips": width / (2 * z)}[moves] * weight

    def push(share: float):
        return solved(
            fidelity="rigid",
            structures=(StackStructure(name="post", material="stone", size=(width, width, tall), count=1),),
            joints=(Joint(friction=friction),),
            loads=Loads(
                gravity=(0, 0, -G),
                points=(
                    PointForce(
                        block="post.b1", vector=(share * critical, 0, 0), point=(width / 2, width / 2, z)
                    ),
                ),
            ),
            analysis=Dynamics(step=0.01, duration=0.1, theta=1.0),
        )

    assert push(0.99).march.report.speed < 1e-9
    moving = push(1.01)
    assert moving.march.report.speed > 1e-4
    spin = np.abs(moving.march.state.rigid_velocity[0, 3:]).max()
    if moves == "slides":  # by 1 % of the friction more than what holds it, and upright
        assert moving.march.report.speed == pytest.approx(0.01 * friction * G * 0.1, rel=1e-6)
        assert spin < 1e-9
    else:
        assert spin > 1e-4


def dropped(restitution: float, theta: float = 0.5, duration: float = 1.2, h: float = 1e-3):
    return solved(
        fidelity="rigid",
        structures=(StackStructure(name="cube", material="stone", size=(0.5, 0.5, 0.5), count=1, gap=1.0),),
        contact=Reach(reach=1.5),
        joints=(Joint(friction=0.5, restitution=restitution, form="velocity"),),
        analysis=Dynamics(step=h, duration=duration, theta=theta),
        probes=(Probe(name="cube", block="cube.b1", point=(0.25, 0.25, 1.25)),),
    )


@pytest.mark.slow
def test_a1_5_restitution_second_apex() -> None:
    """Drop of 1 m, e = 0.8: the second apex is 0.64 m high, 0.36 s after the impact."""
    first = np.sqrt(2 / G)
    apex = first + 0.8 * first
    result = dropped(0.8, duration=apex)
    height = 1.0 + result.summary.probes["cube"][2]
    assert height == pytest.approx(0.64, rel=0.01)


@pytest.mark.slow
def test_a1_5_no_restitution_rests_in_one_step() -> None:
    result = dropped(0.0, duration=0.6)
    assert result.march.report.speed < 1e-10
    assert 1.0 + result.summary.probes["cube"][2] == pytest.approx(0.0, abs=5e-3)


@pytest.mark.parametrize("psi", [0.0, 22.5, 45.0])
@pytest.mark.parametrize("share", [0.99, 1.01])
def test_a1_8_friction_is_isotropic(psi: float, share: float) -> None:
    a, mu = np.radians(psi), 0.4
    pull = share * mu * 2400 * G
    result = solved(
        fidelity="rigid",
        structures=(StackStructure(name="cube", material="stone", size=(1, 1, 1), count=1),),
        joints=(Joint(friction=mu),),
        # at the base, so that the cube does not tip
        loads=Loads(
            gravity=(0, 0, -G),
            points=(
                PointForce(
                    block="cube.b1", vector=(pull * np.cos(a), pull * np.sin(a), 0), point=(0.5, 0.5, 0.0)
                ),
            ),
        ),
        analysis=Dynamics(step=0.01, duration=0.05, theta=1.0),
    )
    assert result.outcome == "finished"
    speed = max(share - 1, 0.0) * mu * G * 0.05  # by what friction does not hold, along the pull, and upright
    expected = np.sqrt(2400) * np.array([speed * np.cos(a), speed * np.sin(a), 0, 0, 0, 0])  # by √mass
    assert result.march.state.rigid_velocity[0] == pytest.approx(expected, abs=1e-8)


def test_a1_7_uplift_or_sliding_under_base_acceleration() -> None:
    """b/h = 0.25: rocking starts at a/g = 0.25 where µ > 0.25; µ = 0.2 slides at 0.2 instead."""

    def moves(acceleration: float, friction: float) -> bool:
        result = solved(
            fidelity="rigid",
            structures=(StackStructure(name="post", material="stone", size=(0.5, 0.5, 2), count=1),),
            joints=(Joint(friction=friction),),
            loads=Loads(gravity=(acceleration * G, 0, -G)),
            analysis=Dynamics(step=0.01, duration=0.05, theta=1.0),
        )
        return result.march.report.speed > 1e-8

    assert not moves(0.25 * 0.995, 1.0)
    assert moves(0.25 * 1.005, 1.0)
    assert not moves(0.2 * 0.995, 0.2)
    assert moves(0.2 * 1.005, 0.2)


@pytest.mark.slow
def test_a1_5_bounces_end_at_zeno_s_time() -> None:
    """e = 0.8 from 1 m: infinitely many bounces in 4.063713 s; found to 2 %."""
    scene = drop(0.8, duration=4.6, gap=1.0)
    built, seen = build(check(scene), Path()), Heights()
    march(built.model, scene.analysis, SolverSettings(), observers=(seen,))
    moving = seen.time[np.array(seen.speed) > 1e-6]
    assert moving[-1] == pytest.approx(4.063713, rel=0.02)


@pytest.mark.slow
def test_a1_5_hundred_elastic_bounces_do_not_grow() -> None:
    """e = 1: the block goes on bouncing to its first height, which no bounce exceeds by 1 %."""
    scene = drop(1.0, duration=9.1, gap=0.01)
    built, seen = build(check(scene), Path()), Heights()
    march(built.model, scene.analysis, SolverSettings(), observers=(seen,))
    heights = 0.01 + np.array(seen.height)
    apexes = heights[1:-1][(heights[1:-1] > heights[:-2]) & (heights[1:-1] >= heights[2:])]
    assert len(apexes) >= 95
    assert apexes.max() <= 0.01 * 1.01
    assert heights.min() > -1e-3


class Heights:
    """Observer of the rise [m] and speed [m/s] of the only free block."""

    def __init__(self) -> None:
        self.steps: list[float] = []
        self.height: list[float] = []
        self.speed: list[float] = []

    @property
    def time(self) -> np.ndarray:
        return np.array(self.steps)

    def record(self, model, state, report) -> None:
        self.steps.append(report.time)
        self.speed.append(report.speed)
        self.height.append(float(report.probes["cube"][1]))


def drop(restitution: float, duration: float, gap: float) -> Scene:
    return Scene(
        dimension=2,
        fidelity="rigid",
        materials={"stone": STONE},
        structures=(StackStructure(name="cube", material="stone", size=(0.5, 0.5), count=1, gap=gap),),
        contact=Reach(reach=1.5 * gap),
        joints=(Joint(friction=0.5, restitution=restitution, form="velocity"),),
        loads=Loads(gravity=(0, -G)),
        analysis=Dynamics(step=1e-3, duration=duration, theta=0.5),
        probes=(Probe(name="cube", block="cube.b1", point=(0.25, gap)),),
    )


@pytest.mark.parametrize("share", [0.99, 1.01])
def test_a1_8_torque_on_four_corners(share: float) -> None:
    """A unit cube on its four corners turns about the vertical at M = µ W √2 / 2."""
    mu, weight = 0.4, 2400 * G
    pull = share * mu * weight * np.sqrt(2) / 2  # a couple of two forces one metre apart, at the base
    result = solved(
        fidelity="rigid",
        structures=(StackStructure(name="cube", material="stone", size=(1, 1, 1), count=1),),
        joints=(Joint(friction=mu),),
        loads=Loads(
            gravity=(0, 0, -G),
            points=(
                PointForce(block="cube.b1", vector=(0, pull, 0), point=(1.0, 0.5, 0.0)),
                PointForce(block="cube.b1", vector=(0, -pull, 0), point=(0.0, 0.5, 0.0)),
            ),
        ),
        analysis=Dynamics(step=0.01, duration=0.05, theta=1.0),
    )
    assert result.outcome == "finished"
    inertia = 2400 / 6
    spin = max(share - 1, 0.0) * pull / share / inertia * 0.05
    expected = [0, 0, 0, 0, 0, np.sqrt(inertia) * spin]
    # forces keep their direction while the cube turns by 2e-4: their arm shrinks by 2e-8
    assert result.march.state.rigid_velocity[0] == pytest.approx(expected, rel=1e-6, abs=1e-8)
