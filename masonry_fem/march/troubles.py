"""Troubles: what went less than well in the steps of a march, and what is said of it at its end.

troubles = Troubles()
troubles.see(made, report)                                           # each step that the march goes on from
troubles.tell_steps(report, strategy, settings)
troubles.tell_overlaps(made, report, model.length, start.gap)
tell_promoted(model, state)                                          # stones that became inelastic on the way
tell_flowed(model, state)                                            # stones that strain beyond their law
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from masonry_fem.bodies.base import FloatArray, nonlinear
from masonry_fem.march.equilibrium import Strategy
from masonry_fem.march.increments import ABRUPT
from masonry_fem.march.model import Model
from masonry_fem.march.state import SystemState
from masonry_fem.march.step import Increment
from masonry_fem.march.step_report import StepReport
from masonry_fem.nscd import Outcome, SolverSettings
from masonry_fem.records.remark import first_few, remark

DEEP = 0.05  # of a block's size: how far blocks may go into each other without a word
FAR = 0.2  # mean plastic strain of a stone beyond which a law of small strains says nothing
SHOWN = 5  # stones that the remark's sentence names


class Troubles:
    """What steps left undone, over a march.

    Attributes
    ----------
    missed, inexact : Errors of the steps that missed the solver's tolerance, and of those that ended where
        the solver came no nearer to it.
    unsettled : What the joints' state still changed by, in steps in which the joint laws did not settle.
    rounding : What rounding alone may make of the errors of ``inexact``, at most.
    abrupt : Times of the steps in which some joint lost more than half of its adhesion at once.
    snapped : Times of the steps in which stones snapped to a balance further away.
    jammed : Number of steps in which overlaps could not be driven apart.
    deepest : Deepest overlap [m].
    """

    def __init__(self) -> None:
        self.missed: list[float] = []
        self.inexact: list[float] = []
        self.rounding = 0.0
        self.unsettled: list[float] = []
        self.abrupt: list[float] = []
        self.snapped: list[float] = []
        self.jammed, self.deepest = 0, 0.0

    @property
    def noted(self) -> dict[str, Any]:
        """All of it by name, for troubles that go on from here."""
        return {name: list(one) if isinstance(one, list) else one for name, one in vars(self).items()}

    def go_on(self, noted: Mapping[str, Any]) -> None:
        """Take over what was noted before."""
        for name in vars(self).keys() & noted.keys():
            setattr(self, name, list(noted[name]) if isinstance(noted[name], list) else noted[name])

    def see(self, made: Increment, report: StepReport) -> None:
        """Note what went wrong in a step."""
        if not report.outcome.solved:
            self.missed.append(report.quality.error)
        elif report.outcome is Outcome.INEXACT:
            self.inexact.append(report.quality.error)
            self.rounding = max(self.rounding, report.rounding)
        if report.joint_change > 0:
            self.unsettled.append(report.joint_change)
        if report.adhesion_loss > ABRUPT:
            self.abrupt.append(report.time)
        if made.snapped:
            self.snapped.append(report.time)
        self.jammed += made.jammed
        self.deepest = max(self.deepest, report.max_penetration)

    def tell_steps(self, report: StepReport, strategy: Strategy, settings: SolverSettings) -> None:
        """Say which steps were not solved as well as asked, or went too far at once.

        Parameters
        ----------
        report : Of the last step.
        strategy : Into how many parts it may divide a step.
        settings : Of the contact solver.
        """
        if self.missed:
            cure = (
                "" if settings.acceptable > 0 else ", and loosen solver.tolerance where that is exact enough"
            )
            remark(
                "missed_tolerance",
                f"{len(self.missed)} of {report.step} steps missed the solver's tolerance "
                f"{settings.tolerance:g}, the worst with an error of {max(self.missed):.1e}; look at the "
                f"certificate{cure}",
            )
        if self.inexact:
            remark(
                "inexact",
                f"{len(self.inexact)} of {report.so_far} ended at an error of up to "
                f"{max(self.inexact):.1e}, and the solver came no nearer to the goal "
                f"of {settings.tolerance:g}. Up to {self.rounding:.1e} of it may be rounding, more where the "
                "coordinates of a file are rounded. If the error is too large for you, set solver.tolerance: "
                "the run then fails where that is not met",
            )
        if self.unsettled:
            remark(
                "unsettled_joints",
                f"joint laws did not settle in {len(self.unsettled)} of {report.step} steps: the joints' "
                f"state still changed by up to {max(self.unsettled):.1e} (of β, of the largest jump, or of "
                "τ/σ where mortar crushes); take smaller steps (in statics analysis.substeps divides "
                "those that need it), or dynamics",
            )
        if self.snapped:
            remark(
                "snapped",
                f"stones cracked abruptly in {len(self.snapped)} of {report.so_far}, first at load "
                f"factor {self.snapped[0]:.4g}: with no equilibrium near by, the structure snaps to another, "
                "found by letting cracks run until they stop; with speed it may crack further. Dynamics "
                "shows the motion itself, kind = 'path' balanced states in between",
            )
        if self.abrupt:
            finest = 2 ** (strategy.parts.bit_length() - 1)  # steps are halved
            even = (
                f", even in 1/{finest} of a load step: the structure snaps back, or the joints "
                "are brittle; the run goes on from the next equilibrium; dynamics shows what happens "
                "in between"
            )
            unknown = (
                ": what happens between two steps is not known, the structure may snap back; "
                "smaller steps tell, in statics analysis.substeps divides those that need it"
            )
            remark(
                "abrupt",
                f"joints gave way abruptly in {len(self.abrupt)} of {report.so_far}, first at "
                f"t = {self.abrupt[0]:.4g}{even if finest > 1 else unknown}",
            )

    def tell_overlaps(self, made: Increment, report: StepReport, size: float, gap: FloatArray) -> None:
        """Say where blocks went into each other, or could not be driven apart.

        Parameters
        ----------
        made : The last step. report : What it did.
        size : Of a block [m]. gap : Between contact points where the march began, shape (c,) [m].
        """
        if self.deepest > DEEP * size + float(np.maximum(-gap, 0.0).max(initial=0.0)):
            remark(
                "fast_meeting",
                f"blocks went into each other by up to {self.deepest:.2g} m: they meet too fast for steps "
                f"of {made.scheme.step:g} s; take smaller steps (joints of form 'velocity' close in "
                "the step after blocks have met)",
            )
        if self.jammed:
            remark(
                "jammed",
                f"overlaps could not be driven apart in {self.jammed} of {report.so_far}: rigid "
                "blocks lie between others that do not give way; they were held where they are. Make "
                "room, or make the blocks elastic",
            )


def tell_promoted(model: Model, state: SystemState) -> None:
    """Remark on the stones of fidelity ``auto`` that became inelastic, and when.

    Parameters
    ----------
    model : The structure. state : Where its march ended.
    """
    times = {
        model.assembly.blocks.names[block]: since
        for group, own in zip(model.groups, state.bodies, strict=True)
        if group.nonlinear and (known := nonlinear(group).promoted(own)) is not None
        for block, since in zip(group.blocks.tolist(), known.tolist(), strict=True)
    }
    names = sorted(
        (name for name, since in times.items() if np.isfinite(since)), key=lambda name: times[name]
    )
    if not names:
        return
    shown = first_few((f"'{name}' at t = {times[name]:.4g}" for name in names), SHOWN)
    remark(
        "promoted",
        f"{len(names)} of {len(times)} stones of fidelity 'auto' became inelastic, as their stress came to "
        f"promote_at of that of first yield: {shown}",
        *names,
    )


def tell_flowed(model: Model, state: SystemState) -> str:
    """Remark on the stones that have flowed so far that small strains do not describe them.

    They have come to their limit: forces beyond it are those of stones that have kept their shape.

    Parameters
    ----------
    model : The structure. state : Where its march ended.

    Returns
    -------
    str : What was told; "" where nothing was.
    """
    strains: dict[str, tuple[float, str]] = {}
    for group, own in zip(model.groups, state.bodies, strict=True):
        plastic = group.material_state(own).get("plastic_strain")
        if plastic is not None:
            means = plastic.mean(axis=(1, 2))
            for body in np.flatnonzero(means > FAR).tolist():
                name = model.assembly.blocks.names[group.blocks[body]]
                strains[name] = (float(means[body]), nonlinear(group).material_name)
    if not strains:
        return ""
    names = sorted(strains, key=lambda name: -strains[name][0])
    shown = first_few((f"'{name}' ({strains[name][1]}) by {strains[name][0]:.2g}" for name in names), SHOWN)
    told = (
        f"at t = {state.time:.4g} stones have flowed, in the mean over their volume, {shown}: they have come "
        "to their limit, and what they bear beyond is not to be trusted, as laws are those of small strains. "
        "Prescribe a displacement instead of a load to see what they bear at most"
    )
    remark("flowed", told, *names)
    return told
