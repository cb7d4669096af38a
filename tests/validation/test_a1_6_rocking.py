"""A1.6: Housner's free rocking of a rigid block, whatever the step (A9.8)."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from masonry_fem.build import build
from masonry_fem.march.march import march
from masonry_fem.nscd import SolverSettings
from masonry_fem.scene import check
from masonry_fem.scene.specs import Contact as Reach
from masonry_fem.scene.specs import Dynamics, Joint, Loads, Scene
from masonry_fem.structures.block import BlockStructure
from tests.validation.scenes import STONE, G

ALPHA = float(np.arctan(0.25))
LOSS = 1 - 1.5 * np.sin(ALPHA) ** 2  # ω⁺/ω⁻ = 0.911765


class Spin:
    """Observer that keeps the spin [rad/s] and turn [rad] of the only free block (2D)."""

    def __init__(self) -> None:
        self.spin: list[float] = []
        self.turn: list[float] = []

    def record(self, model, state, report) -> None:
        for group, own in zip(model.groups, state.bodies, strict=True):
            if not group.prescribed:
                self.spin.append(float(own.velocity[0, 2] / np.sqrt(group.inertia[0, 0])))
                self.turn.append(float(np.arctan2(own.rotation[0, 1, 0], own.rotation[0, 0, 0])))


def rocking(share: float, h: float, duration: float) -> Spin:
    """0.5 × 2 m block let go at θ0 = share · α about its lower left corner, on a rigid floor."""
    scene = check(
        Scene(
            dimension=2,
            fidelity="rigid",
            materials={"stone": STONE},
            structures=(
                BlockStructure(
                    name="ground", material="stone", size=(4.0, 0.5), position=(-2.0, -0.5), support=True
                ),
                # turned about its lower left corner, which stays on the ground
                BlockStructure(
                    name="post", material="stone", size=(0.5, 2.0), rotation=float(np.degrees(share * ALPHA))
                ),
            ),
            contact=Reach(reach=0.3, angle=15.0),
            joints=(Joint(friction=5.0, form="velocity"),),
            loads=Loads(gravity=(0, -G)),
            analysis=Dynamics(step=h, duration=duration, theta=0.5),
        )
    )
    built, seen = build(scene, Path()), Spin()
    plan = scene.analysis
    march(built.model, plan, SolverSettings(tolerance=1e-12), observers=(seen,))
    return seen


class Impact:
    """First impact of a rocking block.

    time : By the tilt left at the start of the step of the impact. spin : There.
    ratio : ω⁺/ω⁻: the step gives the impulse of the impact and of gravity about the new corner
    together; what the next step gives is taken off.
    """

    def __init__(self, seen: Spin, share: float, h: float) -> None:
        spin, tilt = np.abs(seen.spin), np.array(seen.turn) + share * ALPHA
        last = int(np.argmax(spin))  # before the spin drops
        self.spin = spin[last]
        self.time = h * (last + 1) + tilt[last] / spin[last]
        self.ratio = (2 * spin[last + 1] - spin[last + 2]) / spin[last]
        self.next_share = np.abs(tilt[last:]).max() / ALPHA


@pytest.mark.slow
@pytest.mark.parametrize(
    ("share", "time", "speed", "next_share"),
    [
        (0.1, 0.175589, 0.284000, 0.082381),
        (0.3, 0.336169, 0.465667, 0.241154),
        (0.5, 0.493803, 0.565045, 0.386714),
        (0.8, 0.858640, 0.639612, 0.551345),
    ],
)
def test_a1_6_housner_rocking(share: float, time: float, speed: float, next_share: float) -> None:
    """Time to the first impact and spin there to 0.5 %, its loss to 1 %, the next amplitude to 2 %."""
    h = 1e-3
    impact = Impact(rocking(share, h, 2.2 * time), share, h)
    assert impact.time == pytest.approx(time, rel=5e-3)
    assert impact.spin == pytest.approx(speed, rel=5e-3)
    assert impact.ratio == pytest.approx(LOSS, rel=1e-2)
    assert impact.next_share == pytest.approx(next_share, rel=2e-2)


@pytest.mark.slow
def test_a1_6_loss_is_met_to_first_order() -> None:
    """At θ0 = 0.1 α: 3.2e-4 at h = 4e-3, and half of it for half the step."""
    steps = (2e-3, 1e-3, 5e-4, 2.5e-4)
    impacts = [Impact(rocking(0.1, h, 0.19), 0.1, h) for h in steps]
    errors = np.array([abs(impact.ratio / LOSS - 1) for impact in impacts])
    assert errors[1] < 2e-4
    assert np.log2(errors[:-1] / errors[1:]) == pytest.approx(np.ones(3), abs=0.15)
    # the time is met far below its step
    assert [impact.time for impact in impacts] == pytest.approx([0.175589] * 4, rel=5e-4)


@pytest.mark.slow
@pytest.mark.parametrize("h", [1e-2, 1e-4])
def test_a9_8_rocking_with_coarse_and_fine_steps(h: float) -> None:
    """A1.6 at steps a hundred times apart: the time to the first impact within a step and 0.5 %."""
    seen = rocking(0.1, h, 0.175589 + 3 * h)
    assert np.isfinite(seen.spin).all()
    impact = int(np.argmax(np.abs(seen.spin)))
    assert h * (impact + 1) == pytest.approx(0.175589, rel=5e-3, abs=h)
