"""From a scene's analysis and solver records to a strategy and solver settings."""

from __future__ import annotations

from masonry_fem.march.equilibrium import (
    Statics,
    Strategy,
    Transient,
    linear_damping,
    numerical_viscosity,
)
from masonry_fem.nscd import SolverSettings
from masonry_fem.nscd.settings import ACCEPTABLE
from masonry_fem.scene import specs


def strategy(analysis: specs.Analysis) -> Strategy:
    """The strategy that a scene asks for."""
    if isinstance(analysis, specs.Statics):
        return Statics(load_steps=analysis.load_steps, parts=analysis.substeps)
    if isinstance(analysis, specs.Dynamics):
        return Transient(step=analysis.step, duration=analysis.duration, theta=analysis.theta)
    if analysis.strategy == "numerical_viscosity":
        return numerical_viscosity(
            step=analysis.step,
            theta=analysis.theta,
            max_steps=analysis.max_steps,
            tolerance=analysis.tolerance,
        )
    # a large step is brutal damping whose step the user chose long
    return linear_damping(
        step=analysis.step,
        factor=analysis.velocity_factor if analysis.strategy == "linear_damping" else 0.0,
        theta=analysis.theta,
        max_steps=analysis.max_steps,
        tolerance=analysis.tolerance,
    )


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
