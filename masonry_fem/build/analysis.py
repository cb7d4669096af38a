"""From a scene's solver record to solver settings."""

from __future__ import annotations

from masonry_fem.nscd import SolverSettings
from masonry_fem.nscd.settings import ACCEPTABLE
from masonry_fem.scene import specs


def solver_settings(solver: specs.Solver) -> SolverSettings:
    """The contact solver's settings."""
    return SolverSettings(
        method=solver.method,
        tolerance=solver.aim,
        acceptable=ACCEPTABLE if solver.tolerance is None else 0.0,
        max_iterations=solver.max_iterations,
        time_limit=solver.time_limit,
        relaxation=solver.relaxation,
        threads=solver.threads,
        linear=solver.linear,
    )
