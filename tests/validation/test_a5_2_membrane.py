"""A5.2: a thin bonded dome of elastic stones on a base without friction carries its weight as a membrane.

    N_φ = −q R/(1 + cos φ),    N_θ = q R (1/(1 + cos φ) − cos φ),    q = γ t

φ from the crown; along the parallels it pulls beyond 51.83°. The lowest two of the 18 rings are left out:
the bed of the base keeps them from turning, which bends them.
"""

from __future__ import annotations

import numpy as np
import pytest

from masonry_fem.analyses.run import solve_scene
from masonry_fem.scene.specs import Joint, Loads, Material, MeshSettings, Scene
from masonry_fem.structures.dome import DomeStructure
from tests.validation.domes import BONDED, GAMMA, PLANE, RADIUS, G, lune, mean_stresses, membrane

THIN = 0.1  # t/R = 0.02
BENT = 79.0  # [deg] from here down the base bends the shell


def test_a5_2_membrane_stresses() -> None:
    result = lune(thickness=THIN, meridian=PLANE, beds=BONDED, element="Q2")
    assert result.outcome == "equilibrium"
    angle, along_meridian, along_parallel = mean_stresses(result).T
    inside = (angle > 2.5) & (angle < BENT)
    assert inside.sum() == 16
    exact_meridian, exact_parallel = membrane(angle)
    assert along_meridian[inside] == pytest.approx(exact_meridian[inside], rel=0.01)
    assert along_parallel[inside] == pytest.approx(exact_parallel[inside], rel=0.05)
    assert along_parallel[~inside] == pytest.approx(exact_parallel[~inside], rel=0.08)
    # where the parallels begin to pull
    crossing = np.interp(0.0, along_parallel, angle)
    assert crossing == pytest.approx(51.83, abs=0.3)


@pytest.mark.slow
def test_a5_2_a_whole_dome_is_as_its_lune() -> None:
    """24 slices of 12 rings, all bonded: alike in each slice, and a membrane between eye and base."""
    scene = Scene(
        materials={"stone": Material(density=GAMMA / G, young=10e9, poisson=0.0)},
        structures=(
            DomeStructure(
                name="dome", material="stone", radius=RADIUS, thickness=THIN, rings=12, slices=24, oculus=5.0
            ),
        ),
        mesh=MeshSettings(element="Q2", divisions=(1, 1, 1)),
        joints=(
            Joint(law=BONDED),
            Joint(friction=0.0, between=("dome.base.*", "dome.r1.*"), interface="bed"),
        ),
        loads=Loads(gravity=(0.0, 0.0, -G)),
    )
    result = solve_scene(scene)
    assert result.outcome == "equilibrium"
    assert result.summary.shapes == 12
    angle, along_meridian, along_parallel = np.moveaxis(mean_stresses(result).reshape(12, 24, 3), 2, 0)
    assert np.ptp(along_parallel, axis=1).max() < 1e-6 * np.abs(along_parallel).max()
    inside = (angle[:, 0] > 25) & (angle[:, 0] < BENT - 4)
    eye, c = np.cos(np.radians(5.0)), np.cos(np.radians(angle[inside, 0]))
    exact = -GAMMA * RADIUS * (eye - c) / (1 - c**2)  # nothing presses on the eye's rim
    assert along_meridian[inside, 0] == pytest.approx(exact, rel=0.02)
    expected = -GAMMA * RADIUS * c - exact
    assert along_parallel[inside, 0] == pytest.approx(expected, abs=0.02 * GAMMA * RADIUS)
