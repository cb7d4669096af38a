"""PathFollowing: plane problems that tip and slide at once, along a path that may turn back.

Where most joints of a structure are at the limit of friction, Newton's steps cycle: the way to the
solution leads through folds, which no step of theirs gets round. Here a *round* solves the problem
regularised about a centre (``normal_map``) by following, from t = 1 to t = 0, the path

    R(x) = t R(x_0),    x_0 = p_k − ρ v(p_k), slightly shaken so that no two contacts change at once

in *strides* of t, each ended by a few Newton steps, as long as these hold, and else kink by kink
(``kinks``), which goes round folds: between two of them t rises. The sign of the determinant tells on
which side of a fold a stride has ended; one that has jumped to the other side is not taken. Then the
centre moves to the round's solution, and the weight α falls.

    solution = iterate(problem, PathFollowing(), settings, Start(impulse=near))

Problems in space are followed in their plane, where they have one (``InPlane``).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from masonry_fem.errors import ProblemError
from masonry_fem.nscd import graphs
from masonry_fem.nscd.iterate import Iterate
from masonry_fem.nscd.outcome import Outcome
from masonry_fem.nscd.problem import ContactProblem
from masonry_fem.nscd.residuals import Quality
from masonry_fem.nscd.scaling import free_speed
from masonry_fem.nscd.settings import SolverSettings, Start
from masonry_fem.nscd.solvers.kinks import Walk
from masonry_fem.nscd.solvers.normal_map import NormalMap, Piece

FloatArray = NDArray[np.float64]

# Error of a start that no round would mend: the first weights lead away from it, the last ones take for ever.
CLOSE = 1e-6
LEAST_WEIGHT = 1e-11
MILDEST_DECREASE = 0.4  # of α that is worth a round that may fail
# Shake of x_0: this share of the error in velocities, which counts as no more than the second.
SHAKE = 1e-3
MOST_ERROR = 1e-2
FARTHEST = 1e3  # t of a path that leads away
SEED = 1
# A stride: first and least length, Newton steps, and how exactly it ends, relative to where t was 1. The last
# is ‖ρ R‖ / ‖p‖, of which rounding makes 1e-15 and more: what asks for less loses paths by chance.
FIRST_STRIDE = 1.0
LEAST_STRIDE = 1e-3
CORRECTIONS = 8
NEAR = 1e-5
EXACT = 1e-14
# Factor on the next stride after so many Newton steps, and after one that failed.
STRETCH = {0: 2.0, 1: 2.0, 2: 1.5, 3: 1.2}
SHORTEN = 0.4
# Kinks that are crossed one by one before strides are tried again.
KINKS = 30
WALK = 1 + KINKS // 10  # steps that this counts for


@dataclass(frozen=True, slots=True, kw_only=True)
class PathFollowing:
    """Settings of the method.

    Attributes
    ----------
    weight : α of the first round, relative to each contact's scale w.
    decrease : Factor on α after a round.
    patience : Rounds that fail, or bring nothing, after which it is stalled.
    round_steps : Steps of a round after which it is given up: a factor is one, ten kinks are another.
    iterations : Steps in all.
    """

    weight: float = 1e-6
    decrease: float = 1e-2
    patience: int = 3
    round_steps: int = 8000
    iterations: int = 10_000

    @property
    def name(self) -> str:
        """Its name in reports."""
        return "path"

    def init(self, problem: ContactProblem, start: Start | None) -> PathRun:
        """A run on a problem, from a first guess that should be near.

        Raises
        ------
        ProblemError : It is one in 3D, or some bodies have no inertia, or joints cohere.
        """
        return PathRun(problem, self, start)


def followable(problem: ContactProblem) -> bool:
    """True where the method can be used."""
    inert = problem.body_count > 0 and bool((problem.rigid_mass > 0).all())
    return problem.dimension == 2 and inert and not problem.cohesive


class PathRun:
    """Working memory of the method on one problem."""

    def __init__(self, problem: ContactProblem, settings: PathFollowing, start: Start | None) -> None:
        if not followable(problem):
            raise ProblemError(
                f"path following got a problem in {problem.dimension}D with {problem.body_count} bodies, "
                "expected 2D, inertia of all bodies, and dry joints; use 'auto' or 'newton'"
            )
        self.problem, self.settings = problem, settings
        self.equation = NormalMap(problem)
        given = np.zeros_like(problem.free_velocity)
        if start is not None and start.impulse is not None:
            given = start.impulse
        self.centre = graphs.project_cone(given, problem.friction)
        self.speed = free_speed(problem)
        self.weight, self.decrease = settings.weight, settings.decrease
        self.solved: float | None = None  # weight of the last round that was
        self.random = np.random.default_rng(SEED)
        self.round: Path | None = None
        self.steps = 0  # of the round
        self.best, self.idle = np.inf, 0

    def guess(self) -> Iterate:
        """Where it starts."""
        return self._offer(0, None)

    def step(self, quality: Quality, settings: SolverSettings) -> Iterate:
        """A stride or some kinks; the offer changes where a round ends."""
        if self.solved is None and quality.error <= CLOSE:
            return self._offer(0, Outcome.STALLED)
        if self.round is None:
            self.round, self.steps = self._new_round(quality), 0
        with np.errstate(all="ignore"):  # a breakdown is seen in the numbers
            made = self.round.advance()
        self.steps += made
        verdict = None
        if self.round.arrived is not None:
            verdict = self._close_round(self.round.arrived, self.round.first)
        elif self.round.lost or self.steps >= self.settings.round_steps:
            verdict = self._give_up_round()
        return self._offer(made, verdict)

    def _new_round(self, quality: Quality) -> Path:
        equation = self.equation
        equation.hold(self.centre, self.weight)
        x = equation.start(self.centre)
        shake = SHAKE * min(quality.natural_map_velocity, MOST_ERROR) * self.speed
        return Path(equation, x + shake * equation.rho[:, None] * self.random.standard_normal(x.shape))

    def _close_round(self, impulse: FloatArray, error: float) -> Outcome | None:
        """Move the centre to a round's solution; ``error`` is what was left before it."""
        self.centre, self.round, self.solved = impulse, None, self.weight
        self.weight = max(self.decrease * self.weight, LEAST_WEIGHT)
        self.idle = 0 if error < 0.8 * self.best else self.idle + 1
        self.best = min(self.best, error)
        return Outcome.STALLED if self.idle >= self.settings.patience else None

    def _give_up_round(self) -> Outcome | None:
        """Begin the round again with more regularisation: at most as much as one that was solved had.

        With that it costs little, as the centre is close, and brings it closer. With less, rounding decides
        in the end whether a path can be followed.
        """
        self.round = None
        if self.solved is None:
            self.weight = min(10.0 * self.weight, 1.0)
            self.idle += 1
            return Outcome.STALLED if self.idle >= self.settings.patience else None
        if self.decrease == 1.0:  # another shake of x_0 may lead past what rounding has hidden
            self.idle += 1
            return Outcome.STALLED if self.idle >= self.settings.patience else None
        milder = self.decrease**0.5
        self.decrease = milder if milder <= MILDEST_DECREASE else 1.0
        self.weight = self.decrease * self.solved
        return None

    def _offer(self, steps: int, verdict: Outcome | None) -> Iterate:
        velocity = self.problem.balanced_velocity(self.centre)
        factors, self.equation.factors = self.equation.factors, 0
        return Iterate(self.centre, velocity, iterations=steps, linear_solves=factors, verdict=verdict)


