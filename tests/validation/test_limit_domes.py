"""A5.1, A5.3 by conic programs: a hemispherical dome, R = 1, as a lune between planes of symmetry.

The planes bear pressure and no friction: hoops push and never pull. The dome's stones are cut by chords;
their weights and levers are replaced by those of exact spherical wedges where figures are wanted to
their digits. What is left of the chords is the width of the lune: a tenth of a degree.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from masonry_fem.limit import LimitProblem, admissible, interval, support_resultant
from masonry_fem.scene.specs import Joint, Scene
from masonry_fem.structures.dome import DomeStructure
from tests.limit.scenes import GAMMA, number, problem, scene

EYE = 1e-2  # oculus [deg]: joints then lie at equal angles from the springing to the crown


def lune(thickness: float, rings: int, sweep: float, oculus: float = EYE) -> Scene:
    dome = DomeStructure(
        name="dome", material="stone", radius=1.0, thickness=thickness, rings=rings, slices=1, sweep=sweep,
        oculus=oculus, sides=True,
    )  # fmt: skip
    joints = (Joint(friction=100.0), Joint(friction=0.0, interface="meridian"))
    return scene(dome, dimension=3, joints=joints)


def exact(thickness: float, rings: int, sweep: float = 0.1) -> LimitProblem:
    """The lune with the weights of spherical wedges."""
    made = problem(lune(thickness, rings, sweep))
    names = [f"dome.r{ring + 1}.s1" for ring in range(rings)]
    assert [number(made, name) for name in names] == made.blocks.tolist()
    low, high, width = 1 - thickness / 2, 1 + thickness / 2, np.radians(sweep)
    angle = np.linspace(np.pi / 2, np.radians(EYE), rings + 1)
    weight = GAMMA * width * (high**3 - low**3) / 3 * np.diff(np.cos(angle))
    second = -np.diff(angle / 2 - np.sin(2 * angle) / 4)
    lever = GAMMA * width * (high**4 - low**4) / 4 * second / weight * np.sin(width / 2) / (width / 2)
    wrench = np.zeros((rings, 6))
    wrench[:, 2] = -weight
    at = lever[:, None] * [np.cos(width / 2), np.sin(width / 2)] - made.centre[:, :2]
    wrench[:, 3] = at[:, 1] * -weight
    wrench[:, 4] = -at[:, 0] * -weight
    scale = made.force * np.array([1, 1, 1, *[made.length] * 3])
    return replace(made, dead=(wrench / scale).ravel())


def thrust(made: LimitProblem, sweep: float) -> tuple[float, float, float]:
    """Least thrust and weight per radian of longitude over γR³; between them the greatest thrust [N]."""
    width, base = np.radians(sweep), number(made, "dome.base.s1")
    x, y, z = (support_resultant(made, base, axis) for axis in range(3))
    found = interval(made, -(np.cos(width / 2) * x + np.sin(width / 2) * y))
    return found.low / width / GAMMA, found.high, interval(made, z).low / width / GAMMA


@pytest.mark.parametrize(
    ("rings", "least"), [(9, 0.04204), (10, 0.04184), (18, 0.04266), (30, 0.04281), (45, 0.04281)]
)
def test_a5_1_least_thickness(rings: int, least: float) -> None:
    assert admissible(exact(least + 1e-5, rings)).holds
    assert not admissible(exact(least - 1e-5, rings)).holds


@pytest.mark.parametrize("sweep", [1.0, 5.0])
def test_a5_1_stones_cut_by_chords(sweep: float) -> None:
    """18 rings: the chords of 5 degrees take 0.15 % off the least thickness."""
    assert admissible(problem(lune(1.002 * 0.04266, 18, sweep))).holds
    assert not admissible(problem(lune(0.997 * 0.04266, 18, sweep))).holds


@pytest.mark.parametrize(
    ("thickness", "least", "share"),
    [(0.05, 0.011693, 0.2338), (0.1, 0.019469, 0.1945), (0.15, 0.024265, 0.1615)],
)
def test_a5_3_least_thrust(thickness: float, least: float, share: float) -> None:
    """The figures are those of 45 rings; 180 rings have up to 3e-4 more.

    Hoops bear any pressure: only friction at the base bounds the thrust from above.
    """
    low, high, weight = thrust(exact(thickness, 45), 0.1)
    assert low == pytest.approx(least, abs=0.6e-6)
    assert low / weight == pytest.approx(share, abs=1e-4)
    assert weight == pytest.approx(thickness * (1 + thickness**2 / 12), rel=1e-6)
    assert high == pytest.approx(100.0 * weight * GAMMA * np.radians(0.1), rel=1e-6)
