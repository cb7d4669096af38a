"""A9.5: Painlevé's rod, a uniform rod whose lower end is pushed over rough ground.

Sliding, the reaction has p_N (1 + 3 cos θ (cos θ − µ sin θ)) to give, θ the rod's angle with the ground:
where that is negative sliding on would pull the end into the ground, and no force can hold it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from masonry_fem.nscd import ContactProblem, SolverSettings, solve
from tests.nscd.enumeration import enumerate_solutions
from tests.nscd.plane import plane_problem
from tests.validation.scenes import G

# Half the length is 1 m, the mass 1 kg: the inertia is 1/3 about the centre.
INERTIA = 1 / 3
STEEP = np.arctan(2.0)  # 63.43°


def margin(angle: float, friction: float) -> float:
    return 1 + 3 * np.cos(angle) * (np.cos(angle) - friction * np.sin(angle))


@dataclass
class Rod:
    """Position and angle of the centre, and their velocities with the spin last."""

    place: np.ndarray
    speed: np.ndarray

    @property
    def end(self) -> np.ndarray:
        return self.place[:2] - [np.cos(self.place[2]), np.sin(self.place[2])]

    @property
    def energy(self) -> float:
        return float(0.5 * self.speed**2 @ [1, 1, INERTIA] + G * self.place[1])


def rod(angle: float, pushed: float) -> Rod:
    """Its end on the ground, sliding at −``pushed``: friction pushes back, and turns the end down."""
    return Rod(np.array([np.cos(angle), np.sin(angle), angle]), np.array([-pushed, 0.0, 0.0]))


def contact(now: Rod, friction: float, step: float) -> ContactProblem:
    """The end's contact, velocities scaled by the roots of mass and inertia."""
    root = np.sqrt([1.0, 1.0, INERTIA])
    problem = plane_problem(
        [now.end], [[0.0, 1.0]], [[0, -1]], friction, [[0.0, -G * step, 0.0]],
        mass=1.0, velocity=[now.speed * root], centres=[now.place[:2]],
    )  # fmt: skip
    problem.rigid_map[:] /= root
    return problem


def advanced(now: Rod, friction: float, step: float, method: str) -> tuple[Rod, np.ndarray, np.ndarray]:
    """Moreau's step: the rod after it, the impulse and the velocity of its end."""
    root = np.sqrt([1.0, 1.0, INERTIA])
    if now.end[1] > 1e-12:
        speed = now.speed - np.array([0.0, G * step, 0.0])
        impulse, velocity = np.zeros(2), np.full(2, np.inf)
    else:
        found = solve(contact(now, friction, step), SolverSettings(method=method, tolerance=1e-10))
        assert found.converged
        speed, impulse, velocity = found.rigid_velocity[0] / root, found.impulse[0], found.velocity[0]
    return Rod(now.place + 0.5 * step * (now.speed + speed), speed), impulse, velocity


@pytest.mark.parametrize("friction", [1.2, 1.33, 1.34, 2.0])
def test_a9_5_no_force_where_the_margin_is_negative(friction: float) -> None:
    """There are such angles iff µ > 4/3, and there the only solution is an impulse that stops the end."""
    angles = np.radians(np.linspace(1, 89, 177))
    negative = np.array([margin(angle, friction) < 0 for angle in angles])
    assert negative.any() == (friction > 4 / 3)
    assert (margin(STEEP, friction) < 0) == (friction > 4 / 3)
    for angle, paradox in zip(angles[::8], negative[::8], strict=True):
        # so short that near a margin of zero friction does not stop the end within the step
        found = enumerate_solutions(contact(rod(angle, 10.0), friction, 1e-8))
        slides = any(solution.status[0].startswith("slip") for solution in found)
        assert slides != paradox
        assert len(found) == 1


@pytest.mark.parametrize("method", ["auto", "nsgs", "newton"])
@pytest.mark.parametrize("step", [1e-2, 1e-4, 1e-6])
def test_a9_5_it_stops_at_once(step: float, method: str) -> None:
    """µ = 2 at 63.43°: an impulse W⁻¹ (0, 10) of the size of the momentum, whatever the step."""
    after, impulse, velocity = advanced(rod(STEEP, 10.0), 2.0, step, method)
    c, s = np.cos(STEEP), np.sin(STEEP)
    W = np.array([[1 + 3 * c**2, 3 * s * c], [3 * s * c, 1 + 3 * s**2]])
    assert velocity == pytest.approx([0, 0], abs=1e-8)
    # the tangent points along +x, where W_NT = −3 sin θ cos θ
    expected = np.linalg.solve(W, [G * step, -10.0]) * [1, -1]
    assert impulse == pytest.approx(expected, rel=1e-8)
    assert after.energy <= rod(STEEP, 10.0).energy


@pytest.mark.parametrize("friction", [2.0, 5.0])
def test_a9_5_the_march_goes_on(friction: float) -> None:
    """Through the paradox, lift-off and fall: v_N ≥ 0, the cone and the energy hold at every step."""
    now = rod(STEEP, 10.0)
    energy, step = [now.energy], 1e-3
    while now.place[1] > 0.05 and len(energy) < 3000:
        now, impulse, velocity = advanced(now, friction, step, "auto")
        assert velocity[0] >= -1e-9
        assert impulse[0] >= 0
        assert abs(impulse[1]) <= friction * impulse[0] * (1 + 1e-8)
        energy.append(now.energy)
        assert np.isfinite(now.place).all()
    assert max(energy) <= energy[0] * (1 + 1e-9)
    # one step's error in the end's path is O(h²): what the contact gives is of that order
    assert np.diff(energy).max() < 10 * step
    assert len(energy) > 100


def test_a9_5_below_the_critical_friction_it_slides_on() -> None:
    """µ = 1.2 at the same angle: p_N = g h / margin, and the end goes on."""
    step = 1e-4
    _, impulse, velocity = advanced(rod(STEEP, 10.0), 1.2, step, "auto")
    assert impulse[0] == pytest.approx(G * step / margin(STEEP, 1.2), rel=1e-8)
    assert impulse[1] == pytest.approx(1.2 * impulse[0], rel=1e-8)
    assert velocity[0] == pytest.approx(0, abs=1e-10)
    assert velocity[1] < -9
