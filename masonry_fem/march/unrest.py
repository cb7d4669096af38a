"""Unrest: whether a march that ran out of steps could still have come to rest, and rest that is none.

A march ends without rest because nothing can hold the blocks, or because it was too short, or because its
steps were solved too loosely for what counts as rest. Only the first is "no equilibrium". Where steps are
very long, speeds that are nothing beside what the loads give in a step still carry blocks away.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from masonry_fem.march.model import Model
from masonry_fem.march.motion import greatest_shift
from masonry_fem.march.state import SystemState
from masonry_fem.march.step import Increment
from masonry_fem.march.step_report import StepReport
from masonry_fem.nscd.admissible import BALANCED, admissible_impulses

MOVED = 1e-2  # of a block's size: what has gone so far is no settlement
DRIFT = 1e-3  # of a block's size, in a step of what counts as rest
CREEP = 1e4  # times the solver's tolerance, of free fall: rigid blocks that are faster are on their way
SLACK = 10.0  # times the tolerance, of free fall: what steps within the tolerance may carry blocks


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
