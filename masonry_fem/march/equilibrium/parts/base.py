"""Strategy: which steps to make, what to do between them, and when to stop."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator
from typing import TYPE_CHECKING, Literal

from masonry_fem.bodies.base import Scheme
from masonry_fem.records.record import FilePath, Spec

if TYPE_CHECKING:
    from masonry_fem.march.model import Control, Probe
    from masonry_fem.march.step_report import StepReport

SHORTEST, LONGEST = 1e-100, 1e30  # steps [s]: squares of impulses and stiffnesses times h² stay numbers


class Strategy(Spec, frozen=True, kw_only=True, tag_field="kind"):
    """How a scene is marched: what every kind of ``[analysis]`` has.

    Attributes
    ----------
    start : results folder of another run of the same stones (with ``output.checkpoint_steps``), in whose
        final state [this one begins](histories.md); in statics loads that this scene lacks are removed evenly
    new_stones : where stones begin that are new in a stage, or in a run with ``start``: in their
        ``reference`` places, or ``moved`` with the stones that they touch; without stress in both cases
    """

    start: FilePath | None = None
    new_stones: Literal["reference", "moved"] = "reference"

    @property
    @abstractmethod
    def steps(self) -> int:
        """Largest number of steps, parts of steps counted."""

    @property
    @abstractmethod
    def end(self) -> float:
        """Time at the end of the last step [s]; the load factor in statics."""

    @abstractmethod
    def schedule(self) -> Iterator[tuple[Scheme, float]]:
        """(scheme, time at the end) of each step in turn."""

    @property
    def ramp(self) -> float:
        """Time by which motions without a function of time have come to their end [s]."""
        return self.end

    @property
    def loading(self) -> Strategy:
        """What brings the loads on, without what comes after that."""
        return self

    def travelled(self, time: float) -> float:
        """Share of its way that a load which moves has gone by then, without a speed of its own."""
        return 0.0

    @property
    def parts(self) -> int:
        """Most parts that a step in which joints give way may be divided into."""
        return 1

    @property
    def inertia(self) -> bool:
        """Whether time is time; if not it is the load factor, and schemes have inertia 0."""
        return True

    @property
    def seeks_equilibrium(self) -> bool:
        """Whether ending without an equilibrium is a failure; so it is where ``settled`` says what one is."""
        return type(self).settled is not Strategy.settled

    @property
    def steers(self) -> bool:
        """Whether the load factor is an unknown; so it is where ``control`` says what it follows from."""
        return type(self).control is not Strategy.control

    @property
    def kept(self) -> float:
        """What velocities are multiplied by after each step."""
        return 1.0

    def control(self, probes: tuple[Probe, ...]) -> Control | None:
        """What the load factor follows from, given the scene's probes; None: the schedule gives it."""
        return None

    def settled(self, report: StepReport) -> bool:
        """Whether the state that a step reached is an equilibrium."""
        return False

    def balanced(self, report: StepReport) -> bool:
        """Whether forces balance in the state that a step reached, at rest or not."""
        return False


def step_faults(step: float) -> Iterator[tuple[str, str]]:
    """A step of which numbers cannot be computed."""
    if not SHORTEST <= step <= LONGEST:
        yield "step", f"a time from {SHORTEST:g} to {LONGEST:g} s"


def equal_steps(step: float, theta: float, count: int) -> Iterator[tuple[Scheme, float]]:
    """Steps of equal length, each with the time at its end [s], a multiple of the length.

    Parameters
    ----------
    step : Length of a step [s].
    theta : Weight θ of the end of the step, ½ ≤ θ ≤ 1.
    count : Number of steps.
    """
    for index in range(1, count + 1):
        yield Scheme(step, theta), index * step
