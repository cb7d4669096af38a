"""Fold: one step's contact problem solved together with the joint laws.

Law and contact solver take turns: the law gives friction and an affine cohesive reaction
for its trial state, the solver reactions and velocities, the law the next trial state, until that stays:
in the first turn where joints are dry. The first turn takes the law's secant, the others its tangent as
long as that leads nearer.

    solved = solve_with_laws(law, committed, step, settings, start)
    solved.solution, solved.trial
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from masonry_fem.joints.law import Law
from masonry_fem.joints.reduction import Reduction
from masonry_fem.joints.state import JointState
from masonry_fem.joints.tangent import decays, linearise
from masonry_fem.nscd import ContactProblem, Solution, SolverSettings, Start, solve
from masonry_fem.nscd.compliance import Shared, plus

FloatArray = NDArray[np.float64]

# Change of the trial state that ends the turns; the solver's tolerance, where that is larger: what the
# solver leaves open would be chased for ever
SETTLED = 1e-10
# Secants between the tries with tangents, and tangents that may go by without halving the change.
SECANTS = (4, 8, 16, 32, 64)
PATIENCE = 5
STEPS = 8  # of Newton's method on a tangent's contact problem
# Tolerance of the contact problems in between: at most the first, and the second of the last change.
ROUGH = 1e-4
NEARER = 1e-2
DEPTH = 5  # earlier secants that the next dilation is made of
ALIKE = 1e-10  # of the largest difference of two secants: what says nothing
FURTHEST = 30.0  # times the last change of a secant, how far it is extrapolated


@dataclass(frozen=True, slots=True)
class JointStep:
    """What the laws need to know of a step.

    Attributes
    ----------
    active : Contacts that take part in the problem, shape (k,).
    problem : Makes the problem of what the laws have their part in: friction, free velocity, compliance
        and cohesion.
    free_velocity, compliance : Of these what the blocks give, shapes (k, d) [m/s] and (k d, k d) [1/kg].
    jump : ũ_i, jump at the start [m], shape (c, d).
    area : Tributary areas [m²], shape (c,).
    trial : State of the joints to begin with.
    gap_term : From the closures of the joints (c,) to what the free velocity has of gaps and impacts,
        (c, d) [m/s].
    length : h [s].
    """

    active: NDArray[np.int64]
    problem: Callable[..., ContactProblem]
    free_velocity: FloatArray
    compliance: sparse.bsr_array | Shared
    jump: FloatArray
    area: FloatArray
    trial: JointState
    gap_term: Callable[[FloatArray], FloatArray]
    length: float


@dataclass(frozen=True, slots=True)
class Turn:
    """One solve of the contacts with a law's reduction, and what the law makes of it.

    Attributes
    ----------
    solution, problem : Of the contacts. reaction, velocity : Of all contacts, (c, d) [N], [m/s].
    given : State of the joints that it was made with. trial : The state after it.
    loss : Adhesion that it took from the given state, (c,).
    change : Distance between the two states. tolerance : That the contacts were asked to be solved to.
    """

    solution: Solution
    problem: ContactProblem
    reaction: FloatArray
    velocity: FloatArray
    given: JointState
    trial: JointState
    loss: FloatArray
    change: float
    tolerance: float

    @property
    def restless(self) -> int | None:
        """The contact whose state changed most; None where the joints settled."""
        return int(self.trial.differences(self.given).argmax()) if self.change > 0 else None

    @property
    def start(self) -> Start:
        """First guess for the next turn."""
        return Start(self.solution.impulse, self.solution.rigid_velocity)


def solve_with_laws(
    law: Law,
    committed: JointState,
    step: JointStep,
    settings: SolverSettings,
    start: Start | None,
) -> Turn:
    """The last turn of a step; its ``trial`` is the state at the end, its ``change`` 0 where that settled.

    Parameters
    ----------
    law : Of all contacts, dry ones among them.
    committed : State of the joints at the start of the step.
    step : What the laws need to make the step's contact problem.
    settings : Of the contact solver.
    start : First guess of the solution; None: there is none.
    """
    turns = _Turns(law, committed, step, settings)
    at = turns.first(start)
    for secants in SECANTS:
        found = turns.by_tangents(at)
        if found is not None:
            return replace(found, change=0.0)
        at = turns.by_secants(at, secants)
        if turns.settled(at):
            return replace(at, change=0.0)
        if at.solution.outcome.moves or turns.given_up(at):
            break  # with what is left of the joints nothing stands, or no more effort is to be made
    return turns.exact(at)


class _Turns:
    """The turns of one step.

    Tangents converge quadratically near the solution; far from it they may lead nowhere, or leave the
    contact problem without a solution: then secants go on from where the tangents began.
    """

    def __init__(self, law: Law, committed: JointState, step: JointStep, settings: SolverSettings) -> None:
        self._law, self._committed, self._step, self._settings = law, committed, step, settings
        self._roughest = ROUGH

    def settled(self, turn: Turn) -> bool:
        exact = turn.tolerance <= self._settings.tolerance  # asked for, whether or not it was reached
        return exact and turn.change <= max(SETTLED, self._settings.tolerance)

    def given_up(self, turn: Turn) -> bool:
        """Whether the contacts were not solved within a limit of iterations."""
        return self._settings.max_iterations is not None and not turn.solution.solved

    def first(self, start: Start | None) -> Turn:
        """The turn with the trial state that the step begins with."""
        return self._secant(self._step.trial, start, self._settings)

    def exact(self, at: Turn) -> Turn:
        """One more secant, to the tolerance that is asked for.

        Where nothing stood with what was left of the joints, it is made with that again: the speeds of a
        mechanism are of any size, and joints that they are too slow to open would hold once more.
        """
        trial = at.given if at.solution.outcome.moves else at.trial
        return self._secant(trial, at.start, self._settings)

    def by_tangents(self, at: Turn) -> Turn | None:
        """Where tangents from ``at`` on settle; None where they do not come nearer for some turns."""
        if self.settled(at):
            return at
        least, since, brief = np.inf, 0, self._settings
        if brief.method == "auto":  # what is not solved at once is not worth the thorough methods
            brief = replace(brief, method="newton", max_iterations=STEPS, acceptable=0.0)
        while not self.settled(at):
            if not decays(self._committed, at.trial).any():
                return None  # the tangent would be the secant
            reduction = linearise(
                self._law, self._committed, at.trial, self._step.jump, at.reaction, at.velocity,
                self._step.area, self._step.length,
            )  # fmt: skip
            found = self._taken(reduction, self._rough(brief, at), at.trial, at.start)
            if not found.solution.solved:
                return None
            at = found
            since += 1
            if at.change < 0.5 * least:
                least, since = at.change, 0
            if since > PATIENCE:
                return None
        return at

    def by_secants(self, at: Turn, most: int) -> Turn:
        """Where at most so many secants lead."""
        made: list[Turn] = []
        for _ in range(most):
            last, moved = at.loss, at.solution.outcome.moves
            at = self._secant(at.trial, at.start, self._rough(self._settings, at))
            if self.settled(at) or (moved and at.solution.outcome.moves) or self.given_up(at):
                break
            made = [*made[-DEPTH:], at]
            at = replace(at, trial=replace(self._ahead(at, last), dilation=_combined(made)))
        return at

    def _rough(self, settings: SolverSettings, at: Turn) -> SolverSettings:
        """Settings as exact as the smallest change so far deserves: what is close to a switch would flip."""
        self._roughest = min(self._roughest, NEARER * at.change)
        return replace(settings, tolerance=max(settings.tolerance, self._roughest))

    def _secant(self, trial: JointState, start: Start | None, settings: SolverSettings) -> Turn:
        reduction = self._law.reduce(trial, self._step.jump, self._step.area, self._step.length)
        return self._taken(reduction, settings, trial, start)

    def _ahead(self, at: Turn, last: FloatArray) -> JointState:
        """Where secants that creep will end, by Aitken's Δ²; close to a snap-back they need hundreds."""
        slope, size = float(at.loss @ last), float(last @ last)
        if not 0 < slope < size:
            return at.trial
        further = min(slope / (size - slope), FURTHEST)
        adhesion = np.clip(at.trial.adhesion - further * at.loss, 0.0, self._committed.adhesion)
        return replace(at.trial, adhesion=adhesion)

    def _taken(
        self, reduction: Reduction, settings: SolverSettings, trial: JointState, start: Start | None
    ) -> Turn:
        """The turn with a reduction of the law made from ``trial``."""
        step, active = self._step, self._step.active
        part: Reduction = reduction
        at: slice | NDArray[np.int64] = slice(None)
        if len(active) < reduction.count:
            part, at = reduction.take(active), active
        own = step.gap_term(reduction.closure)[at]
        problem = _folded(step, part, own)
        solution = solve(problem, settings, start)
        reaction, velocity = np.zeros((2, *step.jump.shape))
        reaction[at] = solution.impulse / step.length
        # the blocks' own velocity: without gap term, dilation and what the joint's bed gives way
        velocity[at] = solution.velocity - own - part.shift - part.compliance * solution.impulse
        after = self._law.update(
            self._committed, trial, step.jump, reaction, velocity, step.area, step.length
        )  # fmt: skip
        loss = trial.adhesion - after.adhesion
        change = after.distance(trial)
        return Turn(solution, problem, reaction, velocity, trial, after, loss, change, settings.tolerance)


