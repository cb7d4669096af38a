"""Tangent: a law linearised about the last turn, for Newton's method inside a step.

``Law.reduce`` gives secant springs: never negative, always safe, but slow where a joint softens
nearly as steeply as its surroundings give way. The tangent has the slope of the softening branch,
negative past the peak; with it the turns of a step converge quadratically as long as the structure
does not snap back.

    reduction = linearise(law, committed, trial, jump, reaction, velocity, area, step)
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from masonry_fem.joints.law import Law
from masonry_fem.joints.parameters import FloatArray
from masonry_fem.joints.reduction import Reduction
from masonry_fem.joints.state import JointState, Mask
from masonry_fem.nscd.graphs import lengths

NUDGE = 1e-6  # of the jump, for central differences
LEAST = 1e-12  # smallest nudge [m]


def decays(state: JointState, trial: JointState) -> Mask:
    """Where adhesion is on its way down, so that the tangent differs from the secant, shape (c,).

    Parameters
    ----------
    state, trial : The joints at the start of the step and after the last turn.
    """
    return (trial.adhesion < state.adhesion) & (trial.adhesion > 0)


def linearise(
    law: Law,
    state: JointState,
    trial: JointState,
    jump: FloatArray,
    reaction: FloatArray,
    velocity: FloatArray,
    area: FloatArray,
    step: float,
) -> Reduction:
    """The law as the contact solver sees it, tangent at ``velocity``.

    The stiffness is a central difference, the same for every law, and need not be symmetric where damage
    couples the modes. Where adhesion does not decay, or is gone, the secant is the tangent.

    Parameters
    ----------
    law : Of all contacts.
    state, trial, jump, reaction, velocity, area, step : As ``Law.update`` takes them.
    """
    reduction = law.reduce(trial, jump, area, step)
    softens = decays(state, trial)
    if not softens.any():
        return reduction

    def cohesion(at: FloatArray) -> FloatArray:
        after = law.update(state, trial, jump, reaction, at, area, step)
        return law.adhesive_reaction(after, area)

    size = np.maximum(NUDGE * lengths(jump + step * velocity), LEAST) / step
    stiffness = np.empty_like(reduction.stiffness)
    for axis in range(state.dimension):
        nudge = np.zeros_like(velocity)
        nudge[:, axis] = size
        change = cohesion(velocity + nudge) - cohesion(velocity - nudge)
        stiffness[:, :, axis] = change / (2.0 * size[:, None])
    own = reduction.own_velocity(velocity, reaction, step)
    offset = cohesion(velocity) - (stiffness @ own[:, :, None])[:, :, 0]
    return replace(
        reduction,
        offset=np.where(softens[:, None], offset, reduction.offset),
        stiffness=np.where(softens[:, None, None], stiffness, reduction.stiffness),
    )
