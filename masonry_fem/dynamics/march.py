"""March: steps one after another until a strategy is satisfied or nothing more can be done.

made = march(model, Statics(), SolverSettings())
made.outcome, made.message, made.state, made.report
"""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, Protocol

import numpy as np

from masonry_fem.dynamics.clock import Clock
from masonry_fem.dynamics.coupling import connect
from masonry_fem.dynamics.equilibrium import Strategy
from masonry_fem.dynamics.ledger import Ledger
from masonry_fem.dynamics.measure import measure, moving_blocks
from masonry_fem.dynamics.model import Model
from masonry_fem.dynamics.report import StepReport
from masonry_fem.dynamics.state import SystemState
from masonry_fem.dynamics.step import Increment, initial_state, step
from masonry_fem.nscd import Outcome, SolverSettings

logger = logging.getLogger(__name__)

Verdict = Literal["equilibrium", "finished", "no_convergence", "no_equilibrium"]

# a transient march bears a step that missed its tolerance, up to this error
BEARABLE = 1e-3
# Of the largest impulses of a march: errors below the first are rounding, whatever is left of the
# impulses; and these count as never less than the second.
ROUNDING = 1e-12
LEAST_SHARE = 1e-2


class Observer(Protocol):
    """Who is told of each step (recorders, progress)."""

    def record(self, model: Model, state: SystemState, report: StepReport) -> None:
        """See the state that a step reached."""
        ...


@dataclass(frozen=True, slots=True)
class March:
    """How a march ended.

    Attributes
    ----------
    outcome, message : Verdict and its sentence.
    state, report : The last state and what its step did.
    last : Everything of the last step. ledger : Energies summed over the march.
    seconds : CPU time by phase [s]: factorise, solve, step, measure and output.
    moving : Blocks that move where there is no equilibrium: (name, speed [m/s], how).
    """

    outcome: Verdict
    message: str
    state: SystemState
    report: StepReport
    last: Increment
    ledger: Ledger
    seconds: dict[str, float]
    moving: tuple[tuple[str, float, str], ...]


def march(
    model: Model,
    strategy: Strategy,
    settings: SolverSettings,
    *,
    bodies: tuple[Any, ...] | None = None,
    observers: Sequence[Observer] = (),
    keep: int | None = None,
    kept: list[Increment] | None = None,
) -> March:
    """Run ``strategy`` from rest, or from the given body states.

    ``keep`` names a step whose increment is appended to ``kept`` (for replay of its problem).
    """
    coupling = connect(model)
    start = tuple(group.rest() for group in model.groups) if bodies is None else bodies
    state = initial_state(model, coupling, start)
    ledger, clock, largest = Ledger(), Clock(), 0.0
    missed: list[float] = []
    share = min(ROUNDING / settings.tolerance, LEAST_SHARE)
    for scheme, until in strategy.schedule():
        measured = replace(settings, least_impulse=share * largest)
        made = step(model, coupling, state, scheme, measured, until, clock)
        largest = max(largest, float(np.linalg.norm(made.impulse)))
        report = measure(model, coupling, made)
        clock.lap("measure")
        ledger = ledger.add(report, scheme.inertia)
        if keep == report.step and kept is not None:
            kept.append(made)
        for observer in observers:
            observer.record(model, made.after, report)
        clock.lap("output")
        stop = _hopeless(report, scheme.inertia == 0)
        if stop is not None:
            return _ended(stop, model, made, report, ledger, clock)
        if report.outcome is not Outcome.CONVERGED:
            missed.append(report.quality.error)
        if strategy.settled(report):
            return _ended("equilibrium", model, made, report, ledger, clock)
        state = _rested(model, made.after, strategy.velocity_factor)
    verdict: Verdict = "no_equilibrium" if strategy.seeks_equilibrium else "finished"
    if strategy.seeks_equilibrium and report.outcome is not Outcome.CONVERGED:
        verdict = "no_convergence"  # a step that was not solved says nothing of what exists
    if missed:
        logger.warning(
            "%d of %d steps missed the solver's tolerance %g, the worst with an error of %.1e; "
            "look at the certificate, and loosen solver.tolerance where that is exact enough",
            len(missed), report.step, settings.tolerance, max(missed),
        )  # fmt: skip
    return _ended(verdict, model, made, report, ledger, clock)


def _hopeless(report: StepReport, static: bool) -> Verdict | None:
    """Why the march cannot go on after a step, or None; statics bears no miss."""
    if report.outcome.moves:
        return "no_equilibrium"
    if report.outcome is Outcome.CONVERGED:
        return None
    # by impulses alone a tall stack's error looks 1e-5 where two thirds of its weight are missing
    if static or not report.quality.error <= BEARABLE:
        return "no_convergence"
    return None


def _rested(model: Model, state: SystemState, factor: float) -> SystemState:
    """The state with velocities scaled between steps."""
    if factor == 1.0:
        return state
    bodies = tuple(
        group.scale_velocity(own, factor) for group, own in zip(model.groups, state.bodies, strict=True)
    )
    return replace(state, bodies=bodies, velocity=factor * state.velocity)


def _ended(
    verdict: Verdict, model: Model, made: Increment, report: StepReport, ledger: Ledger, clock: Clock
) -> March:
    moving: tuple[tuple[str, float, str], ...] = ()
    if verdict == "equilibrium":
        message = f"Equilibrium after {_steps(report.step)}."
    elif verdict == "finished":
        message = f"Reached t = {report.time:.6g} s in {_steps(report.step)}."
    elif verdict == "no_convergence":
        message = (
            f"Step {report.step}: the contact solver stopped at an error of {report.quality.error:.1e}. "
            f"{report.outcome.sentence} {report.outcome.advice}"
        )
    else:
        moving = tuple(moving_blocks(model, made.after))
        message = _no_equilibrium(report, moving)
    return March(verdict, message, made.after, report, made, ledger, clock.phases, moving)


def _steps(count: int) -> str:
    return "1 step" if count == 1 else f"{count} steps"


def _no_equilibrium(report: StepReport, moving: tuple[tuple[str, float, str], ...]) -> str:
    if not moving:
        return (
            f"No equilibrium was found in {_steps(report.step)}, yet no block moves; "
            "allow more steps, and see to it that a support holds every block."
        )
    ways: dict[str, list[str]] = {}
    for name, _, way in moving:
        ways.setdefault(way, []).append(name)
    parts = [
        f"{', '.join(names[:4])}{f' and {len(names) - 4} more' if len(names) > 4 else ''} "
        f"{way if len(names) == 1 else way.rstrip('s')}"
        for way, names in ways.items()
    ]
    cure = "see what should hold them (supports, friction, joints), or run dynamics to watch the motion"
    start = "No equilibrium"
    if report.outcome is Outcome.AT_LIMIT:
        start = "No equilibrium to rely on: the loads can just be carried, but not with 0.1 % less friction"
    return f"{start} (step {report.step}): {'; '.join(parts)}; {cure}."
