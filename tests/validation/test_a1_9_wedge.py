"""A1.9: a wedge between fixed faces: keystone reactions, friction interval, self-locking.

An arch of a single voussoir is a wedge of half angle ``embrace / 2`` between its springings.
"""

from __future__ import annotations

import numpy as np
import pytest

from masonry_fem.analyses.run import RunResult
from masonry_fem.scene.specs import (
    Dynamics,
    Equilibrium,
    Joint,
    Loads,
    MeshSettings,
    PointForce,
    Table,
)
from masonry_fem.structures.arch import ArchStructure
from tests.validation.scenes import G, solved

ONE_STEP = Equilibrium(strategy="large_step", step=0.01, max_steps=3, tolerance=1e-9)


def keystone(half_angle: float, friction: float, **keys) -> RunResult:
    return solved(
        **{
            "dimension": 2,
            "fidelity": "rigid",
            "structures": (
                ArchStructure(
                    name="key",
                    material="stone",
                    radius=2.0,
                    thickness=0.5,
                    voussoirs=1,
                    embrace=2 * half_angle,
                ),
            ),
            "joints": (Joint(friction=friction),),
            "analysis": ONE_STEP,
        }
        | keys
    )


def reactions(result: RunResult) -> tuple[float, float]:
    """Thrust and resultant of the left face over the weight."""
    weight = result.built.model.groups[1].mass.sum() * G
    force = result.summary.supports["key.springing_left"].force / weight
    return float(force[0]), float(np.linalg.norm(force))


@pytest.mark.parametrize(
    ("half_angle", "normal", "thrust"),
    [(10, 2.879385, 2.835641), (20, 1.461902, 1.373739), (30, 1.0, 0.866025), (1, None, None)],
)
def test_frictionless_keystone(half_angle: float, normal: float | None, thrust: float | None) -> None:
    """N = W/(2 sin a), H = W/(2 tan a); the last row is A9.10's wedge of one degree."""
    a = np.radians(half_angle)
    found = reactions(keystone(half_angle, 0.0))
    assert found[1] == pytest.approx(1 / (2 * np.sin(a)), rel=1e-8)
    assert found[0] == pytest.approx(1 / (2 * np.tan(a)), rel=1e-8)
    if normal is not None:
        assert found == pytest.approx((thrust, normal), abs=1e-6)


@pytest.mark.parametrize(
    ("half_angle", "friction", "most"),
    [(30, 0.2, 1.478030), (20, 0.2, 3.271307), (20, 0.3, 8.669587), (10, 0.6, np.inf)],
)
def test_thrust_lies_in_its_friction_interval(half_angle: float, friction: float, most: float) -> None:
    """H between W/(2 tan(a+φ)) and W/(2 tan(a−φ)), its most; no upper bound where a ≤ φ."""
    a, phi = np.radians(half_angle), np.arctan(friction)
    result = keystone(half_angle, friction)
    assert result.outcome == "equilibrium"
    thrust, _ = reactions(result)
    assert (1 - 1e-6) / (2 * np.tan(a + phi)) <= thrust <= (1 + 1e-6) * most
    vertical = sum(support.force[1] for support in result.summary.supports.values())
    assert vertical == pytest.approx(result.built.model.groups[1].mass.sum() * G, rel=1e-9)


@pytest.mark.parametrize(
    ("half_angle", "share", "least", "most"),
    [
        (10, 0.9, 0, 1e-6), (20, 0.9, 0, 1e-6), (30, 0.9, 0, 1e-6),
        (10, 1.1, 0.05, np.inf), (20, 1.1, 0.05, np.inf), (30, 1.1, 0, 1e-6),
    ],
)  # fmt: skip
def test_wedge_locks_itself_where_friction_exceeds_its_tangent(
    half_angle: float, share: float, least: float, most: float
) -> None:
    """Pushed in without weight and let go: it stays pressed iff tan a ≤ µ, else it is expelled.

    At 30° a friction above the tangent keeps the elastic wedge from sliding in at all (it sticks at
    0.56 µN): it springs back without load, and there is nothing to lock. Its last impulses are then
    rounding of the largest, which no error may be measured by.
    """
    friction = share * np.tan(np.radians(half_angle))
    push = 1e6
    result = keystone(
        half_angle,
        friction,
        fidelity="elastic",
        mesh=MeshSettings(divisions=(2, 2)),
        loads=Loads(
            points=(
                PointForce(
                    block="key.v01",
                    vector=(0.0, -push),
                    time=Table(points=((0.0, 0.0), (0.5, 1.0), (1.0, 0.0))),
                ),
            )
        ),
        # dynamics at a slow pace: without load and without lock nothing holds the wedge
        analysis=Dynamics(step=0.05, duration=1.2, theta=1.0),
    )
    assert result.outcome == "finished"
    left = np.linalg.norm(result.summary.supports["key.springing_left"].force) / push
    assert least <= left <= most
