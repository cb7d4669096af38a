"""Cohesion: one step's contact problem solved together with the joint laws.

Law and contact solver take turns (formulation 5): the law gives an affine cohesive reaction for its
trial state, the solver reactions and velocities, the law the next trial state, until that stays. The
first turn takes the law's secant, the others its tangent as long as that leads nearer.

    solution, problem, trial = solve_with_laws(law, committed, step, problem, settings, start)
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from masonry_fem.nscd import ContactProblem, Outcome, Solution, SolverSettings, Start, solve
from masonry_fem.nscd.laws.law import Law
from masonry_fem.nscd.laws.reduction import Reduction
from masonry_fem.nscd.laws.state import JointState
from masonry_fem.nscd.laws.tangent import linearise

logger = logging.getLogger(__name__)

FloatArray = NDArray[np.float64]

# Change of the trial state that ends the turns; the solver's tolerance, where that is larger: what the
# solver leaves open would be chased for ever
SETTLED = 1e-10
TURNS = 100
# Turns with tangents that may go by without halving the change, and turns with secants after them.
PATIENCE = 6
RESTS = 4
STEPS = 30  # of Newton's method on a tangent's contact problem


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
    trial, turn, tangents = step.trial, None, _Tangents()
    brief = settings
    if settings.method == "auto":  # a tangent that is not solved at once is not worth the thorough methods
        brief = replace(settings, method="newton", max_iterations=STEPS)
    for _ in range(TURNS):
        tangent = turn is not None and tangents.wanted
        if turn is not None and tangent:
            reduction = linearise(
                law, committed, trial, step.jump, turn.reaction, turn.velocity, step.area, step.length
            )
        else:
            reduction = law.reduce(trial, step.jump, step.area, step.length)
        tried = _turn(reduction, step, problem, brief if tangent else settings, start)
        if tangent and tried.solution.outcome is not Outcome.CONVERGED:
            tangents.rest()
            continue
        turn, before = tried, trial
        trial = law.update(
            committed, trial, step.jump, turn.reaction, turn.velocity, step.area, step.length
        )  # fmt: skip
        change = trial.distance(before)
        if change <= max(SETTLED, settings.tolerance):
            return turn.solution, turn.problem, trial
        tangents.see(change)
        start = Start(turn.solution.impulse, turn.solution.rigid_velocity)
    assert turn is not None  # secants are always taken
    logger.warning(
        "joint laws did not settle in %d turns: adhesion still changes by %.1e; where the structure snaps "
        "back, smaller steps or dynamics follow it",
        TURNS, change,
    )  # fmt: skip
    return turn.solution, turn.problem, trial


@dataclass(frozen=True, slots=True)
class _Turn:
    """One solve of the contacts with a law's reduction; reactions [N] and velocities of all contacts."""

    solution: Solution
    problem: ContactProblem
    reaction: FloatArray
    velocity: FloatArray


class _Tangents:
    """Whether the next turn takes the law's tangent or its secant.

    Tangents converge quadratically near the solution; far from it, and where they leave the contact
    problem without a solution, some turns with secants lead nearer.
    """

    def __init__(self) -> None:
        self._resting = 0
        self._least, self._since = np.inf, 0

    @property
    def wanted(self) -> bool:
        return self._resting == 0

    def rest(self) -> None:
        """After a tangent that led nowhere."""
        self._resting, self._least, self._since = RESTS, np.inf, 0

    def see(self, change: float) -> None:
        """After a turn that changed the trial state so much."""
        if self._resting:
            self._resting -= 1
            return
        self._since += 1
        if change < 0.5 * self._least:
            self._least, self._since = change, 0
        elif self._since >= PATIENCE:
            self.rest()


def _turn(
    reduction: Reduction,
    step: JointStep,
    problem: ContactProblem,
    settings: SolverSettings,
    start: Start | None,
) -> _Turn:
    active, h = step.active, step.length
    term, bare = step.gap_term(reduction.closure), step.gap_term(np.zeros_like(reduction.closure))
    part, own = reduction.take(active), term[active]
    cohesive = _cohesive(problem, part, own, own - bare[active], h)
    solution = solve(cohesive, settings, start)
    reaction, velocity = np.zeros_like(step.jump), np.zeros_like(step.jump)
    reaction[active] = solution.impulse / h
    # the blocks' own velocity: without gap term, dilation and what the joint's bed gives way
    velocity[active] = solution.velocity - own - part.shift - part.compliance * solution.impulse
    return _Turn(solution, cohesive, reaction, velocity)


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
