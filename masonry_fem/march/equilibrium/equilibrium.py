"""Equilibrium: damped marches, dynamics as a regularisation of statics.

* numerical viscosity: θ = 1 and the materials' Rayleigh damping take the energy out;
* brutal damping (*amortissement brutal*): velocities are zeroed after each step;
* linear damping (*amortissement linéaire*): velocities are scaled after each step;
* large step: brutal damping with steps far longer than a wave's transit, so that each step
  solves the static problem regularised by M/h².
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated, Literal

from msgspec import Meta

from masonry_fem.bodies.base import Scheme
from masonry_fem.march.equilibrium.parts.base import Strategy, equal_steps, step_faults
from masonry_fem.records.record import Count, Positive, Seconds

if TYPE_CHECKING:
    from masonry_fem.march.step_report import StepReport


class Equilibrium(Strategy, frozen=True, kw_only=True, tag="equilibrium"):
    """March in time towards rest by a ``strategy``; it ends when the structure is in equilibrium.

    Attributes
    ----------
    strategy : how kinetic energy is taken out; see [which strategy when](strategies.md)
    step : length h of a time step
    theta : θ of the scheme: 0.5 conserves energy, 1 damps most
    max_steps : number of steps after which the run ends without equilibrium
    velocity_factor : for ``linear_damping``: velocities are multiplied by this factor after each step
    tolerance : bound on the imbalance of forces, the contact error and the speed, all relative

    Examples
    --------
    kind = "equilibrium"
    strategy = "brutal_damping"
    step = 0.01
    """

    strategy: Literal["numerical_viscosity", "brutal_damping", "linear_damping", "large_step"]
    step: Seconds
    theta: Annotated[float, Meta(ge=0.5, le=1)] = 1.0
    max_steps: Count = 1000
    velocity_factor: Annotated[float, Meta(ge=0, lt=1)] = 0.9
    tolerance: Positive = 1e-6

    @property
    def steps(self) -> int:
        """Largest number of steps."""
        return self.max_steps

    @property
    def end(self) -> float:
        """Time by which it is at rest, or has failed [s]."""
        return self.step * self.max_steps

    @property
    def ramp(self) -> float:
        """The first tenth of the allowed steps [s]."""
        return self.step * max(1, self.max_steps // 10)

    @property
    def kept(self) -> float:
        """What velocities are multiplied by; a large step is brutal damping with a step that is long."""
        return {"numerical_viscosity": 1.0, "linear_damping": self.velocity_factor}.get(self.strategy, 0.0)

    def schedule(self) -> Iterator[tuple[Scheme, float]]:
        """Equal steps."""
        return equal_steps(self.step, self.theta, self.max_steps)

    def settled(self, report: StepReport) -> bool:
        """At rest by three measures: static balance, contact and speed.

        The speed is held against what the loads would give in one step from rest, so that a body
        that falls freely has 1 whatever the units and the step.
        """
        return self.balanced(report) and report.inertial_share(self.step) <= self.tolerance

    def balanced(self, report: StepReport) -> bool:
        """Forces balance and joints obey their laws, whether or not blocks move."""
        return max(report.static_balance, report.natural_map) <= self.tolerance

    def faults(self, dimension: int) -> Iterator[tuple[str, str]]:
        """Steps of which numbers cannot be computed."""
        return step_faults(self.step)
