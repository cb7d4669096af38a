"""Damped marches: dynamics as a regularisation of statics (slides 6.1).

* numerical viscosity: θ = 1 and the materials' Rayleigh damping take the energy out;
* brutal damping (*amortissement brutal*): velocities are zeroed after each step;
* linear damping (*amortissement linéaire*): velocities are scaled after each step;
* large step: brutal damping with steps far longer than a wave's transit, so that each step
  solves the static problem regularised by M/h².
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from masonry_fem.bodies.base import Scheme
from masonry_fem.march.equilibrium.base import at_rest
from masonry_fem.march.step_report import StepReport


@dataclass(frozen=True, slots=True, kw_only=True)
class Damped:
    """March of at most ``max_steps`` steps towards rest.

    Attributes
    ----------
    step : h [s]. theta : of the θ-scheme; 1 is the most dissipative.
    velocity_factor : What remains of the velocities after each step.
    tolerance : On the static balance, the contact residual and the speed, all unit-free.
    """

    step: float
    theta: float = 1.0
    max_steps: int = 1000
    velocity_factor: float = 1.0
    tolerance: float = 1e-6
    seeks_equilibrium: bool = True
    parts: int = 1

    @property
    def steps(self) -> int:
        """Largest number of steps."""
        return self.max_steps

    def schedule(self) -> Iterator[tuple[Scheme, float]]:
        """Equal steps."""
        for index in range(1, self.max_steps + 1):
            yield Scheme(self.step, self.theta), index * self.step

    def settled(self, report: StepReport) -> bool:
        """At rest by the measures of formulation 4."""
        return at_rest(report, self.step, self.tolerance)


def numerical_viscosity(
    *, step: float, theta: float = 1.0, max_steps: int = 1000, tolerance: float = 1e-6
) -> Damped:
    """θ > ½ and Rayleigh damping alone."""
    return Damped(step=step, theta=theta, max_steps=max_steps, tolerance=tolerance)


def linear_damping(
    *,
    step: float,
    factor: float,
    theta: float = 1.0,
    max_steps: int = 1000,
    tolerance: float = 1e-6,
) -> Damped:
    """Velocities times ``factor`` after each step; 0 is brutal damping."""
    return Damped(step=step, theta=theta, max_steps=max_steps, velocity_factor=factor, tolerance=tolerance)
