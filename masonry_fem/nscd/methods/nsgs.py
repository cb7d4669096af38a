"""Nonlinear Gauss–Seidel (NSGS): contact after contact, each solved exactly with the others held.

The solver of Acary's thesis (docs/theory.md). It reaches 1e-4 fast and then slows down if W is
rank-deficient, as it is in most masonry, so it gives up once sweeping no longer pays. If all blocks are rigid
their velocities are kept up to date; any other problem is condensed to its block-sparse W. Relaxed or with
threads, sweeps go colour after colour, else in a shuffled order (``sweep_form``).

    solution = iterate(problem, GaussSeidel(), SolverSettings(tolerance=1e-6))
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from masonry_fem.nscd import graphs
from masonry_fem.nscd.cohesion import refuse_stiffness
from masonry_fem.nscd.iterate import Iterate, Run
from masonry_fem.nscd.outcome import Outcome
from masonry_fem.nscd.problem import ContactProblem
from masonry_fem.nscd.residuals import Quality
from masonry_fem.nscd.settings import SolverSettings, Start
from masonry_fem.nscd.solvers.sweep_form import SweepForm

FloatArray = NDArray[np.float64]

# Sweeps handed out at once: from the first batch, doubled up to some 0.3 s of work.
FIRST_BATCH = 20
BATCH_WORK = 1_000_000
# Stalled is also what after so many sweeps left more than this of its error in the second half of them.
PATIENCE, PROGRESS = 5_000, 0.9


@dataclass(frozen=True, slots=True, kw_only=True)
class GaussSeidel:
    """Settings of NSGS.

    Attributes
    ----------
    iterations : Sweeps allowed where the settings name no limit.
    """

    iterations: int = 50_000
    name: str = "nsgs"

    def init(self, problem: ContactProblem, start: Start | None) -> Run:
        """A run on a problem; it needs inertia wherever a body is in contact."""
        problem.check_inertia(self.name)
        if start is None or start.impulse is None:
            impulse = np.zeros_like(problem.free_velocity)
        elif problem.cohesion_stiffness is not None:
            impulse = start.impulse.copy()  # what the cone bounds is p̃, which each visit makes anew
        else:
            impulse = graphs.project_cone(start.impulse, problem.friction)
        return _SweepRun(self, problem, np.ascontiguousarray(impulse))


method = GaussSeidel  # of ``[solver]``


class _SweepRun:
    """Working memory of NSGS on one problem."""

    def __init__(self, method: GaussSeidel, problem: ContactProblem, impulse: FloatArray) -> None:
        self.method, self.problem, self.impulse = method, problem, impulse
        self.form: SweepForm | None = None
        self.made, self.batch, self.strictness = 0, FIRST_BATCH, 1.0
        self.errors: list[tuple[int, float]] = []

    def guess(self) -> Iterate:
        return Iterate(self.impulse, self.problem.balanced_velocity(self.impulse), iterations=0)

    def step(self, quality: Quality, settings: SolverSettings) -> Iterate:
        """One batch of sweeps."""
        limit = self.method.iterations if settings.max_iterations is None else settings.max_iterations
        count = min(self.batch, limit - self.made)
        if self.form is None:
            if settings.relaxation != 1.0:
                refuse_stiffness(self.problem, f"method 'nsgs' with relaxation {settings.relaxation}")
            self.form = SweepForm(self.problem, settings.relaxation, settings.threads)
        made, error = self.form.sweep(self.impulse, count, self.strictness * settings.tolerance)
        if made < count:
            # the sweeps' own measure held: should assess() disagree, ask more of it next time
            self.strictness *= 0.3
        self.made += made
        self.batch = min(2 * self.batch, max(BATCH_WORK // self.problem.count, FIRST_BATCH))
        verdict = Outcome.STALLED if made == 0 or self._stalled(error, settings.tolerance) else None
        return Iterate(self.impulse, self.problem.balanced_velocity(self.impulse), made, 0, verdict)

    def _stalled(self, error: float, tolerance: float) -> bool:
        best = min(error, self.errors[-1][1]) if self.errors else error
        self.errors.append((self.made, best))
        halfway = [entry for entry in self.errors if 2 * entry[0] <= self.made]
        if self.made < PATIENCE or not halfway or best <= tolerance:
            return False
        return best > PROGRESS * halfway[-1][1]
