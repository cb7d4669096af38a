"""Cohesion: one step's contact problem solved together with the joint laws.

Law and contact solver take turns (formulation 5): the law gives an affine cohesive reaction for its
trial state, the solver reactions and velocities, the law the next trial state, until that stays.

    solution, problem, trial = solve_with_laws(law, committed, step, problem, settings, start)
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from masonry_fem.nscd import ContactProblem, Solution, SolverSettings, Start, solve
from masonry_fem.nscd.laws.law import Law
from masonry_fem.nscd.laws.reduction import Reduction
from masonry_fem.nscd.laws.state import JointState

logger = logging.getLogger(__name__)

FloatArray = NDArray[np.float64]

# Change of the trial state that ends the turns; the solver's tolerance, where that is larger: what the
# solver leaves open would be chased for ever
SETTLED = 1e-10
TURNS = 100


@dataclass(frozen=True, slots=True)
class JointStep:
    """What the laws need to know of a step.

    Attributes
    ----------
    active : Contacts that take part in the problem, shape (k,).
    jump : ũ_i, jump at the start [m], shape (c, d).
    area : Tributary areas [m²], shape (c,).
    trial : State of the joints to begin with.
    gap_term : From the closures of the joints (c,) to what the free velocity has of gaps and impacts,
        (c, d) [m/s].
    length : h [s].
    """

    active: NDArray[np.int64]
    jump: FloatArray
    area: FloatArray
    trial: JointState
    gap_term: Callable[[FloatArray], FloatArray]
    length: float


def solve_with_laws(
    law: Law,
    committed: JointState,
    step: JointStep,
    problem: ContactProblem,
    settings: SolverSettings,
    start: Start | None,
) -> tuple[Solution, ContactProblem, JointState]:
    """Solution of a step, the problem it solves, and the state of the joints at its end.

    ``law`` is that of all contacts, dry ones among them; ``problem`` is the step's without cohesion, its
    gap term that of closed joints.
    """
    trial = step.trial
    bare = step.gap_term(np.zeros(committed.count))
    for _ in range(TURNS):
        reduction = law.reduce(trial, step.jump, step.area, step.length)
        term = step.gap_term(reduction.closure)
        part, own = reduction.take(step.active), term[step.active]
        cohesive = _cohesive(problem, part, own, own - bare[step.active], step.length)
        solution = solve(cohesive, settings, start)
        reaction, velocity = np.zeros_like(step.jump), np.zeros_like(step.jump)
        reaction[step.active] = solution.impulse / step.length
        # the blocks' own velocity: without gap term, dilation and what the joint's bed gives way
        velocity[step.active] = solution.velocity - own - part.shift - part.compliance * solution.impulse
        before, trial = trial, law.update(
            committed, trial, step.jump, reaction, velocity, step.area, step.length
        )  # fmt: skip
        if trial.distance(before) <= max(SETTLED, settings.tolerance):
            return solution, cohesive, trial
        start = Start(solution.impulse, solution.rigid_velocity)
    logger.warning(
        "joint laws did not settle in %d turns: adhesion still changes by %.1e; where the structure snaps "
        "back, smaller steps or dynamics follow it",
        TURNS, trial.distance(before),
    )  # fmt: skip
    return solution, cohesive, trial


def _cohesive(
    problem: ContactProblem, part: Reduction, term: FloatArray, closed: FloatArray, h: float
) -> ContactProblem:
    """The problem with cohesion p_adh = h (a + B v_c), v_c = v without the gap term.

    ``closed`` is what the closures change of that term.
    """
    compliance = problem.compliance
    if part.compliance.any():
        bed = sparse.diags_array(part.compliance.ravel()).tobsr(compliance.blocksize)
        compliance = sparse.bsr_array(compliance + bed, blocksize=compliance.blocksize)
    along = (part.stiffness @ term[:, :, None])[:, :, 0]
    return replace(
        problem,
        friction=part.friction,
        free_velocity=problem.free_velocity + closed + part.shift,
        compliance=compliance,
        cohesion_offset=h * (part.offset - along),
        cohesion_stiffness=h * part.stiffness,
    )
