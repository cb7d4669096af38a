"""Dynamics: a plain march in time."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Annotated

from msgspec import Meta

from masonry_fem.bodies.base import Scheme
from masonry_fem.march.equilibrium.parts.base import Strategy, equal_steps, step_faults
from masonry_fem.records.record import Seconds

MOST_STEPS = 1e9  # a thousandth of a second each: two weeks of computing


class Dynamics(Strategy, frozen=True, kw_only=True, tag="dynamics"):
    """Motion in time from 0 to ``duration``, by the θ-scheme.

    Attributes
    ----------
    step : length h of a time step
    duration : time at which the march ends
    theta : θ of the scheme: 0.5 conserves energy, 1 damps most

    Examples
    --------
    kind = "dynamics"
    step = 0.01
    duration = 0.2
    """

    step: Seconds
    duration: Seconds
    theta: Annotated[float, Meta(ge=0.5, le=1)] = 0.5

    @property
    def steps(self) -> int:
        """Number of steps; the last one ends at or just after the duration."""
        return max(1, math.ceil(self.duration / self.step * (1 - 1e-12)))

    @property
    def end(self) -> float:
        """The duration [s]."""
        return self.duration

    def schedule(self) -> Iterator[tuple[Scheme, float]]:
        """Equal steps."""
        return equal_steps(self.step, self.theta, self.steps)

    def faults(self, dimension: int) -> Iterator[tuple[str, str]]:
        """Durations of no step, or of more than can be made."""
        yield from step_faults(self.step)
        if self.duration < self.step:
            yield "duration", f"a time not shorter than the step ({self.step:g} s)"
        elif not self.duration / self.step <= MOST_STEPS:
            expected = f"at most {MOST_STEPS:.0e} steps of {self.step:g} s; shorten it or take longer steps"
            yield "duration", expected
