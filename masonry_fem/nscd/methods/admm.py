"""ADMM: alternating directions, the friction cones in one half-step and the laws of motion in the other.

With D = ρ w (w the scale of each contact), z the state and s = ‖v_T‖ the friction term, an iteration is

    y = P_K(z)                                                       contact by contact
    W_el x + q + μ s n + B U + D (x − (2 y − z)) = 0,  balance       linear, always the same matrix
    z ← z + a (x − y)

and at its fixed point x = y, v̂ = D (y − z). Anderson's
acceleration turns hundreds of iterations into tens.

The friction term makes the problem non-convex. Updated in each iteration it feeds itself where blocks
tip, and the iteration never ends; so it starts at 0, as in a convex problem, and follows the velocities
only when x − y has become small beside what it lags behind.

The linear half is solved by one factorisation for each ρ (two or three in all).

Where cohesion has a stiffness S, all this is of p̃ = p + S v, but what is offered is p.

What it offers is x, whose balance is exact and whose natural map is half that of y: its impulses may
leave their cones by as much as the tolerance.

    solution = iterate(problem, ADMM(), settings)
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from masonry_fem.nscd.graphs import augmented_velocity, project_cone, tangential_norm
from masonry_fem.nscd.iterate import Iterate
from masonry_fem.nscd.linear import Library
from masonry_fem.nscd.outcome import Outcome
from masonry_fem.nscd.problem import ContactProblem
from masonry_fem.nscd.residuals import Quality
from masonry_fem.nscd.scaling import contact_scale
from masonry_fem.nscd.settings import SolverSettings, Start
from masonry_fem.nscd.solvers.admm_kernel import advance, reflect
from masonry_fem.nscd.solvers.anderson import Anderson
from masonry_fem.nscd.solvers.proximal_step import ProximalStep

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class ADMM:
    """Settings of ADMM.

    Attributes
    ----------
    rho : First ρ, unit-free.
    share, change : ρ becomes ``share`` · ‖W x‖ / ‖x‖ (in the contacts' scales) after 20, 60, 180 …
        iterations where it would change by more than the factor ``change``.
    relaxation : Over-relaxation a, 0 < a < 2.
    memory : Steps that Anderson's acceleration looks back on; 0: none.
    tight, loose : ‖x − y‖ relative to what s lags behind, at which s moves on; ``loose`` and ``tight``
        by turns where ``phase`` iterations, then 1.5 times as many, did not halve the error.
    follow : Share of its lag by which s moves.
    interval : Iterations between two tests of the error.
    patience : Iterations before it may be called stalled.
    progress : It is stalled where the second half of all iterations left more than this of the error.
    iterations : Iterations allowed where the settings name no limit.
    library : Linear factor, see ``linear``.
    """

    rho: float = 0.3
    share: float = 0.5
    change: float = 2.0
    relaxation: float = 1.6
    memory: int = 20
    tight: float = 0.1
    loose: float = 1.0
    phase: int = 150
    follow: float = 0.6
    interval: int = 10
    patience: int = 3_000
    progress: float = 0.5
    iterations: int = 10_000
    library: Library = "auto"

    @property
    def name(self) -> str:
        """Its name in settings and reports."""
        return "admm"

    def init(self, problem: ContactProblem, start: Start | None) -> ADMMRun:
        """A run on a problem."""
        return ADMMRun(problem, self, start)


method = ADMM  # of ``[solver]``


class ADMMRun:
    """Working memory of ADMM on one problem."""

    def __init__(self, problem: ContactProblem, settings: ADMM, start: Start | None) -> None:
        self.problem, self.settings = problem, settings
        scale = contact_scale(problem)
        self.scale, self.root = scale, np.sqrt(scale)
        self.part = ProximalStep(problem, scale, settings.library)
        shape = problem.free_velocity.shape
        self.state = np.zeros(shape)  # z
        self.slip = np.zeros(problem.count)  # s
        self.projected, self.force, self.image = np.zeros(shape), np.zeros(shape), np.zeros(shape)
        self.sliding = np.zeros(problem.count)
        self.friction = np.ascontiguousarray(problem.friction)
        self.free = np.ascontiguousarray(problem.free_velocity)
        self.anderson = Anderson(settings.memory, self.state.size)
        self.impulse, self.rigid_velocity = np.zeros(shape), problem.free_rigid_velocity()
        self.rho, self.weight = 0.0, np.ones(problem.count)
        self.made, self.look = 0, FIRST_LOOK
        self.lag, self.phase = settings.tight, settings.phase
        self.mark = (0, np.inf)  # iterations and error when it was last halved
        self.errors: list[tuple[int, float]] = []
        if start is not None and start.impulse is not None:
            self._begin(start.impulse, start.rigid_velocity)

    def _begin(self, impulse: FloatArray, rigid_velocity: FloatArray | None) -> None:
        dry = self.problem.cohesion_stiffness is None
        self.impulse = project_cone(impulse, self.problem.friction) if dry else impulse.copy()
        balanced = self.problem.balanced_velocity(self.impulse)
        self.rigid_velocity = balanced if rigid_velocity is None else rigid_velocity.copy()
        self.part.rigid_velocity = self.rigid_velocity.copy()

    def guess(self) -> Iterate:
        """The first guess, or no impulses."""
        return Iterate(self.impulse, self.rigid_velocity, iterations=0)

    def step(self, quality: Quality, settings: SolverSettings) -> Iterate:
        """Some iterations."""
        before = self.part.factorisations
        if not self.made:
            self._weigh(self.settings.rho)
            if self.impulse.any():
                self._take_velocity()
        elif self._stalled(quality.error):
            return self._offer(0, 0, Outcome.STALLED)
        elif self.made >= self.look:
            self._adapt()
        self._take_turns(quality.error)
        limit = self.settings.iterations if settings.max_iterations is None else settings.max_iterations
        count = min(self.settings.interval, limit - self.made)
        for _ in range(count):
            self._iterate(self.weight)
        self.made += count
        return self._offer(count, self.part.factorisations - before, None)

    def _take_velocity(self) -> None:
        """The state z of the first guess."""
        velocity = self.problem.velocity(self.impulse, self.rigid_velocity)
        self.slip = tangential_norm(velocity)
        pressed = self.problem.contact_part(self.impulse, velocity)
        self.state = pressed - augmented_velocity(velocity, self.friction) / self.weight[:, None]

    def _weigh(self, rho: float) -> None:
        self.rho, self.weight = rho, rho * self.scale
        self.part.weigh(self.weight)

    def _adapt(self) -> None:
        """A better ρ, from how much velocity the impulses cause."""
        self.look = 3 * self.made
        caused = _caused_velocity(self.problem, self.impulse) / self.root[:, None]
        size = float(np.linalg.norm(self.impulse * self.root[:, None]))
        rho = self.settings.share * float(np.linalg.norm(caused)) / size if size > 0 else 0.0
        if not 0 < rho < np.inf or max(rho / self.rho, self.rho / rho) <= self.settings.change:
            return
        projected = project_cone(self.state, self.friction)
        self.state = projected + self.rho / rho * (self.state - projected)  # y and v̂ stay
        self._weigh(rho)
        self.anderson.forget()

    def _take_turns(self, error: float) -> None:
        """Change how closely s follows where the error does not fall."""
        since, least = self.mark
        if error < 0.5 * least:
            self.mark = (self.made, error)
        elif self.made - since >= self.phase:
            self.mark, self.phase = (self.made, error), self.phase * 3 // 2
            self.lag = self.settings.loose if self.lag == self.settings.tight else self.settings.tight
            self.anderson.forget()

    def _iterate(self, weight: FloatArray) -> None:
        chosen = self.settings
        reflect(
            self.state, weight, self.friction, self.slip, self.free, self.projected, self.force
        )  # fmt: skip
        self.impulse, self.rigid_velocity = self.part.solve(self.force)
        pressed = self.impulse
        if self.problem.cohesive:
            velocity = self.problem.velocity(self.impulse, self.rigid_velocity)
            pressed = self.problem.contact_part(self.impulse, velocity)
        gap, late = advance(
            self.state, self.projected, pressed, weight, self.friction, self.slip, self.root,
            chosen.relaxation, self.image, self.sliding,
        )  # fmt: skip
        scaled = (self.root[:, None] * self.state).ravel()
        self.state = self.anderson.next(scaled, self.image.ravel()).reshape(self.state.shape)
        self.state = self.state / self.root[:, None]
        if gap <= self.lag**2 * late:
            self.slip += chosen.follow * (self.sliding - self.slip)
            self.anderson.skip()

    def _offer(self, count: int, solves: int, verdict: Outcome | None) -> Iterate:
        return Iterate(self.impulse, self.rigid_velocity, count, solves, verdict)

    def _stalled(self, error: float) -> bool:
        self.errors.append((self.made, min(error, self.errors[-1][1]) if self.errors else error))
        if self.made < self.settings.patience:
            return False
        halfway = [best for made, best in self.errors if 2 * made <= self.made]
        return bool(halfway) and self.errors[-1][1] > self.settings.progress * halfway[-1]


def _caused_velocity(problem: ContactProblem, impulse: FloatArray) -> FloatArray:
    """W_el p; where nothing is elastic B M⁻¹ Bᵀ p, with unit mass in statics."""
    if not problem.rigid or not problem.body_count:
        return problem.elastic_velocity(impulse)
    mass = np.where(problem.rigid_mass > 0, problem.rigid_mass, 1.0)
    return problem.contact_velocity(problem.body_impulse(impulse) / mass)


# Iterations after which ρ is first looked at.
FIRST_LOOK = 20