class Path:
    """A round's path R(x) = t R(x_0).

    Attributes
    ----------
    t : From 1 at its start to 0 at its end.
    first : ‖ρ R(x_0)‖ / ‖p‖.
    arrived : Impulses at its end, once it is reached, shape (c, 2).
    lost : True where it cannot be followed.
    """

    def __init__(self, equation: NormalMap, x: FloatArray) -> None:
        self.equation = equation
        self.piece = equation.at(x)
        self.target = self.piece.residual
        self.first = equation.relative(self.target, self.piece.impulse)
        self.t, self.forwards, self.lost = 1.0, True, False
        self.arrived: FloatArray | None = None
        self.stride, self.least = FIRST_STRIDE, LEAST_STRIDE
        self.sense = 0  # sign of the determinant where t falls along the path

    def advance(self) -> int:
        """Go a stride on, or some kinks; the steps that it took, at least one."""
        if not self.sense:
            self.sense = self.piece.sign
        made = self._walk() if self.stride < self.least else self._stride()
        self.lost |= not self.t < FARTHEST
        return max(made, 1)

    def _stride(self) -> int:
        """Go a stride on, or shorten it."""
        ahead = max(self.t - self.stride, 0.0) if self.forwards else self.t + self.stride
        near = EXACT if ahead == 0 else max(EXACT, NEAR * self.first * max(ahead, 0.01))
        piece, made = self._corrected(self.piece, ahead, near)
        if piece is None or (ahead > 0 and self._other_side(piece)):
            self.stride *= SHORTEN
            return made
        self.piece, self.t = piece, ahead
        self.stride *= STRETCH.get(made, 1.0)
        if ahead == 0:
            self.arrived = piece.impulse
        return made

    def _corrected(self, piece: Piece, t: float, near: float) -> tuple[Piece | None, int]:
        """The piece where R(x) = t R(x_0), by Newton's steps; None where they lead nowhere. Their number."""
        errors: list[float] = []
        for made in range(CORRECTIONS + 1):
            missing = piece.residual - t * self.target
            error = self.equation.relative(missing, piece.impulse)
            if error <= near:
                return piece, made
            # the first step leaves the piece, and its error is the larger for it
            if not np.isfinite(error) or (len(errors) > 2 and error > errors[-2]):
                return None, made
            errors.append(error)
            if made < CORRECTIONS:
                piece = self.equation.at(piece.x + piece.change(missing))
        return None, CORRECTIONS

    def _other_side(self, piece: Piece) -> bool:
        """True where a stride has ended beyond a fold."""
        return piece.sign * self.sense == (-1 if self.forwards else 1)

    def _walk(self) -> int:
        """Cross some kinks."""
        walk = Walk(self.piece, self.target, self.t, forwards=self.forwards)
        for _ in range(KINKS):
            walk.cross()
            if walk.endless or walk.unsure or walk.t == 0:
                break
        if walk.t == 0:
            return WALK + self._arrive(walk.x)
        if walk.endless:
            self.lost = True
            return WALK
        walk.step_inside()
        travelled = abs(walk.t - self.t)
        self.lost = walk.unsure and travelled == 0
        # strides that are no longer than this are not worth their price
        self.least = min(max(2 * travelled, 1e-6), 1e-2)
        self.stride = 10 * self.least
        self.forwards, self.t = walk.forwards, walk.t
        piece, made = self._corrected(self.equation.at(walk.x), walk.t, max(EXACT, NEAR * self.first))
        self.lost |= piece is None
        self.piece = self.equation.at(walk.x) if piece is None else piece
        return WALK + made

    def _arrive(self, x: FloatArray) -> int:
        """End a walk that came to t = 0."""
        piece, made = self._corrected(self.equation.at(x), 0.0, EXACT)
        self.t, self.lost = 0.0, piece is None
        self.arrived = None if piece is None else piece.impulse
        return made