def _combined(made: list[Turn]) -> FloatArray:
    """The dilation that comes nearest to leading to itself, of those that turns led to, shape (c,).

    Where sliding opens a joint it is pressed more, and slides less: each turn alone leaves a third of the
    change. Anderson's acceleration finds its way from the last ones, as rounds do from their places.

    References
    ----------
    H. F. Walker, P. Ni, "Anderson acceleration for fixed-point iterations", SIAM Journal on Numerical
    Analysis 49 (2011).
    """
    led = np.array([turn.trial.dilation for turn in made])
    if not led.any():
        return made[-1].trial.dilation
    gone = led - [turn.given.dilation for turn in made]
    shares = np.linalg.lstsq(np.diff(gone, axis=0).T, gone[-1], rcond=ALIKE)[0]
    combined: FloatArray = np.maximum(led[-1] - shares @ np.diff(led, axis=0), 0.0)
    return combined


def _folded(step: JointStep, part: Reduction, term: FloatArray) -> ContactProblem:
    """The problem with a gap term, friction and cohesion p_adh = h (a + B v_c), v_c = v without that term."""
    compliance, offset, stiffness = step.compliance, None, None
    if part.compliance.any():
        compliance = plus(compliance, part.compliance)
    if part.offset.any() or part.stiffness.any():
        along = (part.stiffness @ term[:, :, None])[:, :, 0]
        offset, stiffness = step.length * (part.offset - along), step.length * part.stiffness
    return step.problem(
        friction=part.friction,
        free_velocity=step.free_velocity + term + part.shift,
        compliance=compliance,
        cohesion_offset=offset,
        cohesion_stiffness=stiffness,
    )
