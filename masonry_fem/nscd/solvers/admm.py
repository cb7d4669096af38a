"""ADMM: alternating directions, the friction cones in one half-step and the laws of motion in the other.

With D = ρ w (w the scale of each contact), z the state and s = ‖v_T‖ the friction term, an iteration is

    y = P_K(z)                                                       contact by contact
    W_el x + q + μ s n + B U + D (x − (2 y − z)) = 0,  balance       linear, always the same matrix
    z ← z + a (x − y)

and at its fixed point x = y, v̂ = D (y − z). One factorisation serves as long as ρ stays. Anderson's
acceleration turns hundreds of iterations into tens.

The friction term makes the problem non-convex. Updated in each iteration it feeds itself where blocks
tip, and the iteration never ends; so it starts at 0, as in a convex problem, and follows the velocities
only when x − y has become small beside what it lags behind.

    solution = iterate(problem, ADMM(), settings)
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from masonry_fem.nscd.graphs import project_cone
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
    relaxation : Over-relaxation a, 0 < a < 2.
    memory : Steps that Anderson's acceleration looks back on; 0: none.
    lag : ‖x − y‖ relative to what s lags behind, at which s moves on.
    follow : Share of its lag by which s moves.
    interval : Iterations between two tests of the error.
    patience : Iterations before it may be called stalled.
    progress : It is stalled where the second half of all iterations left more than this of the error.
    iterations : Iterations allowed where the settings name no limit.
    library : Linear factor, see ``linear``.
    """

    rho: float = 0.05
    relaxation: float = 1.6
    memory: int = 20
    lag: float = 0.1
    follow: float = 0.6
    interval: int = 10
    patience: int = 2_000
    progress: float = 0.9
    iterations: int = 10_000
    library: Library = "auto"

    @property
    def name(self) -> str:
        """Its name in settings and reports."""
        return "admm"

    def init(self, problem: ContactProblem, start: Start | None) -> ADMMRun:
        """A run on a problem."""
        return ADMMRun(problem, self, start)


class ADMMRun:
    """Working memory of ADMM on one problem."""

    def __init__(self, problem: ContactProblem, settings: ADMM, start: Start | None) -> None:
        self.problem, self.settings = problem, settings
        scale = contact_scale(problem)
        self.root = np.sqrt(scale)
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
        self.weight: FloatArray | None = None
        self.made = 0
        self.errors: list[tuple[int, float]] = []
        if start is not None and start.impulse is not None:
            self._begin(start.impulse, start.rigid_velocity)

    def _begin(self, impulse: FloatArray, rigid_velocity: FloatArray | None) -> None:
        self.impulse = project_cone(impulse, self.problem.friction)
        balanced = self.problem.balanced_velocity(self.impulse)
        self.rigid_velocity = balanced if rigid_velocity is None else rigid_velocity.copy()
        self.part.rigid_velocity = self.rigid_velocity.copy()

    def guess(self) -> Iterate:
        """The first guess, or no impulses."""
        return Iterate(self.impulse, self.rigid_velocity, iterations=0)

    def step(self, quality: Quality, settings: SolverSettings) -> Iterate:
        """Some iterations."""
        if self._stalled(quality.error, settings.tolerance):
            return self._offer(0, 0, Outcome.STALLED)
        solves = 0
        if self.weight is None:
            self.weight = self.part.weigh(self.settings.rho)
            velocity = self.problem.velocity(self.impulse, self.rigid_velocity)
            self.slip = np.linalg.norm(velocity[:, 1:], axis=1) if self.impulse.any() else self.slip
            velocity[:, 0] += self.friction * self.slip
            self.state = self.impulse - velocity / self.weight[:, None] * self.impulse.any()
            solves = 1
        limit = self.settings.iterations if settings.max_iterations is None else settings.max_iterations
        count = min(self.settings.interval, limit - self.made)
        for _ in range(count):
            self._iterate(self.weight)
        self.made += count
        return self._offer(count, solves, None)

    def _iterate(self, weight: FloatArray) -> None:
        chosen = self.settings
        reflect(
            self.state, weight, self.friction, self.slip, self.free, self.projected, self.force
        )  # fmt: skip
        self.impulse, self.rigid_velocity = self.part.solve(self.force)
        gap, late = advance(
            self.state, self.projected, self.impulse, weight, self.friction, self.slip, self.root,
            chosen.relaxation, self.image, self.sliding,
        )  # fmt: skip
        scaled = (self.root[:, None] * self.state).ravel()
        self.state = self.anderson.next(scaled, self.image.ravel()).reshape(self.state.shape)
        self.state = self.state / self.root[:, None]
        if gap <= chosen.lag**2 * late:
            self.slip += chosen.follow * (self.sliding - self.slip)

    def _offer(self, count: int, solves: int, verdict: Outcome | None) -> Iterate:
        return Iterate(self.impulse, self.rigid_velocity, count, solves, verdict)

    def _stalled(self, error: float, tolerance: float) -> bool:
        best = min(error, self.errors[-1][1]) if self.errors else error
        self.errors.append((self.made, best))
        if self.made < self.settings.patience:
            return False
        then = next(entry[1] for entry in reversed(self.errors) if 2 * entry[0] <= self.made)
        return best > self.settings.progress * then
