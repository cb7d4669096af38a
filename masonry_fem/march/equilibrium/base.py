"""Strategy: which steps to make, what to do between them, and when to stop.

A strategy is data plus two small functions, so that a new one is one file and one line in
``equilibrium/__init__.py``.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Protocol

from masonry_fem.bodies.base import Scheme
from masonry_fem.march.step_report import StepReport


class Strategy(Protocol):
    """How a march runs."""

    @property
    def steps(self) -> int:
        """Largest number of steps, parts of steps counted."""
        ...

    @property
    def parts(self) -> int:
        """Most parts that a step in which joints give way may be divided into."""
        ...

    @property
    def seeks_equilibrium(self) -> bool:
        """Whether ending without an equilibrium is a failure."""
        ...

    @property
    def velocity_factor(self) -> float:
        """What velocities are multiplied by after each step (1: left alone)."""
        ...

    def schedule(self) -> Iterator[tuple[Scheme, float]]:
        """(scheme, time at the end) of each step in turn."""
        ...

    def settled(self, report: StepReport) -> bool:
        """Whether the state that a step reached is an equilibrium."""
        ...


def at_rest(report: StepReport, step: float, tolerance: float) -> bool:
    """Equilibrium by measures only: static balance, contact and speed.

    The speed is held against what the loads would give in one step from rest, so that a body
    that falls freely has 1 whatever the units and the step.
    """
    return (
        report.static_balance <= tolerance
        and report.natural_map <= tolerance
        and report.inertial_share(step) <= tolerance
    )
