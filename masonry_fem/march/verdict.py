"""Verdict: how a march ended, the sentence that says so, and whether it could still have come to rest.

message = sentence(verdict, end)

A march ends without rest because nothing can hold the blocks, or because it was too short, or because its
steps were solved too loosely for what counts as rest. Only the first is "no equilibrium". Where steps are
very long, speeds that are nothing beside what the loads give in a step still carry blocks away.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from masonry_fem.bodies.base import nonlinear
from masonry_fem.joints.law import layers_of
from masonry_fem.march.ledger import Ledger
from masonry_fem.march.measure import moving_blocks
from masonry_fem.march.model import Model
from masonry_fem.march.motion import greatest_shift
from masonry_fem.march.state import SystemState
from masonry_fem.march.step import Increment
from masonry_fem.march.step_report import StepReport
from masonry_fem.nscd import Outcome, SolverSettings
from masonry_fem.nscd.admissible import BALANCED, admissible_impulses
from masonry_fem.records.remark import first_few

Verdict = Literal["equilibrium", "finished", "no_convergence", "no_equilibrium"]

SHOWN = 4  # blocks that a sentence names
UNACCOUNTED = 1e-6  # of the largest energy: what may be missing from the ledger of an equilibrium

MOVED = 1e-2  # of a block's size: what has gone so far is no settlement
DRIFT = 1e-3  # of a block's size, in a step of what counts as rest
CREEP = 1e4  # times the solver's tolerance, of free fall: rigid blocks that are faster are on their way
SLACK = 10.0  # times the tolerance, of free fall: what steps within the tolerance may carry blocks


@dataclass(frozen=True, slots=True)
class End:
    """Where a march ended.

    Attributes
    ----------
    model, made, report : The last step, what it was made with and what it did.
    settings : Of the contact solver. ledger : Energies summed over the march.
    objection : What the written results leave open; "" where nothing.
    drifts : Whether forces balance there, and nothing brakes what moves.
    """

    model: Model
    made: Increment
    report: StepReport
    settings: SolverSettings
    ledger: Ledger
    objection: str
    drifts: bool = False

    def moving(self, verdict: Verdict) -> tuple[tuple[str, float, str], ...]:
        """Blocks that move where there is no equilibrium: (name, speed [m/s], how)."""
        return tuple(moving_blocks(self.model, self.made.after)) if verdict == "no_equilibrium" else ()


def sentence(verdict: Verdict, end: End) -> str:
    """What a verdict means here, and what to do next.

    Parameters
    ----------
    verdict : How the march ended.
    end : Where it did.
    """
    if verdict == "equilibrium":
        return f"Equilibrium after {end.report.so_far}{_missing(end.ledger)}."
    if verdict == "finished":
        return f"Reached {_when(end.report.time, end.made)} in {end.report.so_far}."
    if verdict == "no_equilibrium":
        return _no_equilibrium(end.report, end.moving(verdict))
    if end.report.unsettled:
        return _unsettled(end)
    return _open(end) if end.report.outcome.solved else _unsolved(end)


def _open(end: End) -> str:
    """Why steps that were solved are no equilibrium."""
    if end.report.joint_change == 0:
        return f"No equilibrium in what is written: {end.objection}" if end.objection else _restless(end)
    step = f"Step {end.report.step}, at {_when(end.report.time, end.made)}"
    return (
        f"{step}: the joint laws did not settle, the joints' state still changed by "
        f"{end.report.joint_change:.1e}, most{_where(end)}. Take more load steps, or analysis.substeps."
    )


def _where(end: End) -> str:
    """The joint whose state changed most, and its law, in words."""
    contact, model = end.made.restless, end.model
    assert contact is not None  # as its state changed
    names = [model.assembly.blocks.names[block] for block in model.contacts.blocks[contact]]
    (law,) = (law for law, contacts in model.laws.parts if contact in contacts)
    layers = ", ".join(f"'{layer.name}'" for layer in layers_of(law))
    return f" at that of '{names[0]}' and '{names[1]}' ({layers})"


def _unsolved(end: End) -> str:
    """Why a step was not solved."""
    report, made = end.report, end.made
    stopped = f"Step {report.step}: the contact solver stopped at an error of {report.quality.error:.1e}"
    if made.solution.rounded:
        return (
            f"{stopped}, which is rounding: no tolerance below it can be met here. Loosen the tolerance "
            f"({end.settings.tolerance:g})."
        )
    if report.quality.error <= report.rounding:
        return (
            f"{stopped}, of which rounding alone may make up to {report.rounding:.1e}: blocks are too thin, "
            "or their stiffnesses or masses differ too much, for a more accurate result. Make thin layers "
            "joints with [joints.mortar], and blocks that hardly deform rigid."
        )
    message = f"{stopped}. {report.outcome.sentence} {report.outcome.advice(end.settings)}"
    if made.problem.rigid and (made.problem.free_velocity[:, 0] < 0).any():
        message += (
            " A moving support, or an overlap, squeezes rigid blocks that cannot get out of the way, so that "
            "no motion fulfils the laws of contact; make these blocks elastic, or leave a gap."
        )
    return message


def _missing(ledger: Ledger) -> str:
    """What the energy ledger of an equilibrium leaves open, as the end of its sentence; "" if it closes."""
    if ledger.imbalance <= max(UNACCOUNTED, ledger.rounded):
        return ""
    return (
        f", but {ledger.imbalance:.1e} of the largest energy is missing from its ledger "
        f"({ledger.unaccounted:.3g} J unaccounted for): the steps are too "
        "long to show where it went; take smaller ones"
    )


def _unsettled(end: End) -> str:
    """Which stone was not brought to balance, at what load, what was reached, and what may be done."""
    report, made = end.report, end.made
    if made.before.index == 0:
        kept = "Nothing was in balance before, so that what is written is not in balance"
    else:
        kept = f"The last state in balance, at {_when(made.before.time, made)}, is what is written"
    return f"Step {report.step}, {_when(report.time, made)}: {report.unsettled}. {kept}. {_onward(end)}"


def _onward(end: End) -> str:
    """Why stresses came to no balance, and what may be done."""
    made, model = end.made, end.model
    if model.control is not None:
        return _along_path(made, model)
    if made.scheme.inertia:
        return "The stone yields too far in one step: take shorter steps."
    (softens,) = (nonlinear(group).softens for group in model.groups if made.unsettled in group.blocks)
    if softens:
        why = (
            "The stone loses strength as it cracks: past a peak, and where the structure snaps back, no "
            "greater load has an equilibrium near by. Let the load follow from the opening of the crack "
            "(analysis.kind = 'path'), prescribe a displacement instead of a load, or run dynamics to watch "
            "the stone break"
        )
    elif end.report.material_dissipation == 0:
        why = (
            "No stone has flowed: it is not strength that ends it, but blocks that move too far "
            "in a step, as where they slide or tip. See what should hold them (supports, friction, joints), "
            "or run dynamics to watch the motion"
        )
    else:
        why = (
            "The stone flows, and no load beyond its limit has an equilibrium. Prescribe a displacement "
            "instead of a load to see what it bears at most, or run dynamics to watch it flow"
        )
    return (
        f"{why}. If it should bear this load, take more load steps, and see whether strengths and loads have "
        "the right units."
    )


def _along_path(made: Increment, model: Model) -> str:
    """What may be done where a path ends."""
    if made.solution.outcome.moves or not any(group.deforms for group in model.groups):
        return (
            "Blocks move there as rigid bodies, and no load factor tells how far: a path cannot follow "
            "mechanisms. Make rigid blocks elastic, hold those that part from the others, or run dynamics."
        )
    joints = "" if model.laws.all_plain else ", let joints be dry (paths cannot follow joints that soften)"
    return (
        f"Take more load steps{joints}, or let another displacement grow: one that the loads move and that "
        "never goes back, as the opening of the crack that leads."
    )


def _when(time: float, made: Increment) -> str:
    """A time [s] as it is called in a step: in statics it is the load factor."""
    return f"load factor {time:.6g}" if made.scheme.inertia == 0 else f"t = {time:.6g} s"


def _restless(end: End) -> str:
    """What goes on where a march ran out of steps, and what may end it."""
    report, made = end.report, end.made
    names = [name for name, _, _ in moving_blocks(end.model, made.after)]
    subject, plural = first_few(names, SHOWN), len(names) > 1
    if end.drifts and names:
        return (
            f"Not at rest after {report.so_far}: forces balance, but {subject} "
            f"{'drift' if plural else 'drifts'} on evenly, at up to {report.speed:.1e} m/s, and numerical "
            "viscosity brakes only what strains blocks. More steps do not help: take strategy = "
            "'brutal_damping' or 'large_step', which stop blocks, or materials.*.damping.mass; or see what "
            "should hold them (supports, friction, joints)."
        )
    what = "the state is not yet static"
    if names:
        what = f"{subject} still {'move' if plural else 'moves'}"
    return (
        f"Not at rest after {report.so_far}: contact forces could balance the loads, but {what} (at "
        f"{report.inertial_share(made.scheme.step):.1e} of the speed that the loads would give a free block "
        "in one step). Allow more steps (analysis.max_steps), longer ones or more damping; where speeds no "
        "longer fall, tighten solver.tolerance or loosen analysis.tolerance."
    )


def _no_equilibrium(report: StepReport, moving: tuple[tuple[str, float, str], ...]) -> str:
    if not moving:
        return (
            f"No equilibrium was found in {report.so_far}, yet no block moves; "
            "allow more steps, and see to it that a support holds every block."
        )
    ways: dict[str, list[str]] = {}
    for name, _, way in moving:
        ways.setdefault(way, []).append(name)
    parts = [
        f"{first_few(names, SHOWN)} {way if len(names) == 1 else way.rstrip('s')}"
        for way, names in ways.items()
    ]
    cure = "see what should hold them (supports, friction, joints), or run dynamics to watch the motion"
    start = "No equilibrium"
    if report.outcome is Outcome.AT_LIMIT:
        start = "The loads are at the limit, with 0.1 % less friction there would be no equilibrium"
    if report.outcome is Outcome.UNSTRESSED:
        start = "No equilibrium from a start without stress"
    return f"{start} (step {report.step}): {'; '.join(parts)}; {cure}."


def could_rest(
    model: Model, start: SystemState, made: Increment, report: StepReport, tolerance: float
) -> bool:
    """Whether the last step's contacts could balance the loads, and nothing has gone far.

    Blocks whose loads could be balanced may collapse nonetheless, as Coulomb's friction is not associated:
    rigid blocks that are faster than ``CREEP`` are taken to do so, and whatever has gone farther than
    ``MOVED``.

    Parameters
    ----------
    model : The structure.
    start : Where the march began.
    made : Its last step. report : What this did.
    tolerance : Of the contact solver: blocks of tall stacks drift at up to a thousand times this share of the
        speed that loads give in a step.
    """
    if made.problem.rigid and report.inertial_share(made.scheme.step) > CREEP * tolerance:
        return False
    if greatest_shift(model, start.bodies, made.after.bodies) > MOVED * model.length:
        return False
    problem = made.problem
    still = replace(
        problem,
        rigid_mass=np.zeros_like(problem.rigid_mass),
        rigid_velocity=np.zeros_like(problem.rigid_velocity),
    )
    return admissible_impulses(still).unbalanced <= BALANCED


def drift(model: Model, made: Increment, report: StepReport, tolerance: float) -> float:
    """How far the last step carried blocks at speeds below the solver's tolerance [m]; 0 where it is not far.

    Parameters
    ----------
    model : The structure.
    made : The step. report : What it did.
    tolerance : Of the contact solver.
    """
    if made.scheme.inertia == 0 or report.inertial_share(made.scheme.step) > CREEP * tolerance:
        return 0.0
    shift = greatest_shift(model, made.before.bodies, made.after.bodies)
    return shift if shift > DRIFT * model.length and made.problem.rigid else 0.0


def within_tolerance(made: Increment, report: StepReport, tolerance: float) -> float:
    """How far speeds below the solver's tolerance may carry a block in a step [m]; 0 in statics.

    Parameters
    ----------
    made : The step. report : What it did.
    tolerance : Of the contact solver.
    """
    step = made.scheme.step
    return made.scheme.inertia * SLACK * tolerance * report.load_acceleration * step**2
