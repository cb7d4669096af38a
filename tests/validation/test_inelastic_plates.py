"""A block that yields, in plane strain between two rigid plates: smooth ones, and rough ones.

Smooth plates leave the stress uniform. On Drucker and Prager's cone the stress across the plane tends to
where flow strains nothing in this direction, so that with η, ξ and η̄ of the law the block bears

    q = 2 ξ c/((1 − η η̄/3)/√(1 − η̄²/3) − η),

which is 2 c cos φ/(1 − sin φ) with the fit ``plane_strain`` and associated flow. Mohr and Coulomb's law has
this strength with any flow. Rough plates add nothing where a band of slip passes between them, at 45° + φ/2.
On wider blocks a wedge of stone sticks to each plate; without friction of the stone the block bears what
``prandtl`` computes. A rigid plate, in contact with friction, comes down on a quarter of the block.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

from masonry_fem.analyses.run import solve_scene
from masonry_fem.scene.reading import check
from masonry_fem.scene.specs import (
    Joint,
    Loads,
    Material,
    MeshSettings,
    Motion,
    Scene,
    Statics,
    Support,
    Table,
    material_record,
)
from masonry_fem.structures.block import BlockStructure

C, PHI = 1e6, 30.0
ROUGH = 10.0  # a friction beyond what any point of the plates needs
CONE = {"law": "drucker_prager", "fit": "plane_strain"}
PYRAMID = {"law": "mohr_coulomb"}


def borne(
    size: tuple[float, float], cells: tuple[int, int], closing: float, *, friction: float, steps: int = 5,
    **keys: Any,
) -> float:  # fmt: skip
    """Mean pressure of the plate over C on a quarter of this size [m]; ``closing`` is over its height."""
    law = material_record(keys.pop("law"), cohesion=C, **keys)
    width, height = size
    ramp = Table(points=((0.0, 0.0), (1.0, 1.0)))
    result = solve_scene(
        check(
            Scene(
                dimension=2,
                fidelity="inelastic",
                materials={"m": Material(density=2000.0, young=1e10, poisson=0.3, inelastic=law)},
                structures=(
                    BlockStructure(
                        name="b", material="m", size=size, mesh=MeshSettings(element="Q2", divisions=cells)
                    ),
                    BlockStructure(name="plate", material="m", size=(width, 0.1), position=(0.0, height)),
                ),
                supports=(
                    Support(on="b/left", components=("x",)),
                    Support(on="b/bottom", components=("y",)),
                    Support(on="plate", motion=Motion(displacement=(0.0, -closing * height), time=ramp)),
                ),
                joints=(Joint(friction=friction),),
                loads=Loads(gravity=(0.0, 0.0)),
                analysis=Statics(load_steps=steps),
            )
        )
    )
    assert result.outcome == "equilibrium", result.message
    assert result.march.ledger.imbalance <= 1e-8
    return -float(result.summary.supports["plate"].force[1]) / width / C


def fans(angle: float, steps: int = 40) -> tuple[float, float]:
    """Width over height of a block whose fans of slip lines open by an ``angle``, and its pressure over c.

    Fans about the corners A and B of the free side, at (0, ±1), begin at N, at (-1, 0). The slip lines that
    follow are chords with the mean of the directions at their ends, which Hencky's equations give.
    """
    turn = np.linspace(0.0, angle, steps + 1)
    A, half = 1j, 0.5 * turn[1]
    net = np.zeros((steps + 1, steps + 1), dtype=complex)
    net[:, 0] = A - (1 + 1j) * np.exp(-1j * turn)
    net[0] = net[:, 0].conj()
    for i in range(1, steps + 1):
        for j in range(1, steps + 1):
            first = (1 + 1j) * np.exp(1j * (turn[j] - turn[i] - half))  # along the ray i of A
            second = (1 - 1j) * np.exp(1j * (turn[j] - turn[i] + half))  # along the ray j of B
            chord = net[i - 1, j] - net[i, j - 1]
            net[i, j] = net[i, j - 1] + first * (chord * second.conj()).imag / (first * second.conj()).imag
    line = np.append(net[steps, ::-1], A)  # below the wedge, from the middle of the block to the corner
    pressure = 1 + 2 * (angle + turn[::-1])
    mean = np.append((pressure[1:] + pressure[:-1]) / 2, pressure[-1])
    way = np.diff(line)
    half_width = -net[steps, steps].real
    return half_width, float(mean @ way.real + way.imag.sum()) / half_width


def prandtl(ratio: float) -> float:
    """Pressure over c on a block of that width over its height, from 1 to 3.64, without friction of its own.

    The slip-line field is Prandtl's (Z. angew. Math. Mech. 3, 1923), for blocks of these widths completed by
    Hill (The Mathematical Theory of Plasticity, 1950), who gives 1.5 + ratio/2 as nearly the pressure.
    """
    return fans(brentq(lambda angle: fans(angle)[0] - ratio, 1e-3, np.pi / 4))[1]


def test_the_slip_lines_are_those_of_the_literature():
    """Fans of 45° are those of a block 3.64 times as wide as high (Hill)."""
    assert fans(1e-9) == pytest.approx((1.0, 2.0), rel=1e-6)
    width, pressure = fans(np.pi / 4)
    assert width == pytest.approx(3.64, abs=5e-3)
    assert pressure == pytest.approx(1.5 + width / 2, rel=0.01)
    assert fans(np.pi / 4, 80) == pytest.approx((width, pressure), rel=2e-4)


@pytest.mark.slow
@pytest.mark.parametrize("dilatancy", [0.0, 10.0, PHI])
@pytest.mark.parametrize("keys", [CONE, PYRAMID])
def test_smooth_plates_leave_the_strength_of_plane_strain(keys, dilatancy):
    def slope(angle):  # η of the cone
        tangent = np.tan(np.radians(angle))
        return 3 * tangent / np.sqrt(9 + 12 * tangent**2)

    strength = 2 * np.cos(np.radians(PHI)) / (1 - np.sin(np.radians(PHI)))
    if keys is CONE:
        eta, flow, xi = slope(PHI), slope(dilatancy), slope(PHI) / np.tan(np.radians(PHI))
        uniaxial, strength = strength, 2 * xi / ((1 - eta * flow / 3) / np.sqrt(1 - flow**2 / 3) - eta)
        assert dilatancy < PHI or strength == pytest.approx(uniaxial)
    keys = keys | {"friction_angle": PHI, "dilatancy_angle": dilatancy}
    found = borne((1.0, 1.0), (1, 1), 0.01, friction=0.0, steps=16, **keys)
    assert found == pytest.approx(strength, rel=1e-8)


@pytest.mark.slow
@pytest.mark.parametrize(("keys", "ratio"), [(CONE, 2), (PYRAMID, 2), (PYRAMID, 3)])
def test_rough_plates_on_a_wide_block(keys, ratio):
    """From above at first order, as stone sticks to the plates in a wedge along which the velocity jumps."""
    found = np.array(
        [
            borne((ratio, 1.0), (ratio * n, n), 2e-3, friction=ROUGH, friction_angle=0.0, **keys)
            for n in (4, 8)
        ]
    )
    exact = prandtl(ratio)
    over = found / exact - 1
    assert 0.02 < over[1] < 0.05, over
    assert np.log2(over[0] / over[1]) == pytest.approx(1.0, abs=0.1), over
    assert 2 * found[1] - found[0] == pytest.approx(exact, rel=5e-3)  # extrapolated at that order


@pytest.mark.slow
@pytest.mark.parametrize("keys", [CONE, PYRAMID])
def test_rough_plates_on_a_high_block_with_friction(keys):
    """Twice as high as wide: bands at 60° pass between the plates, and the strength is the uniaxial one."""
    strength = 2 * np.cos(np.radians(PHI)) / (1 - np.sin(np.radians(PHI)))
    over = [
        borne((1.0, 2.0), (n, 2 * n), 2e-3, friction=ROUGH, friction_angle=PHI, **keys) / strength - 1
        for n in (4, 8)
    ]
    assert 0 < over[1] < 0.012, over
    assert np.log2(over[0] / over[1]) > 1.0, over
